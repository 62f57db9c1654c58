# SPDX-License-Identifier: Apache-2.0
"""What the search of the whole circle rests on: its samples, its breaks and its descents."""

from __future__ import annotations

import numpy as np
import pytest
import reference
from posed_muscle import CASES, THETAS, Posed

from linkedplane_ros.linked_planes.band import PIERCED
from linkedplane_ros.linked_planes.chain import energy, planes_exist
from linkedplane_ros.linked_planes.whole_circle import (
    breaks_of,
    descend_from,
    rule_out,
    sample,
    search_circle,
    slackest,
)

H = 1e-4  # rad: of differences


@pytest.mark.parametrize('case', CASES, ids=str)
def test_a_sample_is_the_total_its_slope_its_bands_bends_and_the_fastest_turn(
    case: tuple[int, str],
) -> None:
    posed = Posed(*case)
    for theta in THETAS:
        bands = posed.literal(theta + H * np.array([-1.0, 0.0, 1.0]))
        if any(len(set(band.state)) > 1 for band in bands):
            continue  # an edge
        lengths = np.array([band.length for band in bands])
        found = sample(posed.bands, theta)
        assert found.theta == theta
        assert found.E == pytest.approx(lengths[:, 1].sum(), abs=1e-12)
        slopes = (lengths[:, 2] - lengths[:, 0]) / (2.0 * H)
        assert found.dE == pytest.approx(slopes.sum(), abs=1e-6)
        bends = (lengths[:, 2] - 2.0 * lengths[:, 1] + lengths[:, 0]) / (H * H)
        assert found.bend == pytest.approx(np.abs(bends).sum(), rel=1e-3, abs=1e-5)
        turns = [np.linalg.norm(band.normal[2] - band.normal[0]) / (2.0 * H) for band in bands]
        assert found.turn == pytest.approx(max(turns), rel=1e-4)


@pytest.mark.parametrize(('AA', 'BB', 'fastest'), [(1.0, 0.0, np.pi / 2), (0.0, 1.0, np.pi)])
def test_the_circle_is_broken_just_beside_the_thetas_at_which_a_plane_vanishes(
    AA: float, BB: float, fastest: float
) -> None:
    band = Posed(5, 'ground').bands[0]
    section = band.section._replace(AA=AA, AB=0.0, BB=BB, kind=PIERCED)
    vanishing = [band._replace(section=section)]
    found = np.array(breaks_of(vanishing))
    aside = reference.in_circle(2.0 * (found - fastest)) / 2.0  # from it, or from half a turn on
    assert sorted(np.sign(aside)) == [-1.0, -1.0, 1.0, 1.0]
    for theta, away in zip(found, aside, strict=True):
        assert planes_exist(vanishing, np.cos(theta), np.sin(theta))
        inside = theta - 0.01 * away
        assert not planes_exist(vanishing, np.cos(inside), np.sin(inside))


@pytest.mark.parametrize('phi', [-1.2, 0.0, 0.4, 1.5])
def test_the_circle_is_broken_where_a_plane_turns_fastest(phi: float) -> None:
    c, s, least = np.cos(phi), np.sin(phi), 0.01  # of the normal's square, at its shortest
    forms = {'AA': c * c + least * s * s, 'AB': (1.0 - least) * c * s, 'BB': s * s + least * c * c}
    band = Posed(5, 'ground').bands[0]
    section = band.section._replace(**forms, kind=PIERCED)
    found = breaks_of([band._replace(section=section)])
    want = reference.in_circle([phi + np.pi / 2, phi - np.pi / 2])
    np.testing.assert_allclose(sorted(reference.in_circle(found)), sorted(want), atol=1e-12)
    even = band.section._replace(AA=1.0, AB=0.0, BB=0.6, kind=PIERCED)
    assert breaks_of([band._replace(section=even)]) == []


@pytest.mark.parametrize('start', [-0.7, -0.05, -1e-5, 1e-5, 0.05, 0.7])
def test_a_descent_from_anywhere_goes_down_and_ends_on_the_floor_or_at_its_reach(
    start: float,
) -> None:
    for posed in map(Posed, range(3), ('deltoid',) * 3):
        for band in posed.bands:
            if band.section.kind != PIERCED:
                continue
            c, s = slackest(band.section)
            floor = float(np.arctan2(s, c))
            assert descend_from([band], floor + start, 1.0) == pytest.approx(floor, abs=1e-8)
            short = descend_from([band], floor + start, 0.3 * abs(start))
            moved = floor + start - short
            assert 0.1 * abs(start) < abs(moved) < 0.3 * abs(start)
            assert np.sign(moved) == np.sign(start)


@pytest.mark.parametrize('case', CASES, ids=str)
def test_what_is_left_once_the_circle_is_ruled_out_is_no_longer_than_a_scan(
    case: tuple[int, str],
) -> None:
    posed = Posed(*case)
    samples = [sample(posed.bands, x) for x in np.linspace(-np.pi, np.pi, 9).tolist()]
    totals = reference.total_at(posed.muscle, posed.rotation, reference.circle(720))
    worst = float(reference.circle(720)[totals.argmax()])
    best = rule_out(posed.bands, samples, (float(totals.max()), worst, -1), 0.3)
    assert best[0] <= totals.min() + 1e-9  # m
    assert best[0] == energy(posed.bands, best[1], False, best[2])[0]


@pytest.mark.parametrize('case', CASES, ids=str)
def test_the_search_ends_on_a_floor_or_at_an_edge(case: tuple[int, str]) -> None:
    posed = Posed(*case)
    theta, held = search_circle(posed.bands, 0.3)
    lines = sum(band.section.D for band in posed.bands)
    if held < 0 and energy(posed.bands, theta, False, -1)[0] > lines + 1e-12:
        assert energy(posed.bands, theta, False, -1)[1] == pytest.approx(0.0, abs=1e-6)  # m/rad
