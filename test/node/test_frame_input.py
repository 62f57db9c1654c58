# SPDX-License-Identifier: Apache-2.0
"""Poses of the bones in /tf, live: the same answers as `linkedplane process` gives a recording."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from bags import STORE, Kept, Sent, read_csv, read_messages, write_bag
from geometry_msgs.msg import TransformStamped
from pose_bags import TF, beyond, tf_message, wandering
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from reference import Array
from ros_harness import Peer, running
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from linkedplane_ros import Skeleton
from linkedplane_ros.node.articulated_frames import tf_message_class
from linkedplane_ros.node.frame_input import FrameInput
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task

EXACT = 1e-12  # m
RECORDINGS = 'girdle_abduction_mcap', 'girdle_shrug_mcap'
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STILL = np.eye(3), np.zeros(3)


@pytest.fixture(autouse=True)
def tf2(ros: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in for tf2_msgs, which PyPI has not: a message of one frame each."""
    if importlib.util.find_spec('tf2_msgs') is not None:
        return
    stand_in = ModuleType('tf2_msgs.msg')
    stand_in.TFMessage = TransformStamped  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, 'tf2_msgs', ModuleType('tf2_msgs'))
    monkeypatch.setitem(sys.modules, 'tf2_msgs.msg', stand_in)
    take = FrameInput.take

    def take_one(self: FrameInput, message: Any, topic: str = '/tf') -> None:
        one = isinstance(message, TransformStamped)
        take(self, SimpleNamespace(transforms=[message]) if one else message, topic)

    monkeypatch.setattr(FrameInput, 'take', take_one)


def tf_messages(sent: Sent) -> list[Any]:
    """Return what is to be published of a message of /tf: it, or each of its frames."""
    kind = tf_message_class()
    if kind is not TransformStamped:
        return [deserialize_message(sent[3], kind)]
    return [
        deserialize_message(bytes(STORE.serialize_cdr(each, each.__msgtype__)), kind)
        for each in STORE.deserialize_cdr(sent[3], TF).transforms  # type: ignore[attr-defined]
    ]


@contextmanager
def fed(sent: Sequence[Sent], **parameters: Any) -> Iterator[tuple[MuscleStatePublisher, Any]]:
    """Give a node that has been fed by these messages, and what its muscle has published."""
    parameters = {'input': 'tf', 'markers.enabled': False, **parameters}
    node = MuscleStatePublisher(
        parameter_overrides=[Parameter(name, value=value) for name, value in parameters.items()]
    )
    [muscle] = node._muscles
    real = muscle.topics
    muscle.topics = {name: Kept() for name in real}
    try:
        for topic, kind, _, data in sent:
            if kind == TF:
                node._frames.take(STORE.deserialize_cdr(data, kind), topic)
        yield node, muscle
    finally:
        muscle.topics = real
        node.destroy_node()


def numbers(muscle: Any, topic: str) -> Array:
    """Return the data of all messages on a topic of arrays (m, size)."""
    kept = muscle.topics[topic].got
    return np.array([deserialize_message(each, Float64MultiArray).data for each in kept])


def processed(source: Path, out: Path, options: Options) -> dict[str, Array]:
    """Return the columns of a processed recording."""
    report = run_task(Task(source, out, options))
    assert report.fault == ''
    _, names, values = read_csv(out)
    return dict(zip(names, values.T, strict=True))


def columns_of(columns: dict[str, Array], start: str) -> Array:
    return np.column_stack([each for name, each in columns.items() if name.startswith(start)])


GIRDLE = {'muscle': 'deltoid_girdle', 'skeleton': 'shoulder_girdle'}
CASES = [
    ({'muscle': 'deltoid_girdle'}, Options(muscle='deltoid_girdle', input='tf')),
    (
        {**GIRDLE, 'bone_links': ['thorax:=thorax']},
        Options(**GIRDLE, input='tf', bone_links=['thorax:=thorax']),
    ),
    (
        {'joint_convention': 'isb_yxy'},
        Options(convention='isb_yxy', humerus='humerus', scapula='scapula'),
    ),
]


@pytest.mark.parametrize('recording', RECORDINGS)
@pytest.mark.parametrize(('parameters', 'options'), CASES)
def test_both_recordings_are_answered_as_they_are_processed(
    ros: None,
    shared: Path,
    tmp_path: Path,
    recording: str,
    parameters: dict[str, Any],
    options: Options,
) -> None:
    bag = shared / 'recordings' / recording
    wanted = processed(bag, tmp_path / 'o.csv', options)
    with fed(read_messages(bag), **parameters) as (_, muscle):
        for topic in ('band_lengths', 'moment_arms', 'moment_vectors'):
            found = numbers(muscle, topic)
            expected = columns_of(wanted, f'{topic}/')
            assert found.shape == expected.shape
            np.testing.assert_allclose(found, expected, rtol=0, atol=EXACT)
        states = [
            deserialize_message(each, JointState) for each in muscle.topics['band_states'].got
        ]
        stamps = [each.header.stamp.sec + 1e-9 * each.header.stamp.nanosec for each in states]
        np.testing.assert_allclose(stamps, wanted['time'], rtol=0, atol=1e-6)
        rates = columns_of(wanted, 'lengthening/')
        if 'muscle' not in parameters:
            assert np.isnan(rates).all()
            assert not any(len(each.velocity) for each in states)
            return
        np.testing.assert_allclose(numbers(muscle, 'wrenches'), columns_of(wanted, 'wrenches/'),
                                   rtol=0, atol=1e-10)  # fmt: skip
        assert len(states[0].velocity) == 0
        found = np.array([each.velocity for each in states[1:]])
        np.testing.assert_allclose(found, rates[1:], rtol=0, atol=1e-9)


def girdle_at(q: Array) -> dict[str, tuple[Array, Array]]:
    """Return the frames of the bundled girdle's links in the thorax."""
    girdle = Skeleton.load('shoulder_girdle')
    names = 'thorax', 'clavicle', 'scapula', 'humerus'
    return {'thorax': STILL, **Skeleton(girdle.tree, names, names).pose(q)}


def frames_at(k: int, parent: str = 'lab') -> list[tuple[str, str, tuple[Array, Array]]]:
    """Return the frames of a girdle that moves."""
    q = np.array([0.1, 0.2, 0.0, 0.1, 0.0, 0.1, 0.3, 0.5 + 0.1 * k, 0.2])
    return [(parent, name, beyond(wandering(k), at)) for name, at in girdle_at(q).items()]


def test_a_node_answers_over_dds_each_stamp_once_with_static_frames_that_came_before(
    ros: None, tmp_path: Path
) -> None:
    static = tf_message(0, [('marker', 'humerus', STILL), ('map', 'lab', STILL)], '/tf_static')
    sent = [static]
    for k in range(8):  # in several messages, the humerus behind a frame that does not move
        *others, (parent, _, at) = frames_at(k)
        sent += [tf_message(k, others), tf_message(k, [(parent, 'marker', at)])]
    wanted = processed(
        write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv', Options(**GIRDLE, input='tf')
    )
    peer = Peer('deltoid_girdle')
    latched = peer.create_publisher(tf_message_class(), '/tf_static', LATCHED)
    moving = peer.create_publisher(tf_message_class(), '/tf', QoSProfile(depth=100))
    for message in tf_messages(static):  # before the node is there
        latched.publish(message)
    with running(peer, **GIRDLE, input='tf') as node:
        assert peer.until(lambda: moving.get_subscription_count() > 0)
        assert peer.until(lambda: 'humerus' in node._frames._order[0].tree)
        for each in sent[1:]:
            for message in tf_messages(each):
                moving.publish(message)
        assert peer.answers(8), peer.counts()
        found = np.array([each.data for each in peer.got['band_lengths']])
    np.testing.assert_allclose(found, columns_of(wanted, 'band_lengths/'), rtol=0, atol=EXACT)
    assert set(peer.counts().values()) == {8}


def test_a_slower_frame_counts_as_it_is_until_it_is_too_old(ros: None) -> None:
    sent = []
    for k in range(12):
        hung = {child: each for each in frames_at(k) for child in [each[1]]}
        slow = [hung['clavicle']] if k % 4 == 0 else []
        sent.append(tf_message(k, [hung['scapula'], hung['humerus'], *slow]))
    parameters = {'muscle': 'deltoid_girdle', 'rest_frames': ['clavicle:=first']}
    with fed(sent, **parameters) as (_, muscle):
        assert muscle.tally.answered == 11  # the last one still waits for its clavicle
        assert not muscle.tally.rejected
    with fed(sent, **parameters, joint_timeout=0.015) as (_, muscle):
        # 10 ms old is not too old; 20 and 30 ms are
        assert (muscle.tally.answered, dict(muscle.tally.rejected)) == (6, {'stale': 5})
        assert "frame 'clavicle' is " in muscle.tally.last_rejection


def test_a_stamp_is_answered_once_however_often_it_comes(ros: None) -> None:
    sent = [tf_message(k, frames_at(k)) for k in (0, 0, 1, 1, 1, 2)]
    with fed(sent, muscle='deltoid_girdle') as (_, muscle):
        assert (muscle.tally.received, muscle.tally.answered) == (3, 3)


@pytest.mark.parametrize('case', ['apart', 'loop', 'never', 'not_unit', 'far', 'not_finite'])
def test_frames_that_are_no_poses_are_counted_by_reason_in_one_line(
    ros: None, case: str, capfd: pytest.CaptureFixture[str]
) -> None:
    sent = []
    for k in range(4):
        hung = frames_at(k)
        if case == 'apart':
            hung = [each if each[1] != 'clavicle' else ('map', *each[1:]) for each in hung]
        elif case == 'loop':
            hung = [each if each[1] != 'clavicle' else ('clavicle', *each[1:]) for each in hung]
        elif case == 'never':
            hung = [each for each in hung if each[1] != 'clavicle']
        elif case == 'far':
            hung = [(parent, child, (R, 1e3 * t)) for parent, child, (R, t) in hung]
        elif case == 'not_finite':
            hung = [(parent, child, (R, np.nan * t)) for parent, child, (R, t) in hung]
        sent.append(tf_message(k, hung))
        if case == 'not_unit':
            sent[-1] = (*sent[-1][:3], sent[-1][3][:-32] + bytes(32))
    reason = {'never': 'incomplete'}.get(case, case)
    with fed(sent, muscle='deltoid_girdle') as (_, muscle):
        assert muscle.tally.answered == 0
        assert muscle.tally.rejected[reason] >= 3
        assert set(muscle.tally.rejected) == {reason}
    error = capfd.readouterr().err
    assert error.count('pose not used: ') == 1  # throttled
    line = {
        'apart': "clavicle in 'map'; poses in one frame expected",
        'loop': "frames hang in a loop: 'clavicle' on 'clavicle'",
        'never': "no pose of clavicle; frames met: 'humerus', 'lab', 'scapula', 'thorax'",
        'not_unit': 'unit length expected',
        'far': '3 m at most expected: mm?',
        'not_finite': 'is not finite',
    }[case]
    assert line in error


def test_without_the_messages_of_tf_the_package_is_named(
    ros: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = MuscleStatePublisher()
    try:
        monkeypatch.setitem(sys.modules, 'tf2_msgs', None)
        monkeypatch.delitem(sys.modules, 'tf2_msgs.msg', raising=False)
        [result] = node.set_parameters([Parameter('input', value='tf')])
        assert not result.successful
        assert result.reason.startswith('parameter input: tf needs the package tf2_msgs')
    finally:
        node.destroy_node()


def test_the_skeleton_s_misfit_is_in_the_diagnostics(ros: None) -> None:
    q = np.zeros(9)
    q[7] = 2.9  # beyond the elevation's limit of 2.53
    sent = [tf_message(0, [('lab', *each) for each in girdle_at(q).items()])]
    with fed(sent, **GIRDLE) as (_, muscle):
        assert muscle.tally.answered == 1
        assert muscle.tally.misfit is not None
        assert np.degrees(2.9 - 2.53) == pytest.approx(muscle.tally.misfit[0], abs=1e-4)
        status = muscle.build_status({})
        assert 'the skeleton misses the measured poses by 21.2 deg' in status.message


def test_the_input_is_changed_while_the_node_runs(ros: None) -> None:
    frames = [tf_message(k, frames_at(k)) for k in range(3)]
    with fed(frames, muscle='deltoid_girdle') as (node, muscle):
        assert muscle.tally.answered == 3
        [result] = node.set_parameters([Parameter('input', value='joint_states')])
        assert result.successful, result.reason
        node._answer(JointState(name=['flexion', 'abduction', 'rotation'], position=[0.1] * 3))
        assert muscle.tally.answered == 4
        assert not node._frames._subscriptions
        [result] = node.set_parameters([Parameter('input', value='tf')])
        assert result.successful, result.reason
        assert len(node._frames._subscriptions) == 2
        node._answer(JointState(name=['flexion', 'abduction', 'rotation'], position=[0.1] * 3))
        assert muscle.tally.answered == 4
        node._frames.take(STORE.deserialize_cdr(frames[0][3], TF))
        assert muscle.tally.answered == 5


@pytest.mark.parametrize(
    ('name', 'value', 'line'),
    [
        ('rest_frames', ['sternum:=first'], "'sternum' has no frame"),
        ('rest_frames', ['nowhere'], "'nowhere' given; coincide, first"),
        ('bone_links', ['clavicle'], 'BONE:=LINK expected'),
        ('skeleton', 'hip', "no link of that name for bone 'scapula'"),
        ('input', 'mocap', 'one of joint_states, tf expected'),
    ],
)
def test_what_cannot_be_is_refused_and_the_frames_go_on(
    ros: None, name: str, value: Any, line: str
) -> None:
    frames = [tf_message(k, frames_at(k)) for k in range(2)]
    with fed(frames[:1], muscle='deltoid_girdle') as (node, muscle):
        reader = node._frames._order[0]
        [result] = node.set_parameters([Parameter(name, value=value)])
        assert not result.successful
        assert line in result.reason
        [result] = node.set_parameters([Parameter('markers.rate', value=5.0)])
        assert result.successful
        assert node._frames._order == [reader]  # with what it knows of the frames at rest
        node._frames.take(STORE.deserialize_cdr(frames[1][3], TF))
        assert muscle.tally.answered == 2
