# SPDX-License-Identifier: Apache-2.0
"""What Python calls of the compiled solver: poses to muscle states, and a state to its drawing."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from ..joints.conventions import turn_in_sequence
from ..joints.rotations import PROPER, matrix_rows, rotation_fault
from ..linked_planes.band import WRAPPED, wrap
from ..linked_planes.bones import REST, place_muscle
from ..linked_planes.chain import bands_at, plane_at
from ..linked_planes.compilation import compiled, entry
from ..linked_planes.layout import Muscle, band_count, band_vectors
from ..linked_planes.least_length import solve_theta
from ..linked_planes.moment_vectors import muscle_state
from ..linked_planes.vectors import Rotation, cross, mix, norm, plus, times

SOLVED, NO_PLANE, TOO_FAR = PROPER, 4, 5  # beside the faults of rotations
FARTHEST = 1e3  # m that a bone may be shifted: beyond, lengths lose their micrometres

Outcome = tuple[int, int, int]
"""Of a kernel over poses: the first that has no answer, why, and which band is at fault; or where
it stopped, SOLVED and 0."""


@compiled
def mark_wrapped(corner: bool, states: Any, marks: Any) -> None:
    """Mark the bands whose derivative is one-sided with theta's: those that are wrapped."""
    for i in range(len(states)):
        marks[i] = corner and states[i] == WRAPPED


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
    one_sided: Any,
) -> Outcome:
    """Fill in the states of the poses from start to stop."""
    for k in range(start, stop):
        rotation = matrix_rows(rotations[k])
        fault = rotation_fault(rotation)
        if fault != PROPER:
            return k, fault, 0
        bands = bands_at(muscle, rotation)
        if len(bands) < band_count(muscle):
            return k, NO_PLANE, len(bands)
        theta, held = solve_theta(bands, neutral)
        thetas[k] = theta
        corner = muscle_state(
            muscle, rotation, bands, theta, held, lengths[k], moments[k], states[k], None
        )
        mark_wrapped(corner, states[k], one_sided[k])
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
    one_sided: Any,
    arms: Any,
    lengthening: Any,
) -> Outcome:
    """Fill in all that the node answers to one triple of angles.

    The rotation is (1, 3, 3), lengths, moments and states have a leading 1; mirror is
    AXIS_SIGN of the side.
    """
    turn_in_sequence(units, mix, angles, rotation[0], axes)
    done = solve_poses(muscle, neutral, rotation, 0, 1, theta, lengths, moments, states, one_sided)
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


@compiled
def draw(
    muscle: Muscle,
    rotation: Rotation,
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
    bands = bands_at(muscle, rotation)
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


@entry
def draw_poses(
    muscle: Muscle,
    rotations: Any,
    thetas: Any,
    states: Any,
    insertions: Any,
    centres: Any,
    arcs: Any,
) -> None:
    """Draw the muscle at m poses: all as `draw`, with a leading m."""
    for k in range(len(thetas)):
        rotation = matrix_rows(rotations[k])
        draw(muscle, rotation, thetas[k], states[k], insertions[k], centres[k], arcs[k])


@entry
def draw_bone_poses(
    muscle: Muscle,
    poses: Any,
    thetas: Any,
    states: Any,
    insertions: Any,
    centres: Any,
    arcs: Any,
) -> None:
    """Draw the muscle at m poses (m, k, 3, 4) of k bones: all as `draw`, with a leading m."""
    for j in range(len(thetas)):
        placed = place_muscle(muscle, poses[j])
        draw(placed, REST, thetas[j], states[j], insertions[j], centres[j], arcs[j])
