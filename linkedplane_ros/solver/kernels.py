"""What Python calls of the compiled solver: poses to muscle states, and a state to its drawing."""

from __future__ import annotations

from math import cos, isfinite, sin
from typing import Any

from ..joints.conventions import turn_in_sequence
from ..linked_planes.band import WRAPPED, wrap
from ..linked_planes.chain import bands_at, plane_at
from ..linked_planes.compiled import compiled, entry
from ..linked_planes.layout import Muscle, band_count, band_vectors
from ..linked_planes.least_length import solve_theta
from ..linked_planes.moment_vectors import muscle_state
from ..linked_planes.vectors import Vector, cross, dot, mix, norm, plus, times

SOLVED, NOT_FINITE, NOT_ORTHONORMAL, REFLECTION, NO_PLANE = range(5)
ORTHONORMAL = 1e-6  # how far R^T R may be from the identity


@compiled
def rows_of(matrix: Any) -> tuple[Vector, Vector, Vector]:
    """Return the rows of a (3, 3) matrix."""
    return (
        (matrix[0][0], matrix[0][1], matrix[0][2]),
        (matrix[1][0], matrix[1][1], matrix[1][2]),
        (matrix[2][0], matrix[2][1], matrix[2][2]),
    )


@compiled
def rotation_fault(rotation: tuple[Vector, Vector, Vector]) -> int:
    """Return what keeps a matrix, by its rows, from being a proper rotation, or SOLVED."""
    x, y, z = rotation
    size = dot(x, x) + dot(y, y) + dot(z, z)
    if not isfinite(size):
        return NOT_FINITE
    off = max(abs(dot(x, x) - 1.0), abs(dot(y, y) - 1.0), abs(dot(z, z) - 1.0))
    off = max(off, abs(dot(x, y)), abs(dot(y, z)), abs(dot(z, x)))
    if off > ORTHONORMAL:
        return NOT_ORTHONORMAL
    return REFLECTION if dot(cross(x, y), z) < 0.0 else SOLVED


@entry
def solve_poses(
    muscle: Muscle,
    neutral: float,
    rotations: Any,
    start: int,
    stop: int,
    thetas: Any,
    lengths: Any,
    moments: Any,
    states: Any,
) -> tuple[int, int, int]:
    """Fill in the states of the poses from start to stop.

    Returns the first pose that has none, why (NOT_FINITE ...), and for NO_PLANE which band; or
    stop, SOLVED and 0.
    """
    for k in range(start, stop):
        rotation = rows_of(rotations[k])
        fault = rotation_fault(rotation)
        if fault != SOLVED:
            return k, fault, 0
        bands = bands_at(muscle, rotation)
        if len(bands) < band_count(muscle):
            return k, NO_PLANE, len(bands)
        theta, held = solve_theta(bands, neutral)
        thetas[k] = theta
        muscle_state(muscle, rotation, bands, theta, held, lengths[k], moments[k], states[k])
    return stop, SOLVED, 0


@entry
def answer(
    muscle: Muscle,
    neutral: float,
    units: Any,
    mix: Any,
    angles: Any,
    speeds: Any,
    mirror: float,
    rotation: Any,
    axes: Any,
    theta: Any,
    lengths: Any,
    moments: Any,
    states: Any,
    arms: Any,
    lengthening: Any,
) -> tuple[int, int, int]:
    """Fill in all that the node answers to one triple of angles; return as `solve_poses`.

    The rotation is (1, 3, 3), lengths, moments and states have a leading 1; mirror is -1 for
    the left shoulder, whose axes and moments are (x, -y, -z).
    """
    turn_in_sequence(units, mix, angles, rotation[0], axes)
    done = solve_poses(muscle, neutral, rotation, 0, 1, theta, lengths, moments, states)
    for j in range(3):
        axes[1, j] *= mirror
        axes[2, j] *= mirror
    for i in range(len(lengthening)):
        x = moments[0, 3 * i]
        y = moments[0, 3 * i + 1] * mirror
        z = moments[0, 3 * i + 2] * mirror
        moments[0, 3 * i + 1], moments[0, 3 * i + 2] = y, z
        lengthening[i] = 0.0
        for j in range(3):
            arms[i, j] = x * axes[0, j] + y * axes[1, j] + z * axes[2, j]
            lengthening[i] -= arms[i, j] * speeds[j]
    return done


@entry
def draw(
    muscle: Muscle,
    rotation: Any,
    theta: float,
    states: Any,
    insertions: Any,
    centres: Any,
    arcs: Any,
) -> None:
    """Fill in insertions (n, 3), sphere centres (n, 3) and arcs (n, points, 3); m, ground.

    An arc runs from the first transition point Q to the second, T; a straight band's is left
    as it was.
    """
    bands = bands_at(muscle, rows_of(rotation))
    c, s = cos(theta), sin(theta)
    for i in range(len(bands)):
        band = bands[i]
        C = plus(band_vectors(muscle, i)[0], band.p)
        for axis in range(3):
            insertions[i][axis] = band.S[axis]
            centres[i][axis] = C[axis]
        if states[i] != WRAPPED:
            continue
        n = mix(c, band.A, s, band.B)
        n = times(1.0 / norm(n), n)
        e = cross(band.u, n)
        section = band.section
        d, b, _, _ = plane_at(section, c, s)
        r, arc, t1u, t1e, _, _ = wrap(section.D, section.a, section.tP, section.tS, section.R, d, b)
        centre = mix(1.0, C, -d, n)
        points = len(arcs[i])
        for j in range(points):
            # from the centre to Q: t1 turned a quarter to the bulge; then on along the arc
            turn = arc * j / (points - 1)
            along = t1u * sin(turn) - t1e * cos(turn)
            aside = t1u * cos(turn) + t1e * sin(turn)
            point = plus(centre, mix(r * along, band.u, r * aside, e))
            for axis in range(3):
                arcs[i][j][axis] = point[axis]
