# SPDX-License-Identifier: Apache-2.0
"""The JointStates of a bag, to be played."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from ...errors import RecordingError
from .connections import RecordedMessage
from .opening import open_bag
from .topics import JOINT_STATE


@dataclass(frozen=True)
class Recording:
    """A rosbag2 recording that holds JointStates; its messages stay on disk until asked for."""

    path: Path
    topics: tuple[str, ...]
    """The topics of its JointStates, without those that have none."""
    start: int
    """The time of its first message of any kind, ns since the epoch."""
    end: int
    """The time of its last message of any kind, ns since the epoch."""
    count: int
    """How many JointStates it holds."""
    faults: tuple[str, ...] = ()
    """What is damaged in it and left out, a line each, as far as opening it shows."""

    @staticmethod
    def from_bag(path: str | Path) -> Recording:
        """Return what a bag holds.

        Parameters
        ----------
        path
            The bag's folder, or an .mcap or .db3 file.

        Raises
        ------
        RecordingError
            If it cannot be read, or holds no JointState.
        """
        path = Path(path)
        with closing(open_bag(path)) as bag:
            chosen = [c for c in bag.connections if c.kind == JOINT_STATE]
            count = sum(c.msgcount for c in chosen)
            if not count:
                kinds = ', '.join(sorted({c.kind for c in bag.connections})) or 'nothing'
                raise RecordingError(f'{path}: no {JOINT_STATE} in it, but {kinds}')
            topics = tuple(sorted({c.topic for c in chosen if c.msgcount}))
            return Recording(path, topics, bag.start_time, bag.end_time, count, tuple(bag.faults))

    def messages(self, start_offset: float = 0.0) -> Iterator[RecordedMessage]:
        """Yield the JointStates in recorded order.

        Parameters
        ----------
        start_offset
            Where to begin, s after the recording's start.

        Raises
        ------
        RecordingError
            Where the bag is damaged.
        """
        begin = self.start + round(1e9 * start_offset)
        with closing(open_bag(self.path)) as bag:
            chosen = [c for c in bag.connections if c.kind == JOINT_STATE]
            known = len(bag.faults)
            yield from bag.messages(chosen, start=begin)
            if met := bag.faults[known:]:
                raise RecordingError(f'{self.path}: damaged: {met[0]}')
