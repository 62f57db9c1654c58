# SPDX-License-Identifier: Apache-2.0
"""The comparison of the methods: that each is set up fairly, and that the measures measure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.rivals import Bands, Cylinder, Sphere, breadth
from linkedplane_ros.rivals.cost import cost
from linkedplane_ros.rivals.methods import Method, humeral_head, methods
from linkedplane_ros.rivals.sweeps import (
    poses_between,
    random_sweeps,
    single_axes,
    straight_sweep,
    thesis_motions,
    turns_between,
)

DELTOID = BroadMuscle.load('deltoid')
METHODS = {method.name: method for method in methods(DELTOID)}
STILL = np.eye(3)
COARSE = np.radians(2.0)
OWN = ('sphere, scapula', 'sphere, humerus', 'cylinder, scapula', 'cylinder, humerus')


# The set-up


def test_the_linked_planes_have_every_rival() -> None:
    assert list(METHODS) == [
        'linked planes', 'straight', 'via points', *OWN, 'double cylinder', 'sphere, humeral head',
        'sphere-capped cylinder',
    ]  # fmt: skip


@pytest.mark.parametrize('name', METHODS)
def test_every_method_has_the_muscles_own_attachments(name: str) -> None:
    R = Rotation.from_rotvec((0.5, -0.6, 0.2)).as_matrix()
    ends = np.array([path[[0, -1]] for path in METHODS[name].solver.solve(R).paths()])
    np.testing.assert_array_equal(ends[:, 0], DELTOID.origins)
    np.testing.assert_allclose(ends[:, 1], DELTOID.insertions @ R.T, rtol=0, atol=1e-16)


@pytest.mark.parametrize('name', OWN)
def test_own_spheres_and_cylinders_give_the_linked_path_with_the_arm_at_the_side(name: str) -> None:
    linked, own = METHODS['linked planes'].solver.solve(STILL), METHODS[name].solver.solve(STILL)
    # m: rounding, of a circle found anew
    np.testing.assert_allclose(own.lengths, linked.lengths, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(own.wrap, linked.wrap)
    for there, here in zip(own.paths(9), linked.paths(9), strict=True):
        np.testing.assert_allclose(there, here, rtol=0, atol=1e-9)


@pytest.mark.parametrize('name', ['via points', 'double cylinder'])
def test_the_others_only_cut_the_arc_of_the_linked_path_short(name: str) -> None:
    linked, own = METHODS['linked planes'].solver.solve(STILL), METHODS[name].solver.solve(STILL)
    short = linked.lengths - own.lengths
    assert short[-1] == pytest.approx(0.0, abs=1e-15)  # m: this band is straight
    assert (short[:-1] > 0.0).all()
    assert short.max() < 0.25e-3
    for there, here in zip(own.paths(2), linked.paths(2), strict=True):
        np.testing.assert_allclose(there[[1, -2]], here[[1, -2]], rtol=0, atol=1e-9)


def test_the_humeral_head_is_the_bone_sphere_about_the_joints_centre() -> None:
    head = humeral_head(DELTOID)
    assert head is not None
    assert DELTOID.interference_names[0] == 'sphere_4'
    np.testing.assert_array_equal(head[0], DELTOID.interference_centres[0])
    assert head[1] == DELTOID.interference_radii[0]


def test_a_muscle_without_bones_has_the_other_rivals() -> None:
    bare = replace(
        DELTOID, interference_names=(), interference_centres=np.empty((0, 3)),
        interference_radii=np.empty(0),
    )  # fmt: skip
    assert [method.name for method in methods(bare)] == list(METHODS)[:-2]
    row = breadth.measure(bare, methods(bare)[0], '', [thesis_motions(COARSE)[0]])
    assert (row.in_bone, row.deepest) == (0.0, 0.0)


# The sweeps


def test_no_step_of_a_sweep_is_longer_than_asked_for() -> None:
    sweeps = [*thesis_motions(), *single_axes(DELTOID), *random_sweeps(DELTOID, 5)]
    assert [len(sweep) for sweep in sweeps[:6]] == [161, 181, 121, 321, 241, 241]
    for sweep in sweeps:
        steps = np.degrees(np.linalg.norm(turns_between(sweep), axis=1))
        assert steps.max() < 0.5 + 1e-6  # deg: the file's range is rounded
        assert steps.min() > 0.05


def test_random_sweeps_stay_in_the_range_of_motion_and_are_the_same_every_time() -> None:
    sweeps = random_sweeps(DELTOID, 5, seed=3)
    assert DELTOID.count_outside_range(np.concatenate(sweeps)) == 0
    for way, again in zip(sweeps, random_sweeps(DELTOID, 5, seed=3), strict=True):
        np.testing.assert_array_equal(way, again)
    assert not np.array_equal(sweeps[0], random_sweeps(DELTOID, 1, seed=4)[0])


def test_turns_are_those_between_the_poses() -> None:
    start = Rotation.from_rotvec((0.3, 0.2, 0.1))
    turn = np.array((0.01, -0.02, 0.003))
    poses = np.array((start.as_matrix(), (Rotation.from_rotvec(turn) * start).as_matrix()))
    np.testing.assert_allclose(turns_between(poses), [turn], rtol=0, atol=1e-15)
    finer = poses_between(poses[0], poses[1], 4)
    np.testing.assert_allclose(finer[[0, -1]], poses, rtol=0, atol=1e-15)
    np.testing.assert_allclose(turns_between(finer), np.tile(turn / 4, (4, 1)), rtol=0, atol=1e-15)
    still = poses_between(poses[0], poses[0], 2)
    np.testing.assert_array_equal(still, np.repeat(poses[:1], 3, axis=0))


# The measures


def strip(*bends: float) -> Array:
    """Return polylines (1, n, 5, 3): bands 0.1 apart along x, down z, whose middles are moved."""
    z = -np.linspace(0.0, 1.0, 5)
    lines = np.zeros((1, len(bends), 5, 3))
    for i, bend in enumerate(bends):
        lines[0, i] = np.column_stack((np.full(5, 0.1 * i), np.zeros(5), z))
        lines[0, i, 1:4, 0] += bend
    return lines


def test_places_are_at_their_part_of_the_length() -> None:
    corner = np.array([[[(0, 0, 0), (3, 0, 0), (3, 1, 0), (3, 1, 0)]]], dtype=float)
    places, directions = breadth.places_along(corner)
    np.testing.assert_allclose(places[0, :, 0], [(1, 0, 0), (2, 0, 0), (3, 0, 0)], atol=1e-15)
    np.testing.assert_allclose(directions[0, :2, 0], [(1, 0, 0)] * 2, atol=1e-15)


@pytest.mark.parametrize(
    ('bends', 'crossed'),
    [((0.0, 0.0, 0.0), (0, 0)), ((0.09, 0.0, 0.0), (0, 0)), ((0.11, 0.0, 0.0), (1, 0)),
     ((0.0, 0.0, -0.15), (0, 1)), ((0.3, 0.3, 0.3), (0, 0)), ((-0.5, 0.0, 0.5), (0, 0))],
)  # fmt: skip
def test_neighbours_cross_when_one_passes_the_other(
    bends: tuple[float, ...], crossed: tuple[int, ...]
) -> None:
    lines = strip(*bends)
    found = breadth.are_crossed(*breadth.places_along(lines), lines)
    assert tuple(found.any(axis=1)[0].astype(int)) == crossed


def test_a_turn_of_everything_crosses_nothing_and_uncrosses_nothing() -> None:
    Q = Rotation.from_rotvec((1.0, 2.0, 0.5)).as_matrix()
    for bends in ((0.11, 0.0, 0.0), (0.05, 0.0, -0.05)):
        lines = strip(*bends)
        here = breadth.are_crossed(*breadth.places_along(lines), lines)
        there = breadth.are_crossed(*breadth.places_along(lines @ Q.T), lines @ Q.T)
        np.testing.assert_array_equal(here, there)


def test_straight_lines_never_cross() -> None:
    poses = np.concatenate(random_sweeps(DELTOID, 3, step=COARSE))
    lines = breadth.solve_and_draw(METHODS['straight'].solver, poses)[1]
    assert not breadth.are_crossed(*breadth.places_along(lines), lines).any()


def test_depth_is_that_of_a_line_between_its_points() -> None:
    bone = replace(
        DELTOID, interference_names=('bone',), interference_centres=np.array([(0, 0.01, -0.4)]),
        interference_radii=np.array([0.03]),
    )  # fmt: skip
    line = np.array([[[(0.0, 0, 0), (0, 0, -1)]], [[(0.0, 1, 0), (0, 1, -1)]]])
    np.testing.assert_allclose(breadth.depth_in_bone(line, bone), (0.02, 0.0), rtol=0, atol=1e-15)


def lost() -> tuple[Bands, list[Array]]:
    """Return a band that comes to half a turn round its cylinder on a sweep, and the sweep."""
    band = Cylinder((0.1, -0.05, 0), (-0.1, -0.05, 0), (0, 0, 0), (0, 0, 1), 0.03, 'scapula')
    sweep = np.array([Rotation.from_rotvec((0, 0, x)).as_matrix() for x in np.linspace(0, 2, 90)])
    return Bands([band]), [sweep]


def largest(bands: Bands, sweep: Array, change: breadth.Change) -> float:
    neighbours = np.ones(len(sweep) - 1, dtype=bool)
    return breadth.largest_jump(
        bands, sweep, bands.solve_batch(sweep), turns_between(sweep), neighbours, change
    )


def test_a_jump_is_what_two_poses_differ_by_as_they_come_together() -> None:
    bands, (sweep,) = lost()
    wrap = bands.solve_batch(sweep).wrap[:, 0]
    assert set(wrap) == {WrapState.WRAPPED, WrapState.MISSED}
    # at half a turn both straight parts are at right angles to one diameter of the cylinder
    straight = 2.0 * np.sqrt(0.1**2 + 0.05**2 - 0.03**2)
    around = straight + 0.03 * np.pi
    jump = largest(bands, sweep, breadth.unexplained_changes)
    assert jump == pytest.approx(around - 0.06, abs=1e-7)  # m: a step halved 24 times, at 0.1 m/rad


def test_a_band_that_only_bends_sharply_does_not_jump() -> None:
    band = Bands([Sphere((0, 0.1, 0), (0, -0.1, -0.001), (0, 0, 0), 0.03, 'scapula')])
    sweep = np.array(
        [Rotation.from_rotvec((x, 0, 0)).as_matrix() for x in np.linspace(-0.3, 0.3, 70)]
    )
    assert largest(band, sweep, breadth.unexplained_changes) < 1e-8
    # its moment does: it flips from one side of the sphere to the other
    assert largest(band, sweep, breadth.moment_changes) == pytest.approx(0.06, abs=1e-6)


def test_where_a_band_has_no_path_nothing_jumps() -> None:
    band = Bands([Sphere((0, 0.1, 0), (0, -0.04, 0), (0, 0, -0.02), 0.03, 'scapula')])
    sweep = np.array(
        [Rotation.from_rotvec((x, 0, 0)).as_matrix() for x in np.linspace(0.0, 1.0, 70)]
    )
    states = band.solve_batch(sweep)
    assert set(states.wrap[:, 0]) == {WrapState.INSIDE, WrapState.WRAPPED}
    assert np.abs(np.diff(states.lengths[:, 0])).max() > 2e-3  # m, where 0.04 m turn by 0.015 rad
    assert largest(band, sweep, breadth.unexplained_changes) < 1e-8


# What it says


@pytest.fixture(scope='module')
def rows() -> list[breadth.Breadth]:
    return breadth.compare(DELTOID, sweeps=2, step=COARSE)


def test_every_method_is_looked_at_over_every_motion(rows: list[breadth.Breadth]) -> None:
    motions = ("the thesis's motions", 'each coordinate alone', '2 random motions')
    assert [(row.method, row.motion) for row in rows] == [
        (method, motion) for method in METHODS for motion in motions
    ]
    for row in rows:
        assert 0.0 < row.spacing_least <= 1.0 + 1e-12 or row.motion == motions[2]
        assert row.spacing_least <= row.spacing_most
        assert row.breadth_least <= row.breadth_most
        shares = (row.wrapped, row.missed, row.inside, row.crossed, row.in_bone)
        assert all(0.0 <= share <= 1.0 for share in shares)
        assert np.isfinite(
            (row.move, row.slip, row.length_jump, row.moment_jump, row.deepest)
        ).all()


def test_the_same_comparison_says_the_same(rows: list[breadth.Breadth]) -> None:
    again = breadth.measure(
        DELTOID,
        METHODS['double cylinder'],
        '2 random motions',
        random_sweeps(DELTOID, 2, step=COARSE),
    )
    assert again in rows


def test_over_the_thesis_motions_the_linked_bands_neither_jump_nor_cross() -> None:
    row = breadth.measure(DELTOID, METHODS['linked planes'], '', thesis_motions())
    assert row.crossed == 0.0
    assert row.length_jump < 1e-9
    assert row.moment_jump < 1e-6


def test_where_there_are_no_neighbours_there_is_no_breadth() -> None:
    one = replace(
        DELTOID, band_names=('one',), heads=(), origins=DELTOID.origins[:1],
        insertions=DELTOID.insertions[:1], sphere_centres=DELTOID.sphere_centres[:1],
        sphere_radii=DELTOID.sphere_radii[:1], plane_angles=DELTOID.plane_angles[:1],
    )  # fmt: skip
    with pytest.raises(ValueError, match='muscle: 1 band given, 2 or more expected'):
        breadth.compare(one)
    twice = Bands([METHODS['straight'].solver.models[0]] * 2)
    with pytest.raises(ValueError, match='two bands are one with the arm at the side'):
        breadth.measure(DELTOID, Method('twice', '', twice), '', [straight_sweep(
            np.zeros(3), np.ones(3), COARSE)])  # fmt: skip


def test_every_method_has_its_cost() -> None:
    found = cost(DELTOID, seconds=0.001)
    assert [row.method for row in found] == list(METHODS)
    assert all(row.one_call > 0.0 and row.batch > 0.0 for row in found)


def test_the_linked_planes_are_drawn_as_they_draw_themselves() -> None:
    solver = METHODS['linked planes'].solver
    assert isinstance(solver, LinkedPlaneSolver)
    states, lines = breadth.solve_and_draw(solver, np.array((STILL, thesis_motions()[1][-1])))
    for k, state in enumerate(states):
        for i, path in enumerate(state.paths(breadth.POINTS)):
            np.testing.assert_array_equal(lines[k, i, : len(path)], path)
            assert (lines[k, i, len(path) :] == path[-1]).all()
