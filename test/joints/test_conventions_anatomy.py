# SPDX-License-Identifier: Apache-2.0
"""Joint conventions: what a positive angle does to the arm."""

import numpy as np
import pytest

from linkedplane_ros import JOINT_CONVENTIONS

EXACT = 1e-12  # entries of a rotation matrix: rounding of a few products
ELEVATING = ('isb_yxy', 'opensim_tsm', 'opensim_mobl', 'rep155')
LATERAL, ANTERIOR, SUPERIOR = np.eye(3)
HANGING = -SUPERIOR  # the humerus, from the shoulder to the elbow


def test_flexion_lifts_the_arm_forward() -> None:
    R = JOINT_CONVENTIONS['flexion_abduction_rotation'].rotation([np.pi / 2, 0.0, 0.0])
    np.testing.assert_allclose(R @ HANGING, ANTERIOR, atol=EXACT)


def test_abduction_lifts_the_arm_sideways() -> None:
    R = JOINT_CONVENTIONS['flexion_abduction_rotation'].rotation([0.0, np.pi / 2, 0.0])
    np.testing.assert_allclose(R @ HANGING, LATERAL, atol=EXACT)


def test_positive_axial_rotation_is_internal() -> None:
    for name in ('flexion_abduction_rotation', 'isb_yxy', 'opensim_mobl', 'opensim_tsm'):
        R = JOINT_CONVENTIONS[name].rotation([0.0, 0.0, 0.2])
        assert (R @ LATERAL) @ ANTERIOR > 0.1, name
    R = JOINT_CONVENTIONS['rep155'].rotation([0.0, 0.0, 0.2])
    assert (R @ LATERAL) @ ANTERIOR < -0.1  # REP 155 counts the roll the other way


@pytest.mark.parametrize('name', ELEVATING)
def test_elevation_lifts_the_arm_into_its_plane(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    for plane, towards in ((0.0, LATERAL), (np.pi / 2, ANTERIOR), (-np.pi / 2, -ANTERIOR)):
        R = convention.rotation([plane, np.pi / 2, 0.0])
        np.testing.assert_allclose(R @ HANGING, towards, atol=EXACT)
    np.testing.assert_allclose(
        convention.rotation([0.3, np.pi, 0.0]) @ HANGING, SUPERIOR, atol=EXACT
    )


def test_the_plane_of_mobl_leaves_the_hanging_arm_alone() -> None:
    R = JOINT_CONVENTIONS['opensim_mobl'].rotation([0.7, 0.0, 0.0])
    np.testing.assert_allclose(R, np.eye(3), atol=EXACT)
