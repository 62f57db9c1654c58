# SPDX-License-Identifier: Apache-2.0
"""What the solver answers with: read-only arrays, parts of a batch, paths, small pickles."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from deltoid_poses import POSES

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, MuscleState
from linkedplane_ros.solver.states import Answer, MuscleStates

DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side=side) for side in ('right', 'left'))
STATES = RIGHT.solve_batch(POSES[:10])
ANSWER = RIGHT.answer(JOINT_CONVENTIONS['isb_yxy'], (0.4, 0.9, 0.1), (0.1, 0.2, 0.3))
ANSWERS = RIGHT.answer_batch(JOINT_CONVENTIONS['isb_yxy'], [(0.4, 0.9, 0.1)], [(0.1, 0.2, 0.3)])
FIELDS = ('theta', 'lengths', 'moment_vectors', 'wrap', 'one_sided', 'rotation')

both_sides = pytest.mark.parametrize('solver', [RIGHT, LEFT], ids=['right', 'left'])


def same(one: Any, other: Any) -> bool:
    """Return whether two states have the same numbers to the bit."""
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in FIELDS)


@pytest.mark.parametrize('i', [0, 9, -1, -10, np.int64(3)])
def test_an_integer_takes_the_state_of_a_pose(i: Any) -> None:
    state = STATES[i]
    assert isinstance(state, MuscleState)
    assert isinstance(state.theta, float)
    assert same(state, RIGHT.solve(POSES[:10][i]))


@pytest.mark.parametrize(
    'part',
    [slice(2, 5), slice(None, None, -3), slice(4, 4), slice(5, 99), [3, 1, -1], np.array([7, 7]),
     np.arange(10) % 3 == 0, [True, False] * 5, []],
    ids=repr,
)  # fmt: skip
def test_a_slice_or_an_array_takes_the_states_of_some_poses(part: Any) -> None:
    states = STATES[part]
    assert isinstance(states, MuscleStates)
    indices = np.arange(10)[part].tolist()
    assert len(states) == len(indices)
    assert all(same(one, STATES[i]) for one, i in zip(states, indices, strict=True))
    if isinstance(part, slice) and indices:
        assert np.shares_memory(states.lengths, STATES.lengths)  # nothing is copied


@pytest.mark.parametrize(
    'index',
    [10, -11, [0, 10], np.array([-11]), 1.5, 'first', None, (3,), (0, 1), [[0, 1]], [True] * 9],
)
def test_what_is_no_index_of_a_pose_is_an_index_error(index: Any) -> None:
    with pytest.raises(IndexError):
        STATES[index]


@pytest.mark.parametrize(
    'result', [STATES, STATES[3], STATES[2:5], STATES[[1, 2]], RIGHT.solve(POSES[0]), ANSWER,
               ANSWER.state, ANSWERS], ids=lambda result: type(result).__name__,
)  # fmt: skip
def test_results_are_read_only(result: Any) -> None:
    for each in (result, pickle.loads(pickle.dumps(result))):
        for value in vars(each).values():
            if isinstance(value, np.ndarray):
                with pytest.raises(ValueError, match='read-only'):
                    value[...] = 0.0


@both_sides
def test_a_batch_draws_what_its_states_draw(solver: LinkedPlaneSolver) -> None:
    states = solver.solve_batch(POSES)
    for part in (states, states[::-2], states[:0]):
        n = len(DELTOID.band_names)
        assert part.insertions.shape == part.sphere_centres.shape == (len(part), n, 3)
        paths = part.paths(points=5)
        assert len(paths) == len(part)
        for k, state in enumerate(part):
            np.testing.assert_array_equal(part.insertions[k], state.insertions)
            np.testing.assert_array_equal(part.sphere_centres[k], state.sphere_centres)
            for one, other in zip(paths[k], state.paths(points=5), strict=True):
                np.testing.assert_array_equal(one, other)


@both_sides
def test_insertions_turn_with_the_humerus(solver: LinkedPlaneSolver) -> None:
    states = solver.solve_batch(POSES)
    for state, insertions in zip(states, states.insertions, strict=True):
        # m: products in another order
        expected = state.to_scapula(DELTOID.insertions)
        np.testing.assert_allclose(insertions, expected, rtol=0.0, atol=1e-16)


def test_a_path_of_an_arc_needs_its_two_transition_points() -> None:
    for states in (STATES, STATES[0]):
        with pytest.raises(ValueError, match='points: 1 given, at least 2 expected'):
            states.paths(points=1)


@pytest.mark.parametrize('result', [STATES, STATES[3], STATES[2:5], ANSWER, LEFT])
def test_what_is_pickled_and_back_is_equal(result: Any) -> None:
    assert pickle.loads(pickle.dumps(result)) == result


def test_results_of_other_poses_sides_or_muscles_are_not_equal() -> None:
    ackland = LinkedPlaneSolver(BroadMuscle.load('deltoid_ackland2008'))
    state = RIGHT.solve(POSES[0])
    assert state == STATES[0]
    for other in (STATES[1], LEFT.solve(POSES[0]), ackland.solve(POSES[0]), STATES[:1], None):
        assert state != other
    assert STATES == RIGHT.solve_batch(POSES[:10])
    assert STATES != STATES[:9]
    assert RIGHT == LinkedPlaneSolver(DELTOID)
    for one, other in ((RIGHT, LEFT), (LEFT, RIGHT), (RIGHT, ackland), (RIGHT, None)):
        assert one != other


def test_a_pickle_is_the_muscle_and_the_numbers_of_the_poses() -> None:
    muscle = len(pickle.dumps(DELTOID))
    drawn = RIGHT.solve(POSES[0])
    drawn.insertions  # noqa: B018 (kept by the state, not by its pickle)
    numbers = 9 * (1 + 3) * 8 + 9 + 9 + 9 * 8  # bytes a pose: lengths, vectors, two flags, rotation
    frame = 500  # bytes: the names of classes, the shapes of arrays
    assert len(pickle.dumps(drawn)) < muscle + numbers + frame
    one, ten = (len(pickle.dumps(states)) for states in (STATES[:1], STATES))
    assert ten - one < 9 * (numbers + 16)
    assert isinstance(ANSWER, Answer)
    assert len(pickle.dumps(ANSWER)) < muscle + 3 * numbers + 2 * frame
