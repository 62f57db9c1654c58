# SPDX-License-Identifier: Apache-2.0
"""What the page of conventions says is so, besides its examples and tables."""

from __future__ import annotations

import numpy as np
import pytest

from linkedplane_ros import JOINT_CONVENTIONS


def test_all_conventions_are_at_zero_where_the_frames_coincide() -> None:
    for convention in JOINT_CONVENTIONS.values():
        np.testing.assert_array_equal(convention.rotation([0.0, 0.0, 0.0]), np.eye(3))


def test_mujoco_has_w_first() -> None:
    mujoco = pytest.importorskip('mujoco', reason='mujoco is not installed: nothing to compare')
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.eye(3).ravel())
    np.testing.assert_array_equal(quaternion, [1.0, 0.0, 0.0, 0.0])
