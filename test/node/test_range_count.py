# SPDX-License-Identifier: Apache-2.0
"""The counter of poses outside the range of motion: many at a time, none twice, none lost."""

from __future__ import annotations

import numpy as np
import pytest
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle
from linkedplane_ros.node.range_count import OddCounter

DELTOID = BroadMuscle.load('deltoid')


@pytest.mark.parametrize('count', [0, 1, 255, 256, 257, 600])
def test_every_pose_is_checked_once_and_256_at_a_time(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    checked: list[Array] = []

    def note(_: BroadMuscle, rotations: Array) -> int:
        checked.append(rotations.copy())
        return int(np.sum(rotations[:, 0, 0] < 0.0))

    monkeypatch.setattr(BroadMuscle, 'count_outside_range', note)
    poses = Rotation.random(600, random_state=7).as_matrix()[:count]
    counter = OddCounter(DELTOID.count_outside_range)
    for pose in poses:
        counter.add(pose)
    assert list(map(len, checked)) == [256] * (count // 256)
    assert counter.take_count() == np.sum(poses[:, 0, 0] < 0.0)
    assert counter.take_count() == 0
    np.testing.assert_array_equal(np.concatenate([poses[:0], *checked]), poses)
    assert all(map(len, checked))


def test_a_count_is_of_the_poses_since_the_last_one() -> None:
    inside, outside = (Rotation.from_euler('x', x, degrees=True).as_matrix() for x in (119, 121))
    counter = OddCounter(DELTOID.count_outside_range)
    for outsiders in (3, 1, 0, 2):
        for pose in (inside, *[outside] * outsiders, inside):
            counter.add(pose)
        assert counter.take_count() == outsiders
