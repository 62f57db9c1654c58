# SPDX-License-Identifier: Apache-2.0
"""Mirror images of points, axes and rotations; rotations made and checked."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkedplane_ros import LinkedPlaneError
from linkedplane_ros.joints.rotations import as_matrices, as_matrix, as_rotation, rotation_about
from linkedplane_ros.joints.sides import (
    check_side,
    mirror_axes,
    mirror_columns,
    mirror_points,
    mirror_rotation,
)

ROTATIONS = Rotation.random(20, np.random.default_rng(5)).as_matrix()
REFLECTION = np.diag((-1.0, 1.0, 1.0))
POINTS = np.random.default_rng(6).normal(size=(20, 3))


def test_a_turned_point_mirrored_is_the_mirrored_point_turned_the_mirrored_way() -> None:
    for R, point in zip(ROTATIONS, POINTS, strict=True):
        np.testing.assert_array_equal(mirror_rotation(R), REFLECTION @ R @ REFLECTION)
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
