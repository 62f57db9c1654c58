# SPDX-License-Identifier: Apache-2.0
"""One band round its sphere, against the literal formulas and against brute force."""

from typing import NamedTuple

import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from reference import Array
from scipy.spatial import ConvexHull

from linkedplane_ros.linked_planes.band import (
    BESIDE,
    CLEAR,
    EXTENDED,
    INSIDE,
    MISSED,
    PIERCED,
    WRAPPED,
    length_by_plane,
    obstacle_kind,
    wrap,
    wrap_state,
)

EXACT = 1e-12  # m: the rounding of lengths of some 0.1 m


class Wrap(NamedTuple):
    """A wrapped band in its plane: m, rad, unit tangents along (u, e)."""

    r: float
    arc: float
    t1u: float
    t1e: float
    t2u: float
    t2e: float


class Geometry(NamedTuple):
    """A band from P, the coordinates' origin, along x to S; psi turns its plane about x.

    At psi = 0 it bulges along y, so u x n = e makes n = -z.
    """

    D: float
    centre: tuple[float, float, float]
    R: float
    psi: float = 0.0

    def turned(self, psi: float) -> 'Geometry':
        return self._replace(psi=self.psi + psi)

    @property
    def d(self) -> float:
        _, y, z = self.centre
        return float(y * np.sin(self.psi) - z * np.cos(self.psi))

    @property
    def b(self) -> float:
        _, y, z = self.centre
        return float(y * np.cos(self.psi) + z * np.sin(self.psi))

    @property
    def kind(self) -> int:
        x, y, z = self.centre
        return obstacle_kind(self.D, x, y * y + z * z, self.R)

    @property
    def state(self) -> int:
        return wrap_state(self.kind, self.R, self.d, self.b)

    @property
    def tangents(self) -> tuple[float, float]:
        x, y, z = self.centre
        off = y * y + z * z - self.R * self.R
        return max(x * x + off, 0.0) ** 0.5, max((self.D - x) ** 2 + off, 0.0) ** 0.5

    @property
    def wrap(self) -> Wrap:
        return Wrap(*wrap(self.D, self.centre[0], *self.tangents, self.R, self.d, self.b))

    @property
    def length(self) -> float:
        if self.state != WRAPPED:
            return self.D
        return self.wrap.r * self.wrap.arc + sum(self.tangents)

    @property
    def by_plane(self) -> tuple[float, float]:
        return length_by_plane(self.d, self.b, *self.wrap)

    def literal(self, psi: Array | float = 0.0) -> reference.BandPath:
        """Return the reference's band, its plane turned further by psi."""
        S, centre = np.array([self.D, 0.0, 0.0]), np.array(self.centre)
        n_ref = np.array([0.0, 0.0, -1.0])
        return reference.band(np.zeros(3), S, n_ref, self.psi + np.asarray(psi), centre, self.R)


def random_geometries(count: int, seed: int) -> list[Geometry]:
    """Return bands of every kind: ends 3 to 20 cm apart, spheres of 5 to 40 mm around them."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(count):
        D, R = rng.uniform(0.03, 0.2), rng.uniform(0.005, 0.04)
        x, y, z = rng.uniform(-0.3, 1.3) * D, *rng.uniform(-1.5, 1.5, 2) * R
        psi = float(rng.uniform(-np.pi, np.pi))
        made.append(Geometry(float(D), (float(x), float(y), float(z)), float(R), psi))
    return made


GEOMETRIES = random_geometries(1500, seed=11)
WRAPPED_ONES = [one for one in GEOMETRIES if one.state == WRAPPED]


def test_the_random_geometries_are_of_every_kind() -> None:
    assert {one.kind for one in GEOMETRIES} == {PIERCED, BESIDE, EXTENDED, INSIDE}
    assert min(np.bincount([one.state for one in GEOMETRIES], minlength=4)) > 100


def test_the_state_is_that_of_the_literal_formulas() -> None:
    assert [one.state for one in GEOMETRIES] == [int(one.literal().state) for one in GEOMETRIES]


def test_the_length_is_that_of_the_literal_formulas() -> None:
    for one in GEOMETRIES:
        assert one.length == pytest.approx(float(one.literal().length), abs=EXACT), one


def test_arc_and_tangents_are_those_of_the_literal_formulas() -> None:
    for one in WRAPPED_ONES:
        w, literal = one.wrap, one.literal()
        assert w.arc == pytest.approx(float(literal.arc), abs=1e-9), one  # rad, acos near 1
        assert w.r == pytest.approx(float(literal.r), abs=EXACT), one
        u = np.array([1.0, 0.0, 0.0])
        e = np.cross(u, literal.normal)
        t1 = reference.unit(literal.Q)  # P is the origin
        t2 = reference.unit(np.array([one.D, 0.0, 0.0]) - literal.T)
        np.testing.assert_allclose([w.t1u, w.t1e], [t1 @ u, t1 @ e], atol=1e-8, err_msg=str(one))
        np.testing.assert_allclose([w.t2u, w.t2e], [t2 @ u, t2 @ e], atol=1e-8, err_msg=str(one))


def hull_length(one: Geometry) -> float | None:
    """Return the hull's edge from P over the bulging side to S; None if an end is not on it.

    The polygon of 3000 sides in the circle's stead is short by 3e-8 m at most (r up to 0.04 m).
    """
    turns = reference.circle(3000)
    r = (one.R**2 - one.d**2) ** 0.5
    round_it = np.column_stack([np.cos(turns), np.sin(turns)]) * r + [one.centre[0], one.b]
    points = np.vstack([[[0.0, 0.0], [one.D, 0.0]], round_it])
    clockwise = ConvexHull(points).vertices[::-1].tolist()
    if 0 not in clockwise or 1 not in clockwise:
        return None
    start = clockwise.index(0)
    edge = clockwise[start:] + clockwise[:start]
    edge = edge[: edge.index(1) + 1]
    return float(np.linalg.norm(np.diff(points[edge], axis=0), axis=1).sum())


def test_the_length_is_that_of_the_hull_of_both_ends_and_the_circle() -> None:
    checked = {WRAPPED: 0, CLEAR: 0}
    for one in GEOMETRIES[:600]:
        if one.state not in checked:
            continue
        brute = hull_length(one)
        if brute is not None:
            checked[one.state] += 1
            assert one.length == pytest.approx(brute, abs=1e-6), one  # m, the polygon's fineness
    assert min(checked.values()) > 30


def test_a_turn_of_the_plane_changes_the_length_by_the_closed_forms() -> None:
    h = 1e-3  # rad; the five-point formulas are then off by some 1e-9
    stencil = h * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    checked = 0
    for one in WRAPPED_ONES:
        near = one.literal(stencil)
        if one.wrap.r < 0.5 * one.R or (near.state != WRAPPED).any() or one.wrap.arc < 0.05:
            continue  # where the circle shrinks to nothing L bends too fast for differences
        checked += 1
        first = near.length @ [1.0, -8.0, 0.0, 8.0, -1.0] / (12.0 * h)
        second = near.length @ [-1.0, 16.0, -30.0, 16.0, -1.0] / (12.0 * h * h)
        dL, ddL = one.by_plane
        assert dL == pytest.approx(first, abs=1e-8), one  # m/rad
        assert ddL == pytest.approx(second, rel=1e-6, abs=1e-7), one  # m/rad^2: rounding over h^2
    assert checked > 200


coordinate = st.floats(-0.1, 0.1, allow_subnormal=False)


@settings(deadline=None, max_examples=200, derandomize=True)
@given(
    D=st.floats(1e-3, 0.3),
    centre=st.tuples(coordinate, coordinate, coordinate),
    R=st.floats(1e-3, 0.1),
    psi=st.floats(-4.0, 4.0),
)
def test_a_band_is_finite_and_no_shorter_than_the_straight_line(
    D: float, centre: tuple[float, float, float], R: float, psi: float
) -> None:
    one = Geometry(D, centre, R, psi)
    assert np.isfinite(one.length)
    assert one.length >= D - EXACT
    if one.state == WRAPPED:
        assert 0.0 <= one.wrap.arc <= 2.0 * np.pi
        assert one.length == pytest.approx(sum(one.tangents) + one.wrap.r * one.wrap.arc)


def test_a_plane_that_just_touches_the_sphere_misses_it() -> None:
    touching = Geometry(0.1, (0.05, 0.03, 0.04), 0.05).turned(0.0)
    in_reach = touching._replace(R=0.04 + 1e-9)
    at_the_edge = touching._replace(R=0.04)  # = |d|
    assert at_the_edge.d == -0.04
    assert (at_the_edge.state, in_reach.state) == (MISSED, WRAPPED)
    assert int(at_the_edge.literal().state) == MISSED
    assert at_the_edge.length == 0.1


def test_a_missed_band_is_a_straight_line() -> None:
    for one in GEOMETRIES:
        if one.state == MISSED:
            assert one.length == one.D
            assert abs(one.d) >= one.R


def test_a_line_through_the_centre_wraps_alike_in_every_plane() -> None:
    half_arc = np.pi / 2.0 - np.arccos(0.03 / 0.05)
    for psi in np.linspace(-np.pi, np.pi, 9):
        one = Geometry(0.1, (0.05, 0.0, 0.0), 0.03, float(psi))
        assert one.state == WRAPPED
        assert one.length == pytest.approx(2.0 * (0.04 + 0.03 * half_arc), abs=EXACT)
        assert one.by_plane == pytest.approx((0.0, 0.0), abs=EXACT)


def test_a_line_that_touches_its_sphere_is_clear_on_one_side_and_wraps_on_the_other() -> None:
    below = Geometry(0.1, (0.05, -0.03, 0.0), 0.03)
    assert below.kind == BESIDE
    assert below.state == CLEAR
    above = below.turned(np.pi)
    assert above.state == WRAPPED
    assert above.length == pytest.approx(float(above.literal().length), abs=EXACT)


def test_the_length_is_continuous_where_a_band_comes_to_touch_its_sphere() -> None:
    touching = Geometry(0.1, (0.05, -0.03, 0.0), 0.03)
    pressed = touching._replace(R=0.03 + 1e-9)
    assert pressed.state == WRAPPED
    assert pressed.length == pytest.approx(touching.length, abs=1e-12)  # m; it grows as its root^3
    assert pressed.by_plane == pytest.approx((0.0, 0.0), abs=1e-4)


@pytest.mark.parametrize('b', [-0.01, 0.01])
def test_an_end_on_the_sphere_is_its_own_transition_point(b: float) -> None:
    R = 0.05
    one = Geometry(0.12, ((R * R - b * b) ** 0.5, b, 0.0), R)
    one = one._replace(R=R * (1.0 - 1e-15))  # rounding must not put the end inside
    tP, tS = one.tangents
    assert one.state == WRAPPED
    assert tP < 1e-8  # m: the root of the rounding
    w = one.wrap
    assert one.length == pytest.approx(w.r * w.arc + tS, abs=1e-8)
    # the band leaves along the circle: t1 at right angles to the radius to P
    assert w.t1u * one.centre[0] + w.t1e * b == pytest.approx(0.0, abs=1e-8)


def test_an_end_inside_the_sphere_is_told_and_leaves_a_straight_line() -> None:
    for x in (0.01, 0.09):
        one = Geometry(0.1, (x, 0.01, 0.0), 0.03)
        assert (one.kind, one.state, one.length) == (INSIDE, INSIDE, 0.1)
        assert int(one.literal().state) == INSIDE


@pytest.mark.parametrize('x', [-0.02, 0.14], ids=['before the origin', 'past the insertion'])
def test_a_sphere_past_an_end_is_wrapped_on_the_bulging_side_alone(x: float) -> None:
    over = Geometry(0.1, (x, 0.05, 0.0), 0.03)
    under = over.turned(np.pi)
    assert (over.kind, over.state, under.state) == (BESIDE, WRAPPED, CLEAR)
    assert over.length == pytest.approx(hull_length(over), abs=1e-6)
    assert over.length == pytest.approx(float(over.literal().length), abs=EXACT)


@pytest.mark.parametrize('x', [-0.05, 0.15], ids=['before the origin', 'past the insertion'])
def test_a_sphere_on_the_lines_extension_is_no_obstacle_to_a_band_that_bulges_off(
    x: float,
) -> None:
    over = Geometry(0.1, (x, 0.01, 0.0), 0.03)
    under = over.turned(np.pi)
    assert over.kind == EXTENDED
    assert (under.state, under.length) == (CLEAR, 0.1)
    # the published method sends the other one all the way round
    assert over.state == WRAPPED
    assert over.wrap.arc > np.pi
    assert over.length == pytest.approx(float(over.literal().length), abs=EXACT)
