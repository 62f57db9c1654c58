# SPDX-License-Identifier: Apache-2.0
"""The launch files start what they say, with names that exist."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from launch_stand_ins import (
    DeclareLaunchArgument,
    ExecuteProcess,
    Node,
    Values,
    describe,
    list_started,
    list_started_with,
)

from linkedplane_ros.node.parameters import SPECS
from linkedplane_ros.node.settings import Settings

TOP = Path(__file__).parents[2]
DELTOID = TOP / 'launch' / 'deltoid.launch.py'
BOTH = TOP / 'launch' / 'both_shoulders.launch.py'
FILES = sorted((TOP / 'launch').glob('*.launch.py'))
DEFAULTS = {spec.name: spec.default for spec in SPECS}


def nodes(path: Path, executable: str, **arguments: str) -> list[Node]:
    """Return the nodes of an executable that a launch file starts."""
    found = [action for action in list_started(path, **arguments) if isinstance(action, Node)]
    return [node for node in found if node.executable == executable]


def settings(node: Node) -> Settings:
    """Return the settings that a node's parameters make, read as launch_ros reads them: as YAML."""
    [given] = node.parameters
    values = {name: yaml.safe_load(value) for name, value in given.items()}
    assert values.pop('use_sim_time') in (True, False)
    assert set(values) <= set(DEFAULTS)
    return Settings.from_values(DEFAULTS | values)


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_every_argument_is_described_and_used_and_every_one_used_is_declared(path: Path) -> None:
    entities = describe(path).entities
    declared = [each for each in entities if isinstance(each, DeclareLaunchArgument)]
    assert all(argument.description.endswith('.') for argument in declared)
    values = Values({'bag': 'walk', 'parent_frame': 'torso', 'rviz': 'true'})
    assert list_started_with(entities, values)  # a KeyError for one that is not declared
    assert values.read >= {argument.name for argument in declared}


def test_by_default_the_node_alone_is_started_with_its_defaults() -> None:
    [node] = list_started(DELTOID)
    assert isinstance(node, Node)
    assert (node.package, node.executable, node.namespace) == (
        'linkedplane_ros', 'muscle_state_publisher', '',
    )  # fmt: skip
    assert f"'{node.executable} = " in (TOP / 'setup.py').read_text()
    chosen = settings(node)
    assert chosen.solvers[0].side == 'right'
    assert chosen.joints.names == chosen.convention.coordinates
    assert node.remappings == [('joint_states', 'joint_states')]


def test_the_arguments_reach_the_parameters() -> None:
    [node] = nodes(
        DELTOID,
        'muscle_state_publisher',
        side='left',
        joint_convention='rep155',
        joint_names='[a, b, c]',
        frame_id='left_scapula',
        namespace='left',
        joint_states='/body/joint_states',
    )
    chosen = settings(node)
    assert (chosen.solvers[0].side, chosen.convention.name) == ('left', 'rep155')
    assert chosen.joints.names == ('a', 'b', 'c')
    assert chosen.frame_id == 'left_scapula'
    assert node.namespace == 'left'
    assert node.remappings == [('joint_states', '/body/joint_states')]


@pytest.mark.parametrize(
    ('namespace', 'topic'), [('', '/joint_states'), ('left', 'left/joint_states')]
)
def test_a_recording_is_played_into_the_nodes_namespace(namespace: str, topic: str) -> None:
    _, player = list_started(DELTOID, bag='walk', namespace=namespace)
    assert isinstance(player, ExecuteProcess)
    assert player.cmd == [
        'ros2', 'bag', 'play', '--loop', 'walk', '--remap', f'/joint_states:={topic}',
    ]  # fmt: skip


def test_the_scapula_is_hung_where_the_user_wants_it() -> None:
    [hook] = nodes(DELTOID, 'static_transform_publisher', parent_frame='torso', x='0.1', yaw='-1.5')
    given = dict(zip(hook.arguments[::2], hook.arguments[1::2], strict=True))
    assert given == {
        '--x': '0.1', '--y': '0.0', '--z': '0.0', '--roll': '0.0', '--pitch': '0.0',
        '--yaw': '-1.5', '--frame-id': 'torso', '--child-frame-id': 'scapula',
    }  # fmt: skip


def test_rviz_shows_the_namespaces_markers_in_the_outputs_frame() -> None:
    [rviz] = nodes(DELTOID, 'rviz2', rviz='true', namespace='left', frame_id='left_scapula')
    config, frame = rviz.arguments[1], rviz.arguments[3]
    assert yaml.safe_load(Path(config).read_text())
    assert frame == 'left_scapula'
    # the display's topic is absolute; relative, it follows the namespace
    [(absolute, relative)] = rviz.remappings
    assert f'Value: {absolute}\n' in Path(config).read_text()
    assert '/' + relative == absolute
    assert rviz.namespace == 'left'


def test_both_shoulders_are_two_nodes_that_share_nothing_but_the_torso() -> None:
    found = nodes(BOTH, 'muscle_state_publisher', right_joint_names='[p, q, r]')
    assert [node.namespace for node in found] == ['left', 'right']
    left, right = map(settings, found)
    assert (left.solvers[0].side, left.frame_id) == ('left', 'left_scapula')
    assert (right.solvers[0].side, right.frame_id) == ('right', 'right_scapula')
    assert left.joints.names == left.convention.coordinates
    assert right.joints.names == ('p', 'q', 'r')
    hooks = nodes(BOTH, 'static_transform_publisher')
    given = [dict(zip(h.arguments[::2], h.arguments[1::2], strict=True)) for h in hooks]
    assert [g['--child-frame-id'] for g in given] == ['left_scapula', 'right_scapula']
    assert [g['--frame-id'] for g in given] == ['torso', 'torso']
    assert [float(g['--y']) for g in given] == [0.17, -0.17]


def test_one_rviz_shows_both_shoulders() -> None:
    assert not nodes(BOTH, 'rviz2')
    [rviz] = nodes(BOTH, 'rviz2', rviz='true')
    config = yaml.safe_load(Path(rviz.arguments[1]).read_text())['Visualization Manager']
    topics = [d['Topic']['Value'] for d in config['Displays'] if 'Topic' in d]
    found = nodes(BOTH, 'muscle_state_publisher')
    assert topics == [f'/{node.namespace}/deltoid/markers' for node in found]
    assert config['Global Options']['Fixed Frame'] == 'torso' == rviz.arguments[3]
