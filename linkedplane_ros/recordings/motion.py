"""A motion: a recording as chunks of joint angles, each with what it stood among."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..types import Floats, Stamps, Triple

LONGEST = 2.0**31  # s: a stamp holds no more
ROWS = 5000  # frames that are worked on at a time


@dataclass
class Refused:
    """What could not be used of a recording: how many by reason, and where first."""

    counts: Counter[str] = field(default_factory=Counter)
    first: dict[str, str] = field(default_factory=dict)

    def add(self, reason: str, where: str, count: int = 1) -> None:
        """Count what was met at a place."""
        self.counts[reason] += count
        self.first.setdefault(reason, where)


@dataclass(frozen=True, eq=False)
class Chunk:
    """Some frames of a motion, in their order, and what they stood among."""

    stamps: Stamps
    """(k,) ns."""
    angles: Floats
    """(k, 3) rad."""
    speeds: Floats
    """(k, 3) rad/s; NaN where not known."""
    times: Stamps
    """(k,) ns, when each was recorded."""
    share: float
    """How much of the recording has been read with it, 0 to 1."""
    records: Sequence[Any] = ()
    """A bag's own messages, (connection, time, bytes), all of them."""
    follows: Sequence[int] = ()
    """(k,) the record that each frame stands behind, -1: before them all."""

    def of(self, good: npt.NDArray[np.bool_]) -> Chunk:
        """Return the chunk with some of its frames alone; the records stay."""
        return Chunk(
            self.stamps[good],
            self.angles[good],
            self.speeds[good],
            self.times[good],
            self.share,
            self.records,
            [record for record, keep in zip(self.follows, good, strict=True) if keep],
        )


class Frame(NamedTuple):
    """One frame of a motion."""

    stamp: int
    """ns"""
    time: int
    """When it was recorded, ns."""
    angles: Triple
    """rad"""
    speeds: Triple | None = None
    """rad/s; None where not known."""


class Motion(Protocol):
    """A recording of joint angles."""

    path: Path
    refused: Refused

    keeps_records: bool
    """Whether a bag's own messages are wanted with the frames."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What was read, in which units, and where the velocities come from."""

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames."""


def in_nanoseconds(times: Floats) -> Stamps:
    """Return times (m,), s, as ns; ValueError for times that cannot be seconds."""
    if len(times) and np.abs(times).max() > LONGEST:
        raise ValueError(f'time {times[np.abs(times).argmax()]:g}: more than {LONGEST:g} s; ms?')
    return np.asarray(np.rint(times * 1e9), dtype=np.int64)
