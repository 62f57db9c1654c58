# SPDX-License-Identifier: Apache-2.0
"""How deep the bands enter the interference spheres, and where (thesis ch. 5, Table 5.1).

A band interferes where any part of its path touches or enters a sphere. The paths are taken as
they are, two straight parts and an arc between them, not as the polylines that are drawn.
"""

from __future__ import annotations

import numpy as np

from ..linked_planes.band import WRAPPED
from ..types import Floats
from .states import MuscleState

SHORT = 5e-5  # m: a shorter half arc has no circle, which would be 1e-7 m off


def depths(state: MuscleState) -> tuple[Floats, Floats]:
    """Return how deep each of n bands enters each of k interference spheres, and where.

    Returns
    -------
    depths : Floats
        (n, k) m: the sphere's radius less the distance of the path from its centre; negative: the
        distance to the sphere.
    places : Floats
        (n, k, 3) m, scapula frame: the points of the paths that are closest to the centres.

    """
    muscle = state.solver.muscle
    centres = state.interference_centres
    places = closest_points(state, centres)
    return muscle.interference_radii - np.linalg.norm(places - centres, axis=-1), places


def closest_points(state: MuscleState, centres: Floats) -> Floats:
    """Return the points (n, k, 3) of the n paths that are closest to the centres (k, 3), m."""
    n = len(state.lengths)
    P = state.origins
    S, _, arcs = state.solver.draw_bands(state, 3)
    # a straight band is its line from P to S, and nothing more at S
    straight = state.wrap[:, np.newaxis] != WRAPPED
    Q, M, T = (np.where(straight, S, arcs[:, j]) for j in range(3))
    lines = closest_on_lines(np.concatenate((P, T)), np.concatenate((Q, S)), centres)
    candidates = np.stack((lines[:n], lines[n:], closest_on_arcs(Q, M, T, centres)))
    best = squared_lengths(candidates - centres).argmin(axis=0)
    return np.asarray(np.take_along_axis(candidates, best[np.newaxis, ..., np.newaxis], axis=0)[0])


def closest_on_lines(A: Floats, B: Floats, centres: Floats) -> Floats:
    """Return the points (n, k, 3) of the lines from A to B (n, 3) closest to centres (k, 3)."""
    along = B - A
    size = np.maximum(squared_lengths(along), 1e-30)[:, np.newaxis]
    t = (along @ centres.T - np.sum(A * along, axis=1, keepdims=True)) / size
    offsets: Floats = np.clip(t, 0.0, 1.0)[..., np.newaxis] * along[:, np.newaxis]
    return A[:, np.newaxis] + offsets


def closest_on_arcs(Q: Floats, M: Floats, T: Floats, centres: Floats) -> Floats:
    """Return the points (n, k, 3) of the arcs from Q over their middle M to T closest to centres.

    M where the closest point of the circle lies beyond the arc, so that Q or T, ends of the
    straight parts, is closer than any other of the arc; and for an arc too short for a circle.
    """
    side, up = T - Q, M - 0.5 * (Q + T)
    width, height = np.sqrt(squared_lengths(side)), np.sqrt(squared_lengths(up))
    bent = (width > SHORT) & (height > 0.0)
    width, height = np.where(bent, width, 1.0), np.where(bent, height, 1.0)
    e1, e2 = up / height[:, np.newaxis], side / width[:, np.newaxis]  # from the centre to M; across
    r = squared_lengths(M - Q) / (2.0 * height)
    o = M - r[:, np.newaxis] * e1
    w = centres - o[:, np.newaxis]
    x, y = np.einsum('nki,ni->nk', w, e1), np.einsum('nki,ni->nk', w, e2)
    size = np.hypot(x, y)
    on = (bent & (r > 0.0))[:, np.newaxis] & (size > 0.0)
    on &= x * r[:, np.newaxis] >= size * (r - height)[:, np.newaxis]  # nearer to M than Q and T
    reach = np.where(on, r[:, np.newaxis] / np.where(on, size, 1.0), 0.0)
    turned = x[..., np.newaxis] * e1[:, np.newaxis] + y[..., np.newaxis] * e2[:, np.newaxis]
    point = o[:, np.newaxis] + reach[..., np.newaxis] * turned
    return np.where(on[..., np.newaxis], point, M[:, np.newaxis])


def squared_lengths(vectors: Floats) -> Floats:
    """Return the squared lengths of vectors (..., 3)."""
    return np.asarray(np.einsum('...i,...i->...', vectors, vectors))
