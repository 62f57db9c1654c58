# SPDX-License-Identifier: Apache-2.0
"""A node starts again with what `ros2 param dump` wrote, and empty lists are lists."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from parameter_changes import as_sent, change_parameters
from rclpy.parameter import Parameter, parameter_value_to_python

from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.parameters import NAMES, is_list


def dump_parameters(node: MuscleStatePublisher) -> str:
    """Return what `ros2 param dump` writes: ros2param's verb/dump.py."""
    tree: dict[str, Any] = {}
    names = sorted(node.list_parameters([], 0).names)
    for name, parameter in zip(names, node.get_parameters(names), strict=True):
        *folders, leaf = name.split('.')
        place = tree
        for folder in folders:
            place = place.setdefault(folder, {})
        place[leaf] = parameter_value_to_python(parameter.get_parameter_value())
    whole = {node.get_fully_qualified_name(): {'ros__parameters': tree}}
    return str(yaml.dump(whole, default_flow_style=False))


STARTS: dict[str, dict[str, Any]] = {
    'the defaults': {},
    'no joint names': {'joint_names': []},
    'one empty name': {'joint_names': ['']},
    'words that YAML reads otherwise': {'joint_names': ['no', 'on', '12'], 'frame_id': '1.5'},
    'small numbers': {'joint_offsets': [1e-05, -1e-300, 0.0], 'markers.rate': 1e-7},
    'whole numbers': {'joint_offsets': [1, 0, 2], 'markers.rate': 5, 'scale': 2},
    'lists': {'muscle': ['deltoid', 'deltoid_ackland2008'], 'scale': [1.0, 1.1, 0.9]},
}


@pytest.mark.parametrize('while_running', [False, True], ids=['at the start', 'while running'])
@pytest.mark.parametrize('case', STARTS)
def test_a_node_starts_again_with_what_ros2_param_dump_wrote(
    case: str, while_running: bool, ros: None, tmp_path: Path
) -> None:
    given = [as_sent(name, value) for name, value in STARTS[case].items()]
    first = MuscleStatePublisher(parameter_overrides=[] if while_running else given)
    if while_running:
        assert first.set_parameters_atomically(given).successful
    file = tmp_path / 'dumped.yaml'
    file.write_text(dump_parameters(first))
    second = MuscleStatePublisher(cli_args=['--ros-args', '--params-file', str(file)])
    third = MuscleStatePublisher(cli_args=['--ros-args', '--params-file', str(file)])
    assert dump_parameters(second) == file.read_text()
    for name in NAMES:
        values = [node.get_parameter(name).value for node in (first, second, third)]
        assert [list(value) if is_list(value) else value for value in values[1:]] == 2 * [
            list(values[0]) if is_list(values[0]) else values[0]
        ]
    for node in (first, second, third):
        node.destroy_node()


@pytest.mark.parametrize('kind', ['STRING_ARRAY', 'BOOL_ARRAY', 'BYTE_ARRAY', 'DOUBLE_ARRAY'])
def test_an_empty_list_of_joint_names_is_dumped_and_taken_again(
    kind: str, lone_node: MuscleStatePublisher, tmp_path: Path
) -> None:
    empty = as_sent('joint_names', [], Parameter.Type[kind])
    assert lone_node.set_parameters_atomically([empty]).successful
    file = tmp_path / 'dumped.yaml'
    file.write_text(dump_parameters(lone_node))
    assert 'joint_names: []\n' in file.read_text()
    again = MuscleStatePublisher(cli_args=['--ros-args', '--params-file', str(file)])
    assert dump_parameters(again) == file.read_text()
    assert change_parameters(again, joint_names=['f', 'a', 'r']).successful
    again.destroy_node()


@pytest.mark.parametrize('name', [name for name in NAMES if name != 'joint_names'])
def test_an_empty_list_for_another_parameter_is_refused_by_what_it_is(name: str, ros: None) -> None:
    with pytest.raises(ValueError, match=rf'parameter {name}: \[\] given'):
        MuscleStatePublisher(cli_args=['--ros-args', '-p', f'{name}:=[]'])
