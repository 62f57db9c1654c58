# SPDX-License-Identifier: Apache-2.0
"""Moment arms about humerothoracic coordinates, by difference quotients along the coordinate.

The lengths are those at the bones' whole poses against the thorax, put together here by 4 x 4
matrices: neither screws nor what answers the moment arms has a part in it.
"""

from __future__ import annotations

import numpy as np
import pytest
from reference import Array

from linkedplane_ros import JOINT_CONVENTIONS, RHYTHMS, BroadMuscle, LinkedPlaneSolver, Rest
from linkedplane_ros.skeleton.followed_girdle import FollowedGirdle

ISB = JOINT_CONVENTIONS['isb_yxy']
REST = Rest((0.24, -0.08, -0.1), (-0.4, 0.1, 0.05), (-0.45, 0.24))
LOW, HIGH = (-0.5, 0.15, -1.0), (1.8, 2.4, 1.0)  # rad: the arm raised from 9 to 138 deg
STEP = 1e-4  # rad, and twice that


def matrix(pose: tuple[Array, Array]) -> Array:
    """Return a pose (R, t) as (4, 4)."""
    return np.vstack((np.column_stack(pose), (0.0, 0.0, 0.0, 1.0)))


def bones_at(name: str, angles: Array, solver: LinkedPlaneSolver) -> list[Array]:
    """Return the poses (4, 4) of the muscle's moving bones in the scapula, since rest."""
    now = {bone: matrix(pose) for bone, pose in RHYTHMS[name].bones(angles, REST).items()}
    assert REST.humerus is not None
    start = RHYTHMS[name].bones((*REST.humerus, 0.0), REST)
    rest = {bone: matrix(pose) for bone, pose in start.items()}
    back, from_rest = np.linalg.inv(now['scapula']), np.linalg.inv(rest['clavicle'])
    moved = {
        'clavicle': back @ now['clavicle'] @ from_rest @ rest['scapula'],
        'humerus': back @ now['humerus'],
    }
    return [moved[bone] for bone in solver.bones[1:]]


def lengths_at(solver: LinkedPlaneSolver, name: str, angles: Array) -> tuple[Array, Array]:
    """Return lengths and wrap states (m, n) at angles (m, 3)."""
    poses = np.array([bones_at(name, each, solver) for each in angles])
    states = solver.solve_bones_batch(
        {bone: (poses[:, k, :3, :3], poses[:, k, :3, 3]) for k, bone in enumerate(solver.bones[1:])}
    )
    return states.lengths, states.wrap


@pytest.mark.parametrize('model', ['deltoid', 'deltoid_girdle'])
@pytest.mark.parametrize('name', RHYTHMS)
def test_over_random_poses_moment_arms_are_differences_of_lengths(name: str, model: str) -> None:
    solver = LinkedPlaneSolver(BroadMuscle.load(model))
    angles = np.random.default_rng(19).uniform(LOW, HIGH, (200, 3))
    answers = solver.answer_batch(
        FollowedGirdle(ISB, RHYTHMS[name], REST), angles, np.zeros((200, 3))
    )
    lengths, wrap = lengths_at(solver, name, angles)
    np.testing.assert_allclose(answers.states.lengths, lengths, rtol=0, atol=1e-14)
    smooth = 0
    for j in range(3):
        ends = [lengths_at(solver, name, angles + k * STEP * np.eye(3)[j]) for k in (-2, -1, 1, 2)]
        (a, *_), (b, *_), (c, *_), (d, *_) = ends
        slope = (8.0 * (c - b) - (d - a)) / (12.0 * STEP)
        # no band comes on or off its sphere meanwhile
        same = np.logical_and.reduce([(w == wrap).all(axis=1) for _, w in ends])
        smooth += int(same.sum())
        np.testing.assert_allclose(answers.moment_arms[same, :, j], -slope[same], rtol=0, atol=2e-9)
    assert smooth > 580  # of 600


@pytest.mark.parametrize('name', RHYTHMS)
@pytest.mark.parametrize('convention', ['isb_yxy', 'opensim_mobl', 'rep155'])
@pytest.mark.parametrize('angles', [(0.0, 0.0, 0.0), (0.7, 0.0, -0.3)])
def test_at_the_side_all_is_smooth(
    name: str, convention: str, angles: tuple[float, float, float]
) -> None:
    """Though there plane and axial rotation turn the humerus about one axis."""
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
    followed = FollowedGirdle(JOINT_CONVENTIONS[convention], RHYTHMS[name], REST)
    here = np.array(angles)
    answer = solver.answer(followed, here, np.zeros(3))
    for j in range(3):
        ends = [
            solver.answer(followed, here + k * STEP * np.eye(3)[j], np.zeros(3)).state.lengths
            for k in (-2, -1, 1, 2)
        ]
        slope = (8.0 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12.0 * STEP)
        np.testing.assert_allclose(answer.moment_arms[:, j], -slope, rtol=0, atol=2e-9)


@pytest.mark.parametrize('name', RHYTHMS)
def test_angles_and_the_pose_that_they_give_have_one_answer(name: str) -> None:
    rhythm = RHYTHMS[name]
    for angles in np.random.default_rng(5).uniform((-7.0, 0.1, -7.0), (7.0, 3.0, 7.0), (50, 3)):
        by_angles = rhythm.pose_at(angles, rest=REST)
        by_pose = rhythm.pose(*ISB.rotation_and_axes(angles), REST)
        for field in ('scapula', 'clavicle', 'humerus', 'scapula_axes', 'clavicle_axes', 'axes'):
            np.testing.assert_allclose(
                getattr(by_angles, field), getattr(by_pose, field), rtol=0, atol=1e-12
            )


def test_a_rhythm_states_its_range_and_source() -> None:
    for rhythm in RHYTHMS.values():
        low, high = rhythm.range
        assert 0.0 <= low < high <= np.pi
        assert rhythm.source
        assert rhythm.valid
