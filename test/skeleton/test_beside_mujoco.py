# SPDX-License-Identifier: Apache-2.0
"""Poses and screws of random trees, and of the bundled ones, are those of MuJoCo.

1e-12 m and 1: both compute in doubles, over chains of a few metres.
"""

from __future__ import annotations

import numpy as np
import pytest
from optional import requires
from random_urdfs import MujocoTree, random_urdf

from linkedplane_ros import Skeleton
from linkedplane_ros.skeleton.skeleton import bundled_skeletons

TOLERANCE = 1e-12


@requires('mujoco')
@pytest.mark.parametrize('seed', range(25))
def test_links_of_a_random_tree_stand_and_move_as_in_mujoco(seed: int) -> None:
    text = random_urdf(seed)
    skeleton = Skeleton.from_urdf(text)
    mujoco = MujocoTree(text, skeleton)
    rng = np.random.default_rng(seed)
    for _ in range(3):
        q = rng.normal(size=len(skeleton.coordinates))
        mujoco.set_values(q)
        pose, screws = skeleton.pose(q), skeleton.screws(q)
        assert list(pose) == list(skeleton.bones[1:])
        for k, (bone, (R, t)) in enumerate(pose.items()):
            expected = mujoco.pose(bone, skeleton.bones[0])
            np.testing.assert_allclose(np.column_stack([R, t]), expected, atol=TOLERANCE)
            expected = mujoco.screws(bone, skeleton.bones[0])
            np.testing.assert_allclose(screws[:, k], expected, atol=TOLERANCE)


@requires('mujoco')
@pytest.mark.parametrize('seed', range(25))
def test_bones_seen_from_a_ground_that_is_not_the_root_move_as_in_mujoco(seed: int) -> None:
    text = random_urdf(seed)
    rng = np.random.default_rng(seed)
    whole = Skeleton.from_urdf(text)
    bones = [whole.bones[i] for i in rng.permutation(len(whole.bones))[:4]]
    resting = dict(zip(whole.coordinates, rng.normal(size=len(whole.coordinates)), strict=True))
    skeleton = whole.for_bones(bones, rest=resting)
    mujoco = MujocoTree(text, skeleton)
    mujoco.set_values(np.array(list(resting.values())))
    rest = {bone: np.vstack([mujoco.pose(bone, bones[0]), [0, 0, 0, 1]]) for bone in bones}
    q = rng.normal(size=len(skeleton.coordinates))
    mujoco.set_values(q)
    for k, (bone, (R, t)) in enumerate(skeleton.pose(q).items()):
        # a point of the bone stands at x at rest, so at T_link(rest)^-1 x in the link
        expected = mujoco.pose(bone, bones[0]) @ np.linalg.inv(rest[bone])
        np.testing.assert_allclose(np.column_stack([R, t]), expected, atol=TOLERANCE)
        np.testing.assert_allclose(
            skeleton.screws(q)[:, k], mujoco.screws(bone, bones[0]), atol=TOLERANCE
        )


@requires('mujoco')
@pytest.mark.parametrize('name', sorted(bundled_skeletons()))
def test_mujoco_reads_a_bundled_skeleton_as_it_is(name: str) -> None:
    skeleton = Skeleton.load(name)
    mujoco = MujocoTree(bundled_skeletons()[name], skeleton)
    ground, *bones = skeleton.bones
    mujoco.set_values(np.zeros(len(skeleton.coordinates)))
    rest = {bone: np.vstack([mujoco.pose(bone, ground), [0, 0, 0, 1]]) for bone in bones}
    for q in np.random.default_rng(1).normal(size=(20, len(skeleton.coordinates))):
        mujoco.set_values(q)
        screws = skeleton.screws(q)
        for k, (bone, (R, t)) in enumerate(skeleton.pose(q).items()):
            expected = mujoco.pose(bone, ground) @ np.linalg.inv(rest[bone])
            np.testing.assert_allclose(np.column_stack([R, t]), expected, atol=TOLERANCE)
            np.testing.assert_allclose(screws[:, k], mujoco.screws(bone, ground), atol=TOLERANCE)
