# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a model over its range of motion: warnings by band and pose."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import LinkedPlaneError
from ..joints.conventions import THESIS_CONVENTION
from ..muscle.broad_muscle import BroadMuscle
from ..muscle.parts import COORDINATES
from ..types import Floats, Intervals
from .interference import depths
from .linked_plane_solver import LinkedPlaneSolver
from .states import MuscleStates, WrapState

DEFAULT_RANGE: Intervals = tuple(
    (math.radians(low), math.radians(high)) for low, high in ((-40, 120), (0, 120), (-60, 60))
)
"""The published deltoid's, rad, for models that state none."""
STEPS = (9, 7, 5)  # poses along flexion, abduction and rotation
JUMP = 1e-3  # m: what a length may jump by
HALVINGS = 14  # of the step between two poses; what does not jump hardly changes over the last
NEAR_NORMAL = 10.0  # deg from a band's line to the normal that its plane follows
TURNED_OVER = 90.0  # deg between the sides to which neighbours bulge


@dataclass(frozen=True)
class ModelCheck:
    """The poses at which a model was solved, and what is wrong there."""

    poses: int
    range_of_motion: Intervals
    """Of flexion, abduction and rotation, rad."""
    warnings: tuple[str, ...]
    """A line for each band and kind of trouble, with its worst pose."""


def check_model(muscle: BroadMuscle) -> ModelCheck:
    """Solve a muscle at a grid of poses over its range of motion and collect warnings.

    A muscle that states no range is solved over the deltoid's, DEFAULT_RANGE.
    """
    limits = muscle.range_of_motion or DEFAULT_RANGE
    axes = [np.unique(np.linspace(*span, n)) for span, n in zip(limits, STEPS, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1)
    angles = grid.reshape(-1, 3)
    rotations, turns = THESIS_CONVENTION.rotations_and_axes(angles)
    solver = LinkedPlaneSolver(muscle)
    found: list[str] = []
    reasons = [''] * len(angles)
    try:
        states = solver.solve_batch(rotations)
    except LinkedPlaneError:
        reasons = [unsolved_reason(solver, rotation) for rotation in rotations]
    good = np.array([not reason for reason in reasons])
    if not good.all():
        k = int(good.argmin())
        where = f'({describe_pose(angles[k])}); at {(~good).sum()} of {len(good)} poses'
        found.append(f'{reasons[k]} {where}')
        states = solver.solve_batch(rotations[good])
    for kind in (inside_warnings, normal_warnings, fan_warnings, bone_warnings):
        found += kind(muscle, states, angles[good])
    if good.all():
        found += jump_warnings(solver, grid, states, turns)
    return ModelCheck(len(rotations), limits, tuple(found))


def unsolved_reason(solver: LinkedPlaneSolver, rotation: Floats) -> str:
    """Return why a rotation (3, 3) has no answer; empty if it has one."""
    try:
        solver.solve(rotation)
    except LinkedPlaneError as error:
        return str(error).removeprefix('rotation: ')
    return ''


def describe_pose(angles: Floats) -> str:
    """Return a pose, angles (3,) in rad, in words."""
    degrees = np.degrees(angles).round().astype(int).tolist()
    return ', '.join(f'{name} {d}' for name, d in zip(COORDINATES, degrees, strict=True)) + ' deg'


def inside_warnings(muscle: BroadMuscle, states: MuscleStates, angles: Floats) -> Iterator[str]:
    """Warn of attachments inside their obstacle spheres: there is no path, the band is straight."""
    depths = np.full((2, *states.lengths.shape), -np.inf)  # m, of origins and insertions
    for k in np.flatnonzero((states.wrap == WrapState.INSIDE).any(axis=1)).tolist():
        for end, points in enumerate((states[k].origins, states[k].insertions)):
            away = np.linalg.norm(points - states[k].sphere_centres, axis=1)
            depths[end, k] = muscle.sphere_radii - away
    for name, depth in zip(('origin', 'insertion'), 1e3 * depths, strict=True):
        text = f'its {name} lies inside its obstacle sphere, up to {{:.1f}} mm deep'
        yield from worst_cases(muscle, angles, depth, 0.0, text)


def normal_warnings(muscle: BroadMuscle, states: MuscleStates, angles: Floats) -> Iterator[str]:
    """Warn of normals nearly along the next band: a small change turns its plane a lot."""
    between, _ = fan_angles(muscle, states)
    text = 'its plane follows a normal that runs within {:.1f} deg of its line'
    yield from worst_cases(muscle, angles, -between, -NEAR_NORMAL, text)


def fan_warnings(muscle: BroadMuscle, states: MuscleStates, angles: Floats) -> Iterator[str]:
    """Warn of bands that bulge to another side than the band before: the fan is turned over."""
    _, apart = fan_angles(muscle, states)
    text = (
        'its plane angle turns the fan over: it bulges up to {:.0f} deg away from the band before'
    )
    yield from worst_cases(muscle, angles, apart, TURNED_OVER, text)


def bone_warnings(muscle: BroadMuscle, states: MuscleStates, angles: Floats) -> Iterator[str]:
    """Warn of bands whose paths enter the muscle's interference spheres."""
    if not muscle.interference_names or not len(states):
        return
    deep = np.array([depths(state)[0].max(axis=1) for state in states])
    yield from worst_cases(muscle, angles, 1e3 * deep, 0.0, 'it enters bone, by up to {:.1f} mm')


def fan_angles(muscle: BroadMuscle, states: MuscleStates) -> tuple[Floats, Floats]:
    """Return two angles of each band's plane, deg (m, n).

    That between the band's line and the normal it follows, up to 90 deg; and that between the sides
    to which it and the band before it bulge, 0 for the first.
    """
    n = len(muscle.band_names)
    ends = states.place_points(muscle.insertions, muscle.bones.of_bands('insertion', n))
    lines = ends - states.place_points(muscle.origins, muscle.bones.of_bands('origin', n))
    u = lines / np.linalg.norm(lines, axis=2, keepdims=True)
    m = len(states)
    between, apart = np.empty((m, n)), np.zeros((m, n))
    N = muscle.reference_normal[np.newaxis]
    normal = states.place_points(N, [muscle.bones.reference_normal], shift=False)[:, 0]
    bulge = np.zeros((m, 3))
    for i in range(n):
        phi = (states.theta if i == 0 else np.full(m, muscle.plane_angles[i]))[:, np.newaxis]
        across = normal - (normal * u[:, i]).sum(axis=1, keepdims=True) * u[:, i]
        size = np.linalg.norm(across, axis=1, keepdims=True)
        between[:, i] = np.degrees(np.arcsin(np.minimum(size[:, 0], 1.0)))
        across = across / size
        normal = np.cos(phi) * across + np.sin(phi) * np.cross(u[:, i], across)
        before, bulge = bulge, np.cross(u[:, i], normal)
        if i:
            cosine = (before * bulge).sum(axis=1)
            apart[:, i] = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return between, apart


def jump_warnings(
    solver: LinkedPlaneSolver, grid: Floats, states: MuscleStates, axes: Floats
) -> Iterator[str]:
    """Warn of lengths that jump between neighbouring poses of the grid (.., .., .., 3).

    A plane leaves its sphere on the side of the bulge, or another path becomes the shortest. A jump
    is searched for where a change of length differs from what the moment arms at both ends predict.
    """
    shape = (*grid.shape[:3], len(solver.muscle.band_names))
    lengths = states.lengths.reshape(shape)
    arms = (states.moment_vectors @ axes).reshape(*shape, 3)
    pairs, steps = 0, []
    for j in range(3):
        near, far = ((slice(None),) * j + (part,) for part in (slice(-1), slice(1, None)))
        turn = (grid[far] - grid[near])[..., j, np.newaxis]
        predicted = -0.5 * (arms[near] + arms[far])[..., j] * turn
        differs = (np.abs(lengths[far] - lengths[near] - predicted) > JUMP).any(axis=-1)
        pairs += differs.size
        steps.append(np.stack((grid[near][differs], grid[far][differs])))
    start, end = np.concatenate(steps, axis=1)
    try:
        for _ in range(HALVINGS):
            middle = 0.5 * (start + end)
            changes = np.abs(np.diff(solve_lengths(solver, start, middle, end), axis=0)).max(axis=2)
            later = (changes[1] > changes[0])[:, np.newaxis]
            start, end = np.where(later, middle, start), np.where(later, end, middle)
        sizes = 1e3 * np.abs(np.diff(solve_lengths(solver, start, end), axis=0))[0]
    except LinkedPlaneError as error:
        yield f'{error} (between the poses of the grid)'
        return
    text = 'its length jumps, by up to {:.1f} mm'
    where = f'between {{}} of {pairs} pairs of neighbouring poses'
    yield from worst_cases(solver.muscle, start, sizes, 1e3 * JUMP, text, where)


def solve_lengths(solver: LinkedPlaneSolver, *angles: Floats) -> Floats:
    """Return the lengths (k, m, n) at k times (m, 3) angles, rad."""
    rotations, _ = THESIS_CONVENTION.rotations_and_axes(np.concatenate(angles))
    n = len(solver.muscle.band_names)
    return solver.solve_batch(rotations).lengths.reshape(len(angles), -1, n)


def worst_cases(
    muscle: BroadMuscle,
    angles: Floats,
    amounts: Floats,
    limit: float,
    text: str,
    where: str = '',
) -> Iterator[str]:
    """Yield a warning for each band whose amount is above a limit at any pose.

    Parameters
    ----------
    muscle
        Its n bands are named.
    angles
        (m, 3) the poses, rad.
    amounts
        (m, n) how bad it is; the largest of a band is reported.
    limit
        The largest amount that is not reported.
    text
        What is wrong, with a place for the amount.
    where
        With a place for the number of poses; by default of how many.

    """
    where = where or f'at {{}} of {len(angles)} poses'
    for i in np.flatnonzero((amounts > limit).any(axis=0)).tolist():
        k = int(amounts[:, i].argmax())
        count = int((amounts[:, i] > limit).sum())
        yield (
            f'{muscle.band_names[i]}: {text.format(abs(amounts[k, i]))} '
            f'({describe_pose(angles[k])}); {where.format(count)}'
        )
