"""What the plots remember: the last seconds, and the newest value at each degree."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...types import Floats, Interval


class Recent:
    """The newest rows of numbers, each with its time; the oldest make way."""

    def __init__(self, width: int, most: int) -> None:
        """Keep so many rows of `width` numbers at most."""
        self._rows = np.full((most, 1 + width), np.nan)
        self._count = 0

    def add(self, time: float, values: npt.ArrayLike) -> None:
        """Take a row in, later than the one before; a row of an earlier time begins anew."""
        most = len(self._rows)
        if self._count and time < self._rows[(self._count - 1) % most, 0]:
            self._count = 0
        row = self._rows[self._count % most]
        row[0], row[1:] = time, values
        self._count += 1

    def last(self, seconds: float) -> Floats:
        """Return the rows (k, 1 + width) of the last seconds, oldest first: time and values."""
        most = len(self._rows)
        if self._count <= most:
            rows = self._rows[: self._count]
        else:
            rows = np.roll(self._rows, -(self._count % most), axis=0)
        return np.asarray(rows[rows[:, 0] >= rows[-1, 0] - seconds]) if len(rows) else rows


class Curve:
    """The newest row of numbers at each step of a coordinate: a curve, whichever way it was gone.

    The muscle's state is a function of the pose alone, so while the other coordinates rest each
    step has one value.
    """

    def __init__(self, width: int, low: float, high: float, step: float) -> None:
        """Keep `width` numbers for each step from low to high; what lies beyond is left out."""
        self._low, self._step = low, step
        self._rows = np.full((round((high - low) / step) + 1, 1 + width), np.nan)

    def add(self, place: float, values: npt.ArrayLike) -> None:
        """Take a row in."""
        k = round((place - self._low) / self._step)
        if 0 <= k < len(self._rows):
            self._rows[k, 0], self._rows[k, 1:] = place, values

    def known(self) -> Floats:
        """Return the rows (k, 1 + width) in order: where the coordinate was, and the numbers."""
        return np.asarray(self._rows[np.isfinite(self._rows[:, 0])])


def side_by_side(curves: Sequence[Floats]) -> Floats:
    """Return curves (k, 1 + w) as one table: all their places in order, and the numbers of each.

    Between its places a curve is straight; before and behind them its numbers are NaN.
    """
    places = np.unique(np.concatenate([curve[:, 0] for curve in curves]))
    columns = [places]
    for curve in curves:
        for numbers in curve[:, 1:].T:
            if len(curve):
                columns.append(np.interp(places, curve[:, 0], numbers, np.nan, np.nan))
            else:
                columns.append(np.full(len(places), np.nan))
    return np.column_stack(columns)


def widened(before: Interval | None, values: npt.ArrayLike, step: float) -> Interval | None:
    """Return a range in round steps that holds all values, with room, and the range before.

    NaN does not count; None if there is nothing but NaN.
    """
    finite = np.asarray(values)[np.isfinite(values)]
    if not finite.size:
        return before
    room = 0.1 * step
    low = step * math.floor((float(finite.min()) - room) / step)
    high = step * math.ceil((float(finite.max()) + room) / step)
    return (low, high) if before is None else (min(low, before[0]), max(high, before[1]))
