# SPDX-License-Identifier: Apache-2.0
"""What moves a muscle's bones: joint conventions, skeletons and rhythms, answered in one way.

Moment arms are held against differences of lengths with Richardson's extrapolation (steps of 1e-4
and 2e-4 rad, 1e-9 m), away from kinks.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from linkedplane_ros import (
    JOINT_CONVENTIONS,
    RHYTHMS,
    BroadMuscle,
    LinkedPlaneError,
    LinkedPlaneSolver,
    Rest,
    Skeleton,
)
from linkedplane_ros.joints.articulation import Articulation
from linkedplane_ros.joints.conventions import JointConvention
from linkedplane_ros.muscle.bones import Bones
from linkedplane_ros.skeleton.followed_girdle import FollowedGirdle
from linkedplane_ros.types import Floats

DELTOID, GIRDLE = (BroadMuscle.load(name) for name in ('deltoid', 'deltoid_girdle'))
FOUR_BONES = replace(
    GIRDLE,
    bones=Bones(
        ('scapula', 'clavicle', 'sternum', 'humerus'),
        origin=('sternum', 'clavicle', *['scapula'] * 7),
    ),
)
SIDES = ('right', 'left')
Q = np.array([0.1, -0.2, 0.15, -0.1, 0.2, 0.05, 0.3, 0.8, -0.2])
ANGLES = np.array([0.3, 1.1, -0.2])
REST = Rest((0.6, 0.1, -0.2), (-0.5, 0.15, 0.0), (0.2, 0.25))

# the bundled girdle's glenohumeral joint as a robot has it: a right arm, and its mirror image
ARM = """<robot name="arm">
<link name="scapula"/><link name="clavicle"/><link name="humerus"/>
<joint name="slide" type="prismatic"><parent link="scapula"/><child link="clavicle"/>
<origin xyz="{m}0.02 0 0.03" rpy="0.1 {m}0.2 {m}0.3"/><axis xyz="{m}1 2 3"/>
<limit lower="-1" upper="1"/></joint>
<joint name="lift" type="revolute"><parent link="scapula"/><child link="humerus"/>
<origin xyz="{m}0.001 0.002 0" rpy="-0.1 {m}0.1 {m}0.2"/><axis xyz="0.3 {m}1 {m}0.2"/>
<limit lower="-3" upper="3"/></joint></robot>"""
STERNUM = """<link name="sternum"/><joint name="lean" type="revolute"><parent link="clavicle"/>
<child link="sternum"/><origin xyz="-0.1 0.1 0"/><axis xyz="1 0 2"/><limit lower="-3" upper="3"/>
</joint></robot>"""


def arm(side: str) -> Skeleton:
    m = '' if side == 'right' else '-'
    return Skeleton.from_urdf(ARM.format(m=m)).for_bones(GIRDLE.bones.names)


def arm_of_four_bones() -> Skeleton:
    urdf = ARM.format(m='').replace('</robot>', STERNUM)
    return Skeleton.from_urdf(urdf).for_bones(FOUR_BONES.bones.names)


def by_differences(solver: LinkedPlaneSolver, moved_by: Articulation, q: Floats) -> Floats:
    still = np.zeros(len(q))

    def slope(i: int, step: float) -> Floats:
        ahead, behind = (
            solver.answer(moved_by, q + sign * step * np.eye(len(q))[i], still).state.lengths
            for sign in (1.0, -1.0)
        )
        return (ahead - behind) / (2.0 * step)

    return -np.array([(4.0 * slope(i, 1e-4) - slope(i, 2e-4)) / 3.0 for i in range(len(q))]).T


def every_articulation() -> list[Any]:
    girdle = Skeleton.load('shoulder_girdle')
    each: list[Any] = [
        (DELTOID, JOINT_CONVENTIONS['isb_yxy'], ANGLES),
        (GIRDLE, JOINT_CONVENTIONS['rep155'], ANGLES),
        (GIRDLE, girdle, Q),
        (DELTOID, girdle.for_bones(DELTOID.bones.names), Q),
        (GIRDLE, arm('right'), np.array([0.01, -0.7])),
        (FOUR_BONES, arm_of_four_bones(), np.array([0.01, -0.7, 0.2])),
    ]
    for rhythm in RHYTHMS.values():
        for muscle in (DELTOID, GIRDLE):
            for rest in (None, REST):
                followed = FollowedGirdle(JOINT_CONVENTIONS['opensim_mobl'], rhythm, rest)
                each.append((muscle, followed, ANGLES))
    return each


@pytest.mark.parametrize('side', SIDES)
@pytest.mark.parametrize(('muscle', 'moved_by', 'q'), every_articulation())
def test_moment_arms_are_the_slopes_of_the_lengths(
    muscle: BroadMuscle, moved_by: Articulation, q: Floats, side: str
) -> None:
    solver, speeds = LinkedPlaneSolver(muscle, side), np.linspace(-1.0, 1.3, len(q))
    answer = solver.answer(moved_by, q, speeds)
    want = by_differences(solver, moved_by, q)
    np.testing.assert_allclose(answer.moment_arms, want, rtol=0, atol=1e-9)
    np.testing.assert_allclose(answer.lengthening, -want @ speeds, rtol=0, atol=1e-8)  # m/s


@pytest.mark.parametrize('side', SIDES)
@pytest.mark.parametrize(('muscle', 'moved_by', 'q'), every_articulation())
def test_a_batch_answers_as_one_after_the_other(
    muscle: BroadMuscle, moved_by: Articulation, q: Floats, side: str
) -> None:
    solver = LinkedPlaneSolver(muscle, side)
    values = np.array([q, 0.9 * q, 0.0 * q])
    batch = solver.answer_batch(moved_by, values, 0.5 * values)
    for i, each in enumerate(values):
        alone = solver.answer(moved_by, each, 0.5 * each)
        assert batch.states[i] == alone.state
        np.testing.assert_allclose(batch.moment_arms[i], alone.moment_arms, rtol=0, atol=1e-15)
        np.testing.assert_allclose(batch.lengthening[i], alone.lengthening, rtol=0, atol=1e-14)
    none = solver.answer_batch(moved_by, values[:0], values[:0])
    assert none.moment_arms.shape == (0, 9, len(q))


@pytest.mark.parametrize('moved_by', [JOINT_CONVENTIONS['isb_yxy'], arm('right')])
@pytest.mark.parametrize(
    ('speeds', 'reason'),
    [
        (lambda d: np.ones((1, d)), r'speeds: shape \(1, {d}\) given, \(2, {d}\) finite numbers'),
        (lambda d: np.ones((2, 1)), r'speeds: shape \(2, 1\) given'),
        (lambda d: np.ones(d), r'speeds: shape \({d},\) given'),
        (lambda d: np.ones((2, d + 2)), r'speeds: shape \(2, '),
        (lambda d: [[0.0] * d, [np.nan] * d], r'speeds\[1\]: \[nan, nan.* given, .* rad/s'),
        (lambda d: [[np.inf] * d, [0.0] * d], r'speeds\[0\]: \[inf, inf'),
        (lambda d: 'abc', 'speeds: not an array of numbers'),
        (lambda d: None, 'speeds: not an array of numbers'),
        (lambda d: [[0.0], [0.0] * d], 'speeds: not an array of numbers'),
        (lambda d: np.ones((2, d)) * 1j, 'speeds: not an array of numbers'),
    ],
)
def test_speeds_of_a_batch_are_checked(moved_by: Articulation, speeds: Any, reason: str) -> None:
    d = len(moved_by.coordinates)
    for muscle in (GIRDLE, DELTOID) if isinstance(moved_by, JointConvention) else (GIRDLE,):
        with pytest.raises(LinkedPlaneError, match=reason.format(d=d)):
            LinkedPlaneSolver(muscle).answer_batch(moved_by, np.zeros((2, d)), speeds(d))


def test_a_skeleton_answers_as_its_poses_and_screws() -> None:
    solver, girdle = LinkedPlaneSolver(GIRDLE), Skeleton.load('shoulder_girdle')
    answer, state = solver.answer(girdle, Q, np.zeros(9)), solver.solve_bones(girdle.pose(Q))
    np.testing.assert_array_equal(answer.state.lengths, state.lengths)
    np.testing.assert_array_equal(answer.state.wrenches, state.wrenches)
    want = np.einsum('nkc,dkc->nd', state.wrenches, girdle.screws(Q))
    np.testing.assert_allclose(answer.moment_arms, want, rtol=0, atol=1e-16)


def test_the_bundled_girdle_moves_a_left_muscle_as_its_mirror_image() -> None:
    girdle = Skeleton.load('shoulder_girdle')
    assert girdle.side == 'right'
    right, left = (LinkedPlaneSolver(GIRDLE, side).answer(girdle, Q, np.ones(9)) for side in SIDES)
    np.testing.assert_array_equal(left.state.lengths, right.state.lengths)
    np.testing.assert_allclose(left.moment_arms, right.moment_arms, rtol=0, atol=1e-16)
    np.testing.assert_allclose(left.lengthening, right.lengthening, rtol=0, atol=1e-16)
    mirror = np.array([-1.0, 1.0, 1.0])
    np.testing.assert_array_equal(left.state.insertions, right.state.insertions * mirror)


def test_a_robot_s_left_arm_moves_a_left_muscle_as_it_stands() -> None:
    """The left arm's URDF is the right one's mirror image, written out: what is told is equal."""
    q = np.array([0.02, 0.9])
    right, left = (
        LinkedPlaneSolver(GIRDLE, side).answer(arm(side), q, np.ones(2)) for side in SIDES
    )
    np.testing.assert_allclose(left.state.lengths, right.state.lengths, rtol=0, atol=1e-15)
    mirror = np.array([-1.0, 1.0, 1.0])
    want = right.state.insertions * mirror
    np.testing.assert_allclose(left.state.insertions, want, rtol=0, atol=1e-15)
    # where a bone of a left arm is, is where its own skeleton has it
    R, t = arm('left').pose(q)['humerus']
    insertions = GIRDLE.insertions * mirror @ R.T + t
    np.testing.assert_allclose(left.state.insertions, insertions, rtol=0, atol=1e-15)
    np.testing.assert_allclose(left.moment_arms, right.moment_arms, rtol=0, atol=1e-15)


@pytest.mark.parametrize('name', RHYTHMS)
def test_a_rhythm_of_the_deltoid_is_the_humerus_against_the_scapula_that_follows(
    name: str,
) -> None:
    convention, rhythm = JOINT_CONVENTIONS['isb_yxy'], RHYTHMS[name]
    girdle = rhythm.pose(*convention.rotation_and_axes(ANGLES), rest=REST)
    solver = LinkedPlaneSolver(DELTOID)
    state = solver.solve(girdle.rotation)
    answer = solver.answer(FollowedGirdle(convention, rhythm, REST), ANGLES, np.zeros(3))
    np.testing.assert_allclose(answer.state.lengths, state.lengths, rtol=0, atol=1e-15)
    want = state.moment_vectors @ girdle.axes
    np.testing.assert_allclose(answer.moment_arms, want, rtol=0, atol=1e-15)


def test_at_rest_a_rhythm_leaves_the_clavicle_where_the_muscle_has_it() -> None:
    """And beyond, it is turned about the acromioclavicular joint: against poses in the thorax."""
    convention, rhythm = JOINT_CONVENTIONS['isb_yxy'], RHYTHMS['de_groot_brand_2001']
    followed = FollowedGirdle(convention, rhythm, REST)
    values = np.array([[*REST.humerus, 0.0], ANGLES])  # type: ignore[misc]
    poses = followed.move_bones(values, GIRDLE.bones.names, 'right').poses
    np.testing.assert_allclose(poses[0, 0], np.eye(3, 4), rtol=0, atol=1e-15)
    assert np.abs(poses[1, 0] - np.eye(3, 4)).max() > 0.01
    start, there = (rhythm.bones(each, REST) for each in values)

    def place(bones: Any, bone: str) -> Floats:
        R, t = bones[bone]
        return np.vstack((np.column_stack((R, t)), (0.0, 0.0, 0.0, 1.0)))

    first, now = (
        np.linalg.inv(place(bones, 'scapula')) @ place(bones, 'clavicle')
        for bones in (start, there)
    )
    want = now @ np.linalg.inv(first)
    np.testing.assert_allclose(poses[1, 0], want[:3], rtol=0, atol=1e-15)


@pytest.mark.parametrize('ground', ['thorax', 'clavicle', 'scapula'])
@pytest.mark.parametrize('rest', [None, Rest(), Rest((0.24, -0.08, -0.1)), REST])
@pytest.mark.parametrize('name', RHYTHMS)
def test_rest_is_the_identity_from_any_ground(name: str, rest: Rest | None, ground: str) -> None:
    followed = FollowedGirdle(JOINT_CONVENTIONS['isb_yxy'], RHYTHMS[name], rest)
    hanging = (*((rest and rest.humerus) or (0.0, 0.0)), 0.4)  # axial rotation moves no girdle
    others = [bone for bone in ('thorax', 'clavicle', 'scapula') if bone != ground]
    poses = followed.move_bones([hanging], (ground, *others), 'right').poses[0]
    np.testing.assert_allclose(poses, np.tile(np.eye(3, 4), (2, 1, 1)), rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ('make', 'reason'),
    [
        (lambda isb, mobl: FollowedGirdle(isb, 'mobl'), "rhythm: 'mobl' given, one of RHYTHMS"),  # type: ignore[arg-type]
        (lambda isb, mobl: FollowedGirdle('isb_yxy', mobl), "convention: 'isb_yxy' given, one of"),  # type: ignore[arg-type]
        (
            lambda isb, mobl: FollowedGirdle(isb, mobl, (0, 0, 0)),
            r'rest: \(0, 0, 0\) given, a Rest',
        ),  # type: ignore[arg-type]
        (lambda isb, mobl: mobl.bones([0, 0, 0], (0, 0, 0)), r'rest: \(0, 0, 0\) given, a Rest'),
        (
            lambda isb, mobl: mobl.pose(np.eye(3), rest='still'),
            "rest: 'still' given, a Rest",
        ),
        (lambda isb, mobl: Rest(humerus=(1,)), r'rest: humerus: \(1,\) given, 2 finite numbers'),  # type: ignore[arg-type]
        (lambda isb, mobl: Rest(humerus=(1, 2, 3)), r'humerus: \(1, 2, 3\) given, 2 finite'),  # type: ignore[arg-type]
        (lambda isb, mobl: Rest(humerus=0.3), 'rest: humerus: 0.3 given, 2 finite numbers'),  # type: ignore[arg-type]
        (lambda isb, mobl: Rest(humerus=(0, np.nan)), r'humerus: \(0, nan\) given, 2 finite'),
    ],
)
def test_what_is_no_rhythm_or_rest_is_refused(make: Any, reason: str) -> None:
    with pytest.raises(LinkedPlaneError, match=reason):
        make(JOINT_CONVENTIONS['isb_yxy'], RHYTHMS['mobl'])


def test_what_does_not_fit_the_muscle_is_refused() -> None:
    girdle = Skeleton.load('shoulder_girdle')
    hip = BroadMuscle.load('deltoid')
    with pytest.raises(LinkedPlaneError, match=r'for the bones scapula, clavicle, humerus, the mu'):
        LinkedPlaneSolver(hip).answer(girdle, np.zeros(9), np.zeros(9))
    with pytest.raises(LinkedPlaneError, match=r'^angles: .* given, 9 finite numbers in rad exp'):
        LinkedPlaneSolver(GIRDLE).answer(girdle, np.zeros(3), np.zeros(9))
    with pytest.raises(LinkedPlaneError, match=r'^speeds: .*, 2 finite numbers in m or rad/s exp'):
        LinkedPlaneSolver(GIRDLE).answer(arm('right'), np.zeros(2), (0.0, np.nan))
