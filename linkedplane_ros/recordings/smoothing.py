"""A motion filtered, or brought to another rate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import RecordingError
from ..types import Floats, Stamps
from .bag_motion import BagMotion, Batch
from .motion import ROWS, Chunk, Motion, in_nanoseconds
from .tables import PADDING, differentiated, lowpassed, resampled

GAP = 10.0  # usual steps: a longer one is not bridged
UNEVEN = 1.5  # mean steps: a longer one is uneven
JUMP = 1.5  # rad from frame to frame: no arm moves so


class Smoothed:
    """A motion filtered, brought to a constant rate, and differentiated in time.

    It holds the whole of its angles, and goes on after a gap as if it began anew. The messages of a
    bag, where they are wanted, are kept among the new frames.
    """

    def __init__(self, motion: Motion, rate: float | None, cutoff: float | None) -> None:
        """`rate`, Hz, or None: as recorded; `cutoff`, Hz, or None: not filtered."""
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
        later = self._later(stamps)
        stamps, recorded, angles = stamps[later], recorded[later], angles[later]
        times = 1e-9 * (stamps - stamps[0])
        made = [self._smoothed(times[one], angles[one]) for one in self._unbroken(times)]
        if not made:
            return
        new = np.concatenate([each for each, _, _ in made])
        late = np.interp(new, times, 1e-9 * (recorded - stamps))  # recorded, after its stamp
        stamps = stamps[0] + in_nanoseconds(new)
        frames = Chunk(
            stamps,
            np.concatenate([each for _, each, _ in made]),
            np.concatenate([each for _, _, each in made]),
            np.maximum.accumulate(stamps + in_nanoseconds(late)),
            1.0,
        )
        if isinstance(self.motion, BagMotion) and self.keeps_records:
            yield from among(frames, self.motion.records())
            return
        for k in range(0, len(stamps), ROWS):
            which, share = slice(k, k + ROWS), min((k + ROWS) / len(stamps), 1.0)
            yield part(frames, which, share, (), np.full(len(stamps[which]), -1))

    def _later(self, stamps: Stamps) -> npt.NDArray[np.intp]:
        """Return the frames whose stamps increase, the last of equal ones; count the others."""
        forward = stamps == np.maximum.accumulate(stamps)
        for k in np.flatnonzero(~forward)[:1]:
            where = f'frame {k + 1}, stamp {1e-9 * stamps[k]:.2f} s: earlier than one before it'
            self.refused.add('earlier', where, int((~forward).sum()))
        kept = np.flatnonzero(forward)
        return np.asarray(kept[np.append(np.diff(stamps[kept]) > 0, True)])

    def _unbroken(self, times: Floats) -> Iterator[slice]:
        """Yield the parts of increasing times (m,), s, between gaps; count those too short."""
        steps = np.diff(times)
        usual = np.median(steps) if len(steps) else 0.0
        ends = [0, *(1 + np.flatnonzero(steps > GAP * usual)).tolist(), len(times)]
        least = PADDING + 1 if self.cutoff is not None else 2 if self.rate is not None else 1
        for start, stop in pairwise(ends):
            if stop - start >= least:
                yield slice(start, stop)
                continue
            where = f'{times[start]:.2f} s: a stretch without gaps of {stop - start} frames'
            self.refused.add('too_short', f'{where}; at least {least} expected', stop - start)

    def _smoothed(self, times: Floats, angles: Floats) -> tuple[Floats, Floats, Floats]:
        """Return times (k,), s, angles (k, 3), rad, and velocities, of a motion without gaps."""
        try:
            angles = continuous(times, angles)
            if self.cutoff is not None:
                # as many samples as were recorded are filtered, then brought to the rate asked for
                own = (len(times) - 1) / (times[-1] - times[0])
                if self.rate is None and np.diff(times).max() > UNEVEN / own:
                    raise ValueError(
                        'the recording is not evenly spaced in time; give a --rate, too'
                    )
                times, angles = resampled(times, angles, own)
                angles = lowpassed(angles, own, self.cutoff)
            if self.rate is not None:
                times, angles = resampled(times, angles, self.rate)
        except ValueError as error:
            raise RecordingError(f'{self.path}: {error}') from None
        return times, angles, differentiated(times, angles)


def continuous(times: Floats, angles: Floats) -> Floats:
    """Return angles (m, 3), rad, that cross from pi to -pi as ones that go on beyond pi.

    ValueError where they jump nevertheless, as at a convention's singularity: what comes of a
    filter there is no pose of the arm.
    """
    angles = np.unwrap(angles, axis=0)
    steps = np.abs(np.diff(angles, axis=0)).max(axis=1, initial=0.0)
    for k in np.flatnonzero(steps > JUMP)[:1]:
        raise ValueError(
            f'an angle jumps by {steps[k]:.2f} rad at {times[k]:.2f} s, as at a singularity of the '
            'convention: nothing is to be filtered or resampled across it; another --convention?'
        )
    return angles


def among(frames: Chunk, batches: Iterator[Batch]) -> Iterator[Chunk]:
    """Yield the frames with the messages of a bag, each behind those recorded before it."""
    given = 0
    for records, share, last in batches:
        recorded = np.array([time for _, time, _ in records], dtype=np.int64)
        # those after the last of these messages wait for the next
        end = len(frames.times)
        if not last:
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
