# SPDX-License-Identifier: Apache-2.0
"""Stretches: the parts of a recording in which time goes on, with no difference across their ends.

Where time falls back (a player that starts again, a simulation that is reset, tables put one behind
the other), a new stretch begins.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..types import Floats, Stamps
from .filters import differentiate
from .motion import Refusals

Times = Floats | Stamps
FALLS = 'falls'  # what is noted


def split_stretches(times: Times) -> Iterator[slice]:
    """Yield the parts of times (m,) between which they fall back."""
    starts = 1 + np.flatnonzero(np.diff(times) < 0)
    for start, stop in pairwise([0, *starts.tolist(), len(times)]):
        yield slice(start, stop)


def differentiate_stretches(times: Floats, angles: Floats) -> Floats:
    """Return the velocities of angles that may pass pi, each stretch by itself.

    Parameters
    ----------
    times
        (m,) s.
    angles
        (m, 3) rad.

    Returns
    -------
    speeds
        (m, 3) rad/s, at both ends of a stretch from one side; NaN where a time is repeated, and for
        a frame between two falls. A recording of one frame is at rest.
    """
    if len(times) == 1:
        return differentiate(times, angles)
    speeds = np.full(angles.shape, np.nan)
    for part in split_stretches(times):
        if part.stop - part.start > 1:
            with np.errstate(divide='ignore', invalid='ignore'):  # times that stand still
                speeds[part] = differentiate(times[part], np.unwrap(angles[part], axis=0))
    speeds[~np.isfinite(speeds).all(axis=1)] = np.nan
    return speeds


def choose_timely(stamps: Stamps, late: float) -> npt.NDArray[np.bool_]:
    """Return which frames are not late: not up to `late` ns behind an earlier one of their stretch.

    Stamps of several publishers may come a little out of order; that is no fall of the time.
    """
    timely = np.ones(len(stamps), dtype=np.bool_)
    if not len(stamps) or not (np.diff(stamps) < 0).any():
        return timely
    newest = stamps[0]
    for k, stamp in enumerate(stamps.tolist()):
        timely[k] = not 0 < newest - stamp <= late
        if timely[k]:
            newest = stamp
    return timely


class TimeWatch:
    """Notices, chunk by chunk, where the stamps of a recording fall back.

    Parameters
    ----------
    refused
        Where it is noted.
    place
        What a frame comes from: row or message.
    """

    def __init__(self, refused: Refusals, place: str) -> None:
        """Begin before the first frame."""
        self._refused, self._place = refused, place
        self._last: list[int] = []

    def check(self, stamps: Stamps, numbers: Sequence[int]) -> None:
        """Note the falls in further stamps (k,), ns, of the rows or messages of these numbers."""
        joined = np.array([*self._last, *stamps.tolist()], dtype=np.int64)
        known = len(self._last)
        self._last = joined[-1:].tolist()
        for k in (1 + np.flatnonzero(np.diff(joined) < 0)).tolist():
            before, after = map(format_seconds, joined[k - 1 : k + 1].tolist())
            where = f'at {self._place} {numbers[k - known]}: no difference or filter goes across'
            self._refused.note(FALLS, f'time falls back from {before} s to {after} s {where}')


def format_seconds(nanoseconds: int) -> str:
    """Return a time in s, exact, without zeros at its end."""
    whole, part = divmod(abs(nanoseconds), 10**9)
    text = f'{whole}.{part:09d}'.rstrip('0').rstrip('.')
    return f'-{text}' if nanoseconds < 0 else text
