# SPDX-License-Identifier: Apache-2.0
"""Solve the linked-plane muscle for a pose: lengths, moment vectors, wrap states and paths.

The scapula frame of the right shoulder has its origin at the glenohumeral centre, x lateral,
y anterior, z superior; a pose is the rotation that takes humerus coordinates to scapula ones. The
left shoulder is the mirror image: its frame has x to the body's right as well, and it is posed by
the rotation of the right shoulder at the same anatomical angles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError, describe_value
from ..joints.articulation import (
    Articulation,
    as_value_batch,
    as_values,
    check_articulation,
)
from ..joints.conventions import JointConvention, as_triple
from ..joints.rotations import as_matrices, as_matrix
from ..joints.sides import AXIS_SIGN, check_side, mirror_axes, mirror_points
from ..muscle.broad_muscle import BroadMuscle
from ..types import Bools, Bytes, Floats
from .batches import run_kernel
from .faults import describe_pose_fault
from .kernels import SOLVED, answer, draw_bone_poses, draw_poses, solve_poses
from .over_bones import (
    answer_batch_over_bones,
    answer_over_bones,
    solve_last_bone,
    solve_over_bones,
)
from .packing import pack_broad_muscle
from .poses import Pose, pack_pose_batch, pack_poses
from .states import Answer, AnswerBatch, MuscleState, MuscleStates


class LinkedPlaneSolver:
    """Solves a broad muscle at a pose; the answer depends only on the pose.

    Where numba is installed the first one compiles the solver, or loads it from numba's cache.

    Parameters
    ----------
    muscle
        The right shoulder's, as its file has it.
    side
        The side of the body, 'right' or 'left'. The left shoulder is posed by the rotation of the
        right at the same anatomical angles, and answers in its own scapula frame.

    Raises
    ------
    LinkedPlaneError
        For anything but a BroadMuscle, for another side, and for a muscle that has no plane with
        the arm at the side.

    """

    def __init__(self, muscle: BroadMuscle, side: str = 'right') -> None:
        if not isinstance(muscle, BroadMuscle):
            given = describe_value(muscle)
            raise LinkedPlaneError(
                f'muscle: {given} given, a BroadMuscle expected (BroadMuscle.load)'
            )
        check_side(side)
        self.muscle = muscle
        self.side = side
        self._ball = muscle.has_ball_joint
        if self._ball:
            points = muscle.bones.number_on_ball_joint(muscle.sphere_frames)
            self._flat = pack_broad_muscle(muscle, points)
        self.neutral = 0.0
        neutral = self.solve(np.eye(3))
        neutral.paths()
        self.neutral = neutral.theta

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, LinkedPlaneSolver):
            return NotImplemented
        return self.side == other.side and self.muscle == other.muscle

    def __hash__(self) -> int:
        return hash((self.side, self.muscle))

    def __reduce__(self) -> tuple[Any, ...]:
        return LinkedPlaneSolver, (self.muscle, self.side)  # the rest follows from them

    @property
    def bones(self) -> tuple[str, ...]:
        """The bones: the ground first, then the k that move; a rotation alone poses the last."""
        return self.muscle.bones.names

    @property
    def origins(self) -> Floats:
        """(n, 3) origins, m, scapula frame, with all bones at rest."""
        return self.to_side(self.muscle.origins)

    @cached_property
    def flat_bones(self) -> Any:
        """The muscle with each point on its own bone, as the kernels of several bones take it."""
        return pack_broad_muscle(
            self.muscle, self.muscle.bones.number_points(self.muscle.sphere_frames)
        )

    def solve(self, rotation: npt.ArrayLike) -> MuscleState:
        """Solve one pose.

        Parameters
        ----------
        rotation
            (3, 3) humerus -> scapula, right-shoulder form.

        Returns
        -------
        MuscleState
            Lengths in m, moment vectors in m about the scapula axes, theta in rad, wrap states. In
            a muscle of more bones the last one is posed, and the others are at rest.

        Raises
        ------
        LinkedPlaneError
            For anything but a proper, finite rotation, and where a band's plane is undefined at
            that pose.

        """
        matrix = as_matrix(rotation)
        if not self._ball:
            return solve_last_bone(self, matrix[np.newaxis], 'rotation')[0]
        theta, lengths, moments, wrap, sided = self._solve(matrix[np.newaxis], 'rotation')
        return MuscleState(float(theta[0]), lengths[0], moments[0], wrap[0], sided[0], matrix, self)

    def solve_batch(self, rotations: npt.ArrayLike) -> MuscleStates:
        """Solve many poses; each answer is, to the bit, that of `solve`.

        Parameters
        ----------
        rotations
            (m, 3, 3) humerus -> scapula, right-shoulder form; m may be 0.

        Returns
        -------
        MuscleStates
            The fields of MuscleState with a leading m.

        Raises
        ------
        LinkedPlaneError
            As `solve`, for the first pose that has no answer.

        """
        matrices = as_matrices(rotations)
        if not self._ball:
            return solve_last_bone(self, matrices, 'rotations[{}]')
        return MuscleStates(*self._solve(matrices, 'rotations[{}]'), matrices, self)

    def solve_bones(self, bones: Mapping[str, Pose]) -> MuscleState:
        """Solve the muscle at one pose of each of its bones (spec bones.md).

        Parameters
        ----------
        bones
            For each bone that moves its pose (R, t), right-shoulder form: a point x of the bone
            stands at R x + t in the ground frame; R (3, 3), t (3,) m. A bone left out is at rest,
            where all bones' frames are the ground's.

        Returns
        -------
        MuscleState
            As from `solve`, with the `wrenches` on all bones that move. Moment vectors are about
            the ground's origin, of the last bone.

        Raises
        ------
        LinkedPlaneError
            For a bone that the muscle does not have or that is the ground, for anything but a
            proper, finite rotation and a finite shift, and where a band's plane is undefined.

        """
        return solve_over_bones(self, pack_poses(self.bones, bones), '')[0]

    def solve_bones_batch(self, bones: Mapping[str, Pose]) -> MuscleStates:
        """Solve many poses of the bones; each answer is, to the bit, that of `solve_bones`.

        Parameters
        ----------
        bones
            For each bone that moves its m poses (R, t): R (m, 3, 3), t (m, 3) m. A bone left out
            is at rest; m may be 0.

        Returns
        -------
        MuscleStates
            The fields of MuscleState with a leading m.

        Raises
        ------
        LinkedPlaneError
            As `solve_bones`, for the first pose that has no answer; for no bone at all, and for
            bones with different numbers of poses.

        """
        return solve_over_bones(self, pack_pose_batch(self.bones, bones), '[{}]')

    def answer(
        self, moved_by: Articulation, angles: npt.ArrayLike, speeds: npt.ArrayLike
    ) -> Answer:
        """Return the state, moment arms and lengthening at values and speeds, in one call.

        To rounding the same as the poses and screws of `moved_by`, `solve` or `solve_bones`, and
        their products.

        Parameters
        ----------
        moved_by
            What moves the bones: a joint convention (the last bone, about a ball joint), a
            skeleton for this muscle's bones (`Skeleton.for_bones`), or a `FollowedGirdle`.
        angles
            (d,) of its coordinates, rad; of prismatic joints, m.
        speeds
            (d,) of the same, rad/s or m/s.

        Returns
        -------
        Answer
            The state, moment arms (n, d) in m, lengthening (n,) in m/s, and a convention's axes
            (3, 3).

        Raises
        ------
        LinkedPlaneError
            For anything but an articulation of this muscle's bones and d finite numbers each, and
            where a band's plane is undefined.

        """
        if self._ball and isinstance(moved_by, JointConvention):
            return self._answer_ball_joint(moved_by, angles, speeds)
        check_articulation(moved_by)
        values = as_values('angles', angles, moved_by)
        rates = as_values('speeds', speeds, moved_by, '/s')
        answer = answer_over_bones(self, moved_by, values, rates)
        if isinstance(moved_by, JointConvention):
            return replace(answer, axes=moved_by.axes(values, self.side))
        return answer

    def answer_batch(
        self, moved_by: Articulation, angles: npt.ArrayLike, speeds: npt.ArrayLike
    ) -> AnswerBatch:
        """Return what `answer` does at many values.

        Parameters
        ----------
        moved_by
            As for `answer`.
        angles, speeds
            (m, d) as for `answer`; m may be 0.

        Returns
        -------
        AnswerBatch
            The fields of an Answer with a leading m; to rounding the same.

        Raises
        ------
        LinkedPlaneError
            As `answer`, for the first values that have no answer, and for speeds of another shape
            than the values.

        """
        check_articulation(moved_by)
        if not (self._ball and isinstance(moved_by, JointConvention)):
            return answer_batch_over_bones(self, moved_by, angles, speeds)
        rotations, axes = moved_by.rotations_and_axes(angles, self.side)
        rates = as_value_batch('speeds', speeds, len(rotations), moved_by, '/s')
        states = self.solve_batch(rotations)
        arms = states.moment_vectors @ axes
        return AnswerBatch(states, arms, -np.einsum('knj,kj->kn', arms, rates))

    def _answer_ball_joint(
        self, convention: JointConvention, angles: npt.ArrayLike, speeds: npt.ArrayLike
    ) -> Answer:
        """Return `answer` for a muscle of one ball joint, by one kernel."""
        n = len(self.muscle.band_names)
        rotation, axes, theta = np.empty((1, 3, 3)), np.empty((3, 3)), np.empty(1)
        lengths, moments, arms = np.empty((1, n)), np.empty((1, 3 * n)), np.empty((n, 3))
        wrap, one_sided = np.empty((1, n), dtype=np.uint8), np.empty((1, n), dtype=bool)
        lengthening = np.empty(n)
        _, fault, band = answer(
            self._flat,
            self.neutral,
            *convention.units_and_mix,
            as_triple('angles', angles, 'rad'),
            as_triple('speeds', speeds, 'rad/s'),
            AXIS_SIGN[self.side],
            rotation,
            axes,
            theta,
            lengths,
            moments,
            wrap,
            one_sided,
            arms,
            lengthening,
        )
        if fault != SOLVED:
            raise LinkedPlaneError(describe_pose_fault(self.muscle, fault, band))
        vectors = moments.reshape(n, 3)
        state = MuscleState(
            theta.item(), lengths[0], vectors, wrap[0], one_sided[0], rotation[0], self
        )
        return Answer(state, arms, lengthening, axes)

    def _solve(self, rotations: Floats, name: str) -> tuple[Floats, Floats, Floats, Bytes, Bools]:
        """Return theta (m,), lengths (m, n), moment vectors (m, n, 3), wrap, one_sided (m, n)."""
        m, n = len(rotations), len(self.muscle.band_names)
        theta = np.empty(m)
        lengths = np.empty((m, n))
        moments = np.empty((m, n, 3))
        wrap, one_sided = np.empty((m, n), dtype=np.uint8), np.empty((m, n), dtype=bool)
        filled = theta, lengths, moments.reshape(m, 3 * n), wrap, one_sided
        k, fault, band = run_kernel(solve_poses, (self._flat, self.neutral), rotations, filled)
        if fault != SOLVED:
            raise LinkedPlaneError(
                f'{name.format(k)}: {describe_pose_fault(self.muscle, fault, band)}'
            )
        if self.side == 'left':
            moments = mirror_axes(moments)
        return theta, lengths, moments, wrap, one_sided

    def draw_bands(
        self, state: MuscleState | MuscleStates, points: int
    ) -> tuple[Floats, Floats, Floats]:
        """Return the bands of a state as points in space.

        Parameters
        ----------
        state
            At one pose, or at m: then all arrays have a leading m.
        points
            How many on an arc, at least 2.

        Returns
        -------
        insertions : Floats
            (n, 3) m, scapula frame.
        centres : Floats
            (n, 3) m, of the obstacle spheres, scapula frame.
        arcs : Floats
            (n, points, 3) m, scapula frame; zero for bands that are not wrapped.

        Raises
        ------
        LinkedPlaneError
            For fewer than 2 points.

        """
        if points < 2:
            raise LinkedPlaneError(f'points: {points} given, at least 2 expected (Q and T)')
        *poses, n = state.wrap.shape
        m = poses[0] if poses else 1
        drawn = np.empty((m, n, 3)), np.empty((m, n, 3)), np.zeros((m, n, points, 3))
        # copies, so that the kernel is compiled once and not for each kind of part of an array
        thetas, wrap = np.array(state.theta, ndmin=1), np.array(state.wrap, ndmin=2)
        if state.posed is None:
            draw_poses(self._flat, np.array(state.rotation, ndmin=3), thetas, wrap, *drawn)
        else:
            bone_poses = np.array(state.posed.poses, ndmin=4)
            draw_bone_poses(self.flat_bones, bone_poses, thetas, wrap, *drawn)
        insertions, centres, arcs = map(self.to_side, drawn)
        return (insertions, centres, arcs) if poses else (insertions[0], centres[0], arcs[0])

    def to_side(self, points: Floats) -> Floats:
        """Return points of the right scapula as those of this side.

        Parameters
        ----------
        points
            (..., 3) m, scapula frame of the right shoulder.

        Returns
        -------
        Floats
            (..., 3) m, scapula frame of this side: mirrored, x -> -x, for the left one.

        """
        return mirror_points(points) if self.side == 'left' else points
