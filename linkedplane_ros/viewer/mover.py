# SPDX-License-Identifier: Apache-2.0
"""Moves arms for persons: publishes joint states on its topics, as long as nobody else does."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from threading import Lock

from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from .names import short_name

SHOWN = 3  # names of other publishers in a line
LINGERING = 1.0  # s that a publisher of this node may stay in the graph after its end


class ArmMover:
    """Publishes joint states while a person moves an arm; there is no publisher otherwise."""

    def __init__(self, node: Node, topics: Sequence[str], take: bool) -> None:
        """`take`: go on where others publish on a topic, too."""
        self.topics = [node.resolve_topic_name(topic) for topic in topics]
        self._node = node
        self._take = take
        self._lock = Lock()
        self._publishers: dict[str, Publisher] = {}
        self._ended: dict[str, float] = {}
        self._told: set[str] = set()

    def find_rivals(self, topic: str) -> list[str]:
        """Return the nodes of the other publishers of a topic."""
        rivals = [
            f'{each.node_namespace.rstrip("/")}/{each.node_name}'
            if each.node_namespace.startswith('/')
            else 'its name has not arrived'
            for each in self._node.get_publishers_info_by_topic(topic)
        ]
        own = self._node.get_fully_qualified_name()
        ended = self._ended.get(topic, 0.0)
        present = topic in self._publishers or time.monotonic() < ended + LINGERING
        if present and own in rivals:
            rivals.remove(own)
        return rivals

    def find_obstacle(self, topic: str) -> str:
        """Return why the arm that listens to a topic is not moved from here, or nothing."""
        if topic not in self.topics:
            return f'it listens to {topic}: start the viewer with --topic {topic} to move it'
        rivals = [] if self._take else self.find_rivals(topic)
        line = ''
        if rivals:
            names = ', '.join(map(short_name, rivals[:SHOWN]))
            more = f' and {len(rivals) - SHOWN} more' if len(rivals) > SHOWN else ''
            line = (
                f'another publisher of {topic} is there ({names}{more}): '
                'the arm is not moved from here; --take does so all the same'
            )
        with self._lock:
            if line and topic not in self._told:
                self._node.get_logger().warning(line)
                self._told.add(topic)
            elif not line:
                self._told.discard(topic)
        return line

    def move(self, topic: str, message: JointState) -> bool:
        """Publish a joint state unless something speaks against it; return whether it was."""
        if self.find_obstacle(topic):
            self.release(topic)
            return False
        with self._lock:
            if topic not in self._publishers:
                quality = QoSProfile(depth=10)
                self._publishers[topic] = self._node.create_publisher(JointState, topic, quality)
            own = sum(each.topic_name == topic for each in self._node.subscriptions)
            publisher = self._publishers[topic]
            with suppress(InvalidHandle):  # the node is shut down
                if publisher.get_subscription_count() > own:  # else nobody would hear it
                    publisher.publish(message)
                    return True
            return False

    def release(self, *topics: str) -> None:
        """Leave topics to others; all of them if none is named."""
        with self._lock:
            for topic in topics or list(self._publishers):
                publisher = self._publishers.pop(topic, None)
                if publisher is not None:
                    self._node.destroy_publisher(publisher)
                    self._ended[topic] = time.monotonic()
