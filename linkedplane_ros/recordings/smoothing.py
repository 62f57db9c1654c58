# SPDX-License-Identifier: Apache-2.0
"""A motion filtered, or brought to another rate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..errors import RecordingError
from ..types import Bools, Floats, Stamps
from .bag_motion import BagMotion, Batch
from .filters import PADDING, differentiate, filter_lowpass, resample
from .motion import ROWS, Chunk, Motion, seconds_to_nanoseconds
from .stretches import FALLS, choose_timely, format_seconds, split_stretches

LATE = 0.5  # usual steps: a frame so far behind another is late; further, time has fallen back
GAP = 10.0  # usual steps: a longer one is not bridged
UNEVEN = 1.5  # mean steps: a longer one is uneven
JUMP = 1.5  # rad from frame to frame: no arm moves so


class SmoothedMotion:
    """A motion filtered, brought to a constant rate, and differentiated in time.

    All its angles are in memory at a time; after a gap, and where time falls back, it starts again.
    The messages of a bag, where they are wanted, are kept among the new frames.

    Parameters
    ----------
    motion
        What was recorded.
    rate
        Hz, to resample at; None: as recorded.
    cutoff
        Hz, of the low-pass filter; None: not filtered.
    """

    def __init__(self, motion: Motion, rate: float | None, cutoff: float | None) -> None:
        """Keep what is to be done; the motion is read by `chunks`."""
        self.motion, self.rate, self.cutoff = motion, rate, cutoff
        self.path, self.refused = motion.path, motion.refused
        self.unit, self.met = motion.unit, motion.met
        self.keeps_records = isinstance(motion, BagMotion)
        self.wants_speeds = True
        self.facts: Mapping[str, str] = {**motion.facts, 'velocities': 'differentiated'}

    def chunks(self) -> Iterator[Chunk]:
        """Yield the frames at their new times, with velocities by differences."""
        self.motion.keeps_records = self.motion.wants_speeds = False
        parts = [(c.stamps, c.times, c.angles) for c in self.motion.chunks() if len(c.stamps)]
        if not parts:
            return
        stamps, recorded, angles = (np.concatenate(each) for each in zip(*parts, strict=True))
        kept = self._find_usable(stamps)
        stamps, recorded, angles = stamps[kept], recorded[kept], angles[kept]
        if not (np.diff(stamps) < 0).any():
            self.refused.forget(FALLS)  # frames were late: nothing is split
        times = 1e-9 * (stamps - stamps[0])
        late = 1e-9 * (recorded - stamps)  # recorded, after its stamp
        stretches = []
        for one in self._stretches(times):
            first = stamps[one.start]
            old = 1e-9 * (stamps[one] - first)  # exact to ns, however far from the first stretch
            new, *smooth = self._smooth(old, angles[one], times[one.start], len(times))
            after = seconds_to_nanoseconds(np.interp(new, old, late[one]))
            stretches.append((first + seconds_to_nanoseconds(new), *smooth, after))
        if not stretches:
            return
        stamps, angles, speeds, after = map(np.concatenate, zip(*stretches, strict=True))
        frames = Chunk(stamps, angles, speeds, np.maximum.accumulate(stamps + after), 1.0)
        if isinstance(self.motion, BagMotion) and self.keeps_records:
            yield from merge_with_records(frames, self.motion.batches())
            return
        for k in range(0, len(stamps), ROWS):
            some = frames.select(slice(k, k + ROWS))
            share = min((k + ROWS) / len(stamps), 1.0)
            yield replace(some, share=share, follows=[-1] * len(some.stamps))

    def _find_usable(self, stamps: Stamps) -> Bools:
        """Return which frames count: none that is late, the last at a stamp; count the others."""
        steps = np.diff(stamps)
        usual = np.median(steps[steps > 0]) if (steps > 0).any() else 0.0
        timely = choose_timely(stamps, LATE * float(usual))
        places = np.flatnonzero(timely)
        repeated = np.zeros(len(stamps), dtype=np.bool_)
        repeated[places] = np.append(np.diff(stamps[places]) == 0, False)
        for reason, out, why in (
            ('earlier', ~timely, 'a little earlier than one before it'),
            ('same_time', repeated, 'that of a later frame, which counts'),
        ):
            if out.any():
                k = int(np.argmax(out))
                where = f'frame {k + 1}, stamp {format_seconds(int(stamps[k]))} s: {why}'
                self.refused.add(reason, where, int(out.sum()))
        return np.asarray(timely & ~repeated)

    def _stretches(self, times: Floats) -> Iterator[slice]:
        """Yield the parts of times (m,), s, between falls and gaps; count those too short."""
        steps = np.diff(times)
        usual = np.median(steps[steps > 0]) if (steps > 0).any() else 0.0
        gaps = 1 + np.flatnonzero(steps > GAP * usual)
        falls = [part.start for part in split_stretches(times)]
        ends = sorted({*falls, *gaps.tolist(), len(times)})
        least = PADDING + 1 if self.cutoff is not None else 2 if self.rate is not None else 1
        for start, stop in pairwise(ends):
            if stop - start >= least:
                yield slice(start, stop)
                continue
            where = f'{times[start]:.2f} s: a stretch without gaps of {stop - start} frames'
            self.refused.add('too_short', f'{where}; at least {least} expected', stop - start)

    def _smooth(
        self, times: Floats, angles: Floats, begin: float, frames: int
    ) -> tuple[Floats, Floats, Floats]:
        """Return times (k,), s, angles (k, 3), rad, and velocities, of a stretch of all frames.

        Times are since the stretch's begin, which is in s since the first frame.
        """
        try:
            angles = unwrap_angles(begin + times, angles)
            if self.cutoff is not None:
                # as many samples as were recorded are filtered, then brought to the rate asked for
                mean_rate = (len(times) - 1) / (times[-1] - times[0])
                if self.rate is None and np.diff(times).max() > UNEVEN / mean_rate:
                    raise RecordingError(
                        'the recording is not evenly spaced in time; give a --rate, too'
                    )
                times, angles = resample(times, angles, mean_rate)
                angles = filter_lowpass(angles, mean_rate, self.cutoff)
            if self.rate is not None:
                times, angles = resample(times, angles, self.rate)
        except RecordingError as error:
            raise RecordingError(f'{self.path}: {error}') from None
        if len(times) == 1 < frames:  # between two ends: its velocity is not known
            return times, angles, np.full(angles.shape, np.nan)
        return times, angles, differentiate(times, angles)


def unwrap_angles(times: Floats, angles: Floats) -> Floats:
    """Return angles (m, 3), rad, that cross from pi to -pi as ones that go on beyond pi.

    RecordingError where they still jump, as at a convention's singularity: the result of a filter
    there is no pose of the arm.
    """
    angles = np.unwrap(angles, axis=0)
    steps = np.abs(np.diff(angles, axis=0)).max(axis=1, initial=0.0)
    if (steps > JUMP).any():
        k = int(np.argmax(steps > JUMP))
        raise RecordingError(
            f'an angle jumps by {steps[k]:.2f} rad at {times[k]:.2f} s, as at a singularity of the '
            'convention; no filter and no --rate can cross it: try another --convention'
        )
    return angles


def merge_with_records(frames: Chunk, batches: Iterator[Batch]) -> Iterator[Chunk]:
    """Yield the frames with the messages of a bag, each behind those recorded before it."""
    given = 0
    for records, share, last in batches:
        recorded = np.array([time for _, time, *_ in records], dtype=np.int64)
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
            yield replace(
                frames.select(slice(start, stop)),
                share=share,
                records=records[first:upto],
                follows=(behind - first).tolist(),
            )
            first = upto
        given = end
