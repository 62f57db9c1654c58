"""The solver: golden poses, moment vectors, its interface, paths, and the left shoulder."""

import csv
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reference
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState

DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side=side) for side in ('right', 'left'))
NEUTRAL = RIGHT.solve(np.eye(3)).theta
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def random_angles(count: int, seed: int) -> Array:
    """Return angles, rad: flexion -40..120, abduction 0..120, axial rotation +-60 deg."""
    rng = np.random.default_rng(seed)
    return np.radians(rng.uniform([-40, 0, -60], [120, 120, 60], (count, 3)))


ANGLES = random_angles(70, seed=21)
POSES = np.array([THESIS.rotation(angles) for angles in ANGLES])
BATCH = RIGHT.solve_batch(POSES)


def differences(muscle: BroadMuscle, poses: Array, neutral: float) -> list[reference.Moments]:
    return [reference.moment_vectors(muscle, rotation, neutral) for rotation in poses]


@pytest.fixture(scope='module')
def literal() -> list[reference.Moments]:
    """The reference's moment vectors at POSES."""
    return differences(DELTOID, POSES, NEUTRAL)


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


def test_moment_vectors_are_differences_of_the_literal_method(
    literal: list[reference.Moments],
) -> None:
    checked = mixed = missed = straight = 0
    for state, found in zip(BATCH, literal, strict=True):
        if not found.smooth or found.error > 1e-9:
            continue  # a kink within the differences
        np.testing.assert_allclose(state.moment_vectors, found.vectors, rtol=0.0, atol=1e-8)
        checked += 1
        kinds = set(state.wrap.tolist())
        mixed += len(kinds) == 3
        missed += (state.wrap == WrapState.MISSED).sum() >= 3
        straight += WrapState.WRAPPED not in kinds
    assert checked >= 60
    assert mixed >= 5  # wrapped, clear and missed bands at once
    assert missed >= 5
    assert straight >= 2


def test_moment_vectors_near_a_kink_are_still_close(literal: list[reference.Moments]) -> None:
    for state, found in zip(BATCH, literal, strict=True):
        # m: within the stencil of 8e-3 rad the second derivative, some 0.05 m, may jump
        np.testing.assert_allclose(state.moment_vectors, found.vectors, rtol=0.0, atol=1e-4)


def test_the_sum_over_the_bands_needs_no_linked_term() -> None:
    # dE/dtheta = 0, so at a fixed theta the whole muscle's moments are the same
    h = 1e-3  # rad
    for state, rotation in zip(BATCH, POSES, strict=True):
        slopes = []
        for axis in np.eye(3):
            turned = [
                Rotation.from_rotvec(k * h * axis).as_matrix() @ rotation for k in (-2, -1, 1, 2)
            ]
            found = reference.chain(DELTOID, np.array(turned), state.theta)
            states = np.stack([one.state for one in found])
            if (states != state.wrap[:, np.newaxis]).any():
                break
            E = sum(one.length for one in found)
            slopes.append(E @ np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h))
        else:
            total = state.moment_vectors.sum(axis=0)
            np.testing.assert_allclose(total, np.negative(slopes), rtol=0.0, atol=1e-8)


def test_a_straight_band_pulls_along_its_line() -> None:
    for state in BATCH:
        straight = state.wrap != WrapState.WRAPPED
        pull = reference.unit(DELTOID.origins - state.insertions)
        moment = np.cross(state.insertions, pull)
        np.testing.assert_allclose(
            state.moment_vectors[straight], moment[straight], rtol=0.0, atol=1e-15
        )


def test_moment_vectors_foretell_the_lengths_along_a_motion() -> None:
    # the integral of -v.omega over a flexion is the change of length (Simpson's rule, 161 poses)
    sweep = np.radians(np.linspace(0.0, 80.0, 161))
    states = RIGHT.solve_batch([THESIS.rotation([f, 0.0, 0.0]) for f in sweep])
    rates = -states.moment_vectors[:, :, 0]
    weights = np.array([1.0, *[4.0, 2.0] * 79, 4.0, 1.0]) * (sweep[1] - sweep[0]) / 3.0
    change = states.lengths[-1] - states.lengths[0]
    np.testing.assert_allclose(weights @ rates, change, rtol=0.0, atol=1e-5)  # m: kinks


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
    with pytest.raises(ValueError, match=f'rotation: (.*){told}'):
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
    with pytest.raises(ValueError, match=told):
        RIGHT.solve_batch(rotations)


@pytest.mark.parametrize('side', ['up', 'Right', '', None])
def test_a_shoulder_is_right_or_left(side: Any) -> None:
    with pytest.raises(ValueError, match=r"side: .* given, 'right' or 'left' expected"):
        LinkedPlaneSolver(DELTOID, side=side)


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
    with pytest.raises(ValueError, match=f'points: {points} given, at least 2 needed'):
        RIGHT.solve(np.eye(3)).paths(points)


def test_the_left_shoulder_is_as_long_as_the_right() -> None:
    left = LEFT.solve_batch(POSES)
    assert left.lengths.tobytes() == BATCH.lengths.tobytes()
    assert left.wrap.tobytes() == BATCH.wrap.tobytes()


def test_the_left_shoulders_paths_are_mirrored() -> None:
    for rotation in POSES[:10]:
        right, left = RIGHT.solve(rotation), LEFT.solve(rotation)
        for one, other in zip(right.paths(), left.paths(), strict=True):
            np.testing.assert_array_equal(other, one * [-1.0, 1.0, 1.0])
        np.testing.assert_array_equal(left.sphere_centres, right.sphere_centres * [-1, 1, 1])


@pytest.mark.parametrize('name', list(JOINT_CONVENTIONS))
def test_the_left_shoulders_moment_arms_are_the_rights(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    for angles in np.random.default_rng(4).uniform([-1, 0.2, -1], [1, 1.5, 1], (20, 3)):
        rotation = convention.rotation(angles)
        right = RIGHT.solve(rotation).moment_vectors @ convention.axes(angles)
        left = LEFT.solve(rotation).moment_vectors @ convention.axes(angles, side='left')
        np.testing.assert_allclose(left, right, rtol=0.0, atol=1e-15)


def test_left_moment_vectors_are_differences_of_the_muscle_mirrored_by_hand() -> None:
    muscle = reference.mirrored(DELTOID)
    neutral = reference.neutral_theta(muscle)
    assert neutral == pytest.approx(-NEUTRAL, abs=1e-9)
    checked = 0
    for rotation in POSES[:8]:
        state = LEFT.solve(rotation)
        turned = reference.mirrored_rotation(rotation)
        theta = reference.least_theta(muscle, turned[np.newaxis], neutral)[0]
        lengths = reference.lengths_at(muscle, turned, theta)
        np.testing.assert_allclose(state.lengths, lengths, rtol=0.0, atol=1e-11)
        found = reference.moment_vectors(muscle, turned, neutral)
        if found.smooth and found.error < 1e-9:
            np.testing.assert_allclose(state.moment_vectors, found.vectors, rtol=0.0, atol=1e-8)
            checked += 1
    assert checked >= 5


@pytest.mark.parametrize('name', list(JOINT_CONVENTIONS))
def test_moment_arms_are_the_lengths_slopes_over_the_coordinates(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    h = 1e-4  # rad
    for angles in np.random.default_rng(6).uniform([-1, 0.2, -1], [1, 1.2, 1], (10, 3)):
        state = RIGHT.solve(convention.rotation(angles))
        arms = state.moment_vectors @ convention.axes(angles)
        for j, step in enumerate(h * np.eye(3)):
            ends = RIGHT.solve_batch([convention.rotation(angles + k * step) for k in (1, -1)])
            if (ends.wrap != state.wrap).any():
                continue
            slope = (ends.lengths[0] - ends.lengths[1]) / (2.0 * h)
            np.testing.assert_allclose(arms[:, j], -slope, rtol=0.0, atol=1e-6)  # m: h^2, kinks


@pytest.mark.parametrize('name', JOINT_CONVENTIONS)
@pytest.mark.parametrize('side', ['right', 'left'])
def test_an_answer_is_the_state_its_moment_arms_and_its_lengthening(name: str, side: str) -> None:
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'), side)
    convention, speeds = JOINT_CONVENTIONS[name], (0.3, -1.2, 0.7)
    for angles in ((0.4, 0.9, -0.3), (-0.2, 0.3, 0.6), (0.0, 0.0, 0.0)):
        state, arms, lengthening, axes = solver.answer(convention, angles, speeds)
        want = solver.solve(convention.rotation(angles))
        assert state.theta == want.theta
        np.testing.assert_array_equal(state.lengths, want.lengths)
        np.testing.assert_array_equal(state.moment_vectors, want.moment_vectors)
        np.testing.assert_array_equal(state.wrap, want.wrap)
        np.testing.assert_array_equal(axes, convention.axes(angles, side))
        # m, m/s: products in another order
        np.testing.assert_allclose(arms, want.moment_vectors @ axes, rtol=0, atol=1e-16)
        np.testing.assert_allclose(lengthening, -arms @ speeds, rtol=0, atol=1e-15)
