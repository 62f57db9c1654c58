# SPDX-License-Identifier: Apache-2.0
"""The launch files with the real launch: started, answered, stopped by Ctrl-C."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from posixpath import join

import pytest
from bag_metadata import write_metadata
from launch_runs import TOP, Launch, requires_executable, write_prefix
from optional import requires
from ros_harness import Peer
from sensor_msgs.msg import JointState

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.joints.conventions import THESIS_CONVENTION

pytestmark = requires('launch_ros')
NAMES = ('flexion', 'abduction', 'rotation')
POSE = (0.3, 0.2, 0.1)  # rad
OUTER = """<launch>
  <group>
    <push-ros-namespace namespace="robot"/>
    <set_parameter name="use_sim_time" value="true"/>
    <include file="{file}">
      <arg name="bag" value="{bag}"/>
      <arg name="namespace" value="arm"/>
      <arg name="joint_states" value="human/joint_states"/>
    </include>
  </group>
</launch>
"""
PARAMETERS = """
/**:
  ros__parameters: {joint_names: [p, q, r]}
left:
  muscle_state_publisher:
    ros__parameters: {joint_names: [a, b, c], frame_id: elsewhere}
"""


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., Launch]]:
    """Start launch files; whatever happens, nothing of them is left behind."""
    prefix = write_prefix(tmp_path / 'prefix with a space')
    started: list[Launch] = []

    def start(file: Path | str, *arguments: str) -> Launch:
        started.append(Launch(prefix, file, *arguments))
        return started[-1]

    yield start
    for launch in started:
        launch.end()


@contextmanager
def peer_of(topic: str, namespace: str = '') -> Iterator[Peer]:
    """Feed and read a node in a namespace."""
    peer = Peer(f'{namespace}/deltoid', topic=topic)
    try:
        yield peer
    finally:
        peer.destroy_node()


def answer(launch: Launch, namespace: str, names: Sequence[str] = NAMES) -> JointState:
    """Return what the node in a namespace answers, by its bands, to a joint state."""
    with peer_of(join(namespace, 'joint_states'), namespace.rstrip('/')) as peer:

        def answered() -> bool:
            peer.send(names, POSE)
            return bool(peer.got['band_states']) or launch.process.poll() is not None

        peer.until(answered)
        assert peer.got['band_states'], launch.text
        return peer.got['band_states'][0]


def stops_by_interrupt(launch: Launch, count: int) -> None:
    """Press Ctrl-C: so many nodes end well, and no process is left."""
    assert launch.process.poll() is None, launch.text
    status = launch.interrupt()
    # asyncio may miss a status, and then says so: unknown child process, 255
    ends = r'muscle_state_publisher-\d+\]: process has (?:finished cleanly|died .*, exit code 255)'
    assert len(re.findall(ends, launch.text)) == count, launch.text
    assert launch.left_over() == []
    assert status == 0, launch.text
    for words in ('Traceback', 'deprecated', 'failed to terminate'):
        assert words not in launch.text


@pytest.mark.parametrize('namespace', ['', 'arm', '/arm/'])
def test_one_shoulder_starts_answers_and_stops(
    start: Callable[..., Launch], ros: None, namespace: str
) -> None:
    launch = start('deltoid.launch.py', f'namespace:={namespace}', 'frame_id:=blade')
    assert answer(launch, f'/{namespace.strip("/")}').header.frame_id == 'blade'
    stops_by_interrupt(launch, 1)


def test_arguments_of_every_type_reach_the_node(start: Callable[..., Launch], ros: None) -> None:
    launch = start(
        'deltoid.launch.py',
        'joint_names:=[a, b, c]',
        'joint_signs:=[1.0, -1.0, 1.0]',
        'joint_offsets:=[0, 0.1, 0.0]',
        'markers.enabled:=false',
        'markers.points:=9',
        'markers.rate:=10',
        'scale:=1.05',
        'use_sim_time:=true',
        'muscle:=[deltoid, deltoid_ackland2008]',
    )
    rotation = THESIS_CONVENTION.rotation((POSE[0], 0.1 - POSE[1], POSE[2]))
    expected = LinkedPlaneSolver(BroadMuscle.load('deltoid').scaled('1.05')).solve(rotation)
    assert list(answer(launch, '/', names='abc').position) == pytest.approx(expected.lengths)
    stops_by_interrupt(launch, 1)


def test_both_shoulders_start_answer_and_stop(
    start: Callable[..., Launch], ros: None, tmp_path: Path
) -> None:
    params_file = tmp_path / 'params.yaml'
    params_file.write_text(PARAMETERS)
    launch = start('both_shoulders.launch.py', 'parent_frame:=', f'params_file:={params_file}')
    assert answer(launch, '/left', names='abc').header.frame_id == 'left_scapula'
    assert answer(launch, '/right', names='pqr').header.frame_id == 'right_scapula'
    stops_by_interrupt(launch, 2)


@requires_executable('tf2_ros', 'static_transform_publisher')
def test_both_shoulders_hang_on_the_torso(start: Callable[..., Launch], ros: None) -> None:
    launch = start('both_shoulders.launch.py')
    for side in ('/left', '/right'):
        answer(launch, side)
    stops_by_interrupt(launch, 2)


def test_a_recording_reaches_a_node_in_a_namespace_that_another_launch_file_pushes(
    start: Callable[..., Launch], ros: None, tmp_path: Path
) -> None:
    bag = write_metadata(tmp_path / 'a bag', '/recorded', notes='std_msgs/msg/String')
    outer = tmp_path / 'outer.launch.xml'
    outer.write_text(OUTER.format(file=TOP / 'launch' / 'deltoid.launch.py', bag=bag))
    launch = start(outer)
    with peer_of('/unused', '/robot/arm') as peer:
        peer.until(lambda: bool(peer.got['band_states'] or launch.process.poll() is not None))
        assert peer.got['band_states'], launch.text
    played = json.loads((launch.log.parent / 'bag_play.json').read_text())
    assert played['remap'] == ['/recorded:=/robot/arm/human/joint_states']
    assert (played['bag_path'], played['loop'], played['delay']) == (bag, True, 5.0)
    assert played['clock'] == 40  # SetParameter says so to all nodes
    stops_by_interrupt(launch, 1)


@pytest.mark.parametrize(
    ('file', 'argument', 'line'),
    [
        ('deltoid.launch.py', 'side:=up', "parameter side: 'up' given, one of right, left"),
        ('deltoid.launch.py', 'params_file:=none.yaml', 'params_file: none.yaml: No such file'),
        ('deltoid.launch.py', 'joint_signs:=[1, 2, 1]', 'parameter joint_signs: '),
        ('deltoid.launch.py', 'bag:=none', 'bag: none: no such file or folder'),
        ('both_shoulders.launch.py', 'right_joint_names:=[a, b', 'joint_names: [a, b given, which'),
    ],
)
def test_a_wrong_argument_is_one_line_and_nothing_starts(
    start: Callable[..., Launch], file: str, argument: str, line: str
) -> None:
    launch = start(file, argument)
    assert launch.wait() == 1
    [fault] = [each for each in launch.text.splitlines() if 'ERROR' in each]
    assert line in fault
    assert 'Traceback' not in launch.text
    assert 'process started' not in launch.text
