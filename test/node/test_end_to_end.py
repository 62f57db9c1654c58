# SPDX-License-Identifier: Apache-2.0
"""The node over DDS: real recordings in a process of its own, and input that is no good."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from played_bags import Player
from rclpy.parameter import Parameter
from ros_harness import ANSWERS, PATIENCE, TOPICS, NodeProcess, Peer, running
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.errors import LinkedPlaneError
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.recordings.bags.recording import Recording

EXACT = 1e-12  # m: the node computes what the solver computes
NAMES = ('flexion', 'abduction', 'rotation')
EXAMPLES = Path(__file__).parents[2] / 'msg_examples'


def recorded(path: Path, offset: float) -> list[JointState]:
    """Return the joint states of a recording from `offset` s on."""
    from rclpy.serialization import deserialize_message

    return [
        deserialize_message(message.data, JointState)
        for message in Recording.from_bag(path).messages(offset)
    ]


def expected(message: JointState, convention_name: str, names: tuple[str, ...] = ()) -> np.ndarray:
    """Return lengths, moment arms and moment vectors (n, 7) of the pure solver for a message."""
    convention = JOINT_CONVENTIONS[convention_name]
    position = dict(zip(message.name, message.position, strict=True))
    angles = np.array([position[name] for name in names or convention.coordinates])
    state = SOLVER.solve(convention.rotation(angles))
    arms = state.moment_vectors @ convention.axes(angles)
    return np.column_stack([state.lengths, arms, state.moment_vectors])


SOLVER = LinkedPlaneSolver(BroadMuscle.load('deltoid'))


def check_answers(peer: Peer, inputs: list[JointState], convention: str, names=()) -> None:
    """Every input answered once on every topic, in order, equal to the pure solver."""
    assert peer.counts() == dict.fromkeys(ANSWERS, len(inputs))
    for k, message in enumerate(inputs):
        want = expected(message, convention, names)
        lengths, arms, state, wrap, vectors, arm_states = (peer.got[topic][k] for topic in ANSWERS)
        assert state.header.stamp == message.header.stamp
        assert np.abs(np.array(lengths.data) - want[:, 0]).max() <= EXACT
        assert np.abs(np.array(state.position) - want[:, 0]).max() <= EXACT
        assert np.abs(np.array(arms.data).reshape(-1, 3) - want[:, 1:4]).max() <= EXACT
        assert np.abs(np.array(vectors.data).reshape(-1, 3) - want[:, 4:]).max() <= EXACT
        assert len(wrap.data) == len(want)
        assert arm_states.header == state.header
        assert arm_states.position == arms.data


@pytest.mark.parametrize(
    ('bag', 'convention', 'names', 'offset'),
    [
        ('arm_raise', 'flexion_abduction_rotation', (), 0.0),  # the sample recording
        ('abduction_mcap', 'opensim_tsm', (), 0.0),
        ('flexion_sqlite3', 'opensim_tsm', (), 0.0),
        (
            'daily_motion_mcap',
            'isb_yxy',
            ('th_plane_of_elevation', 'th_elevation', 'th_axial_rotation'),
            80.0,
        ),
    ],
)
def test_every_joint_state_of_a_recording_is_answered_once_in_order_on_every_topic(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    ros: None,
    bag: str,
    convention: str,
    names: tuple,
    offset: float,
) -> None:
    peer = Peer(raw=True)  # reading 150 marker arrays a second would keep a core busy
    path = EXAMPLES / bag
    if not path.exists():
        path = request.getfixturevalue('shared') / 'recordings' / bag
    # as the guide advises for a replay in which nothing may be lost
    parameters = {
        'joint_convention': convention,
        'qos_overrides./joint_states.subscription.depth': 10000,
    }
    if names:
        parameters['joint_names'] = f'[{",".join(names)}]'
    inputs = recorded(path, offset)
    with NodeProcess(tmp_path / 'node.log', **parameters) as process:
        peer.connect(process)
        # only the node listens to the player: this peer's own publisher stays silent
        player = Player(path, '--rate', 2, '--start-offset', offset)
        assert peer.until(player.ended)
        assert player.result()[0] == 0
        assert peer.answers(len(inputs)), peer.counts()
    peer.destroy_node()
    check_answers(peer, inputs, convention, names)
    assert 0 < len(peer.got['markers']) <= len(inputs)


BAD = {
    'sizes that differ': (NAMES, (0.1, 0.2), 'sizes', '3 names but 2 positions'),
    'nan': (NAMES, (0.1, math.nan, 0.2), 'not_finite', "'abduction' is nan"),
    'infinity': (NAMES, (0.1, 0.2, math.inf), 'not_finite', "'rotation' is inf"),
    'minus infinity': (NAMES, (-math.inf, 0.2, 0.1), 'not_finite', "'flexion' is -inf"),
    'degrees': (NAMES, (0.0, 90.0, 0.0), 'degrees', "'abduction' is 90: degrees?"),
    'an empty message': ((), (), 'no_joint', 'no joint at all'),
}


@pytest.mark.parametrize('case', BAD)
def test_bad_input_is_explained_and_the_next_message_answered_as_if_nothing_had_happened(
    node: MuscleStatePublisher, peer: Peer, case: str, capfd: pytest.CaptureFixture[str]
) -> None:
    names, positions, reason, line = BAD[case]
    before = peer.send(NAMES, (0.3, 0.2, 0.1), nanoseconds=1)
    assert peer.answers(1)
    peer.send(names, positions, nanoseconds=2)
    after = peer.send(NAMES, (0.1, 0.5, -0.2), (0.1, 0.2, 0.3), nanoseconds=3)
    assert peer.answers(2)
    assert peer.until(lambda: peer.values()['messages received'] == '3')
    check_answers(peer, [before, after], 'flexion_abduction_rotation')
    assert len(peer.got['band_states'][1].velocity) == 9
    assert peer.values()[f'rejected: {reason}'] == '1'
    assert peer.values()['messages answered'] == '2'
    [told] = [text for text in capfd.readouterr().err.splitlines() if 'not used' in text]
    assert line in told


def test_joints_split_over_several_messages_are_answered_once_all_three_are_known(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    peer.send(('flexion',), (0.3,), nanoseconds=1)
    peer.send(('rotation',), (0.1,), nanoseconds=2)
    peer.send(('abduction',), (0.2,), nanoseconds=3)
    peer.send(('flexion',), (0.4,), nanoseconds=4)
    assert peer.until(lambda: peer.values()['messages received'] == '4')
    assert peer.answers(2)
    whole = [JointState(name=NAMES, position=q) for q in ((0.3, 0.2, 0.1), (0.4, 0.2, 0.1))]
    for message, stamp in zip(whole, (3, 4), strict=True):
        message.header.stamp.nanosec = stamp
    check_answers(peer, whole, 'flexion_abduction_rotation')


def test_joints_in_any_order_among_others_are_found_by_name(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    names = ('elbow', 'rotation', 'wrist', 'abduction', 'flexion', 'thumb')
    message = peer.send(names, (math.nan, 0.1, 900.0, 0.2, 0.3, -math.inf))
    assert peer.answers(1)
    check_answers(peer, [message], 'flexion_abduction_rotation')


@pytest.mark.parametrize(
    'velocities', [(0.1, math.nan, 0.2), (0.1,)], ids=['not finite', 'too few']
)
def test_unusable_velocities_cost_only_the_velocities(
    node: MuscleStatePublisher,
    peer: Peer,
    velocities: tuple[float, ...],
    capfd: pytest.CaptureFixture[str],
) -> None:
    message = peer.send(NAMES, (0.1, 0.2, 0.3), velocities)
    assert peer.answers(1)
    check_answers(peer, [message], 'flexion_abduction_rotation')
    assert len(peer.got['band_states'][0].velocity) == 0
    assert 'velocities left out' in capfd.readouterr().err


def example_names() -> list[str]:
    """Return the names of the sample messages."""
    return sorted(path.stem for path in EXAMPLES.glob('*.yaml') if 'expected' not in path.stem)


@pytest.mark.parametrize('name', example_names())
def test_a_sample_message_gets_its_expected_answer(peer: Peer, name: str) -> None:
    message = yaml.safe_load((EXAMPLES / f'{name}.yaml').read_text())
    want = yaml.safe_load((EXAMPLES / f'{name}.expected.yaml').read_text())
    with running(peer, joint_convention=want['joint_convention']):
        peer.send(message['name'], message['position'], message['velocity'])
        assert peer.answers(1)
    lengths, arms, state, wrap, vectors, arm_states = (peer.got[topic][0] for topic in ANSWERS)
    rounding = 1e-11  # m: the files hold twelve decimals
    assert lengths.layout.dim[0].label == 'band:' + ','.join(want['bands'])
    assert arms.layout.dim[1].label == 'coordinate:' + ','.join(want['coordinates'])
    assert [dim.label for dim in vectors.layout.dim] == [lengths.layout.dim[0].label, 'axis:x,y,z']
    assert np.allclose(lengths.data, want['band_lengths'], rtol=0, atol=rounding)
    assert np.allclose(
        np.array(arms.data).reshape(-1, 3), want['moment_arms'], rtol=0, atol=rounding
    )
    by_name = dict(zip(arm_states.name, arm_states.position, strict=True))
    for band, row in zip(want['bands'], want['moment_arms'], strict=True):
        for coordinate, arm in zip(want['coordinates'], row, strict=True):
            assert by_name[f'{band}/{coordinate}'] == pytest.approx(arm, rel=0, abs=rounding)
    assert np.allclose(state.velocity, want['lengthening_velocity'], rtol=0, atol=rounding)
    assert list(wrap.data) == [
        ('WRAPPED', 'CLEAR', 'MISSED', 'INSIDE').index(wrap) for wrap in want['wrap_states']
    ]


def test_the_topics_and_their_types_are_those_promised(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    promised = {
        '/deltoid/band_states': ['sensor_msgs/msg/JointState'],
        '/deltoid/moment_arm_states': ['sensor_msgs/msg/JointState'],
        '/deltoid/wrap_states': ['std_msgs/msg/UInt8MultiArray'],
        '/deltoid/markers': ['visualization_msgs/msg/MarkerArray'],
        '/diagnostics': ['diagnostic_msgs/msg/DiagnosticArray'],
        '/deltoid/band_lengths': ['std_msgs/msg/Float64MultiArray'],
        '/deltoid/moment_arms': ['std_msgs/msg/Float64MultiArray'],
        '/deltoid/moment_vectors': ['std_msgs/msg/Float64MultiArray'],
    }
    assert {f'/deltoid/{topic}' for topic in TOPICS} | {'/diagnostics'} == set(promised)
    assert peer.until(lambda: promised.items() <= dict(node.get_topic_names_and_types()).items())


MODEL = (Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml').read_text()
BROKEN_MODELS = {
    'missing key': ('reference_normal: [-0.83, 0.29, -0.47]', '', 'reference_normal: missing'),
    'wrong shape': ('[-0.83, 0.29, -0.47]', '[-0.83, 0.29]', 'a list of 3 numbers expected'),
    'nan': ('[-0.83, 0.29, -0.47]', '[-0.83, .nan, -0.47]', 'reference_normal[1]: a finite number'),
    'unknown key': ('name: deltoid', 'name: deltoid\ncolour: red', 'colour: unknown key'),
    'radius below zero': ('[-14.833320, -16.211523, 2.679743, -9.323871, 37.294653]',
                          '[-5.0]', 'sphere.radius: -0.005 m for band anterior_1'),
    'normal along a band': ('[-0.83, 0.29, -0.47]', '{along}', 'parallel to the first band'),
}  # fmt: skip


def broken_model(folder: Path, case: str) -> Path:
    """Return the file of a model that is broken in one way."""
    old, new, _ = BROKEN_MODELS[case]
    along = (SOLVER.muscle.insertions - SOLVER.muscle.origins)[0].tolist()
    path = folder / 'broken.yaml'
    path.write_text(MODEL.replace(old, new.format(along=along)))
    return path


@pytest.mark.parametrize('case', BROKEN_MODELS)
def test_the_node_refuses_a_broken_model(ros: None, tmp_path: Path, case: str) -> None:
    path = broken_model(tmp_path, case)
    with pytest.raises(LinkedPlaneError, match=re.escape(str(path))) as caught:
        MuscleStatePublisher(parameter_overrides=[Parameter('muscle', value=str(path))])
    assert '\n' not in str(caught.value)
    assert BROKEN_MODELS[case][2] in str(caught.value)


def test_a_node_that_is_refused_ends_with_one_line_without_a_traceback(tmp_path: Path) -> None:
    path = broken_model(tmp_path, 'nan')
    process = NodeProcess(tmp_path / 'node.log', muscle=path)
    assert process.process.wait(PATIENCE) == 1
    [line] = process.text.splitlines()
    assert str(path) in line
