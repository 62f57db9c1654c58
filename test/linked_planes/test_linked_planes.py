# SPDX-License-Identifier: Apache-2.0
"""The chain of planes and theta: the least total length, which depends only on the pose."""

import numpy as np
import pytest
import reference
from hypothesis import example, given, settings
from hypothesis import strategies as st
from random_muscles import (
    LEAST,
    SAME,
    deltoid_with_bands,
    random_muscle,
    random_poses,
    wild_muscle,
)
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
NEUTRAL = SOLVER.solve(np.eye(3)).theta


POSES = random_poses(100, seed=7)
BATCH = SOLVER.solve_batch(POSES)
MANY = random_poses(400, seed=8)
SLACK = MANY[(SOLVER.solve_batch(MANY).wrap != WrapState.WRAPPED).all(axis=1)]
STRAIGHT = SOLVER.solve_batch(SLACK)  # the poses at which every band is a straight line


def test_neutral_is_as_published() -> None:
    state = SOLVER.solve(np.eye(3))
    assert state.theta == pytest.approx(-0.503969, abs=5e-7)  # rad, as printed in the spec
    assert state.total_length == pytest.approx(1.333127477, abs=5e-10)  # m, as printed


def test_theta_is_the_global_minimum_over_the_circle() -> None:
    least = reference.total_at(DELTOID, POSES, reference.least_theta(DELTOID, POSES, NEUTRAL))
    np.testing.assert_allclose(BATCH.total_length, least, rtol=0.0, atol=LEAST)
    scan = reference.total_at(DELTOID, POSES[:, np.newaxis], reference.circle(2000)).min(axis=1)
    assert (BATCH.total_length <= scan + LEAST).all()


def test_theta_is_that_of_the_literal_method() -> None:
    theta = reference.least_theta(DELTOID, POSES, NEUTRAL)
    # rad; the end of a plateau is known to the root of the rounding of its first band's arc
    np.testing.assert_allclose(reference.in_circle(theta - BATCH.theta), 0.0, atol=1e-7)


def test_lengths_and_states_are_those_of_the_literal_method() -> None:
    theta = reference.least_theta(DELTOID, POSES, NEUTRAL)
    found = reference.lengths_at(DELTOID, POSES, theta)
    np.testing.assert_allclose(BATCH.lengths, found, rtol=0.0, atol=SAME)
    np.testing.assert_array_equal(BATCH.wrap, reference.states_at(DELTOID, POSES, theta))


def test_the_planes_are_those_of_the_literal_method() -> None:
    # the paths show the planes: their transition points are the literal ones
    state = SOLVER.solve(np.eye(3))
    chain = reference.chain(DELTOID, np.eye(3), state.theta)
    for path, wrap, literal in zip(state.paths(2), state.wrap, chain, strict=True):
        if wrap == WrapState.WRAPPED:
            np.testing.assert_allclose(path[1:3], [literal.Q, literal.T], atol=1e-9)


def test_a_straight_muscle_has_the_theta_nearest_to_neutral() -> None:
    assert len(SLACK) > 15
    theta = reference.least_theta(DELTOID, SLACK, NEUTRAL)
    # rad; where an arc begins is known to the root of its rounding
    np.testing.assert_allclose(reference.in_circle(theta - STRAIGHT.theta), 0.0, atol=1e-7)
    scanned = reference.circle(3600)
    straight = reference.straight_at(DELTOID, SLACK[:, np.newaxis], scanned)
    away = np.where(straight, np.abs(reference.in_circle(scanned - NEUTRAL)), np.inf)
    assert (np.abs(reference.in_circle(STRAIGHT.theta - NEUTRAL)) <= away.min(axis=1) + 1e-9).all()


def test_a_straight_muscle_that_may_keep_neutrals_theta_keeps_it() -> None:
    fine = reference.straight_at(DELTOID, SLACK, NEUTRAL)
    assert (STRAIGHT.theta[fine] == NEUTRAL).all()


def test_a_straight_muscle_is_as_long_as_its_lines() -> None:
    ends = DELTOID.insertions @ SLACK.swapaxes(1, 2) - DELTOID.origins
    lines = np.linalg.norm(ends, axis=2)
    np.testing.assert_allclose(STRAIGHT.lengths, lines, rtol=0.0, atol=1e-15)


def test_the_answer_does_not_depend_on_what_was_solved_before() -> None:
    order = np.random.default_rng(3).permutation(len(POSES))
    shuffled = SOLVER.solve_batch(POSES[order])
    for field in ('theta', 'lengths', 'moment_vectors', 'wrap'):
        again, first = getattr(shuffled, field), getattr(BATCH, field)[order]
        assert again.tobytes() == first.tobytes(), field
    alone = LinkedPlaneSolver(DELTOID).solve(POSES[50])
    assert alone.lengths.tobytes() == BATCH.lengths[50].tobytes()


@pytest.mark.parametrize('count', [1, 2, 9, 40])
def test_any_number_of_bands_is_solved(count: int) -> None:
    muscle = deltoid_with_bands(count)
    batch = LinkedPlaneSolver(muscle).solve_batch(POSES[:20])
    assert batch.lengths.shape == (20, count)
    scan = reference.total_at(muscle, POSES[:20, np.newaxis], reference.circle(720)).min(axis=1)
    assert (batch.total_length <= scan + LEAST).all()
    there = reference.lengths_at(muscle, POSES[:20], batch.theta)
    np.testing.assert_allclose(batch.lengths, there, rtol=0.0, atol=SAME)


@settings(deadline=None, max_examples=60, derandomize=True)
@given(seed=st.integers(0, 10**6))
@example(seed=9)  # two pierced bands whose shortest planes are 121 deg apart
@example(seed=26)  # two dips between the shortest planes of two pierced bands
@example(seed=46)
@example(seed=104)
@example(seed=132)
@example(seed=193)  # bands that jump between the shortest planes of two pierced ones
def test_any_muscle_is_as_short_as_the_best_of_a_scan(seed: int) -> None:
    muscle, rotations = random_muscle(seed)
    batch = LinkedPlaneSolver(muscle).solve_batch(rotations)
    scan = reference.total_at(muscle, rotations[:, np.newaxis], reference.circle(720)).min(axis=1)
    assert (batch.total_length <= scan + LEAST).all()


@pytest.mark.parametrize('part', range(5))
def test_planes_that_turn_unevenly_hide_no_shorter_muscle(part: int) -> None:
    # in all 1,000 poses; make soak scans a million by 0.05 deg
    for seed in range(100 + 20 * part, 120 + 20 * part):
        muscle, rotations = wild_muscle(8 * seed + 3, 10)
        batch = LinkedPlaneSolver(muscle).solve_batch(rotations)
        scanned = reference.circle(720)
        scan = reference.total_at(muscle, rotations[:, np.newaxis], scanned).min(axis=1)
        assert (batch.total_length <= scan + LEAST).all()


@settings(deadline=None, max_examples=60, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_any_muscles_lengths_are_real_ones(seed: int) -> None:
    # theta may stand at the edge of a sphere, where the length jumps: either side will do
    muscle, rotations = random_muscle(seed)
    batch = LinkedPlaneSolver(muscle).solve_batch(rotations)
    around = batch.theta + np.array([[-1e-9], [0.0], [1e-9]])  # rad
    near = reference.lengths_at(muscle, rotations, around)
    off = np.abs(near - batch.lengths)
    assert (off.min(axis=0) < 1e-8).all()  # m: 1e-9 rad at no more than 0.1 m/rad, and the edge


def test_any_muscles_moment_vectors_are_its_lengths_slopes() -> None:
    # also where theta follows the edge of a sphere, about a third of these
    h = 1e-5  # rad
    at_an_edge = 0
    for seed in range(40):
        muscle, rotations = random_muscle(seed)
        solver = LinkedPlaneSolver(muscle)
        for rotation in rotations[:2]:
            state = solver.solve(rotation)
            turns = np.einsum('h,ij->ihj', h * np.array([-2, -1, 1, 2]), np.eye(3)).reshape(-1, 3)
            near = solver.solve_batch(Rotation.from_rotvec(turns).as_matrix() @ rotation)
            if (near.wrap != state.wrap).any() or (abs(near.theta - state.theta) > 0.01).any():
                continue
            L = near.lengths.reshape(3, 4, -1)
            slopes = np.einsum('h,ihn->ni', [1.0, -8.0, 8.0, -1.0], L) / (12.0 * h)
            # m: rounding over h, and steep bends where theta hangs on little
            np.testing.assert_allclose(state.moment_vectors, -slopes, rtol=0.0, atol=1e-6)
            beside = state.theta + np.array([-1e-7, 1e-7])
            sides = reference.states_at(muscle, rotation, beside)
            at_an_edge += (sides[0] != sides[1]).any()
    assert at_an_edge > 10
