# SPDX-License-Identifier: Apache-2.0
"""The single sphere (Garner and Pandy 2000; thesis ch. 3): a band in the plane of P, S and C.

The plane of the attachments and the centre cuts the sphere in a great circle, and the band takes
the shorter side of it. A sphere has no side of its own, so nothing holds a band on one: when the
line from P to S passes the centre, the band changes over, and near there it slips quickly.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from ..linked_planes.band import CLEAR, INSIDE, PIERCED, WRAPPED, obstacle_kind, wrap
from ..linked_planes.compilation import compiled
from ..linked_planes.layout import vector
from ..linked_planes.vectors import ZERO, Rotation, Vector, cross, dot, minus, mix, norm, times
from .bands import PathModel
from .fields import Bone
from .path import (
    NO_ARC,
    OBSTACLE,
    Arc,
    BandRow,
    ObstaclePath,
    across,
    ends,
    make_kernel,
    moment_of,
    placed,
    straight_path,
)


@compiled
def round_sphere(P: Vector, S: Vector, C: Vector, R: float, on_humerus: float) -> ObstaclePath:
    """Return the shorter path from P to S round a sphere, in the plane of P, S and C."""
    line, p = minus(S, P), minus(C, P)
    D = norm(line)
    u = times(1.0 / max(D, 1e-300), line)
    a, pu = dot(p, u), cross(p, u)
    rho2 = dot(pu, pu)
    kind = obstacle_kind(D, a, rho2, R)
    if kind != PIERCED:
        return straight_path(P, S, INSIDE if kind == INSIDE else CLEAR)
    rho = sqrt(rho2)
    # the side of the bulge, away from the centre; any side if the line meets it
    e = times(1.0 / rho, minus(times(a, u), p)) if rho > 1e-12 * R else across(u)
    tP = sqrt(max(rho2 + a * a - R * R, 0.0))
    tS = sqrt(max(rho2 + (D - a) * (D - a) - R * R, 0.0))
    r, turn, t1u, t1e, t2u, t2e = wrap(D, a, tP, tS, R, 0.0, -rho)
    t1, t2 = mix(t1u, u, t1e, e), mix(t2u, u, t2e, e)
    arc = Arc(mix(1.0, P, tP, t1), C, cross(e, u), turn, 0.0)
    moment = moment_of(P, t1, on_humerus, ZERO, ZERO, on_humerus, S, t2)
    return ObstaclePath(tP + r * turn + tS, WRAPPED, 1, moment, arc, NO_ARC)


@compiled
def sphere(row: BandRow, rotation: Rotation) -> ObstaclePath:
    """Return the path of a band of P, S, C, radius, on the humerus."""
    P, S = ends(row, rotation)
    R, on_humerus = row[OBSTACLE + 3], row[OBSTACLE + 4]
    return round_sphere(P, S, placed(rotation, on_humerus, vector(row, OBSTACLE)), R, on_humerus)


@dataclass(frozen=True)
class Sphere(PathModel):
    """A sphere that is fixed to a bone; the band takes its shorter side.

    WRAPPED; CLEAR: the line passes it; INSIDE where an end lies in it.
    """

    centre: Vector
    """In the frame of its bone."""
    radius: float
    """m"""
    bone: Bone
    """'scapula' or 'humerus'."""
    kernel = make_kernel(sphere)
