# SPDX-License-Identifier: Apache-2.0
"""The path of a band: from its origin to its insertion, smoothly over its sphere."""

import numpy as np
import pytest
import reference
from deltoid_poses import BATCH, POSES

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState

DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side=side) for side in ('right', 'left'))


@pytest.mark.parametrize('solver', [RIGHT, LEFT], ids=['right', 'left'])
def test_a_path_leads_from_the_origin_to_the_insertion(solver: LinkedPlaneSolver) -> None:
    mirror = [-1.0, 1.0, 1.0] if solver is LEFT else [1.0, 1.0, 1.0]
    for state in solver.solve_batch(POSES[:20]):
        ends = DELTOID.insertions @ state.rotation.T
        for i, path in enumerate(state.paths()):
            np.testing.assert_allclose(path[0], DELTOID.origins[i] * mirror, atol=1e-15)
            np.testing.assert_allclose(path[-1], ends[i] * mirror, atol=1e-15)
            wrapped = state.wrap[i] == WrapState.WRAPPED
            assert path.shape == ((18, 3) if wrapped else (2, 3))
        np.testing.assert_allclose(state.insertions, ends * mirror, atol=1e-15)


def test_a_paths_length_approaches_the_bands() -> None:
    for state in BATCH[0], BATCH[1], RIGHT.solve(np.eye(3)):
        for points, short in ((16, 1e-3), (2000, 1e-7)):  # m: r arc^3 / 24 / points^2, arc < pi
            steps = [np.diff(path, axis=0) for path in state.paths(points)]
            sizes = np.array([np.linalg.norm(step, axis=1).sum() for step in steps])
            assert (sizes <= state.lengths + 1e-12).all()
            assert (sizes >= state.lengths - short).all()


def test_an_arc_lies_on_its_sphere_and_runs_smoothly_into_its_tangents() -> None:
    points = 400
    for state in (*list(BATCH)[:20], RIGHT.solve(np.eye(3)), LEFT.solve(POSES[0])):
        for i, path in enumerate(state.paths(points)):
            if state.wrap[i] != WrapState.WRAPPED:
                continue
            arc, R = path[1:-1], DELTOID.sphere_radii[i]
            away = np.linalg.norm(arc - state.sphere_centres[i], axis=1)
            np.testing.assert_allclose(away, R, rtol=0.0, atol=1e-12)
            # the two straight parts touch the sphere: they are at right angles to its radius
            for point, end in ((arc[0], path[0]), (arc[-1], path[-1])):
                along = (point - end) @ (point - state.sphere_centres[i])
                assert along == pytest.approx(0.0, abs=1e-12)  # m^2
            # nor do they turn by more than a chord of the arc does
            steps = reference.unit(np.diff(path, axis=0))
            turns = np.linalg.norm(np.diff(steps, axis=0), axis=1)
            assert turns.max() <= 2.0 * np.pi / (points - 1)


def test_the_paths_are_those_of_the_literal_method() -> None:
    for state in list(BATCH)[:20]:
        chain = reference.chain(DELTOID, state.rotation, state.theta)
        centres = reference.sphere_centres(DELTOID, state.rotation)
        np.testing.assert_allclose(state.sphere_centres, centres, atol=1e-14)
        for path, wrap, found in zip(state.paths(2), state.wrap, chain, strict=True):
            if wrap == WrapState.WRAPPED:
                # m: Q by acos is known to the root of the rounding where the arc begins
                np.testing.assert_allclose(path[1:3], [found.Q, found.T], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize('points', [1, 0, -3])
def test_a_path_of_fewer_than_two_points_is_refused(points: int) -> None:
    with pytest.raises(ValueError, match=f'points: {points} given, at least 2 expected'):
        RIGHT.solve(np.eye(3)).paths(points)
