# SPDX-License-Identifier: Apache-2.0
"""The left shoulder is the mirror image of the right."""

import numpy as np
import pytest
import reference
from deltoid_poses import BATCH, POSES

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver

DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side=side) for side in ('right', 'left'))
NEUTRAL = RIGHT.solve(np.eye(3)).theta


def test_the_left_shoulder_is_as_long_as_the_right() -> None:
    left = LEFT.solve_batch(POSES)
    assert left.lengths.tobytes() == BATCH.lengths.tobytes()
    assert left.wrap.tobytes() == BATCH.wrap.tobytes()


def test_the_left_shoulders_paths_are_mirrored() -> None:
    for rotation in POSES[:10]:
        right, left = RIGHT.solve(rotation), LEFT.solve(rotation)
        for one, other in zip(right.paths(), left.paths(), strict=True):
            np.testing.assert_array_equal(other, one * [-1.0, 1.0, 1.0])
        np.testing.assert_array_equal(left.sphere_centres, right.sphere_centres * [-1, 1, 1])


@pytest.mark.parametrize('name', list(JOINT_CONVENTIONS))
def test_the_left_shoulders_moment_arms_are_the_rights(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    for angles in np.random.default_rng(4).uniform([-1, 0.2, -1], [1, 1.5, 1], (20, 3)):
        rotation = convention.rotation(angles)
        right = RIGHT.solve(rotation).moment_vectors @ convention.axes(angles)
        left = LEFT.solve(rotation).moment_vectors @ convention.axes(angles, side='left')
        np.testing.assert_allclose(left, right, rtol=0.0, atol=1e-15)


def test_left_moment_vectors_are_differences_of_the_muscle_mirrored_by_hand() -> None:
    muscle = reference.mirrored(DELTOID)
    neutral = reference.neutral_theta(muscle)
    assert neutral == pytest.approx(-NEUTRAL, abs=1e-9)
    checked = 0
    for rotation in POSES[:8]:
        state = LEFT.solve(rotation)
        turned = reference.mirrored_rotation(rotation)
        theta = reference.least_theta(muscle, turned[np.newaxis], neutral)[0]
        lengths = reference.lengths_at(muscle, turned, theta)
        np.testing.assert_allclose(state.lengths, lengths, rtol=0.0, atol=1e-11)
        found = reference.moment_vectors(muscle, turned, neutral)
        if found.smooth and found.error < 1e-9:
            np.testing.assert_allclose(state.moment_vectors, found.vectors, rtol=0.0, atol=1e-8)
            checked += 1
    assert checked >= 5
