# SPDX-License-Identifier: Apache-2.0
"""The rivals' paths by hand: what each obstacle does to a line."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from random_bands import BONES, MODELS, Model, random_models, random_rotations
from scipy.spatial.transform import Rotation

from linkedplane_ros import WrapState
from linkedplane_ros.rivals import (
    Bands,
    CappedCylinder,
    Cylinder,
    DoubleCylinder,
    PathModel,
    Sphere,
    Straight,
    ViaPoints,
)

STILL = np.eye(3)
every_obstacle = pytest.mark.parametrize('kind', MODELS[2:], ids=lambda kind: kind.__name__)


def test_a_straight_band_is_the_line() -> None:
    state = Straight((0.0, 0.0, 0.0), (0.0, 0.0, -0.1)).solve(STILL)
    assert (state.length, state.wrap) == (0.1, WrapState.CLEAR)
    np.testing.assert_array_equal(state.path(), [(0, 0, 0), (0, 0, -0.1)])


def test_via_points_are_passed_in_order_and_move_with_their_bones() -> None:
    band = ViaPoints((0, 0, 0), (0.1, 0, 0), ((0, 0, 0.05),), ((0.1, 0, 0.05),))
    state = band.solve(Rotation.from_rotvec((np.pi, 0, 0)).as_matrix())
    points = [(0, 0, 0), (0, 0, 0.05), (0.1, 0, -0.05), (0.1, 0, 0)]
    np.testing.assert_allclose(state.path(), points, rtol=0, atol=1e-15)  # m: rounding
    assert state.length == pytest.approx(0.1 + np.hypot(0.1, 0.1), abs=1e-15)  # m: rounding


def quarter(kind: Model, **more: Any) -> PathModel:
    """Return a band with a quarter of a turn about z, right-handed, at a radius of 0.03 m."""
    return kind((0.03, -0.01, 0.0), (-0.01, 0.03, 0.0), (0, 0, 0), radius=0.03, **more)


@pytest.mark.parametrize('bone', BONES)
def test_a_quarter_round_a_sphere_and_round_a_cylinder_is_the_same(bone: str) -> None:
    length = 0.02 + 0.03 * np.pi / 2
    for band in (
        quarter(Sphere, bone=bone),
        quarter(Cylinder, axis=(0, 0, 2), bone=bone),
        quarter(CappedCylinder, axis=(0, 0, 2), bone=bone),
        quarter(CappedCylinder, axis=(0, 0, -2), bone=bone, turn='left-handed'),
    ):
        state = band.solve(STILL)
        assert state.wrap == WrapState.WRAPPED
        assert state.length == pytest.approx(length, abs=1e-15)  # m: rounding
        # it pulls the humerus back, left-handed
        np.testing.assert_allclose(state.moment_vector, (0, 0, -0.03), rtol=0, atol=1e-15)


def test_a_band_on_a_cylinder_is_a_straight_line_when_unrolled() -> None:
    band = Cylinder((0.03, -0.04, 0), (-0.04, 0.03, 0.06), (0, 0, 9), (0, 0, 1), 0.03, 'scapula')
    state = band.solve(STILL)
    flat = 0.08 + 0.03 * np.pi / 2
    assert state.length == pytest.approx(np.hypot(flat, 0.06), abs=1e-15)  # m: rounding
    path = state.path(9)
    on_cylinder = path[1:-1]
    np.testing.assert_allclose(np.hypot(*on_cylinder[:, :2].T), 0.03, rtol=0, atol=1e-15)
    steps = np.diff(on_cylinder, axis=0)
    np.testing.assert_allclose(steps[:, 2], steps[0, 2], rtol=0, atol=1e-15)


def test_the_axis_says_on_which_side_a_cylinder_is_passed() -> None:
    band = Cylinder((0.1, 0.01, 0), (-0.1, 0.01, 0), (0, 0, 0), (0, 0, 1), 0.03, 'scapula')
    other = replace(band, axis=(0, 0, -1))
    assert band.solve(STILL).path()[5, 1] > 0.0 > other.solve(STILL).path()[5, 1]
    assert band.solve(STILL).length < other.solve(STILL).length


def hooked_band(y: float) -> Cylinder:
    """Return a band whose line passes a cylinder of radius 0.03 at -y; its side is that of +y."""
    return Cylinder((0.1, -y, 0), (-0.1, -y, 0), (0, 0, 0), (0, 0, 1), 0.03, 'scapula')


def test_a_line_on_the_wrong_side_is_hooked_round_a_cylinder_up_to_half_a_turn() -> None:
    assert hooked_band(0.04).solve(STILL).wrap == WrapState.WRAPPED
    assert hooked_band(-0.04).solve(STILL).wrap == WrapState.CLEAR
    # half a turn is where both tangents are parallel: the ends as far from the axis as the surface
    near = replace(
        hooked_band(0.1), origin=(0.03 + 1e-9, -0.1, 0), insertion=(-0.03 - 1e-9, -0.1, 0)
    )
    state = near.solve(STILL)
    assert state.wrap == WrapState.WRAPPED
    assert state.length == pytest.approx(0.2 + 0.03 * np.pi, abs=1e-8)  # m: as near as the ends


def test_beyond_half_a_turn_the_band_is_straight_and_missed() -> None:
    beyond = replace(
        hooked_band(0.1), origin=(0.03 - 1e-9, -0.1, 0), insertion=(-0.03 + 1e-9, -0.1, 0)
    )
    state = beyond.solve(STILL)
    assert state.wrap == WrapState.MISSED
    assert state.length == pytest.approx(0.06, abs=1e-8)  # m: as near as the ends


def test_a_sphere_is_passed_on_the_short_side_and_left_when_the_line_keeps_off() -> None:
    for z, wrap in ((0.01, 0), (-0.01, 0), (0.0301, 1)):
        band = Sphere((0.1, 0, z), (-0.1, 0, z), (0, 0, 0), 0.03, 'scapula')
        state = band.solve(STILL)
        assert state.wrap == wrap
        assert (state.path()[1:-1, 2] * z >= 0.0).all()


def test_a_line_through_the_centre_of_a_sphere_has_a_path() -> None:
    for end in np.eye(3):
        P, S = tuple((0.1 * end).tolist()), tuple((-0.08 * end).tolist())
        state = Sphere(P, S, (0, 0, 0), 0.03, 'scapula').solve(STILL)
        flat = np.sqrt(0.1**2 - 0.03**2) + np.sqrt(0.08**2 - 0.03**2)
        turn = np.arcsin(0.03 / 0.1) + np.arcsin(0.03 / 0.08)
        assert state.length == pytest.approx(flat + 0.03 * turn, abs=1e-15)  # m: rounding
        assert np.isfinite(state.moment_vector).all()


def test_two_cylinders_are_wrapped_together_one_alone_or_not_at_all() -> None:
    band = DoubleCylinder((-0.1, 0, 0), (0.19, 0, 0), (0, 0, -0.01), (0, 1, 0), 0.03, 'scapula',
                          (0.09, 0, -0.01), (0, 1, 0), 0.03, 'humerus')  # fmt: skip
    off, far = (0, 0, -0.1), (0.09, 0, -0.1)
    for model, contacts in (
        (band, 3),
        (replace(band, second_centre=far), 1),
        (replace(band, centre=off), 2),
        (replace(band, centre=off, second_centre=far), 0),
    ):
        assert model.solve(STILL).contacts == contacts
    alone = Cylinder(band.origin, band.insertion, band.centre, band.axis, 0.03, 'scapula')
    with_far = replace(band, second_centre=far).solve(STILL)
    assert with_far.length == pytest.approx(alone.solve(STILL).length, abs=1e-15)  # m: rounding
    # both: a belt over two circles on a level
    side = np.sqrt(0.1**2 + 0.01**2 - 0.03**2)
    turn = np.arcsin(0.03 / np.hypot(0.1, 0.01)) + np.arctan2(-0.01, 0.1)
    assert band.solve(STILL).length == pytest.approx(2 * (side + 0.03 * turn) + 0.09, abs=1e-14)


def test_a_band_may_cross_from_the_cap_to_the_cylinder() -> None:
    down = CappedCylinder((0.04, -0.01, 0.04), (-0.02, 0.03, -0.03), (0, 0, 0), (0, 0, 1), 0.03,
                          'scapula')  # fmt: skip
    up = replace(down, origin=down.insertion, insertion=down.origin, turn='left-handed')
    there, back = down.solve(STILL), up.solve(STILL)
    assert (there.contacts, back.contacts) == (3, 3)
    assert there.length == pytest.approx(back.length, abs=1e-15)  # m: rounding
    np.testing.assert_allclose(there.path(), back.path()[::-1], rtol=0, atol=1e-15)
    heights = there.path(50)[1:-1, 2]
    assert (np.diff(heights) <= 1e-15).all()
    assert heights.max() > 0.0 > heights.min()


def test_the_shorter_side_of_a_capped_cylinder_is_the_shorter_of_both() -> None:
    models = random_models(CappedCylinder, 400, seed=5)
    lengths = [
        Bands([replace(model, turn=turn) for model in models]).solve(random_rotations(1)[0])
        for turn in ('right-handed', 'left-handed', 'shorter')
    ]
    right, left, shorter = lengths
    both = (right.wrap == WrapState.WRAPPED) & (left.wrap == WrapState.WRAPPED)
    least = np.minimum(right.lengths, left.lengths)
    np.testing.assert_array_equal(shorter.lengths[both], least[both])
    assert both.sum() > 30
    assert (np.abs(right.lengths - left.lengths)[both] > 1e-3).sum() > 20
    assert not (shorter.wrap == WrapState.MISSED).any()


@every_obstacle
@pytest.mark.parametrize('end', ['origin', 'insertion'])
def test_an_end_in_its_obstacle_is_inside_and_straight(kind: Model, end: str) -> None:
    second = kind is DoubleCylinder and end == 'insertion'
    for model in random_models(kind, 50):
        centre = model.second_centre if second else model.centre
        state = replace(model, **{end: centre}).solve(STILL)
        assert (state.wrap, state.contacts) == (WrapState.INSIDE, 0)
        line = np.subtract(state.model.insertion, state.model.origin)
        assert state.length == pytest.approx(np.linalg.norm(line), abs=1e-15)  # m: rounding
        assert len(state.path()) == 2
