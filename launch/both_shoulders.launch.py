# SPDX-License-Identifier: Apache-2.0
"""Both deltoids, each in a namespace of its own, `left` and `right`, on one torso."""

from collections.abc import Mapping

from launch.actions import GroupAction, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import Action, LaunchContext, LaunchDescription
from linkedplane_ros.node.launching.arguments import (
    PARAMETERS,
    PARAMS_FILE,
    RECORDING,
    declare_arguments,
    parameter_argument,
)
from linkedplane_ros.node.launching.muscle_node import MuscleNode
from linkedplane_ros.node.launching.player import player_actions

SIDES = ('left', 'right')
SET_HERE = ('side', 'frame_id')
EACH = ('joint_names', 'joint_signs', 'joint_offsets')  # for each side
OR_EACH = ('bone_links',)  # for both, or for each side
COMMON = [spec for spec in PARAMETERS if spec.name not in (*SET_HERE, *EACH)]
ARGUMENTS = (
    *map(parameter_argument, COMMON),
    *(
        parameter_argument(spec, f'{side}_')
        for side in SIDES
        for spec in PARAMETERS
        if spec.name in (*EACH, *OR_EACH)
    ),
    PARAMS_FILE,
    ('left_joint_states', 'joint_states', 'The topic of the left arm, in its namespace.'),
    ('right_joint_states', 'joint_states', 'The topic of the right arm, in its namespace.'),
    *RECORDING,
    ('parent_frame', 'torso', 'What the scapulae hang on: x forward, y left, z up (REP 103).'),
    ('left_y', '0.17', 'The left glenohumeral centre in the parent frame, m to the left.'),
    ('right_y', '-0.17', 'The right glenohumeral centre in the parent frame, m to the left.'),
    ('rviz', 'false', 'Show both muscles in RViz.'),
)
BODY_RIGHT = '-1.5707963267948966'  # rad: the scapula's x to the body's right, y forward


def generate_launch_description() -> LaunchDescription:
    """Return what to start."""
    return LaunchDescription([*declare_arguments(ARGUMENTS), OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list[Action]:
    """Return what the arguments ask for."""
    values = context.launch_configurations
    share = FindPackageShare('linkedplane_ros')
    deltoid = PathJoinSubstitution([share, 'launch', 'deltoid.launch.py'])
    shoulders = {side: choose_arguments(values, side) for side in SIDES}
    nodes = [MuscleNode.from_arguments(context, given) for given in shoulders.values()]
    topics = [node.input_topic for node in nodes]
    clock = any(node.parameters['use_sim_time'] for node in nodes)
    config = PathJoinSubstitution([share, 'config', 'both_shoulders.rviz'])
    return [
        *(
            GroupAction(
                [
                    IncludeLaunchDescription(
                        # one for each side: it keeps what it has read, and nothing starts twice
                        PythonLaunchDescriptionSource(deltoid),
                        launch_arguments=given.items(),
                    )
                ]
            )
            for given in shoulders.values()
        ),
        *player_actions(values, topics, clock),
        Node(
            package='rviz2',
            executable='rviz2',
            remappings=[
                (f'/{side}/deltoid/markers', node.marker_topic)
                for side, node in zip(SIDES, nodes, strict=True)
            ],
            arguments=['-d', config, '-f', values['parent_frame']],
            condition=IfCondition(values['rviz']),
        ),
    ]


def choose_arguments(values: Mapping[str, str], side: str) -> dict[str, str]:
    """Return the arguments of one shoulder's launch file."""
    return {
        **{spec.name: values[spec.name] for spec in COMMON},
        **{name: values[f'{side}_{name}'] for name in (*EACH, 'joint_states', 'y')},
        **{name: values[f'{side}_{name}'] or values[name] for name in OR_EACH},
        'side': side,
        'frame_id': f'{side}_scapula',
        'namespace': side,
        'params_file': values['params_file'],
        'bag': '',
        'parent_frame': values['parent_frame'],
        'yaw': BODY_RIGHT,
        'rviz': 'false',
    }
