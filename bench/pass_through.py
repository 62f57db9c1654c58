# SPDX-License-Identifier: Apache-2.0
"""A node that answers every joint state with the same messages as ours, and solves nothing.

What it takes is what any node in Python takes; what ours takes beyond it is the muscle.
"""

from __future__ import annotations

import gc
from contextlib import suppress
from time import perf_counter

import numpy as np

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node import environment

environment.prepare()

import rclpy  # noqa: E402
from rclpy.event_handler import (  # noqa: E402
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
)
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

from linkedplane_ros.drawing.shapes import RateLimiter  # noqa: E402
from linkedplane_ros.node import qos  # noqa: E402
from linkedplane_ros.node.markers import MuscleMarkers  # noqa: E402
from linkedplane_ros.node.messages import Answers, message_class  # noqa: E402
from linkedplane_ros.node.topics import JOINT_STATES, OUTPUTS  # noqa: E402


class PassThrough(Node):
    """Publishes one and the same muscle state for every joint state."""

    def __init__(self) -> None:
        """Solve once."""
        super().__init__('pass_through')
        muscle = BroadMuscle.load('deltoid')
        self.state = LinkedPlaneSolver(muscle).solve(np.eye(3))
        self.markers = MuscleMarkers(muscle, 'scapula', 16)
        self.limiter = RateLimiter(30.0)
        self.answers = Answers(muscle.band_names, ('x', 'y', 'z'), 'scapula')
        self.on_demand = {topic.name for topic in OUTPUTS if topic.on_demand}
        self.outputs = {
            topic.name: self.create_publisher(
                message_class(topic.type),
                f'deltoid/{topic.name}',
                qos.profile(topic),
                event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
            )
            for topic in OUTPUTS
        }
        self.create_subscription(
            JointState,
            JOINT_STATES.name,
            self.answer,
            qos.profile(JOINT_STATES),
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )

    def answer(self, message: JointState) -> None:
        """Publish what there is."""
        state, outputs, stamp = self.state, self.outputs, message.header.stamp
        for name, answer in self.answers.update(
            stamp, state, state.moment_vectors, state.lengths
        ).items():
            if name not in self.on_demand or outputs[name].get_subscription_count():
                outputs[name].publish(answer)
        if outputs['markers'].get_subscription_count() and self.limiter.allows(
            stamp.sec + 1e-9 * stamp.nanosec, perf_counter()
        ):
            outputs['markers'].publish(self.markers.update(state, stamp))


if __name__ == '__main__':
    rclpy.init()
    executor = SingleThreadedExecutor()
    executor.add_node(PassThrough())
    gc.collect()
    gc.freeze()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()
