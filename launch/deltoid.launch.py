# SPDX-License-Identifier: Apache-2.0
"""The deltoid from joint states; optionally with a recording, RViz and a place for the scapula."""

from launch.actions import ExecuteProcess
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, NotEqualsSubstitution, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription
from linkedplane_ros.node.launch_arguments import (
    USE_SIM_TIME,
    declare_arguments,
    parameter_argument,
)

PARAMETERS = ('muscle', 'side', 'joint_convention', 'joint_names', 'frame_id')
PLACE = ('x', 'y', 'z', 'roll', 'pitch', 'yaw')
ARGUMENTS = (
    *map(parameter_argument, PARAMETERS),
    USE_SIM_TIME,
    ('namespace', '', 'The namespace of the node, its topics and the recording played.'),
    ('joint_states', 'joint_states', 'The topic of the joint states.'),
    ('bag', '', 'A recording to play, looped; empty: none.'),
    ('rviz', 'false', 'Show the muscle in RViz.'),
    ('parent_frame', '', 'A frame to hang the scapula frame on; empty: none.'),
    *((name, '0.0', f'The scapula frame in its parent, {name}: m, rad.') for name in PLACE),
)


def generate_launch_description() -> LaunchDescription:
    """Return what to start."""
    value = {name: LaunchConfiguration(name) for name, _, _ in ARGUMENTS}
    share = FindPackageShare('linkedplane_ros')
    return LaunchDescription(
        [
            *declare_arguments(ARGUMENTS),
            Node(
                package='linkedplane_ros',
                executable='muscle_state_publisher',
                namespace=value['namespace'],
                remappings=[('joint_states', value['joint_states'])],
                parameters=[{name: value[name] for name in (*PARAMETERS, 'use_sim_time')}],
                output='screen',
            ),
            ExecuteProcess(
                cmd=[
                    'ros2', 'bag', 'play', '--loop', value['bag'],
                    '--remap', ['/joint_states:=', value['namespace'], '/joint_states'],
                ],
                condition=IfCondition(NotEqualsSubstitution(value['bag'], '')),
                output='screen',
            ),
            Node(
                package='tf2_ros',
                executable='static_transform_publisher',
                namespace=value['namespace'],
                arguments=[
                    *(word for name in PLACE for word in (f'--{name}', value[name])),
                    '--frame-id', value['parent_frame'],
                    '--child-frame-id', value['frame_id'],
                ],
                condition=IfCondition(NotEqualsSubstitution(value['parent_frame'], '')),
            ),
            Node(
                package='rviz2',
                executable='rviz2',
                namespace=value['namespace'],
                remappings=[('/deltoid/markers', 'deltoid/markers')],
                arguments=[
                    '-d', PathJoinSubstitution([share, 'config', 'deltoid.rviz']),
                    '-f', value['frame_id'],
                ],
                condition=IfCondition(value['rviz']),
            ),
        ]
    )  # fmt: skip
