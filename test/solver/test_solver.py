# SPDX-License-Identifier: Apache-2.0
"""The solver: golden poses, its interface, and what it refuses."""

import csv
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from deltoid_poses import BATCH, POSES

from linkedplane_ros import (
    JOINT_CONVENTIONS,
    BroadMuscle,
    LinkedPlaneError,
    LinkedPlaneSolver,
    WrapState,
)

DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side=side) for side in ('right', 'left'))
NEUTRAL = RIGHT.solve(np.eye(3)).theta
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def test_the_golden_poses_are_met(shared: Path) -> None:
    poses: dict[tuple[float, ...], list[dict[str, str]]] = defaultdict(list)
    with (shared / 'golden' / 'deltoid_states.csv').open(newline='') as file:
        for row in csv.DictReader(file):
            angles = (row['flexion_deg'], row['abduction_deg'], row['rotation_deg'])
            poses[tuple(map(float, angles))].append(row)
    assert len(poses) == 24
    for angles, rows in poses.items():
        state = RIGHT.solve(THESIS.rotation(np.radians(angles)))
        lengths = [float(row['length_m']) for row in rows]
        vectors = [[float(row[f'moment_{axis}_m']) for axis in 'xyz'] for row in rows]
        # m: as far as the golden values are known
        np.testing.assert_allclose(state.lengths, lengths, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(state.moment_vectors, vectors, rtol=0.0, atol=1e-7)
        assert [WrapState(w).name.lower() for w in state.wrap] == [row['wrap'] for row in rows]


def test_a_state_has_the_shapes_of_the_interface() -> None:
    state = RIGHT.solve(np.eye(3))
    assert isinstance(state.theta, float)
    assert isinstance(state.total_length, float)
    assert state.total_length == pytest.approx(float(np.sum(state.lengths)), abs=1e-15)
    assert (state.lengths.shape, state.lengths.dtype) == ((9,), np.float64)
    assert (state.moment_vectors.shape, state.moment_vectors.dtype) == ((9, 3), np.float64)
    assert (state.wrap.shape, state.wrap.dtype) == ((9,), np.uint8)
    assert len(state.paths()) == 9
    assert -np.pi < state.theta <= np.pi


def test_the_wrap_states_are_numbered_as_in_the_interface() -> None:
    assert {state.name: state.value for state in WrapState} == {
        'WRAPPED': 0, 'CLEAR': 1, 'MISSED': 2, 'INSIDE': 3,
    }  # fmt: skip


def test_a_batch_leads_with_the_poses() -> None:
    assert BATCH.theta.shape == BATCH.total_length.shape == (70,)
    assert (BATCH.lengths.shape, BATCH.lengths.dtype) == ((70, 9), np.float64)
    assert (BATCH.moment_vectors.shape, BATCH.moment_vectors.dtype) == ((70, 9, 3), np.float64)
    assert (BATCH.wrap.shape, BATCH.wrap.dtype) == ((70, 9), np.uint8)
    assert len(BATCH) == len(list(BATCH)) == 70


@pytest.mark.parametrize('empty', [np.empty((0, 3, 3)), []], ids=['array', 'list'])
def test_an_empty_batch_is_allowed(empty: Any) -> None:
    batch = RIGHT.solve_batch(empty)
    assert batch.lengths.shape == (0, 9)
    assert batch.moment_vectors.shape == (0, 9, 3)
    assert batch.wrap.shape == (0, 9)
    assert batch.theta.shape == batch.total_length.shape == (0,)
    assert list(batch) == []


@pytest.mark.parametrize('solver', [RIGHT, LEFT], ids=['right', 'left'])
def test_a_batch_is_the_single_solutions_to_the_bit(solver: LinkedPlaneSolver) -> None:
    for rotation, one in zip(POSES, solver.solve_batch(POSES), strict=True):
        alone = solver.solve(rotation)
        assert alone.theta == one.theta
        assert alone.total_length == one.total_length
        for field in ('lengths', 'moment_vectors', 'wrap'):
            assert getattr(alone, field).tobytes() == getattr(one, field).tobytes()


def test_solving_does_not_touch_what_it_was_given() -> None:
    rotation = POSES[3].copy()
    state = RIGHT.solve(rotation)
    rotation[:] = 0.0
    np.testing.assert_array_equal(state.rotation, POSES[3])


def test_a_batch_keeps_the_poses_it_solved_whatever_becomes_of_the_array() -> None:
    rotations = POSES[:2].copy()
    batch = RIGHT.solve_batch(rotations)
    rotations[:] = np.eye(3)
    np.testing.assert_array_equal(batch.rotation, POSES[:2])
    ends = DELTOID.insertions @ POSES[0].T
    np.testing.assert_allclose([path[-1] for path in batch[0].paths()], ends, atol=1e-15)


def test_a_rotation_may_be_lists_of_whole_numbers() -> None:
    state = RIGHT.solve([[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert state.theta == NEUTRAL


QUARTER = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]


@pytest.mark.parametrize(
    ('rotation', 'told'),
    [
        (np.eye(4), r'shape \(4, 4\) given, \(3, 3\) expected'),
        (np.zeros(3), r'shape \(3,\) given, \(3, 3\) expected'),
        (np.eye(3)[np.newaxis], r'shape \(1, 3, 3\) given, \(3, 3\) expected'),
        ([], r'shape \(0,\) given, \(3, 3\) expected'),
        (1.0, r'shape .* given, \(3, 3\) expected'),
        ([[1.0], [1.0, 2.0]], r'\(3, 3\).* expected'),
        (np.diag([1.0, np.nan, 1.0]), 'not finite; .*finite numbers expected'),
        (np.diag([1.0, np.inf, 1.0]), 'not finite; .*finite numbers expected'),
        (np.eye(3) * 1e300, r'R\^T R is not the identity .*a rotation expected'),
        (np.diag([-1.0, 1.0, 1.0]), 'determinant .* a proper rotation expected'),
        (1.001 * np.eye(3), 'a rotation( matrix)? expected'),
        (np.zeros((3, 3)), 'a rotation( matrix)? expected'),
        (np.full((3, 3), 1e200), 'expected'),
        ([[1.0, 0.01, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 'a rotation( matrix)? expected'),
        ([['a'] * 3] * 3, r'not an array of numbers; .*\(3, 3\).* expected'),
        ('eye', r'not an array of numbers; .*\(3, 3\).* expected'),
        (None, r'expected'),
        ({'a': 1}, r'not an array of numbers; .*\(3, 3\).* expected'),
    ],
)
def test_what_is_no_rotation_is_refused_with_what_was_expected(rotation: Any, told: str) -> None:
    with pytest.raises(LinkedPlaneError, match=f'rotation: (.*){told}'):
        RIGHT.solve(rotation)


@pytest.mark.parametrize(
    ('rotations', 'told'),
    [
        (np.eye(3), r'shape \(3, 3\) given, \(m, 3, 3\) expected'),
        (np.zeros((2, 3)), r'\(m, 3, 3\) expected'),
        ([QUARTER, np.diag([1.0, np.nan, 1.0])], 'finite numbers expected'),
        ([QUARTER, np.diag([-1.0, 1.0, 1.0])], 'a proper rotation expected'),
        ([QUARTER, 2.0 * np.eye(3)], 'a rotation( matrix)? expected'),
        ('eyes', r'not an array of numbers; .*\(m, 3, 3\) expected'),
    ],
)
def test_one_wrong_rotation_refuses_the_batch(rotations: Any, told: str) -> None:
    with pytest.raises(LinkedPlaneError, match=told):
        RIGHT.solve_batch(rotations)


@pytest.mark.parametrize('side', ['up', 'Right', '', None])
def test_a_shoulder_is_right_or_left(side: Any) -> None:
    with pytest.raises(ValueError, match=r"side: .* given, 'right' or 'left' expected"):
        LinkedPlaneSolver(DELTOID, side=side)


@pytest.mark.parametrize('name', JOINT_CONVENTIONS)
@pytest.mark.parametrize('side', ['right', 'left'])
def test_an_answer_is_the_state_its_moment_arms_and_its_lengthening(name: str, side: str) -> None:
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'), side)
    convention, speeds = JOINT_CONVENTIONS[name], (0.3, -1.2, 0.7)
    for angles in ((0.4, 0.9, -0.3), (-0.2, 0.3, 0.6), (0.0, 0.0, 0.0)):
        answer = solver.answer(convention, angles, speeds)
        state, axes = answer.state, answer.axes
        want = solver.solve(convention.rotation(angles))
        assert state.theta == want.theta
        np.testing.assert_array_equal(state.lengths, want.lengths)
        np.testing.assert_array_equal(state.moment_vectors, want.moment_vectors)
        np.testing.assert_array_equal(state.wrap, want.wrap)
        np.testing.assert_array_equal(axes, convention.axes(angles, side))
        # m, m/s: products in another order
        arms = answer.moment_arms
        np.testing.assert_allclose(arms, want.moment_vectors @ axes, rtol=0, atol=1e-16)
        np.testing.assert_allclose(answer.lengthening, -arms @ speeds, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    'wrong',
    [(0.4, 0.9), (0.4, 0.9, 0.1, 0.2), (), 0.4, None, 'abc', ('0.4', '0.9', '0.1'), (0.4, 0.9, 'x'),
     (0.4, np.nan, 0.1), (np.float64(0.4), np.nan, 0.1), np.full(3, np.nan),
     (0.4, np.inf, 0.1), (0.4, 0.9j, 0.1), np.zeros((3, 3)), [[0.4, 0.9, 0.1]],
     (10**400, 0.9, 0.1)],
    ids=repr,
)  # fmt: skip
@pytest.mark.parametrize(('field', 'unit'), [('angles', 'rad'), ('speeds', 'rad/s')])
def test_what_are_no_angles_or_speeds_gets_no_answer(wrong: Any, field: str, unit: str) -> None:
    given = {'angles': (0.4, 0.9, 0.1), 'speeds': (0.0, 0.0, 0.0), field: wrong}
    with pytest.raises(LinkedPlaneError) as error:
        RIGHT.answer(THESIS, **given)
    text = str(error.value)
    assert text.startswith(f'{field}: ')
    assert text.endswith(f' given, 3 finite numbers in {unit} expected')
    assert len(text) < 160
    assert not any(word in text for word in ('array', 'np.', '\n'))


@pytest.mark.parametrize(
    ('call', 'text'),
    [
        (lambda: LinkedPlaneSolver('deltoid'), "muscle: 'deltoid' given, a BroadMuscle expected"),
        (
            lambda: RIGHT.answer('isb_yxy', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
            "convention: 'isb_yxy' given, one of JOINT_CONVENTIONS expected",
        ),
    ],
)
def test_a_name_in_place_of_what_it_names_is_refused(call: Callable[[], Any], text: str) -> None:
    with pytest.raises(LinkedPlaneError) as error:
        call()
    assert str(error.value).startswith(text)


@pytest.mark.parametrize('angles', [[0, 1, 0], np.array([0.0, 1.0, 0.0], dtype=np.float32)])
def test_angles_may_be_any_three_numbers(angles: Any) -> None:
    answer = RIGHT.answer(THESIS, angles, (0, 0, 0))
    assert answer == RIGHT.answer(THESIS, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0))
