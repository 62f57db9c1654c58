"""The deltoid from joint states; optionally with a recording, RViz and a place for the scapula."""

from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.conditions import IfCondition, LaunchConfigurationNotEquals
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

ARGUMENTS = (
    ('side', 'right', "The shoulder's side: right or left."),
    ('namespace', '', 'The namespace of the node and its topics.'),
    (
        'joint_convention',
        'flexion_abduction_rotation',
        'What the angles mean (README).',
    ),
    ('frame_id', 'scapula', 'The frame of the outputs.'),
    ('bag', '', 'A recording to play, looped; empty: none.'),
    ('rviz', 'false', 'Show the muscle in RViz.'),
    ('parent_frame', '', 'A frame to hang the scapula frame on, without a turn; empty: none.'),
)


def generate_launch_description() -> LaunchDescription:
    """Return what to start."""
    value = {name: LaunchConfiguration(name) for name, _, _ in ARGUMENTS}
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
                output='screen',
                parameters=[
                    {name: value[name] for name in ('side', 'joint_convention', 'frame_id')}
                ],
            ),
            ExecuteProcess(
                cmd=['ros2', 'bag', 'play', '--loop', value['bag']],
                condition=LaunchConfigurationNotEquals('bag', ''),
                output='screen',
            ),
            Node(
                package='tf2_ros',
                executable='static_transform_publisher',
                arguments=[
                    '--frame-id',
                    value['parent_frame'],
                    '--child-frame-id',
                    value['frame_id'],
                ],
                condition=LaunchConfigurationNotEquals('parent_frame', ''),
            ),
            Node(
                package='rviz2',
                executable='rviz2',
                arguments=[
                    '-d',
                    PathJoinSubstitution(
                        [FindPackageShare('linkedplane_ros'), 'config', 'deltoid.rviz']
                    ),
                ],
                condition=IfCondition(value['rviz']),
            ),
        ]
    )
