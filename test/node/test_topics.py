# SPDX-License-Identifier: Apache-2.0
"""The topics that users rely on, and the table of them for the documentation."""

from __future__ import annotations

from linkedplane_ros.node.topics import CLOCK, DIAGNOSTICS, JOINT_STATES, OUTPUTS, topic_rows


def test_the_topics_are_those_that_were_promised() -> None:
    assert [(topic.name, topic.type) for topic in (JOINT_STATES, *OUTPUTS, DIAGNOSTICS)] == [
        ('joint_states', 'sensor_msgs/msg/JointState'),
        ('band_lengths', 'std_msgs/msg/Float64MultiArray'),
        ('moment_arms', 'std_msgs/msg/Float64MultiArray'),
        ('band_states', 'sensor_msgs/msg/JointState'),
        ('wrap_states', 'std_msgs/msg/UInt8MultiArray'),
        ('moment_vectors', 'std_msgs/msg/Float64MultiArray'),
        ('moment_arm_states', 'sensor_msgs/msg/JointState'),
        ('markers', 'visualization_msgs/msg/MarkerArray'),
        ('/diagnostics', 'diagnostic_msgs/msg/DiagnosticArray'),
    ]


def test_the_table_has_a_row_for_each_topic() -> None:
    rows = topic_rows((JOINT_STATES, CLOCK)) + topic_rows(OUTPUTS, 'deltoid/')
    assert rows[0][:3] == ('`joint_states`', 'sensor_msgs/JointState', 'best effort, depth 100')
    assert rows[2][:3] == ('`deltoid/band_lengths`', 'std_msgs/Float64MultiArray',
                           'reliable, depth 2000')  # fmt: skip
    assert len({name for name, *_ in rows}) == 9
    assert all(meaning.endswith('.') for *_, meaning in rows)
    demanded = [name for name, *_, meaning in rows if 'Only while somebody subscribes.' in meaning]
    assert demanded == ['`deltoid/moment_arm_states`', '`deltoid/markers`']
