# SPDX-License-Identifier: Apache-2.0
"""Moment arms beyond the bound: none in a range of motion, true ones outside."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.joints.conventions import THESIS_CONVENTION
from linkedplane_ros.solver.moment_bounds import moment_arm_bounds
from linkedplane_ros.solver.range_check import DEFAULT_RANGE

MODELS = ('deltoid', 'deltoid_ackland2008', 'example_shared_sphere', 'example_humerus_spheres')


@pytest.mark.parametrize('name', MODELS)
def test_no_pose_of_a_models_range_exceeds_the_bound(name: str) -> None:
    muscle = BroadMuscle.load(name)
    low, high = np.array(muscle.range_of_motion or DEFAULT_RANGE).T
    angles = np.random.default_rng(21).uniform(low, high, (2000, 3))
    rotations, axes = THESIS_CONVENTION.rotations_and_axes(angles)
    arms = LinkedPlaneSolver(muscle).solve_batch(rotations).moment_vectors @ axes
    assert (np.abs(arms) < moment_arm_bounds(muscle)[:, np.newaxis]).all()


def test_the_bound_is_exceeded_where_theta_turns_faster_than_the_arm() -> None:
    muscle = BroadMuscle.load('deltoid_ackland2008')
    rotations = Rotation.random(2000, np.random.default_rng(22)).as_matrix()
    moments = LinkedPlaneSolver(muscle).solve_batch(rotations).moment_vectors
    beyond = np.linalg.norm(moments, axis=2) > moment_arm_bounds(muscle)
    assert 0.01 < beyond.any(axis=1).mean() < 0.2


def test_the_bound_follows_the_size_of_the_arm() -> None:
    muscle = BroadMuscle.load('deltoid')
    reach = np.linalg.norm(muscle.insertions, axis=1)
    np.testing.assert_allclose(moment_arm_bounds(muscle), 3.0 * reach)
    longer = muscle.scaled(1.5)
    np.testing.assert_allclose(moment_arm_bounds(longer), 4.5 * reach)
