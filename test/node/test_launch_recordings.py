# SPDX-License-Identifier: Apache-2.0
"""The launch files play a recording to where the nodes listen, or say what does not meet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import played_bags
import pytest
from bag_metadata import write_metadata
from launch_stand_ins import (
    list_started,
)
from launched import BOTH, DELTOID, played
from optional import requires

from linkedplane_ros.errors import LinkedPlaneError


def test_a_topic_that_is_not_recorded_is_named(tmp_path: Path) -> None:
    bag = write_metadata(tmp_path / 'bag', '/joint_states')
    with pytest.raises(LinkedPlaneError, match='JointState on /typo in it, but /joint_states '):
        list_started(DELTOID, bag=bag, bag_topic='/typo')


@pytest.mark.parametrize(
    ('arguments', 'topic'),
    [
        ({}, '/joint_states'),
        ({'namespace': 'left'}, '/left/joint_states'),
        ({'namespace': '/left/'}, '/left/joint_states'),
        ({'joint_states': '/human/joint_states'}, '/human/joint_states'),
        ({'joint_states': 'human', 'namespace': 'left'}, '/left/human'),
        ({'ros_namespace': '/robot'}, '/robot/joint_states'),
        ({'ros_namespace': 'robot', 'namespace': 'left'}, '/robot/left/joint_states'),
        ({'ros_namespace': 'robot', 'namespace': '/left'}, '/left/joint_states'),
        ({'ros_remaps': [('joint_states', '/all')], 'joint_states': 'mine'}, '/all'),
        ({'ros_remaps': [('/left/joint_states', '/all')], 'namespace': 'left'}, '/all'),
        ({'ros_remaps': [('/other', '/all')]}, '/joint_states'),
        ({'joint_states': '~/own', 'namespace': 'left'}, '/left/muscle_state_publisher/own'),
    ],
)
def test_a_recording_is_played_to_the_topic_of_the_node(
    tmp_path: Path, arguments: dict[str, Any], topic: str
) -> None:
    bag = write_metadata(tmp_path / 'my walk', '/recorded', notes='std_msgs/msg/String')
    assert played(DELTOID, bag=bag, **arguments) == [
        'ros2', 'bag', 'play', '--loop', bag, '--delay', '5.0',
        '--remap', f'/recorded:={topic}',
    ]  # fmt: skip


@pytest.mark.parametrize(
    ('topics', 'chosen', 'rules'),
    [
        (['/joint_states', '/deltoid/band_states'], '', ['/joint_states:=/arm']),
        (['/joint_states', '/arm'], '', []),
        (['/a', '/b'], '/b', ['/b:=/arm']),
        (['/a', '/b'], 'b', ['/b:=/arm']),
    ],
)
def test_of_several_topics_of_joint_states_one_is_played_to_the_node(
    tmp_path: Path, topics: list[str], chosen: str, rules: list[str]
) -> None:
    bag = write_metadata(tmp_path / 'bag', *topics)
    command = played(DELTOID, bag=bag, bag_topic=chosen, joint_states='/arm', delay='0')
    assert command == [
        'ros2',
        'bag',
        'play',
        '--loop',
        bag,
        *(['--remap', *rules] if rules else []),
    ]


def test_a_topic_without_messages_is_not_played(tmp_path: Path) -> None:
    topics = '/joint_states', '/human/joint_states'
    bag = write_metadata(tmp_path / 'bag', *topics, empty=['/joint_states'])
    assert played(DELTOID, bag=bag)[-1] == '/human/joint_states:=/joint_states'


def test_a_recordings_path_is_as_the_user_types_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('HOME', str(tmp_path))
    monkeypatch.chdir(tmp_path)
    bag = write_metadata(tmp_path / 'bag', '/joint_states')
    assert played(DELTOID, bag='~/bag')[4] == bag
    assert played(DELTOID, bag='bag')[4] == 'bag'


def test_a_recordings_file_alone_is_played(tmp_path: Path) -> None:
    file = tmp_path / 'walk.mcap'
    file.touch()
    assert '/a:=/joint_states' in played(DELTOID, bag=str(file), bag_topic='/a')


@requires('rosbags')
def test_the_topic_in_a_recordings_file_is_found(tmp_path: Path) -> None:
    sent = played_bags.joint_states('/recorded')
    folder = played_bags.write_bag(tmp_path / 'bag', sent, empty=['/joint_states'])
    [file] = folder.glob('*.mcap')
    assert played(DELTOID, bag=str(file))[-1] == '/recorded:=/joint_states'


@requires('rosbags')
@pytest.mark.parametrize(
    ('arguments', 'rules'),
    [
        ({}, ['/arm/joint_states:=/joint_states']),
        ({'joint_names': '[elbow, flexion, rotation]'}, ['/arm/joint_states:=/joint_states']),
        ({'joint_states': '/arm/joint_states'}, []),
    ],
)
def test_the_topic_that_has_the_joints_is_played(
    tmp_path: Path, arguments: dict[str, str], rules: list[str]
) -> None:
    arm, hand = (
        played_bags.joint_states(topic) for topic in ('/arm/joint_states', '/joint_states')
    )
    bag = str(played_bags.write_bag(tmp_path / 'bag', [*arm, *hand[:1]]))  # flexion alone
    command = played(DELTOID, bag=bag, **arguments)
    assert command[7:] == (['--remap', *rules] if rules else [])


@requires('rosbags')
def test_where_no_topic_has_the_joints_each_is_named_with_its_own(tmp_path: Path) -> None:
    sent = [*played_bags.joint_states('/arm'), *played_bags.joint_states('/hand')]
    bag = str(played_bags.write_bag(tmp_path / 'bag', sent))
    fault = 'no topic has the joints a, b, c; bag_topic:=/arm: flexion, .*; bag_topic:=/hand: flex'
    with pytest.raises(LinkedPlaneError, match=fault):
        list_started(DELTOID, bag=bag, joint_names='[a, b, c]')


@pytest.mark.parametrize(
    ('topics', 'others', 'fault'),
    [
        ([], {'notes': 'std_msgs/msg/String'}, r'no sensor_msgs/msg/JointState .* /notes'),
        ([], {}, 'no sensor_msgs/msg/JointState .* nothing'),
        (['/a', '/b'], {}, 'joint states on /a, /b; choose one with bag_topic:='),
    ],
)
def test_a_recording_that_does_not_reach_the_node_is_refused(
    tmp_path: Path, topics: list[str], others: dict[str, str], fault: str
) -> None:
    with pytest.raises(LinkedPlaneError, match=fault):
        list_started(DELTOID, bag=write_metadata(tmp_path / 'bag', *topics, **others))


@pytest.mark.parametrize('text', ['', 'a: b', 'rosbag2_bagfile_information: 1', '['])
def test_a_folder_that_is_no_recording_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / 'metadata.yaml').write_text(text)
    with pytest.raises(LinkedPlaneError, match='not the metadata of a rosbag2'):
        list_started(DELTOID, bag=str(tmp_path))


@pytest.mark.parametrize(
    ('arguments', 'clock'),
    [
        ({}, False),
        ({'use_sim_time': 'true'}, True),
        ({'use_sim_time': 'false', 'global_params': [('use_sim_time', True)]}, False),
        ({'global_params': [('use_sim_time', True)]}, True),
        ({'global_params': ['of_all.yaml', ('scale', '1')]}, True),
        ({'global_params': ['of_all.yaml', ('use_sim_time', False)]}, False),
    ],
)
def test_under_sim_time_the_recording_brings_its_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: dict[str, Any], clock: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'of_all.yaml').write_text('/**: {ros__parameters: {use_sim_time: true}}')
    bag = write_metadata(tmp_path / 'bag', '/joint_states')
    assert ('--clock' in played(DELTOID, bag=bag, **arguments)) == clock


@pytest.mark.parametrize(
    ('topics', 'arguments', 'rules'),
    [
        (['/left/joint_states', '/right/joint_states'], {}, []),
        (['/l', '/r'], {'left_joint_states': '/l', 'right_joint_states': '/r'}, []),
        (
            ['/both'],
            {'left_joint_states': '/joint_states', 'right_joint_states': '/joint_states'},
            ['--remap', '/both:=/joint_states'],
        ),
    ],
)
def test_one_recording_is_played_to_both_shoulders(
    tmp_path: Path, topics: list[str], arguments: dict[str, str], rules: list[str]
) -> None:
    bag = write_metadata(tmp_path / 'bag', *topics)
    command = played(BOTH, bag=bag, use_sim_time='true', **arguments)
    assert command == ['ros2', 'bag', 'play', '--loop', bag, '--delay', '5.0', '--clock', *rules]


@pytest.mark.parametrize('arguments', [{}, {'bag_topic': '/joint_states'}])
def test_a_recording_that_reaches_neither_or_one_shoulder_is_refused(
    tmp_path: Path, arguments: dict[str, str]
) -> None:
    bag = write_metadata(tmp_path / 'bag', '/joint_states', '/left/joint_states')
    with pytest.raises(
        LinkedPlaneError, match='listen on /left/joint_states and /right/joint_states'
    ):
        list_started(BOTH, bag=bag, **arguments)
