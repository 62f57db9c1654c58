# SPDX-License-Identifier: Apache-2.0
"""The launch files start what they say, with names that exist."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from bag_metadata import write_metadata
from launch_stand_ins import (
    DeclareLaunchArgument,
    Node,
    Values,
    describe,
    list_started,
    list_started_with,
)
from launched import BOTH, DEFAULTS, DELTOID, FILES, TOP, nodes, played, settings

from linkedplane_ros.errors import LinkedPlaneError


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_every_argument_is_described_and_used_and_every_one_used_is_declared(
    path: Path, tmp_path: Path
) -> None:
    entities = describe(path).entities
    declared = [each for each in entities if isinstance(each, DeclareLaunchArgument)]
    assert all(argument.description.endswith('.') for argument in declared)
    bag = write_metadata(tmp_path / 'bag', '/left/joint_states', '/right/joint_states')
    topic = '' if path == BOTH else '/left/joint_states'
    values = Values({'bag': bag, 'bag_topic': topic, 'parent_frame': 'torso', 'rviz': 'true'})
    assert list_started_with(entities, values)  # a KeyError for one that is not declared
    assert values.read >= {argument.name for argument in declared}


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_every_parameter_has_its_argument(path: Path) -> None:
    declared = {e.name for e in describe(path).entities if isinstance(e, DeclareLaunchArgument)}
    wanted = {*DEFAULTS, 'use_sim_time', 'params_file'}
    if path == BOTH:
        each = {'joint_names', 'joint_signs', 'joint_offsets'}
        wanted -= {'side', 'frame_id'} | each
        wanted |= {f'{side}_{name}' for side in ('left', 'right') for name in each}
    assert declared >= wanted


def test_by_default_the_node_alone_is_started_with_its_defaults() -> None:
    node, *others = [each for each in list_started(DELTOID) if isinstance(each, Node)]
    assert not others
    assert (node.package, node.executable, node.namespace) == (
        'linkedplane_ros', 'muscle_state_publisher', '',
    )  # fmt: skip
    assert f"'{node.executable} = " in (TOP / 'setup.py').read_text()
    assert node.parameters == []
    assert node.remappings == [('joint_states', 'joint_states')]


def test_the_arguments_reach_the_parameters() -> None:
    [node] = nodes(
        DELTOID,
        'muscle_state_publisher',
        **{
            'side': 'left',
            'scale': '1.05',
            'joint_convention': 'rep155',
            'joint_names': "[a, '1', 'on']",
            'joint_signs': '[1, -1, 1.0]',
            'joint_offsets': '[0, 1.5708, 0]',
            'frame_id': 'left_scapula',
            'markers.enabled': 'false',
            'markers.rate': '10',
            'namespace': 'left',
            'joint_states': '/body/joint_states',
        },
    )
    chosen = settings(node)
    assert (chosen.solvers[0].side, chosen.convention.name) == ('left', 'rep155')
    assert chosen.scale == '1.05'
    assert chosen.joints.names == ('a', '1', 'on')
    assert chosen.joints.signs == (1.0, -1.0, 1.0)
    assert chosen.joints.offsets == (0.0, 1.5708, 0.0)
    assert chosen.frame_id == 'left_scapula'
    assert (chosen.markers_enabled, chosen.markers_rate) == (False, 10.0)
    assert node.namespace == 'left'
    assert node.remappings == [('joint_states', '/body/joint_states')]


@pytest.mark.parametrize('empty', ['[]', "['']"])
def test_empty_joint_names_are_the_conventions_coordinates(empty: str) -> None:
    [node] = nodes(DELTOID, 'muscle_state_publisher', joint_names=empty)
    assert node.parameters == [{'joint_names': ['']}]  # rcl drops an empty list
    chosen = settings(node)
    assert chosen.joints.names == chosen.convention.coordinates


@pytest.mark.parametrize(
    ('name', 'text', 'fault'),
    [
        ('joint_names', '[a, b', 'not valid YAML'),
        ('muscle', '010', '(text: in quotes)'),
        ('frame_id', '1:30', '(text: in quotes)'),
        ('muscle', '12', 'a number, a date, true or nothing is text in quotes'),
        ('frame_id', '2024-01-01', 'a number, a date, true or nothing is text in quotes'),
        ('joint_names', '[1, b, c]', 'a number, a date, true or nothing is text in quotes'),
        ('joint_names', '{a: b}', '3 joint names expected'),
        ('joint_names', 'a, b, c', '3 joint names expected'),
        ('joint_names', '[a, yes, c]', '3 joint names expected'),
        ('joint_signs', '[1, 1]', '3 finite numbers expected'),
        ('markers.rate', 'fast', 'a finite number'),
        ('use_sim_time', 'maybe', 'true or false expected'),
        ('delay', '-1', 'seconds from 0 expected'),
        ('delay', 'long', 'seconds from 0 expected'),
        ('params_file', 'nowhere.yaml', 'No such file or directory'),
        ('joint_states', 'a b', "a topic's name expected"),
        ('joint_signs', '[1, 2, 1]', '1.0 or -1.0 expected'),
        ('frame_id', '/x', 'the name of a frame expected'),
    ],
)
def test_an_argument_that_cannot_be_used_is_named(
    tmp_path: Path, name: str, text: str, fault: str
) -> None:
    bag = write_metadata(tmp_path / 'bag', '/joint_states')
    with pytest.raises(LinkedPlaneError, match=f'{name}: .*{fault}'):
        list_started(DELTOID, **{'bag': bag, name: text})


def test_nothing_starts_for_a_muscle_or_a_file_that_the_node_would_refuse(tmp_path: Path) -> None:
    with pytest.raises(LinkedPlaneError, match='neither a bundled model'):
        list_started(DELTOID, muscle='nonsense')
    assert list_started(DELTOID, muscle='[nonsense, deltoid]')  # the node goes on with one
    file = tmp_path / 'params.yaml'
    file.write_text('/**: {ros__parameters: {joint_offsets: [1, up, 0]}}')
    with pytest.raises(LinkedPlaneError, match=r'joint_offsets: .* 3 finite numbers expected'):
        list_started(DELTOID, params_file=str(file))


FILE = """
/**/muscle_state_publisher:
  ros__parameters: {side: left, frame_id: everywhere, use_sim_time: true}
left:
  muscle_state_publisher:
    ros__parameters: {frame_id: here}
/*:
  ros__parameters: {frame_id: in_no_namespace}
other_node:
  ros__parameters: {frame_id: elsewhere}
"""


@pytest.mark.parametrize(
    ('namespace', 'given', 'frame'),
    [
        ('left', {}, 'here'),
        ('', {}, 'in_no_namespace'),
        ('robot/left', {}, 'everywhere'),
        ('left', {'frame_id': 'mine'}, 'mine'),
        ('left', {'frame_id': 'scapula'}, 'scapula'),  # the node's default, but given
    ],
)
def test_a_given_argument_wins_over_the_file_and_one_at_its_default_does_not(
    tmp_path: Path, namespace: str, given: dict[str, str], frame: str
) -> None:
    file = tmp_path / 'params.yaml'
    file.write_text(FILE)
    arguments = {'params_file': str(file), 'namespace': namespace, 'parent_frame': 'torso', **given}
    [node] = nodes(DELTOID, 'muscle_state_publisher', **arguments)
    assert node.parameters == [str(file), *([given] if given else [])]
    assert node.name == 'muscle_state_publisher'  # or a file's words for its full name would win
    [hook] = nodes(DELTOID, 'static_transform_publisher', **arguments)
    assert hook.arguments[-2:] == ['--child-frame-id', frame]
    assert '--clock' in played(
        DELTOID, bag=write_metadata(tmp_path / 'bag', '/joint_states'), **arguments
    )


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
    [(shown, published)] = rviz.remappings
    assert f'Value: {shown}\n' in Path(config).read_text()
    assert published == '/left/deltoid/markers'
    assert rviz.namespace == 'left'


@pytest.mark.parametrize('muscle', ['deltoid_ackland2008', '[deltoid_ackland2008, deltoid]'])
def test_rviz_shows_the_muscle_that_is_chosen(muscle: str) -> None:
    [rviz] = nodes(DELTOID, 'rviz2', rviz='true', muscle=muscle)
    assert rviz.remappings == [('/deltoid/markers', '/deltoid_ackland2008/markers')]


def test_both_shoulders_have_one_skeleton_and_links_and_joints_of_their_own() -> None:
    names = [f'j{k}' for k in range(9)]
    given = {'skeleton': 'shoulder_girdle', 'muscle': 'deltoid_girdle'}
    given |= {'left_bone_links': "['clavicle:=scapula']", 'right_joint_names': str(names)}
    left, right = map(settings, nodes(BOTH, 'muscle_state_publisher', **given))
    assert left.joints.names[:2] == ('sc_protraction', 'sc_elevation')
    assert right.joints.names == tuple(names)
    links = [each.articulations.moved_by[0].links for each in (left, right)]
    assert links == [('scapula', 'scapula', 'humerus'), ('scapula', 'clavicle', 'humerus')]


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
    assert rviz.remappings == [(topic, topic) for topic in topics]


def test_in_a_pushed_namespace_rviz_shows_both_shoulders_there() -> None:
    [rviz] = nodes(BOTH, 'rviz2', rviz='true', ros_namespace='robot')
    assert rviz.remappings == [
        (f'/{side}/deltoid/markers', f'/robot/{side}/deltoid/markers') for side in ('left', 'right')
    ]
