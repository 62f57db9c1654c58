# SPDX-License-Identifier: Apache-2.0
"""Joint conventions: the interface's table, its axes, and what is refused."""

import math
from typing import Any

import numpy as np
import pytest
from convention_angles import ANGLES, rotation_about
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, LinkedPlaneError
from linkedplane_ros.joints.conventions import angle_about, principal_angle

EXACT = 1e-12  # entries of a rotation matrix: rounding of a few products
ELEVATING = ('isb_yxy', 'opensim_tsm', 'opensim_mobl', 'rep155')
NAMES = ('flexion_abduction_rotation', *ELEVATING)
TSM_AXIAL = np.array([-0.0584, -0.0846, 0.9947])


def rotation_of_the_table(name: str, angles: Array) -> Array:
    """Return the rotation as the table of the interface writes it."""
    q1, q2, q3 = angles
    X, Y, Z = np.eye(3)
    return {
        'flexion_abduction_rotation': rotation_about(X, q1)
        @ rotation_about(-Y, q2)
        @ rotation_about(Z, q3),
        'isb_yxy': rotation_about(Z, q1) @ rotation_about(-Y, q2) @ rotation_about(Z, q3),
        'opensim_tsm': rotation_about(Z, q1)
        @ rotation_about(-Y, q2)
        @ rotation_about(TSM_AXIAL, q3),
        'opensim_mobl': rotation_about(Z, q1) @ rotation_about(-Y, q2) @ rotation_about(Z, q3 - q1),
        'rep155': rotation_about(Z, q1) @ rotation_about(-Y, q2) @ rotation_about(Z, -q3),
    }[name]


def test_the_conventions_are_those_of_the_interface() -> None:
    coordinates = {name: convention.coordinates for name, convention in JOINT_CONVENTIONS.items()}
    assert coordinates == {
        'flexion_abduction_rotation': ('flexion', 'abduction', 'rotation'),
        'isb_yxy': ('plane_of_elevation', 'elevation', 'axial_rotation'),
        'opensim_tsm': ('plane_elv', 'shoulder_elv', 'axial_rot'),
        'opensim_mobl': ('elv_angle', 'shoulder_elv', 'shoulder_rot'),
        'rep155': ('y_shoulder', 'p_shoulder', 'r_shoulder'),
    }


@pytest.mark.parametrize('name', NAMES)
def test_a_rotation_is_the_one_of_the_table(name: str) -> None:
    for angles in ANGLES:
        found = JOINT_CONVENTIONS[name].rotation(angles)
        np.testing.assert_allclose(found, rotation_of_the_table(name, angles), atol=EXACT)


@pytest.mark.parametrize(
    ('name', 'sequence', 'signs'),
    [
        ('flexion_abduction_rotation', 'XYZ', (1, -1, 1)),
        ('isb_yxy', 'ZYZ', (1, -1, 1)),
        ('rep155', 'ZYZ', (1, -1, -1)),
    ],
)
def test_a_rotation_is_scipys_intrinsic_one(
    name: str, sequence: str, signs: tuple[int, int, int]
) -> None:
    found = [JOINT_CONVENTIONS[name].rotation(angles) for angles in ANGLES]
    scipys = Rotation.from_euler(sequence, ANGLES * signs).as_matrix()
    np.testing.assert_allclose(found, scipys, atol=EXACT)


@pytest.mark.parametrize('name', NAMES)
def test_axes_are_those_about_which_the_coordinates_turn_the_humerus(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    h = 1e-4  # rad
    for angles in ANGLES[:50]:
        axes = convention.axes(angles)
        for j, step in enumerate(h * np.eye(3)):
            one = (
                rotation_of_the_table(name, angles + step)
                @ rotation_of_the_table(name, angles - step).T
            )
            omega = Rotation.from_matrix(one).as_rotvec() / (2.0 * h)
            np.testing.assert_allclose(axes[:, j], omega, atol=1e-8)  # h^2 and rounding over h


def test_axes_are_unit_vectors_but_where_a_coordinate_enters_two_turns() -> None:
    for name in NAMES:
        sizes = np.linalg.norm(JOINT_CONVENTIONS[name].axes(ANGLES[0]), axis=0)
        np.testing.assert_allclose(sizes[1:], 1.0, atol=EXACT)
        assert (abs(sizes[0] - 1.0) < EXACT) == (name != 'opensim_mobl')


@pytest.mark.parametrize('name', NAMES)
def test_axes_of_the_left_are_mirrored_as_axes_of_rotation_are(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    mirror = np.diag([-1.0, 1.0, 1.0])
    h = 1e-4
    for angles in ANGLES[:10]:
        axes = convention.axes(angles, side='left')
        for j, step in enumerate(h * np.eye(3)):
            after, before = (
                mirror @ rotation_of_the_table(name, angles + s) @ mirror for s in (step, -step)
            )
            omega = Rotation.from_matrix(after @ before.T).as_rotvec() / (2.0 * h)
            np.testing.assert_allclose(axes[:, j], omega, atol=1e-8)


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize(
    'angles', [[0.0, 0.0], [[0.0, 0.0, 0.0]], 0.0, [0.0, np.nan, 0.0], [0.0, np.inf, 0.0], 'abc']
)
def test_wrong_angles_are_refused(name: str, angles: object) -> None:
    convention = JOINT_CONVENTIONS[name]
    for use in (convention.rotation, convention.axes):
        with pytest.raises(ValueError, match=r'angles: .*3 finite numbers in rad expected'):
            use(angles)


@pytest.mark.parametrize('rotation', [np.eye(2), np.eye(4), np.zeros(3), np.eye(3)[np.newaxis]])
def test_a_rotation_of_another_shape_is_refused(rotation: Array) -> None:
    for name in NAMES:
        with pytest.raises(ValueError, match=r'rotation: .*\(3, 3\)'):
            JOINT_CONVENTIONS[name].angles(rotation)


def test_an_unknown_side_is_refused() -> None:
    with pytest.raises(ValueError, match="side: 'up' given, 'right' or 'left' expected"):
        JOINT_CONVENTIONS['isb_yxy'].axes([0.0, 0.0, 0.0], side='up')


@pytest.mark.parametrize(
    'angles',
    [
        [[0.1, 0.2]],
        [[0.1, 0.2, 0.3, 0.4]],
        [0.1, 0.2, 0.3],
        [[0.1, 0.2, math.nan]],
        [['a', 'b', 'c']],
        [[0.1], [0.2, 0.3]],
    ],
    ids=['two', 'four', 'not in rows', 'nan', 'text', 'ragged'],
)  # fmt: skip
def test_what_are_no_triples_of_angles_is_refused_in_one_line(angles: Any) -> None:
    with pytest.raises(LinkedPlaneError, match=r'^angles') as refused:
        JOINT_CONVENTIONS['isb_yxy'].rotations_and_axes(angles)
    assert '\n' not in str(refused.value)


def test_a_convention_whose_streams_are_not_against_the_scapula_cautions() -> None:
    cautions = {name: JOINT_CONVENTIONS[name].caution for name in NAMES}
    assert [name for name in NAMES if cautions[name]] == ['opensim_mobl', 'rep155']
    for name, against in (('opensim_mobl', 'thorax'), ('rep155', 'torso')):
        assert cautions[name].startswith(f'{name} streams usually measure the humerus against the ')
        assert f'the {against};' in cautions[name]


@pytest.mark.parametrize('angle', [-3.1, -1.0, -1e-9, 0.0, 0.5, 2.0, 3.1])
def test_the_angle_about_an_axis_is_that_of_the_turn_whatever_lies_along_it(angle: float) -> None:
    for axis, start, along in np.random.default_rng(4).normal(size=(20, 3, 3)):
        axis = axis / np.linalg.norm(axis)
        end = Rotation.from_rotvec(angle * axis).apply(start) + along[0] * axis
        assert angle_about(axis, start, end) == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize('turns', [-2, -1, 0, 1, 3])
@pytest.mark.parametrize('angle', [-3.0, -0.5, 0.0, 1.0, 3.0])
def test_a_principal_angle_is_the_same_one_within_half_a_turn(turns: int, angle: float) -> None:
    assert principal_angle(angle + 2.0 * np.pi * turns) == pytest.approx(angle, abs=1e-14)
    assert principal_angle(-np.pi) == principal_angle(np.pi) == np.pi
