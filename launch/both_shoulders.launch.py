# SPDX-License-Identifier: Apache-2.0
"""Both deltoids, each in a namespace of its own, `left` and `right`, on one torso."""

from launch.actions import GroupAction, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription
from linkedplane_ros.node.launch_arguments import (
    USE_SIM_TIME,
    declare_arguments,
    parameter_argument,
)

ARGUMENTS = (
    parameter_argument('joint_convention'),
    ('left_joint_states', 'joint_states', 'The topic of the left arm, in its namespace.'),
    ('right_joint_states', 'joint_states', 'The topic of the right arm, in its namespace.'),
    ('left_joint_names', "['']", "The left arm's three joints; by default the convention's."),
    ('right_joint_names', "['']", "The right arm's three joints; by default the convention's."),
    USE_SIM_TIME,
    ('parent_frame', 'torso', 'What the scapulae hang on: x forward, y left, z up (REP 103).'),
    ('left_y', '0.17', 'The left glenohumeral centre in the parent frame, m to the left.'),
    ('right_y', '-0.17', 'The right glenohumeral centre in the parent frame, m to the left.'),
    ('rviz', 'false', 'Show both muscles in RViz.'),
)
BODY_RIGHT = '-1.5707963267948966'  # rad: the scapula's x to the body's right, y forward


def generate_launch_description() -> LaunchDescription:
    """Return what to start."""
    value = {name: LaunchConfiguration(name) for name, _, _ in ARGUMENTS}
    share = FindPackageShare('linkedplane_ros')
    deltoid = PathJoinSubstitution([share, 'launch', 'deltoid.launch.py'])
    shoulders = [
        GroupAction(
            [
                IncludeLaunchDescription(
                    # one for each side: it keeps what it has read, and nothing starts twice
                    PythonLaunchDescriptionSource(deltoid),
                    launch_arguments={
                        'side': side,
                        'namespace': side,
                        'frame_id': f'{side}_scapula',
                        'joint_convention': value['joint_convention'],
                        'joint_states': value[f'{side}_joint_states'],
                        'joint_names': value[f'{side}_joint_names'],
                        'use_sim_time': value['use_sim_time'],
                        'parent_frame': value['parent_frame'],
                        'y': value[f'{side}_y'],
                        'yaw': BODY_RIGHT,
                        'rviz': 'false',
                    }.items(),
                )
            ]
        )
        for side in ('left', 'right')
    ]
    return LaunchDescription(
        [
            *declare_arguments(ARGUMENTS),
            *shoulders,
            Node(
                package='rviz2',
                executable='rviz2',
                arguments=[
                    '-d', PathJoinSubstitution([share, 'config', 'both_shoulders.rviz']),
                    '-f', value['parent_frame'],
                ],
                condition=IfCondition(value['rviz']),
            ),
        ]
    )  # fmt: skip
