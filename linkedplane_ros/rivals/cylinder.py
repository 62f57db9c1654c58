# SPDX-License-Identifier: Apache-2.0
"""The single cylinder (Garner and Pandy 2000): a band right-handed about the axis, on a helix.

A cylinder has no ends here. Seen along the axis, the band runs around a circle; unrolled, it is one
straight line, so it rises along the axis in proportion to its length. The axis decides on which
side the band passes: from origin to insertion it turns right-handed about the axis. A band whose
line passes on the other side, even with the cylinder beyond one of its ends, is pulled around the
cylinder as long as it turns by less than half a circle. Beyond that, Garner and Pandy treat the
band as straight, and its length jumps: MISSED here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, sqrt
from typing import NamedTuple

from ..linked_planes.band import CLEAR, INSIDE, MISSED, WRAPPED
from ..linked_planes.compilation import compiled
from ..linked_planes.layout import vector
from ..linked_planes.vectors import (
    ZERO,
    Rotation,
    Vector,
    cross,
    dot,
    minus,
    mix,
    norm,
    plus,
    times,
)
from .bands import PathModel
from .fields import Bone
from .path import (
    NO_ARC,
    OBSTACLE,
    Arc,
    BandRow,
    ObstaclePath,
    ends,
    make_kernel,
    moment_of,
    on_arc,
    placed,
    straight_path,
)

CYLINDER_SIZE = 8  # of its numbers in a row
AT_SURFACE = 1e-12  # of the radius: an end so little below the surface lies on it


class Tube(NamedTuple):
    """A cylinder at a pose, scapula frame."""

    C: Vector  # on its axis
    w: Vector  # the axis, unit
    R: float
    on_humerus: float  # 1; 0 on the scapula


class TubePath(NamedTuple):
    """A band's path past a cylinder."""

    state: int  # WRAPPED, CLEAR or MISSED
    length: float
    after: float  # the length of the straight part from the cylinder to S
    t1: Vector  # unit tangents, from P and to S
    t2: Vector
    arc: Arc
    leaves: Vector  # where the arc ends; P if there is none
    meets: Vector  # where it starts; S if there is none


@compiled
def tube_at(row: BandRow, place: int, rotation: Rotation) -> Tube:
    """Return a cylinder: at a place of a band's row, C, w, radius, on the humerus."""
    R, on_humerus = row[place + 6], row[place + 7]
    C = placed(rotation, on_humerus, vector(row, place))
    w = placed(rotation, on_humerus, vector(row, place + 3))
    return Tube(C, w, R, on_humerus)


@compiled
def inside(X: Vector, tube: Tube) -> bool:
    """Return whether a point lies in a cylinder."""
    x = cross(minus(X, tube.C), tube.w)
    return dot(x, x) < tube.R * tube.R * (1.0 - AT_SURFACE)


@compiled
def touching(p: Vector, w: Vector, R: float, side: float) -> tuple[Vector, float]:
    """Return the unit vector to where a tangent from p touches the circle, and its length.

    p is across the axis w. Seen against w the point lies counter-clockwise of p for a side of 1,
    clockwise for -1. A p within the circle counts as the point above it on the circle.
    """
    pp = dot(p, p)
    t = sqrt(max(pp - R * R, 0.0))
    k = 1.0 / max(sqrt(pp * (R * R + t * t)), 1e-300)
    return mix(k * R, p, side * k * t, cross(w, p)), t


@compiled
def straight_past(P: Vector, S: Vector, state: int) -> TubePath:
    """Return the straight path from P to S."""
    line = minus(S, P)
    D = norm(line)
    u = times(1.0 / max(D, 1e-300), line)
    return TubePath(state, D, D, u, u, NO_ARC, P, S)


@compiled
def path_round(P: Vector, S: Vector, tube: Tube) -> TubePath:
    """Return the path from P to S, both outside, right-handed about the axis."""
    C, w, R, _ = tube
    p, s = minus(P, C), minus(S, C)
    pz, sz = dot(p, w), dot(s, w)
    p, s = mix(1.0, p, -pz, w), mix(1.0, s, -sz, w)
    q, tP = touching(p, w, R, 1.0)
    t, tS = touching(s, w, R, -1.0)
    sine = dot(cross(q, t), w)
    if sine <= 0.0:
        turn = dot(cross(p, s), w)
        kept = turn > 0.0 or (turn == 0.0 and dot(p, s) > 0.0)
        return straight_past(P, S, CLEAR if kept else MISSED)
    turn = atan2(sine, dot(q, t))
    flat, h = tP + R * turn + tS, sz - pz  # unrolled
    L = sqrt(flat * flat + h * h)
    t1 = mix(flat / L, cross(w, q), h / L, w)
    t2 = mix(flat / L, cross(w, t), h / L, w)
    Q = plus(C, mix(R, q, pz + h * tP / flat, w))
    arc = Arc(Q, C, w, turn, h * R * turn / flat)
    return TubePath(WRAPPED, L, L * tS / flat, t1, t2, arc, on_arc(arc, 1.0), Q)


@compiled
def cylinder(row: BandRow, rotation: Rotation) -> ObstaclePath:
    """Return the path of a band of P, S and a cylinder."""
    P, S = ends(row, rotation)
    tube = tube_at(row, OBSTACLE, rotation)
    if inside(P, tube) or inside(S, tube):
        return straight_path(P, S, INSIDE)
    past = path_round(P, S, tube)
    if past.state != WRAPPED:
        return straight_path(P, S, past.state)
    moment = moment_of(P, past.t1, tube.on_humerus, ZERO, ZERO, tube.on_humerus, S, past.t2)
    return ObstaclePath(past.length, WRAPPED, 1, moment, past.arc, NO_ARC)


@dataclass(frozen=True)
class RoundAnAxis(PathModel):
    """What the models with a cylinder have in common: the first one."""

    centre: Vector
    """A point of the axis, in the frame of its bone."""
    axis: Vector
    """Of any length but 0."""
    radius: float
    """m"""
    bone: Bone
    """'scapula' or 'humerus'."""


@dataclass(frozen=True)
class Cylinder(RoundAnAxis):
    """A cylinder without ends that is fixed to a bone; the band turns right-handed about its axis.

    WRAPPED; CLEAR: the line passes it on the band's side; MISSED: half a turn or more on that
    side, so straight; INSIDE where an end lies in it.
    """

    kernel = make_kernel(cylinder)
