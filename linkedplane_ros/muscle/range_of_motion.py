# SPDX-License-Identifier: Apache-2.0
"""Which rotations lie in a range of flexion, abduction and rotation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..types import Bools, Floats, Interval

TOLERANCE = 1e-6  # rad: limits stand in model files with seven digits
SINGULAR = 1e-6  # cosine of the abduction below which rounding spoils flexion and rotation


def find_in_range(rotations: Floats, ranges: Sequence[Interval]) -> Bools:
    """Return which rotations are given by some triple of angles in a range.

    Two triples give a rotation, but at 90 deg of abduction, up or down, any that turn by the same
    in all: there flexion and rotation are about one axis.

    Parameters
    ----------
    rotations
        (m, 3, 3) R(x, flexion) R(-y, abduction) R(z, rotation).
    ranges
        The lowest and highest flexion, abduction and rotation, rad.

    Returns
    -------
    Bools
        (m,)
    """
    R = rotations
    cosine = np.hypot(R[:, 1, 2], R[:, 2, 2])
    flexion = np.arctan2(-R[:, 1, 2], R[:, 2, 2])
    abduction = np.arctan2(-R[:, 0, 2], cosine)
    rotation = np.arctan2(-R[:, 0, 1], R[:, 0, 0])
    within = lie_between((flexion, abduction, rotation), ranges)
    if within.all() and (cosine >= SINGULAR).all():  # the rest takes most of the time
        return within
    within |= lie_between((flexion + np.pi, np.pi - abduction, rotation + np.pi), ranges)
    up = np.sign(abduction)
    (low_f, high_f), limits, (low_r, high_r) = ranges
    turn = np.arctan2(R[:, 1, 0], R[:, 1, 1])  # rotation - flexion; with the abduction down, + it
    least = np.where(up > 0.0, low_r - high_f, low_r + low_f)
    most = np.where(up > 0.0, high_r - low_f, high_r + high_f)
    upright = lies_between(up * np.pi / 2.0, *limits) & lies_between(turn, least, most)
    return np.asarray(np.where(cosine < SINGULAR, upright, within), dtype=bool)


def lie_between(angles: Sequence[Floats], ranges: Sequence[Interval]) -> Bools:
    """Return which of three angles, (m,) each, lie in their intervals all at once."""
    pairs = zip(angles, ranges, strict=True)
    return np.asarray(np.all([lies_between(a, *limits) for a, limits in pairs], axis=0), dtype=bool)


def lies_between(angles: Floats, low: Floats | float, high: Floats | float) -> Bools:
    """Return which angles (m,) lie in an interval, or do so after whole turns."""
    above = (angles - low + TOLERANCE) % (2.0 * np.pi)
    return np.asarray(above <= high - low + 2.0 * TOLERANCE, dtype=bool)
