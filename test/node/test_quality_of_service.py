# SPDX-License-Identifier: Apache-2.0
"""Peers whose quality of service does not fit are named, with the override that helps."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from ros_harness import Peer, together
from sensor_msgs.msg import JointState
from visualization_msgs.msg import MarkerArray

from linkedplane_ros.errors import ArgumentError
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

NAMES = ('flexion', 'abduction', 'rotation')
POSE = (0.3, 0.2, 0.1)  # rad


def reliable_only() -> MuscleStatePublisher:
    """Return a node that takes reliable publishers alone."""
    override = Parameter('qos_overrides./joint_states.subscription.reliability', value='reliable')
    return MuscleStatePublisher(parameter_overrides=[override])


def test_a_publisher_that_does_not_fit_is_named_with_the_override_that_cures_it(
    peer: Peer, capfd: pytest.CaptureFixture[str]
) -> None:
    made, lab = reliable_only(), Node('lab')
    lab.create_publisher(JointState, 'joint_states', qos_profile_sensor_data)
    line = (
        'nothing comes from lab: on /joint_states it offers less than is asked for; start this '
        'node with -p qos_overrides./joint_states.subscription.reliability:=best_effort'
    )
    with together(peer, made):
        assert peer.until(lambda: any(line in a.status[0].message for a in peer.diagnostics))
        assert peer.values()['peers that do not fit'] == '1'
        count = len(peer.diagnostics)
        assert peer.until(lambda: len(peer.diagnostics) > count + 1)
        lab.destroy_node()
        assert peer.until(lambda: peer.values()['peers that do not fit'] == '0')
    made.destroy_node()
    assert capfd.readouterr().err.count(line) == 1


def test_a_subscriber_that_does_not_fit_is_named_with_the_override_that_cures_it(
    peer: Peer, node: MuscleStatePublisher
) -> None:
    viewer = Node('viewer')
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    viewer.create_subscription(MarkerArray, 'deltoid/markers', lambda _: None, latched)
    assert peer.until(lambda: peer.values()['peers that do not fit'] == '1')
    [line] = node._muscles[0].tally.incompatible_peers
    assert line == (
        'viewer receives nothing: on /deltoid/markers it asks for more than is offered; start '
        'this node with -p qos_overrides./deltoid/markers.publisher.durability:=transient_local'
    )
    viewer.destroy_node()


def test_the_cure_for_a_latched_subscriber_is_one(peer: Peer) -> None:
    name = 'qos_overrides./deltoid/markers.publisher.durability'
    made = MuscleStatePublisher(parameter_overrides=[Parameter(name, value='transient_local')])
    got: list[MarkerArray] = []
    with together(peer, made):
        peer.connect()
        peer.send(NAMES, POSE)
        assert peer.until(lambda: bool(peer.got['markers']))
        latched = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        peer.create_subscription(MarkerArray, 'deltoid/markers', got.append, latched)
        assert peer.until(lambda: bool(got))
    made.destroy_node()


@pytest.mark.parametrize(
    ('override', 'value', 'right'),
    [
        ('/joint_states.subscription.reliability', 'fast', 'reliable or best_effort'),
        ('/joint_states.subscription.depth', -3, '1 or more expected'),
        ('/joint_states.subscription.depth', 'deep', "expecting type 'INTEGER'$"),
        ('/deltoid/markers.publisher.durability', 'eternal', 'volatile or transient_local'),
    ],
)
def test_a_wrong_override_of_a_quality_of_service_is_one_line(
    ros: None, override: str, value: Any, right: str
) -> None:
    parameter = Parameter(f'qos_overrides.{override}', value=value)
    with pytest.raises(ArgumentError, match=right) as caught:
        MuscleStatePublisher(parameter_overrides=[parameter])
    assert '\n' not in str(caught.value)


def test_an_override_of_one_output_leaves_the_others_alone(ros: None) -> None:
    name = 'qos_overrides./deltoid/band_lengths.publisher.depth'
    made = MuscleStatePublisher(parameter_overrides=[Parameter(name, value=7)])
    depths = {output: end.qos_profile.depth for output, end in made._muscles[0].topics.items()}
    made.destroy_node()
    assert depths.pop('band_lengths') == 7
    assert depths.pop('markers') == 10
    assert set(depths.values()) == {2000}
