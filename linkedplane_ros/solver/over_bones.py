# SPDX-License-Identifier: Apache-2.0
"""A muscle over several bones that move: its states at their poses (spec bones.md)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError
from ..joints.articulation import Articulation, as_value_batch, rotated_poses
from ..joints.rotations import FAULTS, PROPER, matrix_rows, rotation_fault
from ..joints.sides import AXIS_SIGN, mirror_axes, mirror_points, mirror_screws
from ..skeleton.skeleton import Skeleton
from ..types import Floats
from .batches import run_kernel
from .bone_kernels import answer_bone_poses, answer_chain, solve_bone_poses
from .faults import describe_pose_fault
from .kernels import NO_PLANE, SOLVED
from .results import PosedBones
from .states import Answer, AnswerBatch, MuscleState, MuscleStates

if TYPE_CHECKING:
    from .linked_plane_solver import LinkedPlaneSolver


def solve_over_bones(solver: LinkedPlaneSolver, poses: Floats, index: str) -> MuscleStates:
    """Return the states at the poses (m, k, 3, 4); `index` is what names one in messages."""
    m, k = poses.shape[:2]
    n = len(solver.muscle.band_names)
    theta, lengths = np.empty(m), np.empty((m, n))
    filled = np.empty((m, 2 * k, 3 * n))
    wrap, one_sided = np.empty((m, n), dtype=np.uint8), np.empty((m, n), dtype=bool)
    given = solver.flat_bones, solver.neutral
    filling = theta, lengths, filled, wrap, one_sided
    j, fault, number = run_kernel(solve_bone_poses, given, poses, filling)
    if fault != SOLVED:
        raise LinkedPlaneError(describe_fault(solver, fault, number, index.format(j)))
    moments, forces = np.moveaxis(filled.reshape(m, k, 2, n, 3), 2, 0)
    if solver.side == 'left':
        moments, forces = mirror_axes(moments), mirror_points(forces)
    wrenches = np.concatenate((moments, forces), axis=-1).swapaxes(1, 2).copy()
    vectors, rotations = wrenches[:, :, -1, :3].copy(), poses[:, -1, :, :3].copy()
    posed = PosedBones(poses, wrenches)
    return MuscleStates(theta, lengths, vectors, wrap, one_sided, rotations, solver, posed)


def describe_fault(solver: LinkedPlaneSolver, fault: int, number: int, index: str) -> str:
    """Return why a pose has no answer, from a kernel's outcome; `index` names the pose."""
    where = 'bones' if fault == NO_PLANE else solver.bones[number]
    return f'{where}{index}: {describe_pose_fault(solver.muscle, fault, number)}'


def solve_last_bone(solver: LinkedPlaneSolver, rotations: Floats, name: str) -> MuscleStates:
    """Return the states at rotations (m, 3, 3) of the last bone, the others at rest."""
    for j, rotation in enumerate(rotations.tolist()):
        fault = rotation_fault(matrix_rows(rotation))
        if fault != PROPER:
            raise LinkedPlaneError(f'{name.format(j)}: {FAULTS[fault]}')
    return solve_over_bones(solver, rotated_poses(rotations, len(solver.bones) - 1), '[{}]')


def answer_over_bones(
    solver: LinkedPlaneSolver, moved_by: Articulation, values: Floats, speeds: Floats
) -> Answer:
    """Return `LinkedPlaneSolver.answer` at values (d,) of whatever moves the bones."""
    n, k, d = len(solver.muscle.band_names), len(solver.bones) - 1, len(values)
    theta, lengths, filled = np.empty(1), np.empty((1, n)), np.empty((1, 2 * k, 3 * n))
    wrap, one_sided = np.empty((1, n), dtype=np.uint8), np.empty((1, n), dtype=bool)
    wrenches, arms, lengthening = np.empty((n, k, 6)), np.empty((n, d)), np.empty(n)
    results = theta, lengths, filled, wrap, one_sided, wrenches, arms, lengthening
    given, mirror = (solver.flat_bones, solver.neutral), AXIS_SIGN[solver.side]
    if isinstance(moved_by, Skeleton):  # in one call, for it is timed
        chain = moved_by.pack_for(solver.bones)
        poses, screws = np.empty((1, k, 3, 4)), np.empty((1, d, k, 6))
        own = AXIS_SIGN[moved_by.side or solver.side]
        _, fault, number = answer_chain(
            *given, *chain, values[np.newaxis], speeds, mirror, own, poses, screws, *results
        )
    else:
        poses, screws = moved_by.move_bones(values[np.newaxis], solver.bones, solver.side)
        _, fault, number = answer_bone_poses(*given, poses, screws, speeds, mirror, *results)
    if fault != SOLVED:
        raise LinkedPlaneError(describe_fault(solver, fault, number, ''))
    state = MuscleState(
        theta.item(),
        lengths[0],
        wrenches[:, -1, :3].copy(),
        wrap[0],
        one_sided[0],
        poses[0, -1, :, :3].copy(),
        solver,
        PosedBones(poses[0], wrenches),
    )
    return Answer(state, arms, lengthening)


def answer_batch_over_bones(
    solver: LinkedPlaneSolver,
    moved_by: Articulation,
    values: npt.ArrayLike,
    speeds: npt.ArrayLike,
) -> AnswerBatch:
    """Return `LinkedPlaneSolver.answer_batch` at values (m, d) of whatever moves the bones.

    Moment arms are r = -dL/dq: what the bands do to each bone, times how it moves with q. They are
    the same on both sides, so screws stay in right-shoulder form.
    """
    poses, screws = moved_by.move_bones(values, solver.bones, solver.side)
    rates = as_value_batch('speeds', speeds, len(poses), moved_by, '/s')
    states = solve_over_bones(solver, poses, '[{}]')
    wrenches = states.wrenches
    if solver.side == 'left':
        wrenches = mirror_screws(wrenches)
    arms = np.einsum('mnkc,mdkc->mnd', wrenches, screws)
    return AnswerBatch(states, arms, -np.einsum('mnd,md->mn', arms, rates))
