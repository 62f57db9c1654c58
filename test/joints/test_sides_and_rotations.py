# SPDX-License-Identifier: Apache-2.0
"""Mirror images of points, axes and rotations; rotations made and checked."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkedplane_ros import LinkedPlaneError
from linkedplane_ros.joints.rotations import (
    NOT_FINITE,
    NOT_ORTHONORMAL,
    PROPER,
    REFLECTION,
    as_matrices,
    as_matrix,
    as_rotation,
    matrix_rows,
    rotation_about,
    rotation_fault,
)
from linkedplane_ros.joints.sides import (
    AXIS_SIGN,
    check_side,
    mirror_axes,
    mirror_columns,
    mirror_points,
    mirror_rotation,
)

ROTATIONS = Rotation.random(20, np.random.default_rng(5)).as_matrix()
MIRROR = np.diag((-1.0, 1.0, 1.0))
POINTS = np.random.default_rng(6).normal(size=(20, 3))


def test_a_turned_point_mirrored_is_the_mirrored_point_turned_the_mirrored_way() -> None:
    for R, point in zip(ROTATIONS, POINTS, strict=True):
        np.testing.assert_array_equal(mirror_rotation(R), MIRROR @ R @ MIRROR)
        np.testing.assert_allclose(
            mirror_points(R @ point), mirror_rotation(R) @ mirror_points(point), rtol=0, atol=1e-15
        )


def test_a_mirrored_rotation_turns_by_the_same_angle_about_the_mirrored_axis() -> None:
    for R in ROTATIONS:
        vector = Rotation.from_matrix(R).as_rotvec()
        mirrored = Rotation.from_matrix(mirror_rotation(R)).as_rotvec()
        np.testing.assert_allclose(mirrored, mirror_axes(vector), rtol=0.0, atol=1e-14)  # rad


def test_a_moment_mirrored_is_the_mirrored_levers_and_forces_moment() -> None:
    lever, force = POINTS[:10], POINTS[10:]
    moment = np.cross(mirror_points(lever), mirror_points(force))
    np.testing.assert_array_equal(mirror_axes(np.cross(lever, force)), moment)
    np.testing.assert_array_equal(mirror_columns(lever[:3].T), mirror_axes(lever[:3]).T)


def test_the_sign_of_a_side_is_that_of_mirrored_axes() -> None:
    assert AXIS_SIGN['right'] == 1.0
    np.testing.assert_array_equal(mirror_axes(POINTS)[:, 1:], AXIS_SIGN['left'] * POINTS[:, 1:])
    for R in (np.eye(3), rotation_about(np.array((1.0, 0.0, 0.0)), 0.0)):
        assert not np.signbit(mirror_rotation(R)).any()  # no zero is -0.0


@pytest.mark.parametrize('side', ['up', 'Right', '', None, 3])
def test_a_side_is_right_or_left(side: str) -> None:
    with pytest.raises(LinkedPlaneError, match=r"side: .* given, 'right' or 'left' expected"):
        check_side(side)


def test_a_rotation_about_an_axis_is_right_handed() -> None:
    for vector in POINTS:
        angle = float(np.linalg.norm(vector))
        expected = Rotation.from_rotvec(vector).as_matrix()
        np.testing.assert_allclose(
            rotation_about(vector / angle, angle), expected, rtol=0.0, atol=1e-14
        )
    quarter = rotation_about(np.array((0.0, 0.0, 1.0)), math.pi / 2) @ (1.0, 0.0, 0.0)
    np.testing.assert_allclose(quarter, (0.0, 1.0, 0.0), rtol=0.0, atol=1e-16)


@pytest.mark.parametrize(
    ('matrix', 'reason'),
    [
        (np.full((3, 3), np.nan), 'finite numbers expected'),
        (1.001 * np.eye(3), 'R^T R is not the identity within 1e-06'),
        (np.diag((1.0, -1.0, 1.0)), 'a reflection; a proper rotation expected'),
        (np.eye(4), 'shape (4, 4) given, (3, 3) expected'),
        ('eye', 'not an array of numbers'),
    ],
    ids=['NaN', 'too large', 'reflection', '4 by 4', 'text'],
)
def test_what_is_no_rotation_is_refused(matrix: object, reason: str) -> None:
    with pytest.raises(LinkedPlaneError) as error:
        as_rotation(matrix)
    assert str(error.value).startswith('rotation: ')
    assert reason in str(error.value)


def test_matrices_are_copies() -> None:
    given = np.eye(3)
    for copy in (as_rotation(given), as_matrix(given), as_matrices(given[np.newaxis])):
        copy[...] = 2.0
    np.testing.assert_array_equal(given, np.eye(3))


@pytest.mark.parametrize('row', range(3))
@pytest.mark.parametrize('column', range(3))
@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf])
def test_one_value_that_is_not_finite_is_enough(row: int, column: int, value: float) -> None:
    for R in ROTATIONS[:3]:
        R = R.copy()
        R[row, column] = value
        assert rotation_fault(matrix_rows(R.tolist())) == NOT_FINITE
        R[row, (column + 1) % 3] = 1e300
        assert rotation_fault(matrix_rows(R.tolist())) == NOT_FINITE


@pytest.mark.parametrize('row', range(3))
@pytest.mark.parametrize('column', range(3))
@pytest.mark.parametrize('value', [1e154, -1e200, 1e308])  # finite; their squares are not
def test_one_value_that_is_very_large_is_no_rotation(row: int, column: int, value: float) -> None:
    for R in ROTATIONS[:3]:
        R = R.copy()
        R[row, column] = value
        assert rotation_fault(matrix_rows(R.tolist())) == NOT_ORTHONORMAL
    full = np.full((3, 3), value)
    assert rotation_fault(matrix_rows(full.tolist())) == NOT_ORTHONORMAL


@pytest.mark.parametrize('row', range(3))
@pytest.mark.parametrize('size', [0.0, 0.5, 1.0 - 1e-6, 1.0 + 1e-6, 2.0])
def test_one_row_of_another_length_is_enough(row: int, size: float) -> None:
    for R in ROTATIONS[:3]:
        R = R.copy()
        R[row] *= size  # its square is off by 2e-6 at the least, twice what is allowed
        assert rotation_fault(matrix_rows(R)) == NOT_ORTHONORMAL


@pytest.mark.parametrize('lean', [-0.5, -2e-6, 2e-6, 0.5])
@pytest.mark.parametrize(('one', 'other'), [(0, 1), (1, 2), (2, 0)])
def test_two_rows_that_lean_towards_each_other_are_enough(
    one: int, other: int, lean: float
) -> None:
    for R in ROTATIONS[:3]:
        leaning = R.copy()
        leaning[one] = math.cos(lean) * R[one] + math.sin(lean) * R[other]
        assert rotation_fault(matrix_rows(leaning)) == NOT_ORTHONORMAL


def test_the_rounding_of_a_message_is_no_fault() -> None:
    for R in ROTATIONS:
        for given in (R, R.astype(np.float32), (1.0 - 2e-7) * R, (1.0 + 2e-7) * R):
            assert rotation_fault(matrix_rows(given.tolist())) == PROPER
            assert rotation_fault(matrix_rows((-given).tolist())) == REFLECTION


def test_matrices_are_those_that_were_given_whatever_holds_them() -> None:
    whole = np.arange(18).reshape(2, 3, 3)
    forms = whole, whole.astype(float), whole.astype(np.float32), whole.astype(np.uint8)
    for given in (*forms, whole.tolist(), np.asfortranarray(whole)):
        np.testing.assert_array_equal(as_matrices(given), whole)
        assert as_matrices(given).dtype == np.float64
        np.testing.assert_array_equal(as_matrix(given[1]), whole[1])
        np.testing.assert_array_equal(matrix_rows(given[1]), whole[1])
    for none in ([], np.empty((0, 3, 3)), np.array([], dtype=object)):
        assert as_matrices(none).shape == (0, 3, 3)


class OnAnotherDevice:
    """As a tensor on a graphics card: it refuses to be an array."""

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        raise TypeError('copy it to the host first')


@pytest.mark.parametrize(
    'matrix',
    [np.full((3, 3), 1j), np.full((3, 3), True), np.full((3, 3), None), [['1'] * 3] * 3,
     [[1.0, 2.0], [3.0]], [['a']], OnAnotherDevice()],
    ids=['complex', 'true', 'none', 'text', 'ragged', 'a letter', 'another device'],
)  # fmt: skip
def test_what_are_no_real_numbers_are_no_matrix(matrix: object) -> None:
    for convert, name in ((as_matrix, 'rotation'), (as_matrices, 'rotations')):
        with pytest.raises(LinkedPlaneError, match=rf'^{name}: not an array of numbers; real'):
            convert(matrix)


@pytest.mark.parametrize('shape', [(), (0,), (3,), (2, 2), (2, 3), (3, 2), (4, 4), (3, 3, 3)])
def test_a_matrix_is_3_by_3(shape: tuple[int, ...]) -> None:
    with pytest.raises(LinkedPlaneError, match=r'^rotation: shape .* given, \(3, 3\) expected'):
        as_matrix(np.zeros(shape))


@pytest.mark.parametrize(
    'shape', [(), (1,), (3, 3), (2, 2, 3), (2, 3, 2), (2, 3, 4), (2, 4, 3), (1, 2, 3, 3), (0, 3)]
)
def test_matrices_are_a_row_of_3_by_3(shape: tuple[int, ...]) -> None:
    with pytest.raises(LinkedPlaneError, match=r'^rotations: shape .* \(m, 3, 3\) expected'):
        as_matrices(np.zeros(shape))
