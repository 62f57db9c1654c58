"""The bands' planes as patches to look at: rectangles from the line to the side of the bulge."""

from __future__ import annotations

import math

import numpy as np

from ..linked_planes.vectors import cross, dot, minus, mix, norm, plus, times
from ..solver.linked_plane_solver import MuscleState
from ..types import Floats


def patches(state: MuscleState, width: float) -> Floats:
    """Return the corners (n, 4, 3) of a patch of each band's plane, m, scapula frame.

    In turn origin P and insertion S; then, so much farther towards e, S and P. The chain of the
    planes is that of thesis ch. 4, App. B: each turned by phi from the normal of the one before.
    """
    muscle = state.solver.muscle
    angles = [state.theta, *muscle.plane_angles[1:].tolist()]
    insertions = (muscle.insertions @ state.rotation.T).tolist()
    n = tuple(muscle.reference_normal.tolist())
    corners = []
    for P, S, phi in zip(muscle.origins.tolist(), insertions, angles, strict=True):
        line = minus(S, P)
        u = times(1.0 / norm(line), line)
        m = mix(1.0, n, -dot(n, u), u)
        m = times(1.0 / norm(m), m)
        n = mix(math.cos(phi), m, math.sin(phi), cross(u, m))
        e = times(width, cross(u, n))
        corners.append((P, S, plus(S, e), plus(P, e)))
    return state.solver.mirrored(np.array(corners))
