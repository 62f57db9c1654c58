# SPDX-License-Identifier: Apache-2.0
"""What stands beside the joint states in an MCAP file cannot break them, and is carried over.

The `mcap` library writes the files, and judges what is in them and in the outputs.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from bags import exit_status, read_csv, refusal_line
from mcap_files import JOINT_STATE, JOINT_STATE_TEXT, Schema, Topic, read_mcap, write_mcap
from optional import requires
from rosbags.rosbag2 import Reader

from linkedplane_ros.processing.reading import read_processed

pytestmark = requires('mcap', 'zstandard')  # writes and judges the files

OWN = 'my_msgs/msg/Own'
BESIDE = {
    'no definition': [Topic('/own', Schema(OWN, 'ros2msg', b''))],
    'no encoding': [Topic('/own', Schema(OWN, '', b''))],
    'incomplete': [Topic('/own', Schema(OWN, 'ros2msg', b'Other other\n'))],
    'bytes': [Topic('/own', Schema(OWN, 'ros2msg', bytes(range(256))))],
    'IDL cut': [Topic('/own', Schema(OWN, 'ros2idl', b'module my_msgs { module msg {'))],
    'OMG IDL': [Topic('/own', Schema('my::msg::Own', 'omgidl', b'struct Own { long a; };'))],
    'service': [
        Topic('/srv/_service_event', Schema('p/srv/Do_Event', 'ros2msg', b'bool a\n---\nbool b'))
    ],
    'action': [
        Topic('/go/_action/feedback', Schema('p/action/Go_FeedbackMessage', 'ros2msg', b'\n---\n')),
        Topic('/go/_action/status', Schema('action_msgs/msg/GoalStatusArray', 'ros2msg', b'')),
    ],
    'JSON': [Topic('/own', Schema('own', 'jsonschema', b'{}'), 'json')],
    'protobuf': [Topic('/own', Schema('own.Own', 'protobuf', b'\n\0\xff'), 'protobuf')],
    'no schema': [Topic('/own', None, 'json')],
    'unknown encoding': [Topic('/own', Schema(OWN, 'unknown', b''))],
    'two channels': [Topic('/own', Schema(OWN)), Topic('/own', Schema(OWN), 'cdr', {'a': 'b'})],
    'two types': [Topic('/own', Schema(OWN)), Topic('/own', Schema('my_msgs/msg/Else'))],
    'two definitions': [Topic('/own', Schema(OWN)), Topic('/else', Schema(OWN, text=b'bool b'))],
    'a definition that is not ROS': [
        Topic('/own', Schema('std_msgs/msg/Header', 'ros2msg', b'int32 odd'))
    ],
    'another type on our topic': [Topic('/joint_states', Schema(OWN))],
    'JSON on our topic': [Topic('/joint_states', Schema(encoding='jsonschema'), 'json')],
}
HEAD = JOINT_STATE_TEXT.split(b'=' * 80)[0]
OURS = {
    'ROS 1 spelling': Topic('/joint_states', Schema('sensor_msgs/JointState')),
    'empty': Topic('/joint_states', Schema(text=b'')),
    'no encoding': Topic('/joint_states', Schema(encoding='', text=b'')),
    'bytes': Topic('/joint_states', Schema(text=b'\xff\xfe = no definition')),
    'incomplete': Topic('/joint_states', Schema(text=HEAD)),
    'a field of the header spoilt': Topic(
        '/joint_states', Schema(text=JOINT_STATE_TEXT.replace(b' stamp', b' stanp'))
    ),
    'a type in the header spoilt': Topic(
        '/joint_states', Schema(text=JOINT_STATE_TEXT.replace(b'int32 sec', b'int64 sec'))
    ),
    'IDL cut': Topic('/joint_states', Schema(encoding='ros2idl', text=b'module sensor_msgs {')),
    'broken QoS': Topic('/joint_states', Schema(), 'cdr', {'offered_qos_profiles': '- [: {'}),
    'QoS of text': Topic('/joint_states', Schema(), 'cdr', {'offered_qos_profiles': 'reliable'}),
}
NOTHING = {'index': 'NONE', 'use_statistics': False, 'use_summary_offsets': False}
NOTHING |= {'repeat_channels': False, 'repeat_schemas': False}
LAYOUTS = {
    'no chunks': {'use_chunking': False},
    'no indexes': {'index': 'NONE'},
    'no summary': NOTHING,
    'no summary, no chunks': {**NOTHING, 'use_chunking': False},
    'no statistics': {'use_statistics': False},
    'small chunks': {'chunk_size': 100},
    'lz4': {'compression': 'LZ4'},
    'no profile': {'profile': ''},
    'unknown profile': {'profile': 'x'},
}


def process_to_bag(source: Path, target: Path) -> Path:
    """Process a recording into a bag; return the bag's file."""
    assert exit_status([str(source), str(target)]) == 0
    return target / f'{target.name}.mcap'


@pytest.mark.parametrize('kind', BESIDE)
def test_a_topic_beside_the_joint_states_is_carried_over_as_it_is(
    tmp_path: Path, kind: str
) -> None:
    source = write_mcap(tmp_path / 'in.mcap', BESIDE[kind])
    assert read_mcap(process_to_bag(source, tmp_path / 'out')) == read_mcap(source)
    assert len(read_processed(tmp_path / 'out').times) == 10


@pytest.mark.parametrize('kind', OURS)
def test_joint_states_are_read_by_the_known_definition(tmp_path: Path, kind: str) -> None:
    source = write_mcap(tmp_path / 'in.mcap', ours=OURS[kind])
    assert read_mcap(process_to_bag(source, tmp_path / 'out')) == read_mcap(source)
    assert len(read_processed(tmp_path / 'out').times) == 10


@pytest.mark.parametrize('kind', LAYOUTS)
def test_the_layout_of_a_file_makes_no_difference(tmp_path: Path, kind: str) -> None:
    source = write_mcap(tmp_path / 'in.mcap', BESIDE['no definition'], **LAYOUTS[kind])
    assert read_mcap(process_to_bag(source, tmp_path / 'out')) == read_mcap(source)


def test_quality_of_service_and_hash_are_kept(tmp_path: Path) -> None:
    # of Humble, in numbers; judge: rosbags, which reads them as rosbag2's qos.cpp does
    times = ''.join(
        f'  {name}:\n    sec: 9223372036\n    nsec: 854775807\n'
        for name in ('deadline', 'lifespan', 'liveliness_lease_duration')
    )
    qos = '- history: 1\n  depth: 7\n  reliability: 2\n  durability: 1\n  liveliness: 1\n'
    qos += f'{times}  avoid_ros_namespace_conventions: false\n'
    facts = {'offered_qos_profiles': qos, 'topic_type_hash': 'RIHS01_1234'}
    source = write_mcap(tmp_path / 'in.mcap', [Topic('/own', Schema(OWN), 'cdr', facts)])
    process_to_bag(source, tmp_path / 'out')
    with Reader(source) as before, Reader(tmp_path / 'out') as after:
        [one] = before.topics['/own'].connections
        [other] = after.topics['/own'].connections
        assert other.ext.offered_qos_profiles == one.ext.offered_qos_profiles != []
        assert other.digest == 'RIHS01_1234'


@pytest.mark.parametrize('text', ['- [: {', 'reliable', '- history: 1'])
def test_a_quality_of_service_that_rosbag2_would_stop_at_is_left_out(
    tmp_path: Path, text: str
) -> None:
    from mcap.reader import make_reader

    # it throws in to_rclcpp_qos_vector of its rosbag2_storage/qos.cpp; empty it takes
    ours = Topic('/joint_states', Schema(), 'cdr', {'offered_qos_profiles': text, 'a': 'b'})
    source = write_mcap(tmp_path / 'in.mcap', ours=ours)
    with process_to_bag(source, tmp_path / 'out').open('rb') as file:
        summary = make_reader(file).get_summary()
    facts = {each.topic: each.metadata for each in summary.channels.values()}['/joint_states']
    assert facts['offered_qos_profiles'] == ''
    assert facts['a'] == 'b'


@pytest.mark.parametrize('profile', ['ros1', ''])
def test_messages_of_ros_1_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], profile: str
) -> None:
    ours = Topic('/joint_states', Schema('sensor_msgs/JointState', 'ros1msg'), 'ros1')
    source = write_mcap(tmp_path / 'in.mcap', ours=ours, profile=profile)
    line = refusal_line(capsys, str(source), str(tmp_path / 'out.csv'))
    assert 'ROS 1; convert' in line


def test_joint_states_in_json_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = write_mcap(tmp_path / 'in.mcap', ours=Topic('/joint_states', Schema(), 'json'))
    line = refusal_line(capsys, str(source), str(tmp_path / 'out.csv'))
    assert f'/joint_states ({JOINT_STATE} as json)' in line


CASES = [  # of ../shared/cases: the input, as its README has it
    'mcap_empty_jointstate_schema/a.mcap',
    'mcap_profile/a.mcap',
    'mcap_service_event/a.mcap',
    'mcap_unknown_types/empty.mcap',
    'mcap_unknown_types/idl.mcap',
]


@pytest.mark.parametrize('case', CASES)
def test_a_case_gives_ten_frames_and_a_bag_with_every_message(
    tmp_path: Path, cases: Path, case: str
) -> None:
    source = cases / case
    assert exit_status([str(source), str(tmp_path / 'out.csv')]) == 0
    assert len(read_csv(tmp_path / 'out.csv')[2]) == 10
    assert read_mcap(process_to_bag(source, tmp_path / 'out')) == read_mcap(source)


def test_the_case_of_ros_1_is_named(
    tmp_path: Path, cases: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = cases / 'mcap_profile' / 'ros1.mcap'
    assert 'ROS 1; convert' in refusal_line(capsys, str(source), str(tmp_path / 'out.csv'))
