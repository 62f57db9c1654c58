# SPDX-License-Identifier: Apache-2.0
"""The derivation against the solver: its formulas (formulas.py), its tables, its figures.

The numbers in comments are the page's.
"""

from __future__ import annotations

import ast
import re
from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import reference
from formulas import Band, by_the_page, plane, posed, state_of, wrapped
from reference import Array
from scipy.spatial.transform import Rotation, Slerp

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.linked_planes import least_length as search
from linkedplane_ros.linked_planes import whole_circle
from linkedplane_ros.linked_planes.chain import bands_at
from linkedplane_ros.linked_planes.compilation import COMPILED

TOP = Path(__file__).parents[2]
PAGE = (TOP / 'doc' / 'explanation' / 'derivation.md').read_text()
DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
NEUTRAL = SOLVER.solve(np.eye(3)).theta
EXACT = 1e-13  # m: the rounding of lengths of some 0.1 m


def random_poses(count: int) -> Array:
    """Return the page's random poses of the range of motion."""
    low, high = (-40, 0, -60), (120, 120, 60)
    angles = np.radians(np.random.default_rng(3).uniform(low, high, (count, 3)))
    convention = JOINT_CONVENTIONS['flexion_abduction_rotation']
    return np.array([convention.rotation(each) for each in angles])


POSES = random_poses(2000)
STATES = SOLVER.solve_batch(POSES)


def test_lengths_states_and_moment_vectors_are_those_of_the_formulas() -> None:
    kinds: Counter[int] = Counter()
    for state in list(STATES)[:150]:
        lengths, vectors, states = by_the_page(DELTOID, state.rotation, state.theta)
        np.testing.assert_array_equal(states, state.wrap)
        np.testing.assert_allclose(state.lengths, lengths, rtol=0.0, atol=EXACT)
        # m: a theta that hangs on little, E'' small, makes more of the rounding
        np.testing.assert_allclose(state.moment_vectors, vectors, rtol=0.0, atol=1e-11)
        kinds.update(states.tolist())
    assert min(kinds[each] for each in (WrapState.WRAPPED, WrapState.CLEAR, WrapState.MISSED)) > 50


def test_moment_vectors_at_an_edge_are_those_of_the_formulas() -> None:
    # where a band's state is another on either side of theta, and theta matters to some band
    low, high = (reference.states_at(DELTOID, POSES, STATES.theta + away) for away in (-1e-7, 1e-7))
    matters = (STATES.wrap == WrapState.WRAPPED).any(axis=1)
    held = np.flatnonzero((low != high).any(axis=1) & matters)
    assert len(held) == 2  # as the page says
    for k in held:
        state = STATES[k]
        lengths, vectors, states = by_the_page(DELTOID, state.rotation, state.theta)
        np.testing.assert_array_equal(states, state.wrap)
        np.testing.assert_allclose(state.lengths, lengths, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(state.moment_vectors, vectors, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize('frame', ['ground', 'humerus'])
def test_the_formulas_hold_for_spheres_on_the_bones(frame: str) -> None:
    centres = np.array([band.p for band in posed(DELTOID, np.eye(3))]) + DELTOID.origins
    on_bones = replace(DELTOID, sphere_frame=frame, sphere_centres=centres)
    states = LinkedPlaneSolver(on_bones).solve_batch(POSES[:60])
    wrapped_bands = 0
    for state in states:
        lengths, vectors, wrap = by_the_page(on_bones, state.rotation, state.theta)
        if not np.array_equal(wrap, state.wrap):  # theta held at a sphere's edge
            continue
        np.testing.assert_allclose(state.lengths, lengths, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(state.moment_vectors, vectors, rtol=0.0, atol=1e-9)
        wrapped_bands += int((wrap == WrapState.WRAPPED).sum())
    assert wrapped_bands > 20


def test_the_angles_of_appendix_c_give_the_same_arc() -> None:
    checked = 0
    for state in list(STATES)[:60]:
        for band in posed(DELTOID, state.rotation):
            _, _, d, b, _, _ = plane(band, state.theta)
            if state_of(band, d, b) != WrapState.WRAPPED:
                continue
            w = wrapped(band, d, b)
            centre = [w.r / np.hypot(along, b) for along in (band.a, band.D - band.a)]
            alpha = np.arctan2(-b, -band.a) - np.arctan2(-b, band.D - band.a)  # (14)
            arc = alpha % (2.0 * np.pi) - np.arccos(centre[0]) - np.arccos(centre[1])
            assert w.arc == pytest.approx(arc, abs=1e-7)  # rad: acos near 1
            checked += 1
    assert checked > 100


def five_point(values: Array, h: float) -> tuple[float, float]:
    """Return the first and second derivative from values at -2h .. 2h; error of h^4."""
    first = values @ np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * h)
    second = values @ np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / (12.0 * h * h)
    return float(first), float(second)


def test_derivatives_by_theta_are_those_of_the_formulas() -> None:
    h = 1e-3  # rad
    checked = 0
    for state in list(STATES)[:60]:
        for band in posed(DELTOID, state.rotation):
            at = plane(band, state.theta)
            near = [plane(band, state.theta + k * h) for k in range(-2, 3)]
            psi = np.unwrap([np.arctan2(each.n @ at.e, each.n @ at.n) for each in near])
            assert five_point(psi, h) == pytest.approx((at.J, at.dJ), abs=1e-7)  # (9)
            if band.kind != 'PIERCED':
                continue
            w = wrapped(band, at.d, at.b)
            L = np.array([wrapped(band, each.d, each.b).L for each in near])
            slopes = w.Lpsi * at.J, w.Lpsi2 * at.J**2 + w.Lpsi * at.dJ  # of (19)
            assert five_point(L, h) == pytest.approx(slopes, abs=1e-7)  # m
            checked += 1
    assert checked > 100


def test_all_planes_of_a_band_share_what_the_page_says() -> None:
    # d^2 + b^2 = rho2, and so b^2 - r^2 = rho2 - R^2; a line that passes its sphere meets no circle
    for state in list(STATES)[:20]:
        for band in posed(DELTOID, state.rotation):
            for theta in np.linspace(-3.0, 3.0, 7):
                at = plane(band, theta)
                assert at.d**2 + at.b**2 == pytest.approx(band.rho2, abs=1e-16)


def test_a_band_jumps_onto_its_sphere_by_what_the_page_says() -> None:
    checked = 0
    for state in list(STATES)[:100]:
        for band in posed(DELTOID, state.rotation):
            if band.kind != 'BESIDE' or band.rho2 < band.R**2:
                continue
            d = band.R * (1.0 - 1e-12)
            w = wrapped(band, d, np.sqrt(band.rho2 - d**2))
            assert w.L - band.D == pytest.approx(band.tP + band.tS - band.D, abs=1e-6)  # (35)
            checked += 1
    assert checked > 50


def test_a_band_that_stands_out_a_little_is_longer_by_what_the_page_says() -> None:
    for h in (1e-4, 1e-5):  # m
        a, D, r = 0.06, 0.16, 0.03
        b = h - r
        tP, tS = (np.sqrt(along**2 + b**2 - r**2) for along in (a, D - a))
        zero = np.zeros(3)
        band = Band(
            zero, D, zero, zero, '', (zero,) * 3, 1.0, 0.0, a, b**2, tP, tS, r, '', zero, zero
        )
        w = wrapped(band, 0.0, b)
        excess = 0.5 * h**2 * (1.0 / tP + 1.0 / tS)  # (36)
        assert w.L - D == pytest.approx(excess, rel=50.0 * h)
        assert w.arc == pytest.approx(h * (1.0 / tP + 1.0 / tS), rel=50.0 * h)


def test_theta_jumps_at_the_plateau_alone_and_lengths_do_not() -> None:
    low, high = (-40, 0, -60), (120, 120, 60)
    angles = np.radians(np.random.default_rng(0).uniform(low, high, (400, 3)))
    convention = JOINT_CONVENTIONS['flexion_abduction_rotation']
    ends = Rotation.from_matrix([convention.rotation(each) for each in angles])
    jumps, steps = [], np.zeros(2)
    for k in range(200 if COMPILED else 4):
        way = Slerp([0.0, 1.0], ends[2 * k : 2 * k + 2])(np.linspace(0.0, 1.0, 1500)).as_matrix()
        states = SOLVER.solve_batch(way)
        leap = np.abs((np.diff(states.theta) + np.pi) % (2.0 * np.pi) - np.pi)
        wrapped_ones = (states.wrap == WrapState.WRAPPED).sum(axis=1)
        for j in np.flatnonzero(leap > 0.05):
            jumps.append(leap[j])
            assert sorted(wrapped_ones[j : j + 2].tolist()) == [0, 1]
            for m, values in enumerate((states.lengths, states.moment_vectors)):
                steps[m] = max(steps[m], np.abs(values[j + 1] - values[j]).max())
    assert 0.0 < steps.max() < 1e-4  # m
    if COMPILED:
        assert len(jumps) == 45
        assert (round(min(jumps), 1), round(max(jumps), 1)) == (0.3, 1.4)


WAYS = {
    (): 'the valley, from the guess',
    ('search_pierced',): 'the valley, by 12 thetas',
    ('settle',): 'no pierced band',
    ('search_circle', 'search_pierced'): 'the whole circle',
}


def test_theta_is_found_as_often_in_each_way_as_the_table_says(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # the kernels run uncompiled here, so that they can be watched
    taken: list[str] = []

    def watched(module: ModuleType, name: str) -> Callable[..., Any]:
        original = getattr(module, name)

        def watch(*args: Any) -> Any:
            taken.append(name)
            return original(*args)

        return watch

    for name in ('energy', 'search_pierced', 'settle', 'search_circle'):
        monkeypatch.setattr(search, name, watched(search, name))
    for name in ('energy', 'sample'):
        monkeypatch.setattr(whole_circle, name, watched(whole_circle, name))
    counts: dict[str, list[int]] = defaultdict(list)
    for rotation in POSES.tolist():
        taken.clear()
        search.solve_theta(bands_at(SOLVER._flat, tuple(map(tuple, rotation))), NEUTRAL)
        way = tuple(sorted(set(taken) - {'energy', 'sample'}))
        counts[WAYS[way]].append(taken.count('energy') + taken.count('sample'))
    lines = ['| way | poses | evaluations of (19) in a pose: mean, most |', '| --- | ---: | --- |']
    for way in WAYS.values():
        found = counts[way]
        lines.append(f'| {way} | {len(found)} | {np.mean(found):.1f}, {max(found)} |')
    table = PAGE.partition('<!-- search -->\n')[2].partition('\n<!-- /search -->')[0]
    order = sorted(lines[2:], key=lambda line: -int(line.split('|')[2]))
    assert table.splitlines() == lines[:2] + order


def parsed(module: str) -> ast.Module:
    """Return a module of the algorithm."""
    package = 'solver' if module == 'kernels' else 'linked_planes'
    return ast.parse((TOP / 'linkedplane_ros' / package / f'{module}.py').read_text())


def names_in(module: str, place: str) -> set[str]:
    """Return the identifiers in a function or class of a module, its arguments and fields too."""
    for node in ast.walk(parsed(module)):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node.name == place:
            inside = list(ast.walk(node))
            names = {each.id for each in inside if isinstance(each, ast.Name)}
            return names | {each.arg for each in inside if isinstance(each, ast.arg)} | {place}
    raise AssertionError(f'no {place} in {module}.py')


SYMBOLS = [
    [cell.strip() for cell in line.strip('|').split('|')]
    for line in PAGE.partition('<!-- symbols -->\n')[2].partition('<!--')[0].splitlines()[2:]
]


def test_every_symbol_has_its_name_in_the_code_where_the_table_says() -> None:
    assert len(SYMBOLS) > 50
    for symbol, code, _, _, where in SYMBOLS:
        names = set(re.findall(r'`(\w+)`', code))
        places = re.findall(r'`(\w+)\.(\w+)`', where)
        assert bool(names) == bool(places), symbol
        found = set().union(*(names_in(*place) for place in places))
        assert names <= found, symbol


def test_every_name_in_the_formulas_code_is_in_the_table() -> None:
    named = {name for row in SYMBOLS for name in re.findall(r'`(\w+)`', row[1])}
    for module, place in (
        ('chain', 'Section'),
        ('chain', 'Band'),
        ('chain', 'plane_at'),
        ('band', 'wrap'),
        ('band', 'length_by_plane'),
        ('moment_vectors', 'sphere_moves'),
        ('moment_vectors', 'next_turn'),
        ('moment_vectors', 'pull'),
    ):
        node = next(each for each in ast.walk(parsed(module)) if getattr(each, 'name', '') == place)
        stored = {
            each.id
            for each in ast.walk(node)
            if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
        }
        plain = {'_', 'section', 'moment', 'k2', 'bk', 'eps_D', 'last_nu_D', 'nu_D', 'h_D', 'dh_D',
                 'dd', 'dr', 'dopen_u', 'dopen_e', 'dlast', 'dband'}  # fmt: skip
        assert stored - plain <= named, (place, stored - plain - named)


def test_the_formulas_are_numbered_in_a_row() -> None:
    numbers = [int(number) for number in re.findall(r'\\tag\{(\d+)\}', PAGE)]
    assert numbers == list(range(1, 37))
