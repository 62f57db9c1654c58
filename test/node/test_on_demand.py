# SPDX-License-Identifier: Apache-2.0
"""Topics that cost work or bandwidth: published only while somebody subscribes, or latched."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_harness import TOPICS, Reader
from sensor_msgs.msg import JointState

from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.topics import OUTPUTS

ON_DEMAND = [topic.name for topic in OUTPUTS if topic.on_demand]
POSE = JointState(name=['flexion', 'abduction', 'rotation'], position=[0.3, 0.2, 0.1])


class Counter:
    """Stands at the end of an output: says how many read it, and counts the messages."""

    def __init__(self, readers: int) -> None:
        self.readers = readers
        self.count = 0

    def get_subscription_count(self) -> int:
        return self.readers

    def publish(self, message: Any) -> None:
        self.count += 1


@pytest.mark.parametrize('wanted', ON_DEMAND)
def test_a_topic_on_demand_is_published_while_somebody_subscribes_it(
    lone_node: MuscleStatePublisher, wanted: str
) -> None:
    [muscle] = lone_node._muscles
    real, counters = muscle.topics, {name: Counter(readers=0) for name in TOPICS}
    muscle.topics = counters
    lone_node._answer(POSE)
    assert {name for name, each in counters.items() if not each.count} == set(ON_DEMAND)
    counters[wanted].readers = 1
    lone_node._answer(POSE)
    assert [name for name in ON_DEMAND if counters[name].count] == [wanted]
    before = counters[wanted].count
    counters[wanted].readers = 0
    lone_node._answer(POSE)
    assert counters[wanted].count == before
    muscle.topics = real


@pytest.mark.parametrize('topic', ['moment_arms', *ON_DEMAND])
def test_a_latched_topic_is_kept_for_whoever_subscribes_later(ros: None, topic: str) -> None:
    name = f'qos_overrides./deltoid/{topic}.publisher.durability'
    node = MuscleStatePublisher(parameter_overrides=[Parameter(name, value='transient_local')])
    node._answer(POSE)  # nobody listens, and nothing comes after it
    late, got = Reader('late'), []
    latched = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    late.keep(TOPICS[topic], f'deltoid/{topic}', got.append, qos_profile=latched)
    assert late.until(lambda: bool(got))
    late.destroy_node()
    node.destroy_node()


def test_the_names_of_the_moment_arms_follow_the_convention(
    lone_node: MuscleStatePublisher,
) -> None:
    def arm_names() -> list[str]:
        [muscle] = lone_node._muscles
        return list(muscle._answers._topics['moment_arm_states'].name)

    assert arm_names()[:3] == ['anterior_1/flexion', 'anterior_1/abduction', 'anterior_1/rotation']
    [result] = lone_node.set_parameters([Parameter('joint_convention', value='isb_yxy')])
    assert result.successful
    assert arm_names()[0] == 'anterior_1/plane_of_elevation'
    assert len(arm_names()) == 27
