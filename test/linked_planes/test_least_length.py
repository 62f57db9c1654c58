# SPDX-License-Identifier: Apache-2.0
"""The parts of the search for theta, each against scans of the circle by the literal method."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import reference
from posed_muscle import CASES, THETAS, Posed, posed_bands
from random_muscles import DELTOID
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle
from linkedplane_ros.linked_planes import least_length, whole_circle
from linkedplane_ros.linked_planes.band import BESIDE, EXTENDED, PIERCED, WRAPPED
from linkedplane_ros.linked_planes.chain import Band, energy, plane_at
from linkedplane_ros.linked_planes.least_length import (
    near_side,
    others_straight,
    search_pierced,
    settle,
    solve_theta,
    stiffness,
    turn_evenly,
)
from linkedplane_ros.linked_planes.whole_circle import (
    EVEN,
    descend,
    edges,
    least,
    search_circle,
    slackest,
    unevenness,
    wrapped_angle,
)

LEAST = 1e-9  # m: what a total may exceed the least one of a scan by
CIRCLE = reference.circle(720)


@pytest.fixture(params=CASES, ids=str, scope='module')
def posed(request: pytest.FixtureRequest) -> Posed:
    """Return a posed muscle."""
    return Posed(*request.param)


def of_kind(posed: Posed, kind: int) -> list[tuple[int, Band]]:
    """Return the bands that meet their spheres so, with their places."""
    return [(i, band) for i, band in enumerate(posed.bands) if band.section.kind == kind]


def speeds(band: Band) -> Array:
    """Return how fast a band's plane turns, over the circle."""
    return np.array([abs(plane_at(band.section, np.cos(x), np.sin(x))[2]) for x in CIRCLE])


@pytest.mark.parametrize('angle', [-20.0, -7.0, -np.pi, -3.0, 0.0, 0.5, np.pi, 3.2, 6.0, 9.5, 50.0])
def test_a_wrapped_angle_is_the_same_one_within_half_a_turn(angle: float) -> None:
    found = wrapped_angle(angle)
    assert -np.pi < found <= np.pi
    assert abs(np.exp(1j * found) - np.exp(1j * angle)) < 1e-14


def test_a_pierced_band_is_slackest_where_no_other_plane_is_shorter(posed: Posed) -> None:
    lengths = [one.length for one in posed.literal(CIRCLE)]
    for i, band in of_kind(posed, PIERCED):
        c, s = slackest(band.section)
        assert np.hypot(c, s) == pytest.approx(1.0, abs=1e-15)
        here = float(posed.literal(np.arctan2(s, c))[i].length)
        assert here <= lengths[i].min() + 1e-12  # m
        d, b, _, _ = plane_at(band.section, c, s)
        assert d == pytest.approx(0.0, abs=1e-15)
        assert b < 0.0


def test_a_line_through_a_spheres_centre_is_slackest_everywhere() -> None:
    section = Posed(5, 'ground').bands[0].section._replace(dA=0.0, dB=0.0)
    assert slackest(section) == (1.0, 0.0)


def test_the_stiffness_of_a_short_arc_is_the_lengths_second_difference() -> None:
    checked = 0
    h = 1e-3  # rad
    for seed in range(60):
        posed = Posed(seed, ('moving', 'ground')[seed % 2])
        for i, band in of_kind(posed, PIERCED):
            c, s = slackest(band.section)
            one = posed.literal(np.arctan2(s, c) + h * np.array([-1.0, 0.0, 1.0]))[i]
            second = (one.length[0] - 2.0 * one.length[1] + one.length[2]) / (h * h)
            if one.arc[1] < 0.4 and second > 1e-3:
                checked += 1
                # a sine in the arc's stead: off by a sixth of the arc's square
                assert stiffness(band.section, c, s) == pytest.approx(second, rel=0.05)
    assert checked > 5


def test_unevenness_is_the_fastest_turn_over_the_slowest(posed: Posed) -> None:
    for band in posed.bands:
        turns = speeds(band)
        # a scan of half a degree meets each to the square of a hundredth
        assert unevenness(band.section) == pytest.approx(turns.max() / turns.min(), rel=2e-2)
    pierced = [unevenness(band.section) for _, band in of_kind(posed, PIERCED)]
    assert turn_evenly(posed.bands) == all(each <= EVEN for each in pierced)


def test_a_band_comes_to_touch_its_sphere_at_its_edges(posed: Posed) -> None:
    for i, band in enumerate(posed.bands):
        found = edges(band.section)
        if band.section.kind not in (BESIDE, EXTENDED):
            assert found == []
            continue
        assert all(-np.pi < edge <= np.pi for edge in found)
        wraps = posed.literal(np.add.outer(found, [-1e-6, 1e-6]))[i].state == WRAPPED
        assert (wraps[:, 0] != wraps[:, 1]).all()
        scan = posed.literal(reference.circle(3600))[i].state == WRAPPED
        assert len(found) == (scan != np.roll(scan, 1)).sum()


def test_others_are_straight_where_no_band_beside_its_sphere_is_wrapped(posed: Posed) -> None:
    for theta in THETAS:
        wrapped = [
            band.section.kind in (BESIDE, EXTENDED) and one.state == WRAPPED
            for band, one in zip(posed.bands, posed.literal(theta), strict=True)
        ]
        for held in range(-1, len(wrapped)):
            but_held = [is_it for i, is_it in enumerate(wrapped) if i != held]
            assert others_straight(posed.bands, theta, held) == (not any(but_held))


def test_the_near_side_is_where_every_pierced_band_bulges_off_its_spheres_centre(
    posed: Posed,
) -> None:
    centres = reference.sphere_centres(posed.muscle, posed.rotation)
    for theta in THETAS:
        bulges = [
            np.cross(band.u, one.normal) @ (centres[i] - posed.muscle.origins[i])
            for i, (band, one) in enumerate(zip(posed.bands, posed.literal(theta), strict=True))
            if band.section.kind == PIERCED
        ]
        assert near_side(posed.bands, theta) == all(b < 0.0 for b in bulges)


def test_a_descent_ends_at_the_bottom_of_its_valley(posed: Posed) -> None:
    for _, band in of_kind(posed, PIERCED):
        c, s = slackest(band.section)
        bottom = float(np.arctan2(s, c))
        for low, start, high in ((0.8, 0.7, 0.9), (0.9, -0.7, 0.8), (1e-3, 0.0, 1e-3)):
            found = descend([band], bottom - low, bottom + start, bottom + high, True)
            assert found == pytest.approx(bottom, abs=1e-9)  # rad


def test_of_two_candidates_the_shorter_is_better_and_then_the_one_nearer_to_neutral() -> None:
    bands = Posed(5, 'ground').bands
    E = energy(bands, 0.5, False, -1)[0]
    assert least(bands, 0.5, -1, (E + 1e-6, 2.0, 0), 2.0) == (E, 0.5, -1)
    assert least(bands, 0.5, -1, (E - 1e-6, 2.0, 0), 0.5) == (E - 1e-6, 2.0, 0)
    assert least(bands, 0.5, -1, (E, 2.0, 0), 1.0) == (E, 0.5, -1)
    assert least(bands, 0.5, -1, (E, 2.0, 0), 1.5) == (E, 2.0, 0)
    assert least(bands, 0.5, -1, (E, 1.5, 0), 1.0) == (E, 1.5, 0)  # as near: the first one stays
    assert least(bands, 0.5, -1, (E, -3.0, 0), 3.0) == (E, -3.0, 0)  # over pi, it is nearer
    held = len(bands) - 1
    straight = energy(bands, 0.5, False, held)[0]
    assert least(bands, 0.5, held, (straight + 1e-6, 2.0, 0), 2.0) == (straight, 0.5, held)


def test_every_search_is_as_good_as_a_scan(posed: Posed) -> None:
    scan = reference.total_at(posed.muscle, posed.rotation, CIRCLE).min()
    for neutral in (-2.0, 0.3):
        for theta, held in (search_circle(posed.bands, neutral), solve_theta(posed.bands, neutral)):
            assert -np.pi < theta <= np.pi
            assert energy(posed.bands, theta, False, held)[0] <= scan + LEAST
            assert held < 0 or posed.bands[held].section.kind in (BESIDE, EXTENDED)


@pytest.mark.parametrize('end', [np.pi - 0.004, -np.pi + 0.004])
def test_the_least_length_is_found_wherever_theta_is_counted_from(posed: Posed, end: float) -> None:
    # in the last of 360 steps round the circle, and in the first
    for search in (search_circle, solve_theta):
        theta, held = search(posed.bands, 0.3)
        turned = posed.count_from(theta - end)
        found, held_there = search(turned, wrapped_angle(0.3 - (theta - end)))
        length = energy(posed.bands, theta, False, held)[0]
        assert energy(turned, found, False, held_there)[0] == pytest.approx(length, abs=LEAST)
        if held < 0 and length > sum(band.section.D for band in posed.bands) + LEAST:
            assert abs(np.exp(1j * found) - np.exp(1j * end)) < 1e-6  # rad


def crossing_bands(seed: int) -> tuple[BroadMuscle, Array]:
    """Return two bands round spheres in their middles, nearly at right angles, and a rotation.

    The second plane turns some 1 / cos^2 of the angle between them as fast as at its slowest.
    """
    rng = np.random.default_rng(seed)
    R = Rotation.random(random_state=seed).as_matrix()
    u = reference.unit(rng.normal(size=3))
    aside = reference.unit(np.cross(u, rng.normal(size=3)))
    lean = rng.uniform(0.08, 0.15)  # rad off the right angle
    lines = 0.12 * np.array([u, np.cos(lean) * aside + np.sin(lean) * u])
    origins = rng.uniform(-0.05, 0.05, (2, 3))
    muscle = replace(
        DELTOID,
        band_names=('one', 'other'),
        heads=(),
        origins=origins,
        insertions=(origins + lines) @ R,
        sphere_centres=origins + 0.5 * lines + rng.normal(0.0, 0.003, (2, 3)),
        sphere_radii=np.array([0.02, 0.02]),
        sphere_frame='ground',
        plane_angles=rng.uniform(-0.6, 0.6, 2),
        reference_normal=reference.unit(rng.normal(size=3)),
    )
    return muscle, R


@pytest.mark.parametrize('seed', range(12))
def test_a_plane_that_turns_very_unevenly_is_searched_finely(seed: int) -> None:
    muscle, R = crossing_bands(seed)
    bands = posed_bands(muscle, R)
    assert [band.section.kind for band in bands] == [PIERCED, PIERCED]
    assert unevenness(bands[1].section) > 40.0
    scan = reference.total_at(muscle, R, reference.circle(7200)).min()
    for theta, held in (search_circle(bands, 0.3), solve_theta(bands, 0.3)):
        assert energy(bands, theta, False, held)[0] <= scan + LEAST


def test_pierced_bands_together_are_as_short_as_in_a_scan(posed: Posed) -> None:
    if not of_kind(posed, PIERCED) or not turn_evenly(posed.bands):
        return
    found = energy(posed.bands, search_pierced(posed.bands, 12), True, -1)[0]
    scan = min(energy(posed.bands, x, True, -1)[0] for x in CIRCLE)
    assert found <= scan + LEAST


@pytest.mark.parametrize('stretch', range(12))
def test_pierced_bands_are_shortest_in_whichever_stretch_of_the_circle(stretch: int) -> None:
    end = -np.pi + 2.0 * np.pi * (stretch + 0.4) / 12  # rad: in this one of 12 stretches
    for posed in map(Posed, range(3), ('deltoid',) * 3):
        theta = search_pierced(posed.bands, 12)
        found = search_pierced(posed.count_from(theta - end), 12)
        assert found == pytest.approx(end, abs=1e-6)


def test_two_pierced_bands_balance_at_their_shortest_however_far_from_the_guess() -> None:
    near = np.linspace(-0.02, 0.02, 801)  # rad
    for seed in range(20, 36):
        posed = Posed(seed, 'deltoid')
        theta, held = solve_theta(posed.bands, 0.0)
        scan = reference.total_at(posed.muscle, posed.rotation, theta + near).min()
        assert energy(posed.bands, theta, False, held)[0] <= scan + LEAST


def test_the_circle_is_not_searched_where_one_valley_or_none_will_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    evaluations = 0

    def counted(*given: Any) -> tuple[float, float, float]:
        nonlocal evaluations
        evaluations += 1
        return energy(*given)

    for module in (least_length, whole_circle):
        monkeypatch.setattr(module, 'energy', counted)
    counts = []
    for seed in range(40):
        posed = Posed(seed, 'deltoid')
        evaluations = 0
        solve_theta(posed.bands, -0.5)
        pierced = len(of_kind(posed, PIERCED))
        if pierced < 2:
            assert evaluations == pierced  # straight, or the one band's own theta
        assert evaluations < 30  # the whole circle costs hundreds
        counts.append(evaluations)
    assert np.median(counts) <= 3.0  # the guess is good: a Newton step or two
    settled = 0
    for seed in range(40):
        posed = Posed(seed, 'ground')
        evaluations = 0
        _, held = settle(posed.bands, 0.1)
        if not of_kind(posed, PIERCED):
            assert evaluations == 0
            settled += held >= 0
    assert settled > 3


def test_a_muscle_that_may_be_straight_settles_nearest_to_neutral() -> None:
    moved = 0
    for seed in range(40):
        posed = Posed(seed, 'ground')
        straight = reference.straight_at(posed.muscle, posed.rotation, CIRCLE)
        if of_kind(posed, PIERCED) or not straight.any():
            continue
        for neutral in (-2.9, 0.1, 1.7):
            theta, held = settle(posed.bands, neutral)
            assert solve_theta(posed.bands, neutral) == (theta, held)
            assert others_straight(posed.bands, theta, held)
            away = np.abs(reference.in_circle(CIRCLE[straight] - neutral)).min()
            found = abs(reference.in_circle(theta - neutral))
            assert away - 2.0 * np.pi / 720 <= found <= away + 1e-9  # rad: the step of the scan
            assert (held < 0) == (theta == neutral)
            moved += held >= 0
    assert moved > 5
