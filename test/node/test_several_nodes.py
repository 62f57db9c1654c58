# SPDX-License-Identifier: Apache-2.0
"""Several nodes in one process, side by side and one after the other."""

from __future__ import annotations

import numpy as np
from rclpy.node import Node
from rclpy.parameter import Parameter
from ros_harness import Peer, together

from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

NAMES = ('flexion', 'abduction', 'rotation')
POSE = (0.3, 0.2, 0.1)  # rad


def test_several_nodes_share_a_process_and_an_executor(peer: Peer) -> None:
    left = MuscleStatePublisher(
        namespace='left', parameter_overrides=[Parameter('side', value='left')]
    )
    right = MuscleStatePublisher()
    bystander = Node('bystander')
    ticks = []
    bystander.create_timer(0.01, lambda: ticks.append(1))
    reader = Peer('left/deltoid', topic='left/joint_states')
    reader.executor_of_its_own = peer.executor_of_its_own
    with together(peer, left, right, bystander, reader):
        peer.connect()
        reader.connect()
        for k in range(10):
            peer.send(NAMES, POSE)
            reader.send(NAMES, POSE)
            assert peer.answers(k + 1)
            assert reader.answers(k + 1)
        assert peer.until(lambda: len(ticks) > 5)
    for node in (left, right, bystander, reader):
        node.destroy_node()
    mirrored = [np.array(p.got['moment_vectors'][-1].data).reshape(-1, 3) for p in (peer, reader)]
    np.testing.assert_allclose(mirrored[0] * (1, -1, -1), mirrored[1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        peer.got['moment_arms'][-1].data, reader.got['moment_arms'][-1].data, rtol=0, atol=1e-12
    )
    for made in (left, right, bystander, reader):
        made.destroy_node()


def test_a_second_node_in_one_process_follows_the_first(peer: Peer) -> None:
    for k in range(2):
        made = MuscleStatePublisher()
        with together(peer, made):
            peer.diagnostics.clear()
            peer.connect()
            peer.send(NAMES, POSE)
            assert peer.answers(k + 1)
        made.destroy_node()
