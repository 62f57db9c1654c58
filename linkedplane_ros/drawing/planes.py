# SPDX-License-Identifier: Apache-2.0
"""The bands' planes as patches to look at: rectangles from the straight line to the bulge."""

from __future__ import annotations

import math

import numpy as np

from ..linked_planes.vectors import cross, dot, minus, mix, norm, plus, times
from ..solver.states import MuscleState
from ..types import Floats


def plane_patches(state: MuscleState, width: float) -> Floats:
    """Return the corners of a patch of each band's plane.

    The chain of the planes is that of thesis ch. 4, App. B: each is turned by phi from the normal
    of the one before.

    Parameters
    ----------
    state
        The muscle at a pose.
    width
        m, from the line between origin and insertion towards the bulge.

    Returns
    -------
    corners
        (n, 4, 3) m, scapula frame: origin P and insertion S; then S and P, moved by `width`.
    """
    muscle = state.solver.muscle
    angles = [state.theta, *muscle.plane_angles[1:].tolist()]
    bones, bands = muscle.bones, len(muscle.band_names)
    origins = state.place_points(muscle.origins, bones.of_bands('origin', bands)).tolist()
    insertions = state.place_points(muscle.insertions, bones.of_bands('insertion', bands)).tolist()
    N = muscle.reference_normal[np.newaxis]
    n = tuple(state.place_points(N, [bones.reference_normal], shift=False)[0].tolist())
    corners = []
    for P, S, phi in zip(origins, insertions, angles, strict=True):
        line = minus(S, P)
        u = times(1.0 / norm(line), line)
        m = mix(1.0, n, -dot(n, u), u)
        m = times(1.0 / norm(m), m)
        n = mix(math.cos(phi), m, math.sin(phi), cross(u, m))
        e = times(width, cross(u, n))
        corners.append((P, S, plus(S, e), plus(P, e)))
    return state.solver.to_side(np.array(corners))
