"""A motion filtered, or brought to another rate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .bag_motion import BagMotion
from .motion import ROWS, Chunk, Motion, Stamps, in_nanoseconds
from .recordings import RecordingError
from .tables import differentiated, lowpassed, resampled

Floats = npt.NDArray[np.float64]


class Smoothed:
    """A motion filtered and brought to a constant rate; it holds the whole of its angles.

    The messages of a bag, where they are wanted, are kept among the new frames.
    """

    def __init__(self, motion: Motion, rate: float | None, cutoff: float | None) -> None:
        """`rate`, Hz, or None: as recorded, which has to be even to be filtered; `cutoff`, Hz."""
        self.motion, self.rate, self.cutoff = motion, rate, cutoff
        self.path, self.refused = motion.path, motion.refused
        self.keeps_records = isinstance(motion, BagMotion)
        self.facts: Mapping[str, str] = {**motion.facts, 'velocities': 'differentiated'}

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames at their new times, with velocities by differences."""
        self.motion.keeps_records = False
        parts = [(c.stamps, c.times, c.angles) for c in self.motion.chunks() if len(c.stamps)]
        if not parts:
            return
        stamps, recorded, angles = (np.concatenate(each) for each in zip(*parts, strict=True))
        start, whole = int(stamps[0]), 1e-9 * (stamps - stamps[0])
        try:
            times, angles = self._smoothed(whole, angles)
        except ValueError as error:
            raise RecordingError(f'{self.path}: {error}') from None
        behind = np.interp(times, whole, 1e-9 * (recorded - stamps))  # recorded, after its stamp
        stamps = start + in_nanoseconds(times)
        written = np.maximum.accumulate(stamps + in_nanoseconds(behind))
        frames = Chunk(stamps, angles, differentiated(times, angles), written, 1.0)
        if isinstance(self.motion, BagMotion) and self.keeps_records:
            yield from among(frames, self.motion.records())
            return
        for k in range(0, len(stamps), ROWS):
            which, share = slice(k, k + ROWS), min((k + ROWS) / len(stamps), 1.0)
            yield part(frames, which, share, (), np.full(len(stamps[which]), -1))

    def _smoothed(self, times: Floats, angles: Floats) -> tuple[Floats, Floats]:
        """Return times (k,), s, and angles (k, 3), rad, filtered, then resampled."""
        rate = self.rate or steady_rate(times)
        # as many samples as were recorded are filtered, then brought to the rate asked for
        if self.cutoff is not None:
            own = (len(times) - 1) / times[-1] if len(times) > 1 and times[-1] > 0.0 else rate
            times, angles = resampled(times, angles, own)
            angles = lowpassed(angles, own, self.cutoff)
        if self.rate is not None:
            times, angles = resampled(times, angles, rate)
        return times, angles


def among(frames: Chunk, batches: Iterator[tuple[float, list[Any]]]) -> Iterator[Chunk]:
    """Yield the frames with the messages of a bag, each behind those recorded before it."""
    given = 0
    for share, records in batches:
        recorded = np.array([time for _, time, _ in records], dtype=np.int64)
        # those after the last of these messages wait for the next
        end = len(frames.times)
        if share < 1.0:
            end = int(np.searchsorted(frames.times, recorded[-1], side='right'))
        follows = np.searchsorted(recorded, frames.times[given:end], side='right') - 1
        first = 0
        for start in range(given, max(end, given + 1), ROWS):
            stop = min(start + ROWS, end)
            behind = follows[start - given : stop - given]
            upto = len(records) if stop == end else int(behind[-1]) + 1
            yield part(frames, slice(start, stop), share, records[first:upto], behind - first)
            first = upto
        given = end


def part(
    frames: Chunk, which: slice, share: float, records: Sequence[Any], follows: Stamps
) -> Chunk:
    """Return some of the frames, and the messages that they stand among."""
    return Chunk(
        frames.stamps[which],
        frames.angles[which],
        frames.speeds[which],
        frames.times[which],
        share,
        records,
        follows.tolist(),
    )


def steady_rate(times: Floats) -> float:
    """Return the rate, Hz, of evenly spaced times (m,), s; ValueError for others."""
    steps = np.diff(times)
    if len(steps) and 0.0 < steps.min() and steps.max() < 1.5 * np.median(steps):
        return float(1.0 / np.median(steps))
    raise ValueError('the recording is not evenly spaced in time; give a --rate, too')
