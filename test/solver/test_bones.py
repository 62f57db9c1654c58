# SPDX-License-Identifier: Apache-2.0
"""A muscle over several bones (spec bones.md): its lengths, and the wrenches on every bone."""

from __future__ import annotations

import csv
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reference
from random_bones import (
    NAMES,
    Poses,
    at_pose,
    girdle_poses,
    moved,
    random_muscle_on_bones,
    with_poses,
)
from random_muscles import random_poses
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import (
    BroadMuscle,
    LinkedPlaneError,
    LinkedPlaneSolver,
    MuscleStates,
    WrapState,
)
from linkedplane_ros.linked_planes.compilation import COMPILED
from linkedplane_ros.muscle.bones import Bones

DELTOID, GIRDLE = (BroadMuscle.load(name) for name in ('deltoid', 'deltoid_girdle'))
BALL, SOLVER = LinkedPlaneSolver(DELTOID), LinkedPlaneSolver(GIRDLE)
MANY = 500 if COMPILED else 12
FIELDS = ('theta', 'lengths', 'moment_vectors', 'wrap', 'wrenches')


def golden_poses(rows: list[dict[str, str]]) -> Poses:
    """Return the poses of a golden file, by bone."""

    def numbers(bone: str, *names: str) -> Array:
        return np.array([[float(row[f'{bone}_{name}']) for name in names] for row in rows])

    places = [f'R{i}{j}' for i in range(3) for j in range(3)]
    return {
        bone: (numbers(bone, *places).reshape(-1, 3, 3), numbers(bone, 'tx_m', 'ty_m', 'tz_m'))
        for bone in NAMES[1:]
    }


def test_the_girdle_is_that_of_an_independent_implementation(shared: Path) -> None:
    lines = (shared / 'golden' / 'deltoid_clavicle_states.csv').read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith('#')))
    states = SOLVER.solve_bones_batch(golden_poses(rows[::9]))
    assert len(states) == 24
    names = [f'{what}_{axis}{unit}' for what, unit in (('moment', '_m'), ('force', ''))
             for axis in 'xyz']  # fmt: skip
    wrenches = np.array(
        [[float(row[f'{bone}_{name}']) for name in names] for row in rows for bone in NAMES[1:]]
    ).reshape(24, 9, 2, 6)
    lengths = np.array([float(row['length_m']) for row in rows]).reshape(24, 9)
    np.testing.assert_allclose(states.lengths, lengths, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(states.wrenches[..., :3], wrenches[..., :3], rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(states.wrenches[..., 3:], wrenches[..., 3:], rtol=0.0, atol=1e-6)
    wrap = [WrapState(each).name.lower() for each in states.wrap.ravel()]
    assert wrap == [row['wrap'] for row in rows]


def slopes(solver: LinkedPlaneSolver, poses: Poses, bone: str, h: float) -> Array:
    """Return dL/d(twist) (m, n, 6) of a bone by solving anew, with an error of h^4; rad and m / 10.

    A slide is by a tenth of a turn's number, for lengths are about a tenth of a metre.
    """
    units = np.diag([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])
    twists = (h * np.array((-1.0, -0.5, 0.5, 1.0)))[:, np.newaxis, np.newaxis] * units
    m = len(poses[bone][0])
    L = [
        solver.solve_bones_batch(
            {**poses, bone: moved(poses[bone], np.broadcast_to(twist, (m, 6)))}
        ).lengths
        for twist in twists.reshape(-1, 6)
    ]
    L = np.reshape(L, (4, 6, m, -1))
    found = np.moveaxis((8.0 * (L[2] - L[1]) - (L[3] - L[0])) / (6.0 * h), 0, -1)
    return np.asarray(found / units.diagonal())


def test_wrenches_are_the_slopes_of_the_solve_over_500_poses() -> None:
    # Richardson's central differences; where two steps differ there is a kink, or too sharp a bend
    poses = girdle_poses(MANY, seed=14)
    states = SOLVER.solve_bones_batch(poses)
    for k, bone in enumerate(SOLVER.bones[1:]):
        coarse, fine = (slopes(SOLVER, poses, bone, h) for h in (2e-3, 1e-3))
        differ = np.abs(fine - coarse)
        smooth = differ[..., :3].max(axis=(1, 2)) < 3e-9
        smooth &= differ[..., 3:].max(axis=(1, 2)) < 3e-8
        off = np.abs(states.wrenches[:, :, k] + fine)[smooth]
        assert smooth.sum() > 0.85 * MANY
        assert off[..., :3].max() <= 1e-8  # m
        assert off[..., 3:].max() <= 1e-7  # of 1: the slide is a tenth of the turn


def test_wrenches_of_any_muscle_are_slopes_and_add_up_to_zero() -> None:
    # all points, N, SC and HM too, on any of three bones; none on the ground
    checked = linked = normals = 0
    for seed in range(60 if COMPILED else 4):
        muscle, poses = random_muscle_on_bones(seed)
        solver = LinkedPlaneSolver(muscle)
        states = solver.solve_bones_batch(poses)
        total = np.abs(states.wrenches.sum(axis=2))
        size = np.abs(states.wrenches).max(axis=(1, 2, 3))
        assert (total.max(axis=(1, 2)) <= 1e-12 * np.maximum(size, 1.0)).all()
        for k, bone in enumerate(solver.bones[1:]):
            coarse, fine = (slopes(solver, poses, bone, h) for h in (2e-3, 1e-3))
            differ = np.abs(fine - coarse).max(axis=1)
            smooth = (differ < 3e-9).all(axis=1)
            off = np.abs(states.wrenches[:, :, k] + fine)[smooth]
            assert off.max(initial=0.0) <= 1e-8, (seed, bone)
            checked += int(smooth.sum())
            wraps = (states.wrap[smooth] == WrapState.WRAPPED).sum(axis=1)
            linked += int((wraps > 1).sum())
            normals += int((wraps > 1).sum()) * (muscle.bones.reference_normal == bone)
    if COMPILED:
        assert checked > 350
        assert linked > 60
        assert normals > 15


def test_the_wrenches_of_the_girdle_and_the_grounds_add_up_to_zero() -> None:
    world = replace(GIRDLE, bones=replace(GIRDLE.bones, names=('world', *NAMES)))
    poses = girdle_poses(100, seed=5)
    still = np.broadcast_to(np.eye(3), (100, 3, 3)), np.zeros((100, 3))
    states = LinkedPlaneSolver(world).solve_bones_batch({'scapula': still, **poses})
    np.testing.assert_allclose(states.wrenches.sum(axis=2), 0.0, atol=1e-12)
    ours = SOLVER.solve_bones_batch(poses)
    np.testing.assert_allclose(states.wrenches[:, :, 1:], ours.wrenches, rtol=0.0, atol=1e-13)


def test_a_rigid_motion_of_all_bones_changes_no_length_and_turns_the_wrenches() -> None:
    for seed in range(12):
        muscle, poses = random_muscle_on_bones(seed)
        solver = LinkedPlaneSolver(muscle)
        here = solver.solve_bones_batch(poses)
        Q, shift = Rotation.random(random_state=seed).as_matrix(), np.array([0.3, -0.2, 0.1])
        there = solver.solve_bones_batch(
            {bone: (Q @ R, t @ Q.T + shift) for bone, (R, t) in poses.items()}
        )
        # where theta has its choice, rounding may take another of the same total
        same = np.abs(there.theta - here.theta) < 1e-6
        assert same.any()
        np.testing.assert_allclose(there.total_length, here.total_length, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(there.lengths[same], here.lengths[same], rtol=0.0, atol=1e-10)


def reference_lengths(poses: Poses, theta: Array) -> Array:
    """Return the girdle's lengths, literally, at poses of its bones and thetas (m,)."""
    lengths = []
    for k, each in enumerate(theta):
        pose = at_pose(poses, k)
        placed = place_by_hand(GIRDLE, pose)
        lengths.append(reference.lengths_at(placed, np.eye(3), each))
    return np.array(lengths)


def place_by_hand(muscle: BroadMuscle, pose: Poses) -> BroadMuscle:
    """Return a muscle of a ball joint, at rest where the girdle is at a pose."""
    rest = np.eye(3), np.zeros(3)

    def place(points: Array, bones: tuple[str, ...]) -> Array:
        placed = [
            pose.get(bone, rest)[0] @ x + pose.get(bone, rest)[1]
            for x, bone in zip(points, bones, strict=True)
        ]
        return np.array(placed)

    n, bones = len(muscle.band_names), muscle.bones
    return replace(
        DELTOID,
        origins=place(muscle.origins, bones.of_bands('origin', n)),
        insertions=place(muscle.insertions, bones.of_bands('insertion', n)),
        ground_point=place(muscle.ground_point[np.newaxis], (bones.ground_point,))[0],
        humeral_point=place(muscle.humeral_point[np.newaxis], (bones.humeral_point,))[0],
    )


def test_lengths_are_those_of_the_literal_method_with_all_points_placed() -> None:
    poses = girdle_poses(30, seed=8)
    states = SOLVER.solve_bones_batch(poses)
    off = np.abs(reference_lengths(poses, states.theta) - states.lengths)
    assert np.median(off) < 1e-11
    assert off.max() < 1e-8  # m: theta at the edge of a sphere, where acos is near 1
    for k in range(5):  # no theta of a scan is better
        placed = place_by_hand(GIRDLE, at_pose(poses, k))
        scan = reference.total_at(placed, np.eye(3), reference.circle(3600)).min()
        assert states.total_length[k] <= scan + 1e-9


def test_a_clavicle_that_stays_with_the_scapula_gives_the_ball_joints_answer() -> None:
    rotations = random_poses(MANY, seed=3)
    ball, girdle = BALL.solve_batch(rotations), SOLVER.solve_batch(rotations)
    for field in FIELDS[:4]:  # only rotations: the very same kernel
        assert getattr(girdle, field).tobytes() == getattr(ball, field).tobytes(), field
    shifts = np.zeros((MANY, 3))
    bones = SOLVER.solve_bones_batch({'humerus': (rotations, shifts)})
    np.testing.assert_allclose(bones.lengths, ball.lengths, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(bones.moment_vectors, ball.moment_vectors, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(bones.wrap, ball.wrap)
    np.testing.assert_allclose(bones.wrenches[:, :, 1, :3], ball.moment_vectors, atol=1e-12)
    mine = BALL.solve_bones_batch({'humerus': (rotations, shifts)})
    np.testing.assert_allclose(mine.lengths, ball.lengths, rtol=0.0, atol=1e-14)
    assert mine.wrenches.shape == (MANY, 9, 1, 6)


def test_a_straight_band_pulls_along_its_line_on_both_bones() -> None:
    states = SOLVER.solve_bones_batch(girdle_poses(200, seed=2))
    straight = states.wrap != WrapState.WRAPPED
    straight[:, 2:] = False  # those of the clavicle
    assert straight.sum() > 20
    P, S = states.origins[straight], states.insertions[straight]
    u = reference.unit(S - P)
    clavicle, humerus = np.moveaxis(states.wrenches[straight], 1, 0)
    pull = np.concatenate((np.cross(P, u), u), axis=1)
    np.testing.assert_allclose(clavicle, pull, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(humerus, -pull, rtol=0.0, atol=1e-14)


def test_the_answer_depends_only_on_the_pose_and_a_batch_is_its_poses() -> None:
    count = 600 if COMPILED else 20  # in threads, compiled
    poses = girdle_poses(count, seed=6)
    batch = SOLVER.solve_bones_batch(poses)
    order = np.random.default_rng(1).permutation(count)
    shuffled = SOLVER.solve_bones_batch(with_poses(poses, order))
    for field in FIELDS:
        again, first = getattr(shuffled, field), getattr(batch, field)[order]
        assert again.tobytes() == first.tobytes(), field
    for k in (0, 7, count - 1):
        alone = LinkedPlaneSolver(GIRDLE).solve_bones(at_pose(poses, k))
        assert alone == batch[k]
        assert alone.wrenches.tobytes() == batch.wrenches[k].tobytes()
        for one, other in zip(alone.paths(), batch.paths()[k], strict=True):
            assert one.tobytes() == other.tobytes()
    assert batch[3:5] == SOLVER.solve_bones_batch(with_poses(poses, np.array([3, 4])))


def test_wrenches_of_a_rotation_alone_are_those_of_the_bones() -> None:
    rotation = random_poses(1, seed=9)[0]
    state = BALL.solve(rotation)
    assert state.wrenches.shape == (9, 1, 6)
    np.testing.assert_allclose(state.wrenches[:, 0, :3], state.moment_vectors, atol=1e-13)
    assert state.poses['humerus'][0].tobytes() == rotation.tobytes()
    assert state != BALL.solve_bones({'humerus': (rotation, ZERO)})
    batch = BALL.solve_batch([rotation, EYE])
    assert batch.wrenches.shape == (2, 9, 1, 6)
    assert batch.wrenches[0].tobytes() == state.wrenches.tobytes()
    R, t = batch.poses['humerus']
    assert (R.shape, t.shape) == ((2, 3, 3), (2, 3))
    assert R[0].tobytes() == rotation.tobytes()


def test_the_left_girdle_is_the_mirror_image_of_the_right() -> None:
    poses = girdle_poses(40, seed=11)
    right = SOLVER.solve_bones_batch(poses)
    left = LinkedPlaneSolver(GIRDLE, 'left').solve_bones_batch(poses)
    assert left.lengths.tobytes() == right.lengths.tobytes()
    for mirrored, states in ((1.0, right), (-1.0, left)):
        np.testing.assert_array_equal(states.origins[..., 0], mirrored * right.origins[..., 0])
    for one, other in zip(right[3].paths(), left[3].paths(), strict=True):
        np.testing.assert_array_equal(other, one * [-1.0, 1.0, 1.0])
    # the muscle mirrored by hand, at poses mirrored by hand
    by_hand = LinkedPlaneSolver(reference.mirrored(GIRDLE))
    mirror = np.diag([-1.0, 1.0, 1.0])
    turned = {bone: (mirror @ R @ mirror, t * [-1, 1, 1]) for bone, (R, t) in poses.items()}
    literal = by_hand.solve_bones_batch(turned)
    np.testing.assert_allclose(left.lengths, literal.lengths, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(left.wrenches, literal.wrenches, rtol=0.0, atol=1e-10)


def test_a_state_is_read_only_compares_by_value_and_is_pickled() -> None:
    poses = girdle_poses(3, seed=1)
    batch = SOLVER.solve_bones_batch(poses)
    again: MuscleStates = pickle.loads(pickle.dumps(batch))
    assert again == batch
    assert again.wrenches.tobytes() == batch.wrenches.tobytes()
    for R, t in batch.poses.values():
        assert R.shape == (3, 3, 3)
        assert t.shape == (3, 3)
    with pytest.raises(ValueError, match='read-only'):
        batch.wrenches[0, 0] = 0.0
    assert SOLVER.bones == NAMES


def test_what_is_on_a_bone_goes_with_it() -> None:
    pose = at_pose(girdle_poses(1, seed=4), 0)
    muscle = replace(GIRDLE, interference_bones=('humerus', 'clavicle', 'scapula'))
    state = LinkedPlaneSolver(muscle).solve_bones(pose)
    placed = place_by_hand(GIRDLE, pose)
    np.testing.assert_allclose(state.origins, placed.origins, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(state.insertions, placed.insertions, rtol=0.0, atol=1e-15)
    for k, bone in enumerate(muscle.interference_bones):
        R, t = pose.get(bone, (np.eye(3), np.zeros(3)))
        centre = R @ muscle.interference_centres[k] + t
        np.testing.assert_allclose(state.interference_centres[k], centre, rtol=0.0, atol=1e-15)
    R, t = pose['humerus']
    point = np.array([0.01, 0.02, -0.1])
    np.testing.assert_allclose(state.to_scapula(point), R @ point + t, rtol=0.0, atol=1e-15)
    for path, P, S in zip(state.paths(), placed.origins, placed.insertions, strict=True):
        np.testing.assert_allclose(path[[0, -1]], [P, S], rtol=0.0, atol=1e-15)


def test_a_muscle_whose_joint_moves_more_than_insertions_is_solved_by_a_rotation() -> None:
    # an origin on the humerus, an insertion on the scapula: the rotation is the pose of one bone
    origins = ('humerus', *['scapula'] * 8)
    insertions = ('scapula', *['humerus'] * 8)
    turned = replace(DELTOID, bones=Bones(origin=origins, insertion=insertions))
    assert not turned.has_ball_joint
    solver = LinkedPlaneSolver(turned)
    rotations = random_poses(20, seed=2)
    states = solver.solve_batch(rotations)
    bones = solver.solve_bones_batch({'humerus': (rotations, np.zeros((20, 3)))})
    for field in FIELDS:
        assert getattr(states, field).tobytes() == getattr(bones, field).tobytes(), field
    assert solver.solve(rotations[4]) == states[4]
    line = rotations[:, np.newaxis] @ turned.origins[0] - turned.insertions[0]
    assert (states.lengths[:, 0] >= np.linalg.norm(line[:, 0], axis=-1) - 1e-12).all()


EYE, ZERO = np.eye(3), np.zeros(3)
REFUSED: list[tuple[Any, str]] = [
    (5, 'bones: 5 given, a mapping of bones to their poses (R, t) expected'),
    ({'femur': (EYE, ZERO)}, "bones: 'femur' given, one of clavicle, humerus expected"),
    ({3: (EYE, ZERO)}, 'bones: 3 given, one of clavicle, humerus expected'),
    (
        {'scapula': (EYE, ZERO)},
        'bones: scapula given, which is the ground and does not move; clavicle, humerus expected',
    ),
    ({'humerus': EYE}, 'humerus: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] given, a '
                       'rotation (3, 3) and a shift (3,) expected'),
    ({'humerus': (EYE,)}, 'a rotation (3, 3) and a shift (3,) expected'),
    ({'humerus': 'up'}, "humerus: 'up' given, a rotation (3, 3) and a shift (3,) expected"),
    ({'humerus': (EYE[:2], ZERO)}, 'humerus: rotation: shape (2, 3) given, (3, 3) expected'),
    ({'clavicle': (EYE, ZERO[:2])}, 'clavicle: shift: shape (2,) given, (3,) expected'),
    ({'clavicle': (EYE, np.zeros((3, 1)))}, 'clavicle: shift: shape (3, 1) given, (3,) expected'),
    ({'clavicle': (EYE, [None] * 3)}, 'clavicle: shift: not an array of numbers'),
    ({'clavicle': (1.1 * EYE, ZERO)}, 'clavicle: R^T R is not the identity within 1e-06'),
    ({'humerus': (-EYE, ZERO)}, 'humerus: its determinant is -1, a reflection'),
    ({'humerus': (np.nan * EYE, ZERO)}, 'humerus: a value is not finite'),
    ({'clavicle': (EYE, [0, np.inf, 0])}, 'clavicle: a value is not finite'),
    ({'humerus': (1e300 * EYE, ZERO)}, 'humerus: R^T R is not the identity'),
    ({'clavicle': (EYE, [0, -1e300, 0])}, 'clavicle: its shift is beyond 1000 m'),
    ({'humerus': (EYE, [1e3, 0, 0])}, 'humerus: its shift is beyond 1000 m'),
]  # fmt: skip


@pytest.mark.parametrize(('bones', 'reason'), REFUSED)
def test_what_is_no_pose_of_a_bone_is_refused_in_one_line(bones: Any, reason: str) -> None:
    with pytest.raises(LinkedPlaneError) as caught:
        SOLVER.solve_bones(bones)
    assert reason in str(caught.value)
    assert str(caught.value).isprintable()


def many(count: int) -> tuple[Array, Array]:
    """Return rest poses."""
    return np.broadcast_to(EYE, (count, 3, 3)).copy(), np.zeros((count, 3))


def spoilt(part: int, place: int, value: float) -> tuple[Array, Array]:
    """Return rest poses with something wrong in one."""
    pose = many(5)
    pose[part][place] = value
    return pose


@pytest.mark.parametrize(
    ('bones', 'reason'),
    [
        ({}, 'bones: none given, at least one of clavicle, humerus expected'),
        ({'humerus': (EYE, ZERO)}, 'humerus: rotation: shape (3, 3) given, (m, 3, 3) expected'),
        (
            {'clavicle': many(3), 'humerus': many(5)},
            'humerus: 5 rotations given, 3 expected, as there are rotations of clavicle',
        ),
        ({'humerus': (many(3)[0], ZERO)}, 'humerus: shift: shape (3,) given, (m, 3) expected'),
        ({'humerus': (many(3)[0], many(2)[1])}, 'humerus: 2 shifts given, 3 expected'),
        ({'humerus': spoilt(0, 3, 2.0)}, 'humerus[3]: R^T R is not the identity'),
        ({'humerus': many(5), 'clavicle': spoilt(1, 4, np.nan)}, 'clavicle[4]: a value is not f'),
    ],
)
def test_what_are_no_poses_of_bones_is_refused_in_one_line(bones: Any, reason: str) -> None:
    with pytest.raises(LinkedPlaneError) as caught:
        SOLVER.solve_bones_batch(bones)
    assert str(caught.value).startswith(reason)


def test_a_pose_without_a_plane_names_the_band() -> None:
    away = GIRDLE.insertions[2] - GIRDLE.origins[2]
    with pytest.raises(ValueError, match=r'^bones: band anterior_3 has no plane at this pose'):
        SOLVER.solve_bones({'humerus': (EYE, -away)})
    shifts = np.array([ZERO, -away])
    with pytest.raises(ValueError, match=r'^bones\[1\]: band anterior_3 has no plane'):
        SOLVER.solve_bones_batch({'humerus': (many(2)[0], shifts)})


def test_no_poses_are_an_empty_batch() -> None:
    states = SOLVER.solve_bones_batch({'humerus': many(0)})
    assert states.wrenches.shape == (0, 9, 2, 6)
    assert len(SOLVER.solve_bones_batch({'humerus': ([], [])})) == 0
