# SPDX-License-Identifier: Apache-2.0
"""What may change without changing the answer: the axes, the size, the first band's angle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from deltoid_poses import RANGES
from hypothesis import given, settings
from hypothesis import strategies as st
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
unit_quaternions = st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(
    lambda q: np.linalg.norm(q) > 0.1
)
in_range = st.tuples(*(st.floats(*span) for span in RANGES))
few = settings(deadline=None, max_examples=60, derandomize=True)


def turned(muscle: BroadMuscle, Q: Array) -> BroadMuscle:
    """Return the muscle with both frames turned about the glenohumeral centre."""
    return replace(
        muscle,
        origins=muscle.origins @ Q.T,
        insertions=muscle.insertions @ Q.T,
        ground_point=Q @ muscle.ground_point,
        humeral_point=Q @ muscle.humeral_point,
        reference_normal=Q @ muscle.reference_normal,
    )


@few
@given(q=unit_quaternions, angles=in_range)
def test_a_rigid_motion_of_everything_turns_the_moments_and_keeps_the_rest(
    q: list[float], angles: tuple[float, ...]
) -> None:
    Q = Rotation.from_quat(q).as_matrix()
    R = THESIS.rotation(angles)
    here, there = SOLVER.solve(R), LinkedPlaneSolver(turned(DELTOID, Q)).solve(Q @ R @ Q.T)
    # m, rad: rounding; lengths depend on theta by up to 0.03 m/rad
    np.testing.assert_allclose(there.lengths, here.lengths, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(
        there.moment_vectors, here.moment_vectors @ Q.T, rtol=0.0, atol=1e-10
    )


@few
@given(scale=st.floats(1e-3, 50.0), angles=in_range)
def test_lengths_and_moments_scale_with_the_muscle(scale: float, angles: tuple[float, ...]) -> None:
    larger = replace(
        DELTOID,
        origins=DELTOID.origins * scale,
        insertions=DELTOID.insertions * scale,
        sphere_centres=DELTOID.sphere_centres * scale,
        sphere_radii=DELTOID.sphere_radii * scale,
        ground_point=DELTOID.ground_point * scale,
        humeral_point=DELTOID.humeral_point * scale,
    )
    R = THESIS.rotation(angles)
    here, there = SOLVER.solve(R), LinkedPlaneSolver(larger).solve(R)
    np.testing.assert_allclose(there.lengths / scale, here.lengths, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(
        there.moment_vectors / scale, here.moment_vectors, rtol=0.0, atol=1e-10
    )


@few
@given(first=st.floats(-3, 3), angles=in_range)
def test_the_first_bands_own_angle_is_taken_up_by_theta(
    first: float, angles: tuple[float, ...]
) -> None:
    phi = DELTOID.plane_angles.copy()
    phi[0] += first
    R = THESIS.rotation(angles)
    there = LinkedPlaneSolver(replace(DELTOID, plane_angles=phi)).solve(R)
    np.testing.assert_array_equal(there.lengths, SOLVER.solve(R).lengths)


@few
@given(turn=st.floats(-1, 1), angles=in_range)
def test_a_turned_reference_normal_gives_another_theta_and_the_same_lengths(
    turn: float, angles: tuple[float, ...]
) -> None:
    axis = np.cross(DELTOID.reference_normal, (0.0, 0.0, 1.0))
    Q = Rotation.from_rotvec(turn * axis / np.linalg.norm(axis)).as_matrix()
    other = LinkedPlaneSolver(replace(DELTOID, reference_normal=Q @ DELTOID.reference_normal))
    R = THESIS.rotation(angles)
    np.testing.assert_allclose(other.solve(R).lengths, SOLVER.solve(R).lengths, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        other.solve(R).moment_vectors, SOLVER.solve(R).moment_vectors, rtol=0, atol=1e-10
    )
