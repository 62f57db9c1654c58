# SPDX-License-Identifier: Apache-2.0
"""The node with a skeleton: what moves the bones, what is answered, what is refused and how."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from free_bones import find_screws, find_values, list_joints, write_urdf
from girdle_recordings import recorded_angles, recorded_joints
from optional import requires
from parameter_changes import EXACT, as_sent, change_parameters
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_harness import NodeProcess, Peer, running
from std_msgs.msg import Float64MultiArray, String

from linkedplane_ros import (
    JOINT_CONVENTIONS,
    RHYTHMS,
    BroadMuscle,
    LinkedPlaneSolver,
    Rest,
    Skeleton,
    WrapState,
)
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.processing.solving import ValuesSolving
from linkedplane_ros.recordings.motion import Chunk, Refusals
from linkedplane_ros.skeleton.followed_girdle import FollowedGirdle
from linkedplane_ros.types import Floats

MUSCLE = BroadMuscle.load('deltoid_girdle')
SOLVER = LinkedPlaneSolver(MUSCLE)
GIRDLE = Skeleton.load('shoulder_girdle')
JOINTS = GIRDLE.coordinates
Q = (0.0, 0.0, 0.0, -0.1, 0.2, 0.05, 0.3, 0.8, -0.2)  # rad; the sternoclavicular joint is idle
BONES = MUSCLE.bones.names[1:]
WITH_GIRDLE = {'muscle': 'deltoid_girdle', 'skeleton': 'shoulder_girdle'}
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture
def girdle_peer(ros: None) -> Iterator[Peer]:
    made = Peer('deltoid_girdle')
    yield made
    made.destroy_node()


def values_of(peer: Peer) -> dict[str, str]:
    """Return the diagnostics from now on."""
    peer.diagnostics.clear()
    return peer.values()


def newest(peer: Peer, topic: str) -> Floats:
    message = peer.got[topic][-1]
    return np.array(message.data).reshape([each.size for each in message.layout.dim])


def test_the_golden_states_come_out_of_the_node(
    girdle_peer: Peer, tmp_path: Path, shared: Path
) -> None:
    """Each bone is slid and turned by joints that can take any pose: m and rad in one skeleton."""
    lines = (shared / 'golden' / 'deltoid_clavicle_states.csv').read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith('#')))
    urdf = tmp_path / 'free.urdf'
    urdf.write_text(write_urdf('scapula', BONES))
    with running(girdle_peer, muscle='deltoid_girdle', skeleton=str(urdf)):
        for k in range(24):
            nine = rows[9 * k : 9 * k + 9]
            poses = {bone: read_pose(nine[0], bone) for bone in BONES}
            girdle_peer.send(list_joints(BONES), find_values(poses))
            assert girdle_peer.answers(k + 1)
            lengths = [float(row['length_m']) for row in nine]
            np.testing.assert_allclose(newest(girdle_peer, 'band_lengths'), lengths, 0, 1e-9)
            wraps = [
                WrapState(each).name.lower() for each in girdle_peer.got['wrap_states'][k].data
            ]
            assert wraps == [row['wrap'] for row in nine]
            want = np.hstack([
                read_wrenches(nine, bone) @ screws.T for bone, screws in find_screws(poses).items()
            ])  # fmt: skip
            # 1e-7 m of the moments, 1e-6 of the forces, which is the golden file's worth
            np.testing.assert_allclose(newest(girdle_peer, 'moment_arms'), want, 0, 2e-6)


def read_pose(row: dict[str, str], bone: str) -> tuple[Floats, Floats]:
    turn = [float(row[f'{bone}_R{i}{j}']) for i in range(3) for j in range(3)]
    return np.reshape(turn, (3, 3)), np.array([float(row[f'{bone}_t{axis}_m']) for axis in 'xyz'])


def read_wrenches(rows: list[dict[str, str]], bone: str) -> Floats:
    names = [f'{bone}_moment_{axis}_m' for axis in 'xyz']
    names += [f'{bone}_force_{axis}' for axis in 'xyz']
    return np.array([[float(row[name]) for name in names] for row in rows])


def test_moment_arms_are_about_the_joints_by_name(girdle_peer: Peer) -> None:
    with running(girdle_peer, **WITH_GIRDLE):
        girdle_peer.send(JOINTS, Q, 9 * (1.0,))
        assert girdle_peer.answers(1)
        answer = SOLVER.answer(GIRDLE, Q, np.ones(9))
        np.testing.assert_allclose(newest(girdle_peer, 'moment_arms'), answer.moment_arms, 0, EXACT)
        got = girdle_peer.got['moment_arms'][0].layout.dim
        assert [(each.size, each.stride) for each in got] == [(9, 81), (9, 9)]
        assert got[1].label == 'coordinate:' + ','.join(JOINTS)
        states = girdle_peer.got['moment_arm_states'][0]
        assert list(states.name[:2]) == ['anterior_1/sc_protraction', 'anterior_1/sc_elevation']
        assert states.position == girdle_peer.got['moment_arms'][0].data
        # the idle joints' speeds stretch nothing
        speeds = girdle_peer.got['band_states'][0].velocity
        np.testing.assert_allclose(speeds, answer.lengthening, 0, EXACT)
        values = values_of(girdle_peer)
        assert values['skeleton'] == 'shoulder_girdle'
        assert values['bones'] == 'scapula (ground), clavicle, humerus'
        assert values['joints'] == ', '.join(JOINTS)
        shown = {marker.ns for marker in girdle_peer.got['markers'][-1].markers}
        assert 'bones' in shown


def test_wrenches_are_published_to_who_asks(girdle_peer: Peer) -> None:
    got: list[Any] = []
    with running(girdle_peer, **WITH_GIRDLE) as node:
        girdle_peer.send(JOINTS, Q)
        assert girdle_peer.answers(1)
        girdle_peer.keep(Float64MultiArray, 'deltoid_girdle/wrenches', got.append)
        girdle_peer.connect()
        girdle_peer.send(JOINTS, Q)
        assert girdle_peer.until(lambda: bool(got))
        labels = [each.label for each in got[0].layout.dim]
        assert labels[1:] == ['bone:clavicle,humerus', 'component:mx,my,mz,fx,fy,fz']
        want = SOLVER.answer(GIRDLE, Q, np.zeros(9)).state.wrenches
        np.testing.assert_allclose(np.reshape(got[0].data, (9, 2, 6)), want, 0, EXACT)
        topics = node.get_publisher_names_and_types_by_node(node.get_name(), '/')
        assert '/deltoid_girdle/wrenches' in dict(topics)


def test_joints_that_move_nothing_are_not_needed_and_others_are_named(girdle_peer: Peer) -> None:
    """The sternoclavicular joint moves all bones together; the rest is needed, each by name."""
    needed = dict(zip(JOINTS[3:], Q[3:], strict=True))
    with running(girdle_peer, **WITH_GIRDLE):
        girdle_peer.send(list(needed)[1:], list(needed.values())[1:])
        assert girdle_peer.until(lambda: 'ac_protraction' in newest_line(girdle_peer))
        assert newest_line(girdle_peer).endswith(
            "waiting for joint 'ac_protraction', not seen so far"
        )
        assert girdle_peer.values()['joints not seen so far'] == 'ac_protraction'
        girdle_peer.send(['ac_protraction', 'leg'], [Q[3], 500.0])
        assert girdle_peer.answers(1)
        want = SOLVER.answer(GIRDLE, Q, np.zeros(9)).state.lengths
        np.testing.assert_allclose(newest(girdle_peer, 'band_lengths'), want, 0, EXACT)


def newest_line(peer: Peer) -> str:
    return peer.diagnostics[-1].status[0].message if peer.diagnostics else ''


def test_signs_offsets_and_names_are_one_for_each_joint(girdle_peer: Peer) -> None:
    names, signs = [f'j{k}' for k in range(9)], [1.0, -1.0] * 4 + [-1.0]
    offsets = [0.01 * k for k in range(9)]
    given = {'joint_names': names, 'joint_signs': signs, 'joint_offsets': offsets}
    with running(girdle_peer, **WITH_GIRDLE, **given):
        girdle_peer.send(names, (np.array(signs) * (np.array(Q) - offsets)).tolist())
        assert girdle_peer.answers(1)
        want = SOLVER.answer(GIRDLE, Q, np.zeros(9)).state.lengths
        np.testing.assert_allclose(newest(girdle_peer, 'band_lengths'), want, 0, EXACT)


def test_a_left_muscle_is_moved_by_the_mirror_image_of_the_bundled_girdle(
    girdle_peer: Peer,
) -> None:
    with running(girdle_peer, **WITH_GIRDLE, side='left'):
        girdle_peer.send(JOINTS, Q)
        assert girdle_peer.answers(1)
        want = SOLVER.answer(GIRDLE, Q, np.zeros(9))
        np.testing.assert_allclose(newest(girdle_peer, 'moment_arms'), want.moment_arms, 0, EXACT)
        vectors = newest(girdle_peer, 'moment_vectors')
        np.testing.assert_allclose(vectors, want.state.moment_vectors * (1, -1, -1), 0, EXACT)
        assert girdle_peer.values()['side of the skeleton'] == 'right'


@pytest.mark.parametrize(
    ('urdf', 'reason'),
    [
        ('<joint name="a" type="revolute"><parent link="scapula"/><child link="humerus"/>'
         '<limit lower="0" upper="1"/></joint><joint name="b" type="fixed">'
         '<parent link="clavicle"/><child link="humerus"/></joint>', 'a loop; a tree expected'),
        ('<joint name="a" type="floating"><parent link="scapula"/><child link="clavicle"/></joint>'
         '<joint name="b" type="fixed"><parent link="clavicle"/><child link="humerus"/></joint>',
         "joint 'a': type 'floating' has six coordinates"),
        ('<joint name="a" type="fixed"><parent link="scapula"/><child link="clavicle"/></joint>'
         '<joint name="b" type="fixed"><parent link="clavicle"/><child link="humerus"/></joint>',
         'no joint moves the bones scapula, clavicle, humerus against each other'),
    ],
    ids=['loop', 'floating', 'still'],
)  # fmt: skip
def test_a_urdf_that_cannot_move_the_bones_is_one_line(
    ros: None, tmp_path: Path, urdf: str, reason: str
) -> None:
    path = tmp_path / 'arm.urdf'
    links = ''.join(f'<link name="{bone}"/>' for bone in MUSCLE.bones.names)
    path.write_text(f'<robot name="arm">{links}{urdf}</robot>')
    node = MuscleStatePublisher(parameter_overrides=[as_sent('muscle', 'deltoid_girdle')])
    result = change_parameters(node, skeleton=str(path))
    node.destroy_node()
    assert not result.successful
    assert result.reason.startswith(f'parameter skeleton: {path}: ')
    assert reason in result.reason
    assert '\n' not in result.reason


def test_a_urdf_without_the_bones_ends_the_node_with_one_line(tmp_path: Path) -> None:
    path = tmp_path / 'robot.urdf'
    path.write_text(write_urdf('scapula', BONES, 'r/'))
    log = tmp_path / 'node.log'
    process = NodeProcess(log, muscle='deltoid_girdle', skeleton=str(path))
    assert process.process.wait(120) == 1
    [line] = [each for each in process.text.splitlines() if 'parameter skeleton' in each]
    assert "no link of that name for bone 'scapula'; its links are r/scapula" in line
    assert line.endswith('bone_links: scapula:=LINK names another')
    assert 'Traceback' not in process.text


def test_links_of_other_names_are_the_bones_that_bone_links_says(
    girdle_peer: Peer, tmp_path: Path
) -> None:
    path = tmp_path / 'robot.urdf'
    path.write_text(write_urdf('scapula', BONES, 'r/'))
    links = [f'{bone}:=r/{bone}' for bone in MUSCLE.bones.names]
    poses = GIRDLE.pose(Q)
    given = {'muscle': 'deltoid_girdle', 'skeleton': str(path), 'bone_links': links}
    with running(girdle_peer, **given):
        girdle_peer.send(list_joints(BONES), find_values(poses))
        assert girdle_peer.answers(1)
        want = SOLVER.solve_bones(poses).lengths
        np.testing.assert_allclose(newest(girdle_peer, 'band_lengths'), want, 0, EXACT)


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'rhythm': 'mobl'}, "rhythm: 'mobl' given beside skeleton 'shoulder_girdle'; one of them"),
        ({'bone_links': ['tibia:=t']}, "bone_links: 'tibia' is no bone of deltoid_girdle; those"),
        ({'bone_links': ['clavicle']}, "bone_links: 'clavicle' given, BONE:=LINK expected"),
        ({'joint_names': ['a', 'b', 'c']}, 'joint_names: 3 given, 9 expected, one for each'),
        ({'joint_signs': [1.0, 1.0, -1.0]}, 'parameter joint_signs: 3 given, 9 expected'),
        ({'joint_offsets': [9.0] + 8 * [0.0]}, 'a full turn at most expected, |offset| <= 2 pi'),
        ({'muscle': 'deltoid', 'skeleton': 'hip'}, "hip: no link of that name for bone 'scapula'"),
        ({'skeleton': '', 'rest': 'still'}, "parameter rest: 'still' given, only with a rhythm"),
        ({'skeleton': '', 'rhythm': 'mobl', 'rest': 'soon'}, "'still', 3 or 5 numbers in rad"),
        ({'skeleton': '', 'rhythm': 'mobl', 'rest': '32 10.7 -10.3'}, 'parameter rest: scapula: '),
        ({'skeleton': '', 'rhythm': 'mobl', 'rest': '32 11 -10 still'}, 'degrees? rad expected'),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_refused_and_changes_nothing(
    ros: None, changes: dict[str, Any], reason: str
) -> None:
    given = [as_sent(name, value) for name, value in WITH_GIRDLE.items()]
    node = MuscleStatePublisher(parameter_overrides=given)
    before = node._settings
    result = change_parameters(node, **changes)
    assert not result.successful
    assert reason in result.reason
    assert node._settings is before
    node.destroy_node()


def test_a_robot_description_may_come_late_change_and_be_broken(
    girdle_peer: Peer, tmp_path: Path
) -> None:
    given = {'muscle': 'deltoid_girdle', 'skeleton': 'robot_description'}
    names, poses = list_joints(BONES), GIRDLE.pose(Q)
    with NodeProcess(tmp_path / 'node.log', **given) as process:
        girdle_peer.connect(process)
        girdle_peer.send(JOINTS, Q)
        awaited = 'waiting for a URDF on the topic robot_description'
        assert girdle_peer.until(lambda: girdle_peer.values()['rejected: waiting'] == '1')
        assert newest_line(girdle_peer).startswith(awaited)
        description = girdle_peer.create_publisher(String, 'robot_description', LATCHED)
        description.publish(String(data=write_urdf('scapula', BONES)))
        assert girdle_peer.until(lambda: 'humerus_turn_x' in girdle_peer.values()['joints'])
        girdle_peer.send(names, find_values(poses))
        assert girdle_peer.answers(1)
        want = SOLVER.solve_bones(poses).lengths
        np.testing.assert_allclose(newest(girdle_peer, 'band_lengths'), want, 0, EXACT)
        description.publish(String(data='<robot name="broken"><link name="scapula"/>'))
        line = 'robot description not used: parameter skeleton: robot_description: not valid XML'
        assert girdle_peer.until(lambda: line in process.text)
        girdle_peer.send(names, find_values(poses))
        assert girdle_peer.answers(2)
        turned = write_urdf('scapula', BONES).replace('humerus_turn_x', 'humerus_roll')
        description.publish(String(data=turned))
        assert girdle_peer.until(lambda: 'humerus_roll' in girdle_peer.values()['joints'])
        girdle_peer.send([*names[:-1], 'humerus_roll'], find_values(poses))
        assert girdle_peer.answers(3)
        text = process.text
    assert text.count(awaited) == 1
    [refused] = [each for each in text.splitlines() if 'description not used' in each]
    assert refused.endswith('the one before stays')


@pytest.mark.parametrize('rhythm', ['de_groot_brand_2001', '2.5'])
def test_a_rhythm_moves_clavicle_and_scapula_with_what_the_arm_does(
    girdle_peer: Peer, rhythm: str
) -> None:
    convention, rest = JOINT_CONVENTIONS['isb_yxy'], (0.6, 0.1, -0.2, 0.2, 0.25)
    given = {'muscle': 'deltoid_girdle', 'rhythm': rhythm, 'rest': list(rest)}
    with running(girdle_peer, **given, joint_convention='isb_yxy') as node:
        girdle_peer.send(convention.coordinates, (0.3, 1.2, 0.1), (0.1, 0.2, 0.3))
        assert girdle_peer.answers(1)
        moved_by = node._settings.articulations.moved_by[0]
        assert isinstance(moved_by, FollowedGirdle)
        if rhythm in RHYTHMS:
            assert moved_by == FollowedGirdle(convention, RHYTHMS[rhythm], Rest.from_numbers(rest))
        answer = SOLVER.answer(moved_by, (0.3, 1.2, 0.1), (0.1, 0.2, 0.3))
        np.testing.assert_allclose(newest(girdle_peer, 'moment_arms'), answer.moment_arms, 0, EXACT)
        speeds = girdle_peer.got['band_states'][0].velocity
        np.testing.assert_allclose(speeds, answer.lengthening, 0, EXACT)
        values = girdle_peer.values()
        assert rhythm in values['rhythm']
        assert values['rest'].startswith('0.6 0.1 -0.2')


def test_the_rest_of_a_rhythm_may_be_that_of_the_first_still_second(girdle_peer: Peer) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    given = {'muscle': 'deltoid_girdle', 'rhythm': 'mobl', 'rest': 'still'}
    with running(girdle_peer, **given, joint_convention='isb_yxy') as node:
        for k in range(12):
            girdle_peer.send(convention.coordinates, (0.3, 0.2, 0.0), nanoseconds=10**8 * (k + 1))
        assert girdle_peer.answers(2)
        rest = node._settings.articulations.moved_by[0].rest  # type: ignore[attr-defined]
        assert rest.humerus == pytest.approx((0.3, 0.2))
        assert values_of(girdle_peer)['rejected: waiting'] == '10'
        change_parameters(node, markers__rate=10.0)
        girdle_peer.send(convention.coordinates, (0.3, 1.2, 0.0), nanoseconds=2 * 10**9)
        assert girdle_peer.answers(3)  # the rest is kept


@requires('rosbags')
def test_the_shrug_in_the_node_is_the_one_of_a_processed_recording(
    girdle_peer: Peer, shared: Path
) -> None:
    """The recording's own joints are another model's, so angles are taken from its poses."""
    bag = shared / 'recordings' / 'girdle_shrug_mcap'
    angles = recorded_angles(bag)[::40]
    with running(girdle_peer, **WITH_GIRDLE):
        names = recorded_joints(bag)
        assert not set(names) & set(JOINTS[:6])
        girdle_peer.send(names, np.zeros(len(names)))
        assert girdle_peer.until(
            lambda: 'none of the joints ac_protraction' in newest_line(girdle_peer)
        )
        for k, each in enumerate(angles):
            girdle_peer.send(JOINTS, each.tolist(), nanoseconds=k + 1)
        assert girdle_peer.answers(len(angles))
    stamps, refused = np.arange(len(angles)), Refusals()
    chunk = Chunk(stamps, angles, np.zeros_like(angles), stamps, 1.0)
    processed = ValuesSolving(SOLVER, GIRDLE, refused).solve(chunk)
    lengths = np.array([each.data for each in girdle_peer.got['band_lengths']])
    arms = np.array([each.data for each in girdle_peer.got['moment_arms']]).reshape(-1, 9, 9)
    np.testing.assert_allclose(lengths, processed.states.lengths, 0, EXACT)
    np.testing.assert_allclose(arms, processed.arms, 0, EXACT)
    # the clavicle rises: its bands change length, though the arm hardly turns
    assert np.ptp(lengths[:, :2], axis=0).min() > 0.005  # m
