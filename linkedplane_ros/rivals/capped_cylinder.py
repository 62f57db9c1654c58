# SPDX-License-Identifier: Apache-2.0
"""The sphere-capped cylinder, or stub (Garner and Pandy 2000; thesis App. A).

A cylinder that ends in a half sphere of its radius. Its surface has no edge, and it is convex: a
band touches it along one stretch, a great circle on the cap, a helix on the cylinder, or one after
the other; where they meet, on the seam, both cross it at one angle. Over the cap a band is free to
change sides, so a side is a choice here: right-handed or left-handed about the axis where it lies
on the cylinder, or whichever is shorter. (Which of these is the published rule is not known here:
only the abstract of the paper and the work of others on it were available.)
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt
from typing import NamedTuple

from ..linked_planes.band import CLEAR, INSIDE, MISSED, PIERCED, WRAPPED, obstacle_kind
from ..linked_planes.compilation import compiled
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
from .cylinder import AT_SURFACE, CYLINDER_SIZE, RoundAnAxis, Tube, inside, path_round, tube_at
from .fields import Turn
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
    straight_path,
)
from .sphere import round_sphere

ENDLESS = 1e300  # m
PARTS = 12  # in which the seam is searched where a crossing may be missed otherwise


# A capped cylinder is a Tube whose C is the cap's centre and whose axis leads to the cap.


@compiled
def height(stub: Tube, X: Vector) -> float:
    """Return the height of a point above the seam, m: positive on the cap's side."""
    return dot(minus(X, stub.C), stub.w)


@compiled
def in_stub(stub: Tube, X: Vector) -> bool:
    """Return whether a point lies in the obstacle."""
    if height(stub, X) <= 0.0:
        return inside(X, stub)
    x = minus(X, stub.C)
    return dot(x, x) < stub.R * stub.R * (1.0 - AT_SURFACE)


@compiled
def in_the_way(stub: Tube, P: Vector, S: Vector) -> bool:
    """Return whether the line from P to S, both outside, runs through the obstacle."""
    line, p = minus(S, P), minus(stub.C, P)
    D = norm(line)
    u = times(1.0 / max(D, 1e-300), line)
    pu = cross(p, u)
    if obstacle_kind(D, dot(p, u), dot(pu, pu), stub.R) == PIERCED:
        return True
    # where the line is in the endless cylinder: parts of its length, then those below the seam
    pz, sz = height(stub, P), height(stub, S)
    x, v = mix(-1.0, p, -pz, stub.w), mix(1.0, line, pz - sz, stub.w)
    a, b, c = dot(v, v), dot(x, v), dot(x, x) - stub.R * stub.R
    root = b * b - a * c
    if root <= 0.0 or a == 0.0:
        return False
    start, stop = max((-b - sqrt(root)) / a, 0.0), min((-b + sqrt(root)) / a, 1.0)
    return start < stop and min(pz + start * (sz - pz), pz + stop * (sz - pz)) < 0.0


@compiled
def bend(turn: float, c: float, s: float, far: float, h: float, R: float) -> tuple[float, float]:
    """Return by how much a band bends on the seam, `turn` (rad) from its end A, and the slope.

    The difference of the cosines of the angles at which great circle and helix meet the seam, there
    where the band crosses it; c, s are the cosine and sine of A's height above the seam, seen from
    the centre; far (m) the unrolled distance from A's meridian to the other end B, h (m) B's depth.
    """
    q = sqrt(max(s * s + c * c * sin(turn) * sin(turn), 1e-300))
    left = far - R * turn
    L = sqrt(max(left * left + h * h, 1e-300))
    slope = c * cos(turn) * s * s / (q * q * q) + R * h * h / (L * L * L)
    return c * sin(turn) / q - left / L, slope


@compiled
def seam_turn(c: float, s: float, last: float, far: float, h: float, R: float) -> float:
    """Return the turn from A at which a band crosses the seam without a bend; -1 if it does not.

    The first one, up to `last` or half a circle, at which the bend comes up through zero: there the
    length is least. Up to a quarter of a circle the bend only grows.
    """
    last = min(last, pi)
    low, high = 0.0, min(last, 0.5 * pi)
    part = (last - high) / PARTS
    for _ in range(PARTS):
        if part <= 0.0 or bend(high, c, s, far, h, R)[0] >= 0.0:
            break
        low, high = high, min(high + part, last)
    if bend(low, c, s, far, h, R)[0] > 0.0 or bend(high, c, s, far, h, R)[0] < 0.0:
        return -1.0
    turn = 0.5 * (low + high)
    for _ in range(100):
        there, slope = bend(turn, c, s, far, h, R)
        if there > 0.0:
            high = turn
        else:
            low = turn
        last, turn = turn, turn - there / slope if slope > 0.0 else low
        if not low < turn < high:
            turn = 0.5 * (low + high)
        if abs(turn - last) < 1e-15:
            break
    return turn


class Crossing(NamedTuple):
    """A band from A over the cap, the seam and the cylinder to B."""

    length: float  # -1 if there is none
    t1: Vector  # unit tangents, from A and to B
    t2: Vector
    cap: Arc
    helix: Arc


@compiled
def crossing(stub: Tube, A: Vector, B: Vector, side: float) -> Crossing:
    """Return the band from A, above the seam, to B, below it, that crosses it on the obstacle.

    Right-handed about the axis for a side of 1, left-handed for -1.
    """
    none = Crossing(-1.0, ZERO, ZERO, NO_ARC, NO_ARC)
    R, w, a, b = stub.R, times(side, stub.w), minus(A, stub.C), minus(B, stub.C)
    az, bz = dot(a, stub.w), dot(b, stub.w)
    rA = norm(a)
    x, y = mix(1.0, a, -az, stub.w), mix(1.0, b, -bz, stub.w)
    out, rB = norm(x), norm(y)
    if az <= 0.0 or bz >= 0.0 or out < 1e-12 * R or rB < R * (1.0 - AT_SURFACE):
        return none
    x = times(1.0 / out, x)
    to_B = atan2(dot(cross(x, y), w), dot(x, y)) % (2.0 * pi)
    tA, tB = sqrt(max(rA * rA - R * R, 0.0)), sqrt(max(rB * rB - R * R, 0.0))
    ends_at = to_B - atan2(tB, R)  # where the helix leaves the cylinder
    if ends_at <= 0.0:
        return none
    c, s = out / rA, az / rA
    turn = seam_turn(c, s, ends_at, R * ends_at + tB, bz, R)
    W = mix(cos(turn), x, sin(turn), cross(w, x))
    on_cap = atan2(sqrt(s * s + c * c * sin(turn) * sin(turn)), c * cos(turn)) - atan2(tA, R)
    if turn < 0.0 or on_cap < 0.0:
        return none
    a = times(1.0 / rA, a)
    over = cross(cross(a, W), a)  # from A towards W, along the sphere
    over = times(1.0 / max(norm(over), 1e-300), over)
    t1 = mix(-tA / rA, a, R / rA, over)
    Q = plus(A, times(tA, t1))
    left = R * (ends_at - turn)
    flat = left + tB
    L = sqrt(flat * flat + bz * bz)
    leaves = mix(cos(ends_at), x, sin(ends_at), cross(w, x))
    t2 = mix(flat / L, cross(w, leaves), bz / L, stub.w)
    cap = Arc(Q, stub.C, cross(a, over), on_cap, 0.0)
    helix = Arc(plus(stub.C, times(R, W)), stub.C, w, ends_at - turn, side * bz * left / flat)
    return Crossing(tA + R * on_cap + L, t1, t2, cap, helix)


@compiled
def reversed_arc(arc: Arc) -> Arc:
    """Return an arc in the other direction."""
    return Arc(on_arc(arc, 1.0), arc.centre, times(-1.0, arc.axis), arc.turn, arc.rise)


@compiled
def stub_moment(stub: Tube, P: Vector, t1: Vector, S: Vector, t2: Vector) -> Vector:
    """Return -dL/domega of a band on the obstacle, with unit tangents t1 from P and t2 to S."""
    return moment_of(P, t1, stub.on_humerus, ZERO, ZERO, stub.on_humerus, S, t2)


@compiled
def on_the_cap(stub: Tube, P: Vector, S: Vector) -> ObstaclePath:
    """Return the band around only the cap; MISSED and endless if it leaves the cap."""
    cap = round_sphere(P, S, stub.C, stub.R, stub.on_humerus)
    low = min(height(stub, cap.first.start), height(stub, on_arc(cap.first, 1.0)))
    if cap.state == WRAPPED and low >= -AT_SURFACE * stub.R:
        return cap
    return ObstaclePath(ENDLESS, MISSED, 0, ZERO, NO_ARC, NO_ARC)


@compiled
def round_stub(stub: Tube, P: Vector, S: Vector, side: float) -> ObstaclePath:
    """Return the shortest band from P to S, turning on the cylinder to one side, or to either (0).

    A side of 1 is right-handed about the axis, -1 left-handed.
    """
    if in_stub(stub, P) or in_stub(stub, S):
        return straight_path(P, S, INSIDE)
    if not in_the_way(stub, P, S):
        return straight_path(P, S, CLEAR)
    best = on_the_cap(stub, P, S)
    for k in range(2):
        turn = 1.0 - 2.0 * k
        if turn * side < 0.0:
            continue
        past = path_round(P, S, Tube(stub.C, times(turn, stub.w), stub.R, stub.on_humerus))
        high = max(height(stub, past.meets), height(stub, past.leaves))
        if past.state == WRAPPED and high <= AT_SURFACE * stub.R and past.length < best.length:
            moment = stub_moment(stub, P, past.t1, S, past.t2)
            best = ObstaclePath(past.length, WRAPPED, 2, moment, NO_ARC, past.arc)
        # the seam is crossed from above: towards S, or towards P
        back = height(stub, P) < 0.0
        A, B, about = (S, P, -turn) if back else (P, S, turn)
        down = crossing(stub, A, B, about)
        if not 0.0 < down.length < best.length:
            continue
        t1, t2, first, second = down.t1, down.t2, down.cap, down.helix
        if back:
            t1, t2 = times(-1.0, t2), times(-1.0, t1)
            first, second = reversed_arc(second), reversed_arc(first)
        best = ObstaclePath(down.length, WRAPPED, 3, stub_moment(stub, P, t1, S, t2), first, second)
    return best if best.state == WRAPPED else straight_path(P, S, MISSED)


@compiled
def capped_cylinder(row: BandRow, rotation: Rotation) -> ObstaclePath:
    """Return the path of a band of P, S, a cylinder that ends in C, and the side."""
    P, S = ends(row, rotation)
    stub = tube_at(row, OBSTACLE, rotation)
    return round_stub(stub, P, S, row[OBSTACLE + CYLINDER_SIZE])


@dataclass(frozen=True)
class CappedCylinder(RoundAnAxis):
    """A cylinder, endless on one side and closed by a half sphere on the other, fixed to a bone.

    Its centre is the cap's, its axis leads from the cylinder to the cap.

    WRAPPED (contacts: 1 the cap, 2 the cylinder, 3 both); CLEAR: the line passes it, on either
    side; MISSED: there is no path on the side asked for; INSIDE where an end lies in it.
    """

    turn: Turn = 'right-handed'
    """How the band turns about the axis on the cylinder; on the cap it takes the shorter side."""
    kernel = make_kernel(capped_cylinder)
