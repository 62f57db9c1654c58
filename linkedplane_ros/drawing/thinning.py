# SPDX-License-Identifier: Apache-2.0
"""Long recordings with few points: what a line or a strip on a page can show."""

from __future__ import annotations

import numpy as np

from ..types import Bools, Floats

CELLS = 2000  # along a strip of wrap states


def thin_points(x: Floats, y: Floats, most: int) -> tuple[Floats, Floats]:
    """Return some of many points, such that the line through them looks the same.

    Of each of up to most // 5 runs of frames there remain the least and greatest y, the least and
    greatest x (over time: the ends of the run) and, if it has a gap, a NaN.

    Parameters
    ----------
    x, y
        (m,)
    most
        How many points are left at most, 5 or more.

    Returns
    -------
    x, y
        The points left, in their order.
    """
    m = len(x)
    if m <= most:
        return x, y
    run = -(-m // (most // 5))
    filled = np.pad(np.stack((x, y)), ((0, 0), (0, -m % run)), mode='edge').reshape(2, -1, run)
    gap = np.isnan(filled).any(axis=0)
    places = np.concatenate(
        [gap.argmax(axis=1)]
        + [np.where(gap, np.inf, values).argmin(axis=1) for values in filled]
        + [np.where(gap, -np.inf, values).argmax(axis=1) for values in filled]
    )
    kept = np.unique(np.minimum(places + run * np.tile(np.arange(filled.shape[1]), 5), m - 1))
    return x[kept], y[kept]


def covered_intervals(x: Floats, here: Bools) -> list[tuple[float, float]]:
    """Return where `here` holds at any frame: stretches of x.

    A frame lasts until the next one. x is divided into CELLS cells, so there are never many
    stretches.

    Parameters
    ----------
    x, here
        (m,)

    Returns
    -------
    stretches
        The start and the width of each.
    """
    begin, end = x[here], np.append(x[1:], np.nan)[here]
    if not len(begin):
        return []
    low, high = np.fmin(begin, end), np.fmax(begin, end)
    start = low.min()
    cell = max((high.max() - start) / CELLS, 1e-9)
    first, last = (np.minimum((ends - start) / cell, CELLS - 1).astype(int) for ends in (low, high))
    entered, left = (np.bincount(cells, minlength=CELLS + 1) for cells in (first, last + 1))
    edges = np.flatnonzero(np.diff(np.cumsum(entered - left) > 0, prepend=False))
    return [(start + cell * a, cell * (b - a)) for a, b in edges.reshape(-1, 2).tolist()]
