# SPDX-License-Identifier: Apache-2.0
"""The muscle at the poses of a criterion, compiled: no Python objects between poses.

A muscle comes in the flat layout (linked_planes/layout.py), but with its numbers as a file has
them: the reference normal of any length, phi and 0 for the cosine and sine of phi. Every number of
a model then stands in it as it is, and the sequence is linear in all of them.
"""

from __future__ import annotations

from math import cos, inf, sin
from typing import Any

from ..joints.rotations import matrix_rows
from ..linked_planes.band import PIERCED
from ..linked_planes.chain import Band, Section, bands_at, plane_at, state_at
from ..linked_planes.compilation import compiled, entry
from ..linked_planes.layout import (
    COS_PHI,
    GROUND,
    HUMERUS,
    NORMAL,
    SIN_PHI,
    Muscle,
    band_count,
    band_numbers,
    band_place,
    band_vectors,
    vector,
)
from ..linked_planes.least_length import solve_theta
from ..linked_planes.moment_vectors import muscle_state
from ..linked_planes.path import band_path, depth_in_spheres, halfway
from ..linked_planes.vectors import ZERO, cross, dot, minus, norm, times

PHI = COS_PHI  # where phi stands among the numbers of a band


@entry
def combine(base: Any, columns: Any, x: Any) -> Any:
    """Return base (k,) + columns (k, p) x (p,), a flat muscle.

    Not by NumPy: the widest instructions of its products would slow all that follows them.
    """
    made = base.copy()
    for i in range(len(base)):
        for j in range(len(x)):
            made[i] += columns[i, j] * x[j]
    return made


@compiled
def prepare_muscle(muscle: Muscle) -> None:
    """Make a flat muscle, in place, what the solver's kernels take."""
    size = norm(vector(muscle, NORMAL))
    for axis in range(3):
        muscle[NORMAL + axis] /= size
    for i in range(band_count(muscle)):
        k = band_place(i)
        phi = muscle[k + PHI]
        muscle[k + COS_PHI], muscle[k + SIN_PHI] = cos(phi), sin(phi)


@compiled
def fixed_end_depth(muscle: Muscle, i: int) -> float:
    """Return how deep (m) a band's end that its sphere moves with lies in it, at any pose.

    At least: infinite for a radius that is not positive.
    """
    P, S, centre = band_vectors(muscle, i)
    R, _, _, frame = band_numbers(muscle, i)
    if R <= 0.0:
        return inf
    if frame == GROUND:
        return R - norm(minus(centre, P))
    if frame == HUMERUS:
        return R - norm(minus(centre, S))
    return R - norm(centre)


@compiled
def end_depth(band: Band) -> float:
    """Return how deep (m) the deeper end of a band lies in its sphere; negative: its distance."""
    section = band.section
    to_S = norm(minus(band.p, times(section.D, band.u)))
    return section.R - min(norm(band.p), to_S)


@compiled
def past_edge(section: Section, d: float, b: float) -> float:
    """Return how far (m) a band is past the edge where its length jumps; negative: how far away.

    It jumps where a plane leaves the sphere while the sphere lies on the side of the bulge (b > 0).
    A band whose line pierces the sphere wraps it in every plane.
    """
    if section.kind == PIERCED:
        return -section.R
    return min(b, abs(d) - section.R)


@entry
def evaluate(
    muscle: Muscle,
    rotations: Any,
    spheres: Any,
    lengths: Any,
    moments: Any,
    states: Any,
    depths: Any,
    insides: Any,
    edges: Any,
    gaps: Any,
    spacing: Any,
) -> tuple[int, float]:
    """Fill in the muscle's states at m poses; the flat muscle is changed.

    Lengths and moments as `solve_poses`, for the first poses, as many as they have rows; wrap
    states (m, n); how deep each band enters the interference spheres and how deep its ends lie
    in its own obstacle sphere (m, n), m; how far it is past the edge where its length jumps
    (m, n), m; gaps (m, n - 1), m: by how much each band's middle lies on the far side of the
    one before, seen from the joint's centre outwards; spacing (n - 1,), m: how far apart the
    origins of neighbours are.

    Returns how many poses were solved and, if that is none because an end of a band lies in
    its sphere at any pose, how deep, m.
    """
    n = band_count(muscle)
    prepare_muscle(muscle)
    most = -inf
    for i in range(n):
        most = max(most, fixed_end_depth(muscle, i))
    if most >= 0.0:
        return 0, most
    bands = bands_at(muscle, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    if len(bands) < n:
        return 0, 0.0
    neutral = solve_theta(bands, 0.0)[0]
    for i in range(1, n):
        origin, before = band_vectors(muscle, i)[0], band_vectors(muscle, i - 1)[0]
        spacing[i - 1] = norm(minus(origin, before))
    for j in range(len(rotations)):
        rotation = matrix_rows(rotations[j])
        bands = bands_at(muscle, rotation)
        if len(bands) < n:
            return j, 0.0
        theta, held = solve_theta(bands, neutral)
        c, s = cos(theta), sin(theta)
        if j < len(lengths):
            filled = lengths[j], moments[j], states[j]
            muscle_state(muscle, rotation, bands, theta, held, *filled, None)
        middle, along = ZERO, ZERO
        for i in range(n):
            band = bands[i]
            d, b, _, _ = plane_at(band.section, c, s)
            states[j, i] = state_at(band.section, d, b, i, held)
            path = band_path(band, c, s, states[j, i])
            depths[j, i] = depth_in_spheres(path, spheres)
            insides[j, i] = end_depth(band)
            edges[j, i] = past_edge(band.section, d, b)
            before, side = middle, cross(along, middle)
            middle, along = halfway(path)
            if i > 0:
                gaps[j, i - 1] = dot(minus(middle, before), side) / max(norm(side), 1e-9)
    return len(rotations), 0.0
