# SPDX-License-Identifier: Apache-2.0
"""The numbers in the plots: of the last seconds, and the newest at each degree."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...types import Floats, Interval


class Recent:
    """The newest rows of numbers, each with its time."""

    def __init__(self, width: int, most: int) -> None:
        """Keep `most` rows of `width` numbers."""
        self._rows = np.full((most, 1 + width), np.nan)
        self._count = 0

    def add(self, time: float, values: npt.ArrayLike) -> None:
        """Add a row; one of an earlier time than the last clears the others."""
        most = len(self._rows)
        if self._count and time < self._rows[(self._count - 1) % most, 0]:
            self._count = 0
        row = self._rows[self._count % most]
        row[0], row[1:] = time, values
        self._count += 1

    def rows_of_last(self, seconds: float) -> Floats:
        """Return the rows (k, 1 + width) of the last seconds, oldest first: time and values."""
        most = len(self._rows)
        if self._count <= most:
            rows = self._rows[: self._count]
        else:
            rows = np.roll(self._rows, -(self._count % most), axis=0)
        return np.asarray(rows[rows[:, 0] >= rows[-1, 0] - seconds]) if len(rows) else rows


class CoordinateCurve:
    """The newest row of numbers at each step of a coordinate: a curve.

    The muscle's state depends only on the pose, so each step has one value while the other
    coordinates rest.
    """

    def __init__(self, width: int, low: float, high: float, step: float) -> None:
        """Keep `width` numbers for each step from low to high; ignore others."""
        self._low, self._step = low, step
        self._rows = np.full((round((high - low) / step) + 1, 1 + width), np.nan)

    def add(self, place: float, values: npt.ArrayLike) -> None:
        """Add a row at a place of the coordinate."""
        k = round((place - self._low) / self._step)
        if 0 <= k < len(self._rows):
            self._rows[k, 0], self._rows[k, 1:] = place, values

    def known_rows(self) -> Floats:
        """Return the rows (k, 1 + width) in order: place and numbers."""
        return np.asarray(self._rows[np.isfinite(self._rows[:, 0])])


def merge_curves(curves: Sequence[Floats]) -> Floats:
    """Return curves (k, 1 + w) as one table: all their places in order, then the numbers of each.

    Between its places a curve is straight; outside of them its numbers are NaN.
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


def widen_range(before: Interval | None, values: npt.ArrayLike, step: float) -> Interval | None:
    """Return a range in round steps around all values, with room, and the range before.

    NaN is ignored; None if there are no other values and no range before.
    """
    finite = np.asarray(values)[np.isfinite(values)]
    if not finite.size:
        return before
    room = 0.1 * step
    low = step * math.floor((float(finite.min()) - room) / step)
    high = step * math.ceil((float(finite.max()) + room) / step)
    return (low, high) if before is None else (min(low, before[0]), max(high, before[1]))
