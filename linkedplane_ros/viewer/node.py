# SPDX-License-Identifier: Apache-2.0
"""The ROS side of the viewer: finds muscles, reads their newest states, moves arms."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from threading import Event
from typing import Any

import numpy as np
from rcl_interfaces.msg import ParameterEvent
from rclpy._rclpy_pybind11 import RCLError
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_parameter_events
from sensor_msgs.msg import JointState

from ..processing.topics import FLOAT_ARRAY, MARKERS
from ..types import Floats
from .arguments import TOPIC
from .mover import ArmMover
from .newest import MuscleInfo
from .reader import MuscleReader

FRAME = 1.0 / 60.0  # s: no screen shows more
POLL, POLLS = 0.001, 12  # s between polls for the rest of an answer, and their number
ANSWER = 8  # messages: more come from a stream that is faster than its markers
DISCOVERY = 0.5  # s between searches for muscles and nodes


def find_muscles(topics: list[tuple[str, list[str]]]) -> list[str]:
    """Return the prefixes (`/deltoid`) of the muscles among topics, given with their types."""
    kinds = dict(topics)
    prefixes = [topic.removesuffix('/markers') for topic in kinds if topic.endswith('/markers')]
    return sorted(
        prefix
        for prefix in prefixes
        if MARKERS.type in kinds[f'{prefix}/markers']
        and FLOAT_ARRAY in kinds.get(f'{prefix}/band_lengths', ())
    )


class ViewerNode(Node):
    """Reads every muscle that it finds, and moves those that listen to its topics."""

    def __init__(self, topics: Sequence[str] = (TOPIC,), take: bool = False, **kwargs: Any) -> None:
        """Look out for muscles from now on.

        Parameters
        ----------
        topics
            Of the joint states that it may publish.
        take
            Whether it does where others publish on such a topic, too.
        kwargs
            For the node.

        """
        super().__init__('muscle_viewer', **kwargs)
        self.mover = ArmMover(self, topics, take)
        self.fresh = Event()
        self.readers: dict[str, MuscleReader] = {}
        self.create_timer(DISCOVERY, self._discover, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.create_subscription(
            ParameterEvent,
            '/parameter_events',
            self._on_parameter_event,
            qos_profile_parameter_events,
        )
        self._discover()

    def _discover(self) -> None:
        for prefix in find_muscles(self.get_topic_names_and_types()):
            if prefix not in self.readers:
                reader = MuscleReader(self, prefix, self.fresh, self.mover)
                self.readers = {**self.readers, prefix: reader}
        for reader in self.readers.values():
            reader.discover()

    def _on_parameter_event(self, event: ParameterEvent) -> None:
        for reader in self.readers.values():
            reader.on_parameter_event(event)

    def move_arm(self, info: MuscleInfo, angles: Floats, speeds: Floats) -> bool:
        """Publish coordinates (d,), rad or m, and speeds (d,), of a muscle as a joint state.

        Returns
        -------
        bool
            Whether they were published.

        """
        if info.obstacle or not np.isfinite((angles, speeds)).all():
            return False
        joints = info.joints
        signs = np.array(joints.signs)
        message = JointState(
            name=list(joints.names),
            position=(signs * (angles - joints.offsets)).tolist(),
            velocity=(signs * speeds).tolist(),
        )
        message.header.stamp = self.get_clock().now().to_msg()
        return self.mover.move(info.joint_topic, message)

    def spin(self, going: Callable[[], bool]) -> None:
        """Read the newest messages once a frame, as long as `going()`.

        The queues are short: what is not read in time is never read, so this thread has as little
        to do at 1 kHz as at 60 Hz.
        """
        try:
            executor = SingleThreadedExecutor(context=self.context)
            executor.add_node(self)
            while going():
                executor.spin_once(timeout_sec=0.1)
                if any(reader.is_waiting for reader in self.readers.values()):
                    begun = time.monotonic()
                    self._gather_answer(executor)
                    time.sleep(max(begun + FRAME - time.monotonic(), 0.0))
            executor.shutdown()
        except (ExternalShutdownException, RCLError):  # shut down during a call
            if self.context.ok():
                raise

    def _gather_answer(self, executor: SingleThreadedExecutor) -> None:
        """Read all of an answer; wait a little for the markers, its last part."""
        readers = self.readers.values()
        enough = self._taken + ANSWER * len(readers)
        for _ in range(POLLS):
            time.sleep(POLL)
            before = -1
            while before != (before := self._taken):
                executor.spin_once(timeout_sec=0.0)
            whole = all(reader.is_complete or not reader.is_waiting for reader in readers)
            if whole or self._taken > enough:
                break
        for reader in readers:
            reader.hand_over()

    @property
    def _taken(self) -> int:
        return sum(reader.taken for reader in self.readers.values())
