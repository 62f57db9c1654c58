"""The deltoid from joint states; optionally with a recording, RViz and a place for the scapula."""

from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.conditions import IfCondition, LaunchConfigurationNotEquals
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

PLACE = ('x', 'y', 'z', 'roll', 'pitch', 'yaw')
ARGUMENTS = (
    ('muscle', 'deltoid', 'A bundled model or the path of a model file (.yaml); or [a list].'),
    ('side', 'right', "The shoulder's side: right or left."),
    ('namespace', '', 'The namespace of the node, its topics and the recording played.'),
    ('joint_states', 'joint_states', 'The topic of the joint states.'),
    ('joint_convention', 'flexion_abduction_rotation', 'What the angles mean (README).'),
    ('joint_names', "['']", "The three joints in the convention's order; by default its own."),
    ('frame_id', 'scapula', 'The frame of the outputs.'),
    ('use_sim_time', 'false', 'Take the time from /clock, as of a recording played with --clock.'),
    ('bag', '', 'A recording to play, looped; empty: none.'),
    ('rviz', 'false', 'Show the muscle in RViz.'),
    ('parent_frame', '', 'A frame to hang the scapula frame on; empty: none.'),
    *((name, '0.0', f'The scapula frame in its parent, {name}: m, rad.') for name in PLACE),
)


def generate_launch_description() -> LaunchDescription:
    """Return what to start."""
    value = {name: LaunchConfiguration(name) for name, _, _ in ARGUMENTS}
    parameters = (
        'muscle', 'side', 'joint_convention', 'joint_names', 'frame_id', 'use_sim_time',
    )  # fmt: skip
    share = FindPackageShare('linkedplane_ros')
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, default, meaning in ARGUMENTS
            ),
            Node(
                package='linkedplane_ros',
                executable='muscle_state_publisher',
                namespace=value['namespace'],
                remappings=[('joint_states', value['joint_states'])],
                parameters=[{name: value[name] for name in parameters}],
                output='screen',
            ),
            ExecuteProcess(
                cmd=[
                    'ros2', 'bag', 'play', '--loop', value['bag'],
                    '--remap', ['/joint_states:=', value['namespace'], '/joint_states'],
                ],
                condition=LaunchConfigurationNotEquals('bag', ''),
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
                condition=LaunchConfigurationNotEquals('parent_frame', ''),
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
