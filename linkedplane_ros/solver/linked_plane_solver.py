# SPDX-License-Identifier: Apache-2.0
"""Solve the linked-plane muscle for a pose: lengths, moment vectors, wrap states and paths.

The scapula frame of the right shoulder has its origin at the glenohumeral centre, x lateral,
y anterior, z superior; a pose is the rotation that takes humerus coordinates to scapula ones. The
left shoulder is the mirror image: its frame has x to the body's right as well, and it is posed by
the rotation of the right shoulder at the same anatomical angles.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError, describe_value
from ..joints.conventions import JointConvention, as_triple
from ..joints.rotations import FAULTS, as_matrices, as_matrix
from ..joints.sides import AXIS_SIGN, check_side, mirror_axes, mirror_points
from ..linked_planes.compilation import COMPILED
from ..linked_planes.layout import pack_muscle
from ..muscle.bones import Bones
from ..muscle.broad_muscle import BroadMuscle
from ..types import Bytes, Floats
from .batches import run_kernel
from .kernels import NO_PLANE, SOLVED, answer, draw_poses, solve_poses
from .states import Answer, MuscleState, MuscleStates

NO_PLANE_REASON = (
    'band {} has no plane at this pose: it ends where it begins, or the normal before it runs '
    'along its line'
)
NO_FRAME_REASON = ', or its sphere has no frame: HM lies in line with its origin and SC'


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
        self._flat = pack_broad_muscle(muscle)
        self._neutral = 0.0
        neutral = self.solve(np.eye(3))
        neutral.paths()
        self._neutral = neutral.theta

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, LinkedPlaneSolver):
            return NotImplemented
        return self.side == other.side and self.muscle == other.muscle

    def __hash__(self) -> int:
        return hash((self.side, self.muscle))

    def __reduce__(self) -> tuple[Any, ...]:
        return LinkedPlaneSolver, (self.muscle, self.side)  # the rest follows from them

    @property
    def origins(self) -> Floats:
        """(n, 3) origins, m, scapula frame."""
        return self.to_side(self.muscle.origins)

    def solve(self, rotation: npt.ArrayLike) -> MuscleState:
        """Solve one pose.

        Parameters
        ----------
        rotation
            (3, 3) humerus -> scapula, right-shoulder form.

        Returns
        -------
        MuscleState
            Lengths in m, moment vectors in m about the scapula axes, theta in rad, wrap states.

        Raises
        ------
        LinkedPlaneError
            For anything but a proper, finite rotation, and where a band's plane is undefined at
            that pose.

        """
        matrix = as_matrix(rotation)
        theta, lengths, moments, wrap = self._solve(matrix[np.newaxis], 'rotation')
        return MuscleState(float(theta[0]), lengths[0], moments[0], wrap[0], matrix, self)

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
        return MuscleStates(*self._solve(matrices, 'rotations[{}]'), matrices, self)

    def answer(
        self, convention: JointConvention, angles: npt.ArrayLike, speeds: npt.ArrayLike
    ) -> Answer:
        """Return the state, moment arms and lengthening at three angles and speeds, in one call.

        To rounding the same as `convention.rotation_and_axes`, `solve` and their products.

        Parameters
        ----------
        convention
            What the angles mean.
        angles
            (3,) rad.
        speeds
            (3,) rad/s, of the angles.

        Returns
        -------
        Answer
            The state, moment arms (n, 3) in m, lengthening (n,) in m/s, and axes (3, 3).

        Raises
        ------
        LinkedPlaneError
            For anything but a JointConvention and three finite numbers each, and where a band's
            plane is undefined.

        """
        if not isinstance(convention, JointConvention):
            given = describe_value(convention)
            raise LinkedPlaneError(f'convention: {given} given, one of JOINT_CONVENTIONS expected')
        n = len(self.muscle.band_names)
        rotation, axes, theta = np.empty((1, 3, 3)), np.empty((3, 3)), np.empty(1)
        lengths, moments, arms = np.empty((1, n)), np.empty((1, 3 * n)), np.empty((n, 3))
        wrap, lengthening = np.empty((1, n), dtype=np.uint8), np.empty(n)
        _, fault, band = answer(
            self._flat,
            self._neutral,
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
            arms,
            lengthening,
        )
        if fault != SOLVED:
            raise LinkedPlaneError(self._reason(fault, band))
        vectors = moments.reshape(n, 3)
        state = MuscleState(theta.item(), lengths[0], vectors, wrap[0], rotation[0], self)
        return Answer(state, arms, lengthening, axes)

    def _solve(self, rotations: Floats, name: str) -> tuple[Floats, Floats, Floats, Bytes]:
        """Return theta (m,), lengths (m, n), moment vectors (m, n, 3) and wrap (m, n)."""
        m, n = len(rotations), len(self.muscle.band_names)
        theta = np.empty(m)
        lengths = np.empty((m, n))
        moments = np.empty((m, n, 3))
        wrap = np.empty((m, n), dtype=np.uint8)
        filled = theta, lengths, moments.reshape(m, 3 * n), wrap
        k, fault, band = run_kernel(solve_poses, (self._flat, self._neutral), rotations, filled)
        if fault != SOLVED:
            raise LinkedPlaneError(f'{name.format(k)}: {self._reason(fault, band)}')
        if self.side == 'left':
            moments = mirror_axes(moments)
        return theta, lengths, moments, wrap

    def _reason(self, fault: int, band: int) -> str:
        """Return why a pose has no answer; `band` is the one that has no plane."""
        if fault != NO_PLANE:
            return FAULTS[fault]
        moving = self.muscle.sphere_frames[band] == 'moving'
        reason = NO_PLANE_REASON.format(self.muscle.band_names[band])
        return reason + NO_FRAME_REASON if moving else reason

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
        rotations = np.array(state.rotation, ndmin=3)
        thetas, wrap = np.array(state.theta, ndmin=1), np.array(state.wrap, ndmin=2)
        draw_poses(self._flat, rotations, thetas, wrap, *drawn)
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


def pack_broad_muscle(muscle: BroadMuscle) -> Any:
    """Return the muscle as the kernels read it: an array compiled, a list, faster, if not."""
    numbers = pack_muscle(
        muscle.reference_normal,
        muscle.ground_point,
        muscle.humeral_point,
        muscle.origins,
        muscle.insertions,
        muscle.sphere_centres,
        muscle.sphere_radii,
        np.cos(muscle.plane_angles),
        np.sin(muscle.plane_angles),
        Bones().number_on_ball_joint(muscle.sphere_frames),
    )
    return numbers if COMPILED else numbers.tolist()
