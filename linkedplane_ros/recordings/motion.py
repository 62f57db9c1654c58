# SPDX-License-Identifier: Apache-2.0
"""A motion: a recording as chunks of joint angles, each with the messages around it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import RecordingError
from ..types import Bools, Floats, JointValues, Stamps
from .units import AngleRange, AngleUnit

LATEST = 2.0**31  # s: a stamp holds no more
ROWS = 5000  # frames that are worked on at a time


@dataclass
class Refusals:
    """What could not be used of a recording."""

    counts: Counter[str] = field(default_factory=Counter)
    """How many, by reason."""
    first: dict[str, str] = field(default_factory=dict)
    """Where each reason was first met."""
    notes: list[str] = field(default_factory=list)
    """What else is worth knowing, a line each."""
    noted: Counter[str] = field(default_factory=Counter)
    """How often something of which the first place is enough was met, by what it is."""
    first_noted: dict[str, str] = field(default_factory=dict)
    """The line on its first place."""
    used: int = 0
    """How many frames could be used, before any resampling."""

    @property
    def most(self) -> bool:
        """Whether more of the frames were refused than were kept."""
        late = self.counts['no_plane'] + self.counts['too_short']  # these could be used at first
        spare = self.counts['same_time'] + self.counts['earlier']  # beside one that is kept
        lost = self.counts.total() - spare
        return lost > self.used - late

    def add(self, reason: str, where: str, count: int = 1) -> None:
        """Count something that cannot be used, and where it stands."""
        self.counts[reason] += count
        self.first.setdefault(reason, where)

    def note(self, what: str, line: str, count: int = 1) -> None:
        """Count something that is used, and yet worth knowing; the first line is kept."""
        self.noted[what] += count
        self.first_noted.setdefault(what, line)

    def forget(self, what: str) -> None:
        """Leave out what was noted and has turned out not to be so."""
        self.noted.pop(what, None)
        self.first_noted.pop(what, None)

    def warn(self) -> tuple[str, ...]:
        """Return a line for each kind of what was noted, with its count."""
        return tuple(
            f'warning: {line}' + (f' ({self.noted[what]:,} in all)' if self.noted[what] > 1 else '')
            for what, line in self.first_noted.items()
        )


@dataclass(frozen=True, eq=False)
class Chunk:
    """Some frames of a motion, k of them in their order, and the messages around them."""

    stamps: Stamps
    """(k,) ns."""
    angles: Floats
    """(k, d) rad; of prismatic joints, m."""
    speeds: Floats
    """(k, d) rad/s or m/s; NaN where not known."""
    times: Stamps
    """(k,) ns, when each was recorded."""
    share: float
    """How much of the recording has been read with it, 0 to 1."""
    records: Sequence[Any] = ()
    """A bag's own messages, (connection, time, bytes), all of them."""
    follows: Sequence[int] = ()
    """(k,) the index in records of the message before each frame; -1: before all."""
    poses: Floats | None = None
    """(k, bones, 3, 4) where the bones were measured: the angles then follow from them."""

    def select(self, which: Bools | slice) -> Chunk:
        """Return the chunk with some of its frames only; the messages stay all."""
        return replace(
            self,
            stamps=self.stamps[which],
            angles=self.angles[which],
            speeds=self.speeds[which],
            times=self.times[which],
            poses=None if self.poses is None else self.poses[which],
            follows=np.array(self.follows, dtype=np.int64)[which].tolist(),
        )


class Place(NamedTuple):
    """A message among those that are read."""

    number: int
    """From 1."""
    time: int
    """When it was recorded, ns."""
    instead: int | None = None
    """The stamp that counts, ns, where its own was not filled in (0)."""


class Refused(NamedTuple):
    """A frame that cannot be used, and the message that is the reason."""

    reason: str
    text: str
    place: Place


class Frame(NamedTuple):
    """One frame of a motion."""

    stamp: int
    """ns"""
    place: Place
    """The message that brought it."""
    angles: JointValues
    """(d) rad; of prismatic joints, m."""
    speeds: JointValues | None = None
    """(d) rad/s or m/s; None where not known."""
    poses: Floats | None = None
    """(k, 3, 4) of the bones, where they were measured: the angles then follow from them."""


class Motion(Protocol):
    """A recording of joint angles."""

    path: Path
    refused: Refusals

    unit: AngleUnit
    met: AngleRange
    """The angles that were met in the recording, where nobody says their unit."""
    keeps_records: bool
    """Whether a bag's own messages are wanted with the frames."""
    wants_speeds: bool
    """Whether velocities are wanted; where not, those that are no recorded ones are left out."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What was read, in which units, and where the velocities come from."""

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames."""


def seconds_to_nanoseconds(times: Floats) -> Stamps:
    """Return times (m,), s, in ns; RecordingError for times that cannot be seconds."""
    if len(times) and np.abs(times).max() > LATEST:
        worst = times[np.abs(times).argmax()]
        raise RecordingError(f'time {worst:g}: more than {LATEST:g} s; ms?')
    return np.asarray(np.rint(times * 1e9), dtype=np.int64)
