# SPDX-License-Identifier: Apache-2.0
"""The node in a process of its own: from its ROS arguments to its end."""

from __future__ import annotations

import gc
from collections.abc import Sequence

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from ..errors import escape_controls
from .interruption import interruptible
from .muscle_state_publisher import MuscleStatePublisher
from .outputs import THROTTLE
from .ros_arguments import argument_errors, initialise_ros


def spin(executor: SingleThreadedExecutor, node: Node) -> None:
    """Work until ROS is shut down; an unexpected error in a message or request is logged."""
    while True:
        try:
            return executor.spin()
        except (ExternalShutdownException, RCLError, InvalidHandle):
            raise
        except Exception as error:
            node.get_logger().error(
                escape_controls(f'unexpected {type(error).__name__}, passed over: {error}'),
                throttle_duration_sec=THROTTLE,
            )


def main(ros_arguments: Sequence[str] = ()) -> None:
    """Run the node until it is interrupted or terminated; LinkedPlaneError for a mistake."""
    initialise_ros(ros_arguments)
    node = None
    try:
        executor = SingleThreadedExecutor()  # before a signal can come: it fails noisily after one
        with interruptible(), argument_errors():
            node = MuscleStatePublisher()
        executor.add_node(node)
        gc.collect()
        gc.freeze()  # what is loaded by now stays: searching it again takes tens of ms
        spin(executor, node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (RCLError, InvalidHandle):
        if rclpy.ok():  # otherwise the signal came in the middle of a call
            raise
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
