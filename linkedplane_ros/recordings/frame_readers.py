# SPDX-License-Identifier: Apache-2.0
"""What makes frames of a bag's messages: of its joint states here, of poses in `poses`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ..joints.joint_state import JointMemory, OtherJoints, Rejected
from .bags.topics import JOINT_STATE
from .frame_tree import stamp_in_nanoseconds
from .motion import Frame, Place, Refused
from .units import AngleRange, AngleUnit


class FrameReader(Protocol):
    """Reads the frames of a motion out of a bag's messages."""

    unit: AngleUnit
    met: AngleRange
    """The positions that were met, where nobody says their unit."""

    @property
    def width(self) -> int:
        """How many angles a frame has."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What is read, for an output's metadata."""

    @property
    def notes(self) -> Sequence[str]:
        """What is worth knowing of how frames were read, a line each."""

    def accepts(self, topic: str, kind: str) -> bool:
        """Return whether a topic's messages of a type are read."""

    def read_frames(self, message: Any, topic: str, place: Place) -> Iterator[Frame | Refused]:
        """Yield the frames that a message completes; OtherJoints if it is of none of them."""

    def last_frames(self) -> Iterator[Frame | Refused]:
        """Yield the frames that only the end of the recording completes."""

    def unused_messages(self) -> Iterator[tuple[str, int, str]]:
        """Yield why, how many and where: messages without a frame that were not rejected."""


RADIANS = AngleUnit(False, 'REP 103')


@dataclass
class JointFrameReader:
    """Reads frames out of joint states, as the node does."""

    topic: str
    memory: JointMemory
    unit: AngleUnit = RADIANS
    met: AngleRange = field(init=False)

    def __post_init__(self) -> None:
        """Begin with no position."""
        self.met = AngleRange(self.memory.joints.turning)

    @property
    def width(self) -> int:
        """How many joints there are."""
        return len(self.memory.joints.names)

    @property
    def notes(self) -> Sequence[str]:
        """Nothing."""
        return ()

    @property
    def facts(self) -> Mapping[str, str]:
        """Where the angles come from."""
        return {
            'topic': self.topic,
            'read_in': self.unit.fact,
            **self.memory.joints.facts,
            'velocities': 'recorded, where the recording has them',
        }

    def accepts(self, topic: str, kind: str) -> bool:
        """Return whether these are the joint states chosen."""
        return kind == JOINT_STATE and topic == self.topic

    def read_frames(self, message: Any, topic: str, place: Place) -> Iterator[Frame | Refused]:
        """Yield the one frame of a message; OtherJoints if it has none of the joints."""
        positions, velocities = message.position, message.velocity
        if not self.unit.said:
            self.met.extend_named(message.name, positions)
        elif self.unit.degrees:
            sliding = self.memory.joints.sliding
            turns = np.array([name not in sliding for name in message.name], dtype=bool)
            positions, velocities = (
                np.where(turns, np.radians(each), each) if len(each) == len(turns) else each
                for each in (positions, velocities)
            )
        try:
            angles, speeds, _ = self.memory.take_message(
                message.name, positions.tolist(), velocities.tolist()
            )
        except OtherJoints:
            raise
        except Rejected as error:
            yield Refused(error.reason, str(error), place)
            return
        stamp = place.instead
        if stamp is None:
            stamp = stamp_in_nanoseconds(message.header.stamp)
        yield Frame(stamp, place, angles, speeds)

    def last_frames(self) -> Iterator[Frame | Refused]:
        """Yield nothing: no message waits for another."""
        yield from ()

    def unused_messages(self) -> Iterator[tuple[str, int, str]]:
        """Yield nothing: each message has its frame, or was rejected."""
        yield from ()
