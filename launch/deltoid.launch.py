# SPDX-License-Identifier: Apache-2.0
"""The deltoid from joint states; optionally with a recording, RViz and a place for the scapula."""

from launch.actions import OpaqueFunction
from launch.conditions import IfCondition
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

PLACE = ('x', 'y', 'z', 'roll', 'pitch', 'yaw')
ARGUMENTS = (
    *map(parameter_argument, PARAMETERS),
    PARAMS_FILE,
    ('namespace', '', 'The namespace of the node and its topics.'),
    ('joint_states', 'joint_states', 'The topic of the joint states; a recording is played to it.'),
    *RECORDING,
    ('rviz', 'false', 'Show the muscle in RViz.'),
    ('parent_frame', '', 'A frame to hang the scapula frame on; empty: none.'),
    *((name, '0.0', f'The scapula frame in its parent, {name}: m, rad.') for name in PLACE),
)


def generate_launch_description() -> LaunchDescription:
    """Return what to start."""
    return LaunchDescription([*declare_arguments(ARGUMENTS), OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list[Action]:
    """Return what the arguments ask for."""
    values = context.launch_configurations
    node = MuscleNode.from_arguments(context, values)
    clock = node.parameters['use_sim_time']
    actions = [node.start(), *player_actions(values, [node.input_topic], clock, node.joint_names)]
    if values['parent_frame']:
        actions.append(
            Node(
                package='tf2_ros',
                executable='static_transform_publisher',
                namespace=values['namespace'],
                arguments=[
                    *(word for name in PLACE for word in (f'--{name}', values[name])),
                    '--frame-id', values['parent_frame'],
                    '--child-frame-id', node.frame_id,
                ],
            )
        )  # fmt: skip
    config = [FindPackageShare('linkedplane_ros'), 'config', 'deltoid.rviz']
    actions.append(
        Node(
            package='rviz2',
            executable='rviz2',
            namespace=values['namespace'],
            remappings=[('/deltoid/markers', node.marker_topic)],
            arguments=['-d', PathJoinSubstitution(config), '-f', node.frame_id],
            condition=IfCondition(values['rviz']),
        )
    )
    return actions
