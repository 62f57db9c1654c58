# SPDX-License-Identifier: Apache-2.0
"""Values of whatever coordinates move bones, their units, and bones at rest but for the last."""

from __future__ import annotations

from decimal import Decimal
from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkedplane_ros import LinkedPlaneError
from linkedplane_ros.joints.articulation import (
    CONTINUOUS,
    PRISMATIC,
    REVOLUTE,
    Articulation,
    as_values,
    name_unit,
    rest_poses,
    rotated_poses,
)


class Slide:
    """A slide and a wheel."""

    coordinates = ('slide', 'wheel')
    kinds = (PRISMATIC, CONTINUOUS)


SLIDE = cast(Articulation, Slide())


@pytest.mark.parametrize(
    ('kinds', 'unit'),
    [
        ((REVOLUTE,), 'rad'),
        ((CONTINUOUS, CONTINUOUS), 'rad'),
        ((PRISMATIC,), 'm'),
        ((PRISMATIC, CONTINUOUS), 'm or rad'),
        ((REVOLUTE, CONTINUOUS, PRISMATIC, REVOLUTE), 'rad or m'),
    ],
)
def test_joints_that_turn_are_in_rad_and_those_that_slide_in_m(
    kinds: tuple[str, ...], unit: str
) -> None:
    assert name_unit(kinds) == unit


@pytest.mark.parametrize('values', [(1, -2.5), [1.0, -2.5], np.array([1.0, -2.5], np.float32)])
def test_a_finite_number_for_each_coordinate_is_taken_and_copied(values: Any) -> None:
    found = as_values('values', values, SLIDE)
    assert found.dtype == np.float64
    assert found.tolist() == [1.0, -2.5]
    assert not np.shares_memory(found, values)


@pytest.mark.parametrize(
    'values',
    [(1.0,), (1.0, 2.0, 3.0), (), 1.0, None, 'ab', (1.0, np.nan), (np.inf, 1.0), (1.0, 'x'),
     (1.0, 10**400), (1.0, Decimal('sNaN')), (1.0, 2j), np.zeros((2, 2))],
    ids=repr,
)  # fmt: skip
def test_anything_else_is_refused_in_one_line(values: Any) -> None:
    with pytest.raises(LinkedPlaneError) as error:
        as_values('speeds', values, SLIDE, '/s')
    text = str(error.value)
    assert text.startswith('speeds: ')
    assert text.endswith(' given, 2 finite numbers in m or rad/s expected')
    assert '\n' not in text


@pytest.mark.parametrize('k', [1, 2, 3])
def test_bones_at_rest_are_where_the_ground_is_and_a_rotation_turns_the_last(k: int) -> None:
    rest = np.tile(np.eye(3, 4), (5, k, 1, 1))
    np.testing.assert_array_equal(rest_poses(5, k), rest)
    rotations = Rotation.random(5, random_state=3).as_matrix()
    found = rotated_poses(rotations, k)
    np.testing.assert_array_equal(found[:, :-1], rest[:, 1:])
    np.testing.assert_array_equal(found[:, -1, :, :3], rotations)
    np.testing.assert_array_equal(found[:, -1, :, 3], np.zeros((5, 3)))
