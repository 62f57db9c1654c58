# SPDX-License-Identifier: Apache-2.0
"""The values of a skeleton's joints, found from where its bones were measured."""

from __future__ import annotations

import numpy as np
import pytest
from random_urdfs import joint, link, robot
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, Skeleton
from linkedplane_ros.joints.sides import mirror_poses
from linkedplane_ros.skeleton.posture import PostureSearch
from linkedplane_ros.types import Floats

BONES = ('scapula', 'clavicle', 'humerus')
GIRDLE = Skeleton.load('shoulder_girdle')
LOWER, UPPER = np.array(GIRDLE.limits).T


def poses_at(skeleton: Skeleton, values: Floats) -> Floats:
    """Return where the bones stand (m, k, 3, 4)."""
    posed = skeleton.pose_batch(values)
    return np.stack(
        [np.concatenate([R, t[..., np.newaxis]], axis=-1) for R, t in posed.values()], axis=1
    )


def random_values(m: int) -> Floats:
    values = np.random.default_rng(m).uniform(LOWER, UPPER, (m, 9))
    values[:, :3] = 0.0  # nothing of the SC joint is seen from the scapula
    values[:, 7] = np.abs(values[:, 7])
    return values


def test_any_posture_within_the_limits_is_found_from_its_poses() -> None:
    poses = poses_at(GIRDLE, random_values(100))
    found = PostureSearch(GIRDLE, BONES).find(poses)
    assert found.turn.max() < 1e-6  # rad
    assert found.shift.max() < 1e-6  # m
    np.testing.assert_allclose(poses_at(GIRDLE, found.values), poses, rtol=0, atol=1e-6)
    assert (found.values >= LOWER).all()
    assert (found.values <= UPPER).all()
    assert (found.values[:, :3] == 0.0).all()


def test_what_is_found_depends_on_the_pose_alone() -> None:
    poses = poses_at(GIRDLE, random_values(30))
    search = PostureSearch(GIRDLE, BONES)
    together = search.find(poses).values
    order = np.random.default_rng(0).permutation(30)
    np.testing.assert_array_equal(search.find(poses[order]).values, together[order])
    for k in (3, 17):
        alone = PostureSearch(GIRDLE, BONES).find(poses[k : k + 1]).values[0]
        np.testing.assert_allclose(alone, together[k], rtol=0, atol=1e-12)


def test_bones_of_another_length_turn_as_measured() -> None:
    values = random_values(20)
    values[:, 3:6] *= 0.5
    poses = poses_at(GIRDLE, values)
    poses[:, 0, :, 3] += (0.02, -0.01, 0.015)  # m: another subject's clavicle
    found = PostureSearch(GIRDLE, BONES).find(poses)
    assert found.turn.max() < 1e-5  # rad
    np.testing.assert_allclose(found.shift, np.linalg.norm((0.02, -0.01, 0.015)), rtol=1e-3)
    isb = JOINT_CONVENTIONS['isb_yxy']
    for q, pose in zip(found.values, poses, strict=True):
        np.testing.assert_allclose(isb.rotation(q[6:]), pose[1, :, :3], rtol=0, atol=1e-6)


def test_beyond_the_limits_the_nearest_posture_within_is_given_with_its_misfit() -> None:
    beyond = np.zeros((1, 9))
    beyond[0, 7] = UPPER[7] + 0.3
    found = PostureSearch(GIRDLE, BONES).find(poses_at(GIRDLE, beyond))
    assert found.values[0, 7] == UPPER[7]
    assert found.turn[0] == pytest.approx(0.3, abs=1e-6)


def test_sliding_and_endless_joints_are_found_too() -> None:
    limit = '<limit lower="-0.2" upper="0.3" effort="1" velocity="1"/>'
    skeleton = Skeleton.from_urdf(
        robot(
            *map(link, ('base', 'a', 'b', 'tip')),
            joint('lift', 'prismatic', 'base', 'a', f'<axis xyz="0 0 1"/>{limit}'),
            joint('spin', 'continuous', 'a', 'b', '<axis xyz="0 1 0"/>'),
            joint('push', 'prismatic', 'b', 'tip', f'<axis xyz="1 0 0"/>{limit}'),
        )
    ).for_bones(('base', 'tip'))
    values = np.array([(0.1, 0.4, -0.15), (0.25, -3.0, 0.29), (-0.19, 3.1, 0.0)])
    found = PostureSearch(skeleton, ('base', 'tip')).find(poses_at(skeleton, values))
    apart = found.values - values
    apart[:, 1] = (apart[:, 1] + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(apart, 0.0, rtol=0, atol=1e-6)
    assert np.abs(found.values[:, 1]).max() <= np.pi


def test_the_left_arm_takes_the_same_values_as_the_mirrored_right_one() -> None:
    values = random_values(10)
    text = robot(
        *map(link, ('scapula', 'a', 'humerus')),
        *(
            joint(name, 'continuous', *ends, f'<axis xyz="{axis}"/>')
            for name, ends, axis in (
                ('p', ('scapula', 'a'), '0 0 1'),
                ('q', ('a', 'humerus'), '0 1 0'),
            )
        ),
    )
    skeleton = Skeleton.from_urdf(text).for_bones(('scapula', 'humerus'))
    values = values[:, 6:8]
    own = poses_at(skeleton, values)  # as it stands on the left side
    found = PostureSearch(skeleton, ('scapula', 'humerus'), 'left').find(mirror_poses(own))
    assert found.turn.max() < 1e-6
    wanted = Rotation.from_euler('ZY', values).as_matrix()
    np.testing.assert_allclose(
        Rotation.from_euler('ZY', found.values).as_matrix(), wanted, rtol=0, atol=1e-6
    )
