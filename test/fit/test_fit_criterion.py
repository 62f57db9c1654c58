# SPDX-License-Identifier: Apache-2.0
"""The criterion: the thesis's sum of squares, against its definition in plain NumPy."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from fits import deepest, numbered_backwards, simulated
from random_muscles import random_poses
from reference import Array

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.fit.criterion import IMPOSSIBLE, Criterion, Weights
from linkedplane_ros.fit.measurements import Data, Measurement
from linkedplane_ros.fit.parameters import build_space
from linkedplane_ros.fit.space import Space
from linkedplane_ros.fit.states import FitStates, pose_grid
from linkedplane_ros.solver.states import MuscleState

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
STEP = 1e-4  # m, of the laid out paths: half of it at the most beside their nearest point


def laid_out(state: MuscleState) -> list[Array]:
    """Return each band's path as points (k, 3), m, STEP apart or less."""
    ways = []
    for path in state.paths(1000):  # an arc is some 100 mm at the most
        first, last = (
            a
            + np.linspace(0.0, 1.0, int(np.linalg.norm(b - a) / STEP) + 2)[:, np.newaxis] * (b - a)
            for a, b in (path[:2], path[-2:])
        )
        pieces = (first,) if len(path) == 2 else (first[:-1], path[1:-1], last[1:])
        ways.append(np.concatenate(pieces))
    return ways


def criterion_of(
    data: Data, weights: Weights, more: Array | None = None
) -> tuple[Criterion, Space]:
    parameters = build_space(DELTOID.definition)
    return Criterion.from_data(DELTOID, parameters, data, weights, more), parameters


def in_words(muscle: BroadMuscle, data: Data, weights: Weights, more: Array) -> float:
    """Return the criterion by its definition, one deviation after the other, mm^2."""
    solver, total, rotations = LinkedPlaneSolver(muscle), 0.0, {}
    for each in data.measurements:
        rotation, axis = each.pose()
        rotations[tuple(rotation.ravel() + 0.0)] = rotation
        state = solver.solve(rotation)
        length = 1e3 * (state.lengths[each.band] - each.length)
        arm = weights.arm_scale * state.moment_vectors[each.band] @ axis - each.arm
        total += each.weight * (weights.length * length**2 + weights.arm * (1e3 * arm) ** 2)
    states = solver.solve_batch(np.array([*rotations.values(), *more]))
    for entered in deepest(states).ravel():
        total += 100.0 * weights.interference * max(1e3 * (entered + weights.clearance), 0.0) ** 2
    spacing = np.linalg.norm(np.diff(muscle.origins, axis=0), axis=1)
    for state in states:
        for gap, widest in zip(gaps(state), spacing, strict=True):
            short, wide = max(weights.gap - gap, 0.0), max(gap + 1e-3 - widest, 0.0)
            total += 100.0 * weights.order * 1e6 * (short**2 + wide**2)
        for past in past_edges(state):
            total += 100.0 * weights.jumps * max(1e3 * (past + 1e-3), 0.0) ** 2
        ends = np.stack((solver.origins, state.insertions)) - state.sphere_centres
        inside = muscle.sphere_radii - np.linalg.norm(ends, axis=2).min(axis=0)
        total += 100.0 * float(np.sum(np.maximum(1e3 * inside + 1.0, 0.0) ** 2))
    return float(total)


def gaps(state: MuscleState) -> Array:
    """Return by how much each band's middle lies behind the one before, (n - 1), m."""
    middles = []
    for way in laid_out(state):
        along = np.concatenate(([0.0], np.linalg.norm(np.diff(way, axis=0), axis=1).cumsum()))
        near = np.searchsorted(along, 0.5 * along[-1])
        direction = way[near] - way[near - 1]
        rest = (0.5 * along[-1] - along[near - 1]) / (along[near] - along[near - 1])
        middles.append((way[near - 1] + rest * direction, direction))
    found = []
    for (x, direction), (after, _) in pairwise(middles):
        side = np.cross(direction, x)
        found.append((after - x) @ side / np.linalg.norm(side))
    return np.array(found)


def past_edges(state: MuscleState) -> Array:
    """Return how far each band is past the edge where its length jumps, (n,), m (App. B, C)."""
    solver, n, found = state.solver, state.solver.muscle.reference_normal, []
    muscle = solver.muscle
    angles = (state.theta, *muscle.plane_angles[1:])
    evaluate_poses = zip(solver.origins, state.insertions, state.sphere_centres, strict=True)
    for (P, S, C), R, phi in zip(evaluate_poses, muscle.sphere_radii, angles, strict=True):
        D = np.linalg.norm(S - P)
        u = (S - P) / D
        m = n - (n @ u) * u
        m /= np.linalg.norm(m)
        n = m * np.cos(phi) + np.cross(u, m) * np.sin(phi)
        along, d, b = (C - P) @ u, (C - P) @ n, (C - P) @ np.cross(u, n)
        pierced = 0.0 < along < D and d**2 + b**2 < R**2
        found.append(-R if pierced else min(b, abs(d) - R))
    return np.array(found)


def with_spheres_moved(parameters: Space, seed: int, share: float = 0.1) -> Array:
    """Return parameters at random, up to a share of the way to their bounds from the start."""
    rng = np.random.default_rng(seed)
    ends = np.where(rng.random(len(parameters.low)) < 0.5, parameters.low, parameters.high)
    return np.asarray(parameters.start + share * rng.random(len(ends)) * (ends - parameters.start))


@pytest.mark.parametrize('seed', range(4))
def test_the_criterion_is_its_definition(seed: int) -> None:
    data = simulated(DELTOID, off=0.01, seed=seed)
    weights = Weights(
        length=0.7, arm=1.3, interference=0.4, order=0.6, jumps=0.5, clearance=1e-3, arm_scale=0.5
    )
    more = random_poses(6, seed)
    criterion, parameters = criterion_of(data, weights, more)
    x = with_spheres_moved(parameters, seed)
    muscle = DELTOID.with_coefficients(parameters.coefficients(x))
    expected = in_words(muscle, data, weights, more)
    # the middles of laid out paths are on chords of 0.1 mm
    assert criterion.value(x) == pytest.approx(expected, rel=1e-5)
    plain = replace(weights, order=0.0)
    criterion = replace(criterion, weights=plain)
    assert criterion.value(x) == pytest.approx(in_words(muscle, data, plain, more), rel=1e-9)


def test_the_criterion_is_the_sum_of_the_squared_residuals() -> None:
    criterion, parameters = criterion_of(
        simulated(DELTOID, off=0.01), Weights(order=1.0), random_poses(5, 0)
    )
    x = with_spheres_moved(parameters, 1)
    residuals = criterion.residuals(x)
    assert not isinstance(residuals, float)
    assert residuals @ residuals == pytest.approx(criterion.value(x), rel=1e-12)


def test_a_model_fits_what_it_has_simulated() -> None:
    criterion, parameters = criterion_of(simulated(DELTOID), Weights(interference=0.0))
    assert criterion.value(parameters.start) < 1e-16  # mm^2: rounding


def test_the_kernel_solves_as_the_solver_does() -> None:
    more = random_poses(200, 3)
    criterion, parameters = criterion_of(simulated(DELTOID), Weights(), more)
    found, expected = criterion.states(parameters.start), SOLVER.solve_batch(criterion.rotations)
    assert isinstance(found, FitStates)
    k = criterion.measured
    np.testing.assert_allclose(found.lengths, expected.lengths[:k], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(found.moments, expected.moment_vectors[:k], rtol=0.0, atol=1e-10)
    np.testing.assert_array_equal(found.wrap, expected.wrap)
    np.testing.assert_allclose(found.depths, deepest(expected), rtol=0.0, atol=1e-9)


def test_a_muscle_without_paths_is_worse_the_farther_it_is_from_having_one() -> None:
    criterion, parameters = criterion_of(simulated(DELTOID), Weights())
    radii = [p.name.startswith('sphere.radius') for p in parameters.parameters]
    values = []
    for more in (80.0, 120.0):  # mm: the origins lie in their spheres, in whatever pose
        x = parameters.start + np.where(radii, more, 0.0)
        assert isinstance(criterion.residuals(x), float)
        values.append(criterion.value(x))
    assert IMPOSSIBLE < values[0] < values[1] < math.inf


def test_the_grid_has_the_ends_of_the_ranges_and_no_longer_steps() -> None:
    angles, rotations = pose_grid([(-0.7, 2.1), (0.0, 2.1), (0.2, 0.2)], (0.5, 2.1, 1.0))
    flexion, abduction, rotation = (sorted(set(column)) for column in angles.T.tolist())
    assert (flexion[0], flexion[-1], len(flexion)) == (-0.7, 2.1, 7)
    assert abduction == [0.0, 2.1]
    assert rotation == [0.2]
    assert rotations.shape == (14, 3, 3)


def test_a_band_that_turns_over_the_one_before_it_is_out_of_order() -> None:
    for muscle, side in ((DELTOID, 1.0), (numbered_backwards(), -1.0)):
        parameters = build_space(muscle.definition, ['sphere.radius'])
        one = Measurement('', 0, 'flexion', (0.0,), 0.15, 0.0)
        criterion = Criterion.from_data(muscle, parameters, Data(Path('x'), (one,), 1.0, None))
        assert criterion.side == side  # as the bands of the model that is fitted are numbered
        for of, sign in ((criterion, 1.0), (replace(criterion, side=-side), -1.0)):
            states = of.states(parameters.start)
            assert isinstance(states, FitStates)
            assert not (states.wrap == WrapState.INSIDE).any()
            assert (sign * states.gaps[0] > 0.0).all()
