# SPDX-License-Identifier: Apache-2.0
"""The chain of planes at any theta, not only at the solved one, against the literal method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import reference
from posed_muscle import CASES, THETAS, Posed, posed_bands
from random_muscles import deltoid_with_bands, random_muscle_in_frames
from reference import Array

from linkedplane_ros.linked_planes.band import BESIDE, CLEAR, INSIDE, MISSED, PIERCED, WRAPPED
from linkedplane_ros.linked_planes.chain import (
    energy,
    moving_frame,
    plane_at,
    state_at,
)
from linkedplane_ros.linked_planes.path import band_path, depth_in_spheres, distance, halfway

SAME = 1e-11  # m: the rounding of a length, with room for acos near 1


@pytest.fixture(params=CASES, ids=str, scope='module')
def posed(request: pytest.FixtureRequest) -> Posed:
    """Return a posed muscle."""
    return Posed(*request.param)


def test_every_plane_is_that_of_the_literal_method(posed: Posed) -> None:
    centres = reference.sphere_centres(posed.muscle, posed.rotation)
    for theta in THETAS:
        c, s = np.cos(theta), np.sin(theta)
        literal = posed.literal(theta)
        assert len(posed.bands) == len(literal)
        for i, (band, one) in enumerate(zip(posed.bands, literal, strict=True)):
            P, S = posed.muscle.origins[i], posed.rotation @ posed.muscle.insertions[i]
            e = np.cross(S - P, one.normal) / np.linalg.norm(S - P)
            d, b, _, _ = plane_at(band.section, c, s)
            assert d == pytest.approx((centres[i] - P) @ one.normal, abs=SAME)
            assert b == pytest.approx((centres[i] - P) @ e, abs=SAME)
            assert state_at(band.section, d, b, 0, -1) == one.state
            np.testing.assert_allclose(band.S, S, rtol=0.0, atol=SAME)
            np.testing.assert_allclose(P + band.p, centres[i], rtol=0.0, atol=SAME)


def test_a_plane_turns_about_its_line_as_its_slopes_say(posed: Posed) -> None:
    h = 1e-4  # rad; differences of the second order
    for theta in THETAS:
        ends = theta - h, theta + h
        normals = [[one.normal for one in posed.literal(end)] for end in ends]
        for band, before, after in zip(posed.bands, *normals, strict=True):
            turn = np.cross(before, after) @ band.u / (2.0 * h)
            _, _, J, dJ = plane_at(band.section, np.cos(theta), np.sin(theta))
            assert J == pytest.approx(turn, rel=1e-5, abs=1e-6)
            low, high = (plane_at(band.section, np.cos(end), np.sin(end))[2] for end in ends)
            assert dJ == pytest.approx((high - low) / (2.0 * h), rel=1e-4, abs=1e-5)


def test_the_whole_length_and_its_slopes_are_those_of_the_literal_method(posed: Posed) -> None:
    h = 1e-4  # rad
    steps = h * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    for theta in THETAS:
        E, dE, ddE = energy(posed.bands, theta, False, -1)
        near = reference.total_at(posed.muscle, posed.rotation, theta + steps)
        assert E == pytest.approx(near[2], abs=SAME)
        if any(len(set(one.state.tolist())) > 1 for one in posed.literal(theta + steps)):
            continue  # a band comes to touch its sphere there
        assert dE == pytest.approx(near @ [1, -8, 0, 8, -1] / (12 * h), rel=1e-6, abs=1e-8)
        second = near @ [-1, 16, -30, 16, -1] / (12 * h * h)
        assert ddE == pytest.approx(second, rel=1e-3, abs=1e-5)  # rounding over h^2


def test_pierced_bands_alone_are_the_whole_length_without_the_others(posed: Posed) -> None:
    held = len(posed.bands) - 1
    for theta in THETAS:
        lengths = [float(one.length) for one in posed.literal(theta)]
        pierced = [band.section.kind == PIERCED for band in posed.bands]
        kept = sum(length for length, is_it in zip(lengths, pierced, strict=True) if is_it)
        assert energy(posed.bands, theta, True, -1)[0] == pytest.approx(kept, abs=SAME)
        straight = sum(lengths[:-1]) + posed.bands[-1].section.D  # the last one is held
        assert energy(posed.bands, theta, False, held)[0] == pytest.approx(straight, abs=SAME)


def test_a_held_band_is_missed_at_its_spheres_rim_and_clear_at_a_lines_extension(
    posed: Posed,
) -> None:
    for band in posed.bands:
        R, kind = band.section.R, band.section.kind
        for d, b in ((R, 1e-9), (-R, 1e-12), ((1.0 - 1e-7) * R, 0.0)):
            state = state_at(band.section, d, b, 0, 0)
            assert state == (MISSED if kind == BESIDE else CLEAR)
        if kind == BESIDE:  # another one is held, and this one's edge is there as well
            assert state_at(band.section, (1.0 - 1e-14) * R, 0.1 * R, 1, 0) == MISSED
            assert state_at(band.section, (1.0 - 1e-9) * R, 0.1 * R, 1, 0) == WRAPPED


@pytest.mark.parametrize('fault', ['line', 'plane', 'frame', 'frame: HM is its origin'])
def test_the_chain_ends_before_a_band_that_has_no_line_no_plane_or_no_frame(fault: str) -> None:
    muscle, rotations = random_muscle_in_frames(4, 'moving')
    R = rotations[0]
    assert muscle.ground_point is not None
    assert muscle.humeral_point is not None
    SC, HM = muscle.ground_point, R @ muscle.humeral_point
    insertions, origins = muscle.insertions.copy(), muscle.origins.copy()
    last = 1  # of five: the others have all, and are not reached
    assert len(origins) == 5
    if fault == 'line':
        insertions[last] = R.T @ origins[last]
    elif fault == 'plane':
        last = 0
        insertions[0] = R.T @ (origins[0] + 0.1 * muscle.reference_normal)
    else:
        origins[last] = HM if 'HM' in fault else SC + 2.0 * (HM - SC)
    assert len(posed_bands(replace(muscle, origins=origins, insertions=insertions), R)) == last


@pytest.mark.parametrize('end', ['origin', 'insertion'])
def test_an_end_inside_its_sphere_leaves_a_straight_band(end: str) -> None:
    posed = Posed(5, 'ground')
    muscle, R = posed.muscle, posed.rotation
    origins, insertions = muscle.origins.copy(), muscle.insertions.copy()
    inside = muscle.sphere_centres[0] + 0.3 * muscle.sphere_radii[0] * np.eye(3)[0]
    if end == 'origin':
        origins[0] = inside
    else:
        insertions[0] = R.T @ inside
    band = posed_bands(replace(muscle, origins=origins, insertions=insertions), R)[0]
    D = np.linalg.norm(R @ insertions[0] - origins[0])
    for theta in THETAS:
        d, b, _, _ = plane_at(band.section, np.cos(theta), np.sin(theta))
        assert state_at(band.section, d, b, 0, -1) == INSIDE
        assert energy([band], theta, False, -1) == (pytest.approx(D, abs=SAME), 0.0, 0.0)


@pytest.mark.parametrize('case', range(10))
def test_a_moving_frame_points_to_hm_and_has_sc_in_its_plane(case: int) -> None:
    P, HM, SC = np.random.default_rng(case).normal(size=(3, 3))
    x, y, z, lever, skew = moving_frame(tuple(P), tuple(HM), tuple(SC))
    assert lever == pytest.approx(np.linalg.norm(HM - P), rel=1e-14)
    np.testing.assert_allclose(lever * np.array(x), HM - P, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(np.cross(x, y), z, rtol=0.0, atol=1e-14)
    along, aside = (SC - P) @ x, (SC - P) @ y
    assert aside > 0.0
    np.testing.assert_allclose(
        P + along * np.array(x) + aside * np.array(y), SC, rtol=0.0, atol=1e-13
    )
    assert skew == pytest.approx(along / aside, rel=1e-12)


def test_the_planes_of_a_long_chain_are_those_of_the_literal_method() -> None:
    muscle = deltoid_with_bands(80)
    R = Posed(0, 'deltoid').rotation
    bands = posed_bands(muscle, R)
    assert len(bands) == 80
    for theta in THETAS:
        c, s = np.cos(theta), np.sin(theta)
        for band, one in zip(bands, reference.chain(muscle, R, theta), strict=True):
            normal = c * np.array(band.A) + s * np.array(band.B)
            np.testing.assert_allclose(reference.unit(normal), one.normal, rtol=0.0, atol=1e-9)


def polyline(posed: Posed, i: int, one: reference.BandPath) -> Array:
    """Return a band's path by the literal method, its arc in a thousand chords."""
    P, S = posed.muscle.origins[i], posed.rotation @ posed.muscle.insertions[i]
    if one.state != WRAPPED:
        return np.array([P, S])
    from_Q = one.Q - one.centre
    turns = np.linspace(0.0, -float(one.arc), 1001)[:, np.newaxis]  # clockwise about the normal
    arc = np.cos(turns) * from_Q + np.sin(turns) * np.cross(one.normal, from_Q)
    if np.linalg.norm(arc[-1] - (one.T - one.centre)) > 1e-6:
        arc = np.cos(turns) * from_Q - np.sin(turns) * np.cross(one.normal, from_Q)
    np.testing.assert_allclose(arc[-1], one.T - one.centre, rtol=0.0, atol=1e-6)
    return np.vstack([P, one.centre + arc, S])


def test_the_distance_from_a_path_is_that_from_its_polyline(posed: Posed) -> None:
    rng = np.random.default_rng(5)
    for theta in THETAS[:3]:
        for i, (band, one) in enumerate(zip(posed.bands, posed.literal(theta), strict=True)):
            path = band_path(band, np.cos(theta), np.sin(theta), int(one.state))
            line = polyline(posed, i, one)
            start, along = line[:-1], np.diff(line, axis=0)
            centres = line[rng.integers(0, len(line), 6)] + rng.normal(0.0, 0.03, (6, 3))
            for X in centres:
                size = np.maximum((along**2).sum(axis=1), 1e-30)
                share = np.clip(((X - start) * along).sum(axis=1) / size, 0.0, 1.0)
                off = np.linalg.norm(start + share[:, np.newaxis] * along - X, axis=1).min()
                # m: a chord's height over its arc, of 2 pi and 6 cm at most
                assert distance(path, tuple(X)) == pytest.approx(off, abs=1e-6)
            spheres = np.column_stack([centres, rng.uniform(0.01, 0.03, 6)])
            deepest = max(s[3] - distance(path, tuple(s[:3])) for s in spheres)
            assert depth_in_spheres(path, spheres) == deepest
            assert depth_in_spheres(path, spheres[:0]) == -np.inf


def test_the_point_halfway_along_a_path_is_that_of_its_polyline(posed: Posed) -> None:
    for theta in THETAS[:3]:
        for i, (band, one) in enumerate(zip(posed.bands, posed.literal(theta), strict=True)):
            path = band_path(band, np.cos(theta), np.sin(theta), int(one.state))
            line = polyline(posed, i, one)
            steps = np.diff(line, axis=0)
            far = np.concatenate(([0.0], np.cumsum(np.linalg.norm(steps, axis=1))))
            k = int(np.searchsorted(far, 0.5 * far[-1])) - 1
            share = (0.5 * far[-1] - far[k]) / (far[k + 1] - far[k])
            point, direction = halfway(path)
            np.testing.assert_allclose(point, line[k] + share * steps[k], rtol=0.0, atol=1e-6)
            # rad: the turn of the arc over a chord
            np.testing.assert_allclose(direction, reference.unit(steps[k]), rtol=0.0, atol=7e-3)


def test_the_random_muscles_show_every_state() -> None:
    found = set()
    for case in CASES:
        found |= {int(one.state) for theta in THETAS for one in Posed(*case).literal(theta)}
    assert found == {WRAPPED, CLEAR, MISSED, INSIDE}
