# SPDX-License-Identifier: Apache-2.0
"""How the viewer moves the arm: to the poses of the case study, in sweeps, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle
from linkedplane_ros.viewer.panels import motions
from linkedplane_ros.viewer.panels.ranges import slider_ranges

DELTOID = BroadMuscle.load('deltoid')


@pytest.mark.parametrize('name', JOINT_CONVENTIONS)
def test_the_end_poses_of_the_case_study_are_the_same_in_every_convention(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    found = motions.end_poses(convention)
    assert list(found) == ['neutral', 'flexion 80', 'abduction 90', 'scaption 60']
    scaption = math.sin(math.radians(30)), -math.cos(math.radians(30)), 0.0
    for (axis, degrees), angles in zip(
        (((1, 0, 0), 0), ((1, 0, 0), 80), ((0, -1, 0), 90), (scaption, 60)),
        found.values(),
        strict=True,
    ):
        expected = Rotation.from_rotvec(np.radians(degrees) * np.array(axis)).as_matrix()
        np.testing.assert_allclose(convention.rotation(angles), expected, atol=1e-9)
    for angles in found.values():
        for angle, (low, high) in zip(
            angles, slider_ranges(convention, DELTOID.range_of_motion), strict=True
        ):
            assert low - 1e-9 <= angle <= high + 1e-9


def test_a_glide_begins_and_ends_at_rest_and_its_speeds_are_its_slope() -> None:
    start, end = np.array((0.1, 0.0, -0.4)), np.array((1.3, 0.5, 0.2))
    glide = motions.Glide(start, end, 100.0)
    for now, place in ((100.0, start), (100.0 + glide.seconds, end), (1e6, end)):
        angles, speeds = glide.pose_at(now)
        np.testing.assert_allclose(angles, place, atol=1e-12)
        np.testing.assert_allclose(speeds, 0.0, atol=1e-12)
    for now in np.linspace(100.01, 99.99 + glide.seconds, 9):
        slope = (glide.pose_at(now + 1e-5)[0] - glide.pose_at(now - 1e-5)[0]) / 2e-5
        np.testing.assert_allclose(glide.pose_at(now)[1], slope, atol=1e-6)


def test_a_sweep_sets_out_from_where_the_arm_is_and_stays_in_its_range() -> None:
    arm = motions.Arm(np.zeros(3))
    arm.drag(np.array((0.5, 0.2, 0.1)), 0.0)
    arm.sweep(0, -0.7, 2.0, 0.0)
    times = np.arange(0.0, 30.0, 1 / 60)
    speeds, angles = [], []
    for now in times:
        speeds.append(arm.advance(now))
        angles.append(arm.angles)
    angles = np.array(angles)
    np.testing.assert_allclose(angles[0], (0.5, 0.2, 0.1))
    np.testing.assert_allclose(angles[:, 1:], [(0.2, 0.1)] * len(times))
    assert angles[:, 0].min() == pytest.approx(-0.7, abs=1e-3)
    assert angles[:, 0].max() == pytest.approx(2.0, abs=1e-3)
    assert np.abs(np.diff(angles[:, 0])).max() < 0.05
    # the mean over a 60th of a second beside the speed at its end: 7 rad/s^2 make 0.06 rad/s
    np.testing.assert_allclose(np.diff(angles, axis=0) * 60, np.array(speeds)[1:], atol=0.1)


def test_a_dragged_arm_has_the_speed_of_the_hand_and_none_at_the_first_touch() -> None:
    arm = motions.Arm(np.zeros(3))
    assert arm.drag(np.array((0.1, 0.0, 0.0)), 5.0).tolist() == [0.0, 0.0, 0.0]
    assert arm.drag(np.array((0.2, 0.0, 0.0)), 5.1) == pytest.approx((1.0, 0.0, 0.0))
    assert arm.drag(np.array((0.3, 0.0, 0.0)), 9.0).tolist() == [0.0, 0.0, 0.0]
    assert not arm.is_moving
