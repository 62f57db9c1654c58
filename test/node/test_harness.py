# SPDX-License-Identifier: Apache-2.0
"""The tests' own readers: nothing of one test is left for the next."""

from __future__ import annotations

from rclpy.event_handler import PublisherEventCallbacks
from ros_harness import Peer
from std_msgs.msg import Empty

TOPIC = '/matched'


def test_what_is_destroyed_after_a_wait_is_gone(peer: Peer) -> None:
    matched: list[object] = []
    events = PublisherEventCallbacks(matched=matched.append)
    publisher = peer.create_publisher(Empty, TOPIC, 1, event_callbacks=events)
    subscription = peer.create_subscription(Empty, TOPIC, lambda _: None, 1)
    assert peer.until(lambda: bool(matched))  # the wait ends with an event
    peer.destroy_publisher(publisher)
    peer.destroy_subscription(subscription)
    assert peer.count_publishers(TOPIC) == peer.count_subscribers(TOPIC) == 0
