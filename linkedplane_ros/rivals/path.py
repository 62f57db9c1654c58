# SPDX-License-Identifier: Apache-2.0
"""A band's path as straight parts and arcs, and the kernels that work out many (m, scapula frame).

A band is a flat row of numbers: its origin P (scapula frame), its insertion S (humerus frame), then
its obstacle, as its method reads it. A kernel turns it and a humerus -> scapula rotation into an
ObstaclePath.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin
from typing import Any, NamedTuple

from ..joints.rotations import PROPER, matrix_rows, rotation_fault
from ..linked_planes.compilation import compiled, entry
from ..linked_planes.layout import vector
from ..linked_planes.vectors import (
    ZERO,
    Rotation,
    Vector,
    blend,
    cross,
    dot,
    minus,
    norm,
    plus,
    times,
    turned,
)
from ..solver.kernels import SOLVED, Outcome

BandRow = list[float]

ROW_ORIGIN, ROW_INSERTION, OBSTACLE = 0, 3, 6  # where numbers start in a row
ARC_NUMBERS = 11  # of an Arc


class Arc(NamedTuple):
    """A stretch of a path on an obstacle: a helix, without a rise a circle, without either a point.

    It starts at `start` and turns right-handed about the axis through `centre`, as it rises.
    """

    start: Vector
    centre: Vector
    axis: Vector  # unit
    turn: float  # rad
    rise: float  # m, along the axis


NO_ARC = Arc(ZERO, ZERO, ZERO, 0.0, 0.0)


class ObstaclePath(NamedTuple):
    """A band's path from its origin over at most two arcs to its insertion."""

    length: float
    state: int  # WRAPPED, CLEAR, MISSED or INSIDE
    contacts: int  # parts of the obstacle that it lies on: 0, 1 the first, 2 the second, 3 both
    moment: Vector  # -dL/domega
    first: Arc  # on the first part; with 3 contacts, the one nearer to the origin
    second: Arc


@compiled
def ends(row: BandRow, rotation: Rotation) -> tuple[Vector, Vector]:
    """Return a band's origin and insertion, scapula frame."""
    return vector(row, ROW_ORIGIN), turned(rotation, vector(row, ROW_INSERTION))


@compiled
def placed(rotation: Rotation, on_humerus: float, point: Vector) -> Vector:
    """Return a point or direction, on the scapula (0) or the humerus (1), in the scapula frame."""
    return turned(rotation, point) if on_humerus > 0.5 else point


@compiled
def moment_of(
    P: Vector, t1: Vector, first: float, x: Vector, t: Vector, second: float, S: Vector, t2: Vector
) -> Vector:
    """Return -dL/domega of a path of three straight parts, P to a bone to a bone to S.

    A frictionless band pulls along its straight parts: one from a scapular to a humeral point
    counts, one back counts against it, one that stays on its bone does not. t1 leads from P, t
    through x, t2 to S; `first` and `second` are 0 on the scapula and 1 on the humerus. As the path
    is the shortest, its contacts may count as fixed to their bones (the envelope theorem).
    """
    pull = blend(first, cross(P, t1), second - first, cross(x, t), 1.0 - second, cross(S, t2))
    return times(-1.0, pull)


@compiled
def straight_path(P: Vector, S: Vector, state: int) -> ObstaclePath:
    """Return the straight path from P to S."""
    line = minus(S, P)
    D = norm(line)
    u = times(1.0 / max(D, 1e-300), line)
    return ObstaclePath(D, state, 0, times(-1.0, cross(S, u)), NO_ARC, NO_ARC)


@compiled
def on_arc(arc: Arc, part: float) -> Vector:
    """Return the point at a part, 0 to 1, of an arc."""
    v, w = minus(arc.start, arc.centre), arc.axis
    c, s = cos(part * arc.turn), sin(part * arc.turn)
    around = blend(c, v, s, cross(w, v), (1.0 - c) * dot(w, v) + part * arc.rise, w)
    return plus(arc.centre, around)


@compiled
def across(u: Vector) -> Vector:
    """Return a unit vector at right angles to a unit vector: always the same one."""
    x, y, z = u
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        v = cross(u, (1.0, 0.0, 0.0))
    elif abs(y) <= abs(z):
        v = cross(u, (0.0, 1.0, 0.0))
    else:
        v = cross(u, (0.0, 0.0, 1.0))
    return times(1.0 / norm(v), v)


@compiled
def write_arc(arc: Arc, numbers: Any, i: int) -> None:
    """Write an arc as the i-th of a flat row of numbers that starts with how many there are."""
    k = 1 + ARC_NUMBERS * i
    numbers[k], numbers[k + 1], numbers[k + 2] = arc.start
    numbers[k + 3], numbers[k + 4], numbers[k + 5] = arc.centre
    numbers[k + 6], numbers[k + 7], numbers[k + 8] = arc.axis
    numbers[k + 9], numbers[k + 10] = arc.turn, arc.rise
    numbers[0] = i + 1


@compiled
def write_arcs(row: BandRow, rotation: Rotation, path: ObstaclePath, numbers: Any) -> None:
    """Write the arcs of a path, in order."""
    numbers[0] = 0
    if path.contacts == 1 or path.contacts == 3:
        write_arc(path.first, numbers, 0)
    if path.contacts >= 2:
        write_arc(path.second, numbers, path.contacts - 2)


PathOf = Callable[[BandRow, Rotation], ObstaclePath]
ArcsOf = Callable[[BandRow, Rotation, ObstaclePath, Any], None]
PathKernel = Callable[..., Outcome]


def make_kernel(path_of: PathOf, arcs_of: ArcsOf = write_arcs) -> PathKernel:
    """Return the kernel that solves bands of one method."""

    @entry
    def solve(
        bands: Any,
        rotations: Any,
        start: int,
        stop: int,
        lengths: Any,
        moments: Any,
        states: Any,
        contacts: Any,
        arcs: Any,
    ) -> Outcome:
        """Fill in the bands (n) at the poses from start to stop.

        Moments are (m, 3 n); arcs, as `write_arcs` has them, (m, n, k), or (m, n, 0) for none.
        """
        for k in range(start, stop):
            rotation = matrix_rows(rotations[k])
            fault = rotation_fault(rotation)
            if fault != PROPER:
                return k, fault, 0
            for i in range(len(bands)):
                path = path_of(bands[i], rotation)
                lengths[k][i] = path.length
                states[k][i] = path.state
                contacts[k][i] = path.contacts
                moments[k][3 * i], moments[k][3 * i + 1], moments[k][3 * i + 2] = path.moment
                if len(arcs[k][i]) > 0:
                    arcs_of(bands[i], rotation, path, arcs[k][i])
        return stop, SOLVED, 0

    return solve
