# SPDX-License-Identifier: Apache-2.0
"""Which rotations lie in a muscle's range of motion."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle
from linkedplane_ros.muscle.range_of_motion import find_in_range

DELTOID = BroadMuscle.load('deltoid')
RANGES = DELTOID.range_of_motion
assert RANGES is not None


def rotations(degrees: Array) -> Array:
    """Return R(x, flexion) R(-y, abduction) R(z, rotation), by SciPy, over quaternions."""
    turned = Rotation.from_euler('XYZ', np.atleast_2d(degrees) * (1, -1, 1), degrees=True)
    return np.array(Rotation.from_quat(turned.as_quat()).as_matrix())


@pytest.mark.parametrize('abduction', [90.0, 90.0 - 1e-9, 90.0 + 1e-9, 89.99, 90.01])
def test_a_pose_in_range_is_in_range_also_where_flexion_and_rotation_are_one(
    abduction: float,
) -> None:
    poses = [
        (flexion, abduction, rotation)
        for flexion, rotation in itertools.product((-40, -13, 0, 51, 120), (-60, -7, 0, 33, 60))
    ]
    assert DELTOID.count_outside_range(rotations(np.array(poses, dtype=float))) == 0


@pytest.mark.parametrize('up', [1.0, -1.0])
def test_upright_a_pose_is_outside_where_no_share_of_its_turn_is_in_range(up: float) -> None:
    ranges = [(-0.5, 1.0), (-np.pi / 2, np.pi / 2), (-0.25, 0.5)]
    # rotation - up * flexion is all that is seen
    corners = [r - up * f for f, r in itertools.product(ranges[0], ranges[2])]
    least, most = min(corners), max(corners)
    turns = np.array([least - 1e-3, least + 1e-3, 0.0, most - 1e-3, most + 1e-3])
    poses = [(0.0, up * 90.0, turn) for turn in np.degrees(turns)]
    found = find_in_range(rotations(np.array(poses)), ranges)
    assert found.tolist() == [False, True, True, True, False]


def test_elsewhere_two_triples_give_a_rotation_and_one_in_range_is_enough() -> None:
    low, high = np.degrees(RANGES).T
    angles = np.random.default_rng(4).uniform(-180.0, 180.0, (2000, 3))
    other = np.array([angles[:, 0] + 180.0, 180.0 - angles[:, 1], angles[:, 2] + 180.0]).T
    wrapped = [np.degrees(np.angle(np.exp(1j * np.radians(each)))) for each in (angles, other)]
    wanted = np.any([((low < each) & (each < high)).all(axis=1) for each in wrapped], axis=0)
    assert 0 < wanted.sum() < 2000
    np.testing.assert_array_equal(find_in_range(rotations(angles), RANGES), wanted)
