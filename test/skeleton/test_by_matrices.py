# SPDX-License-Identifier: Apache-2.0
"""Poses of random trees are products of SciPy's matrices, read from the URDF anew."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest
from random_urdfs import joint, link, random_urdf, robot
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import Skeleton


def numbers(element: Element, tag: str, attribute: str) -> Array:
    """Return the numbers of an attribute of a part, of zeros where it is not there."""
    part = element.find(tag)
    return np.array((part.get(attribute) if part is not None else '0 0 0').split(), dtype=float)


def value(name: str, joints: dict[str, Element], values: dict[str, float]) -> float:
    """Return a joint's value: its own, or what it takes of the one that it mimics."""
    mimic = joints[name].find('mimic')
    if mimic is None:
        return values[name]
    other = value(mimic.get('joint'), joints, values)
    return float(mimic.get('multiplier')) * other + float(mimic.get('offset'))


def pose_by_matrices(text: str, to: str, values: dict[str, float]) -> Array:
    """Return the (4, 4) pose of a link in the root, from its joints upwards."""
    joints = {each.get('name'): each for each in ElementTree.fromstring(text).findall('joint')}
    above = {each.find('child').get('link'): each for each in joints.values()}
    pose = np.eye(4)
    while to in above:
        element = above[to]
        place, moved = np.eye(4), np.eye(4)
        place[:3, :3] = Rotation.from_euler('xyz', numbers(element, 'origin', 'rpy')).as_matrix()
        place[:3, 3] = numbers(element, 'origin', 'xyz')
        axis = numbers(element, 'axis', 'xyz')
        kind = element.get('type')
        if kind != 'fixed':
            along = axis / np.linalg.norm(axis) * value(element.get('name'), joints, values)
            if kind == 'prismatic':
                moved[:3, 3] = along
            else:
                moved[:3, :3] = Rotation.from_rotvec(along).as_matrix()
        pose = place @ moved @ pose
        to = element.find('parent').get('link')
    return pose


@pytest.mark.parametrize('seed', range(200, 215))
def test_links_stand_where_products_of_matrices_put_them(seed: int) -> None:
    text = random_urdf(seed, links=10)
    skeleton = Skeleton.from_urdf(text)
    q = np.random.default_rng(seed).normal(size=len(skeleton.coordinates))
    values = dict(zip(skeleton.coordinates, q.tolist(), strict=True))
    for name, (R, t) in skeleton.pose(q).items():
        expected = pose_by_matrices(text, name, values)
        np.testing.assert_allclose(R, expected[:3, :3], rtol=0, atol=1e-13)
        np.testing.assert_allclose(t, expected[:3, 3], rtol=0, atol=1e-12)  # m


@pytest.mark.parametrize('seed', range(230, 240))
@pytest.mark.parametrize('placed', [False, True])
def test_the_ground_stands_in_the_root_where_products_of_matrices_put_it(
    seed: int, placed: bool
) -> None:
    text = random_urdf(seed, links=10)
    whole = Skeleton.from_urdf(text)
    rng = np.random.default_rng(seed)
    ground, bone = rng.choice(whole.links, 2, replace=False).tolist()
    xyz, rpy = rng.normal(size=(2, 3)) * placed
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = Rotation.from_euler('xyz', rpy).as_matrix(), xyz
    given = ','.join(map(repr, [*xyz.tolist(), *rpy.tolist()]))
    skeleton = whole.for_bones(['g', bone], {'g': f'{ground}@{given}' if placed else ground})
    q = rng.normal(size=len(whole.coordinates))
    values = dict(zip(whole.coordinates, q.tolist(), strict=True))
    expected = (pose_by_matrices(text, ground, values) @ place)[:3]
    np.testing.assert_allclose(skeleton.pose_ground(q), expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(skeleton.pose_ground(q, 'left'), skeleton.pose_ground(q))


def test_in_a_skeleton_of_the_other_side_the_ground_is_the_mirror_image() -> None:
    skeleton = Skeleton.load('shoulder_girdle')
    q = np.random.default_rng(7).normal(size=len(skeleton.coordinates))
    right, left = (skeleton.pose_ground(q, side) for side in ('right', 'left'))
    mirror = np.diag([-1.0, 1.0, 1.0])
    np.testing.assert_array_equal(right, skeleton.pose_ground(q))
    np.testing.assert_allclose(left[:, :3], mirror @ right[:, :3] @ mirror, rtol=0, atol=1e-15)
    np.testing.assert_allclose(left[:, 3], mirror @ right[:, 3], rtol=0, atol=1e-15)


def test_a_joint_that_takes_nothing_of_a_coordinate_does_not_need_it() -> None:
    limit = '<axis xyz="0 0 1"/>'
    text = robot(
        *map(link, 'abcd'),
        joint('leads', 'revolute', 'a', 'b', limit),
        joint('stays', 'revolute', 'a', 'c', f'{limit}<mimic joint="leads" multiplier="0"/>'),
        joint('moves', 'revolute', 'c', 'd', limit),
    )
    assert Skeleton.from_urdf(text).for_bones(['a', 'd']).moving == ('moves',)
    assert Skeleton.from_urdf(text).moving == ('leads', 'moves')
