# SPDX-License-Identifier: Apache-2.0
"""Publish a recording's joint states at their recorded times, without ros2 bag."""

from __future__ import annotations

import time
from dataclasses import dataclass

import rclpy
from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from ..recordings.bags.recording import Recording
from . import qos
from .ros_arguments import argument_errors, warn_of_unknown_parameters
from .topics import CLOCK

SETTLING = 0.3  # s: a subscriber is known here a little earlier than this publisher there
TAKING = 60.0  # s for slow subscribers to take the last messages
MOMENT = Duration(seconds=0.1)  # Ctrl-C is noticed between two waits
OUTPUT_QOS = QoSProfile(depth=10000)


@dataclass(frozen=True)
class Playback:
    """How fast a recording is played, from where, and how often."""

    rate: float = 1.0
    """Speed: 1 is as recorded."""
    loop: bool = False
    start_offset: float = 0.0
    """s into the recording."""
    clock: float = 0.0
    """Messages a second on /clock, Hz; 0: none."""
    wait: float = 10.0
    """s to wait for subscribers, at most."""
    subscribers: int = 1
    """How many to wait for."""


def play_recording(recording: Recording, how: Playback) -> int:
    """Play a recording; rclpy must be initialised.

    Parameters
    ----------
    recording
        Its joint states are published on their recorded topics.
    how
        How fast, from where, and how often.

    Returns
    -------
    int
        The number of messages published.

    """
    with argument_errors():
        node = rclpy.create_node('linkedplane_play')
    warn_of_unknown_parameters(node)
    publishers = {
        topic: node.create_publisher(JointState, topic, OUTPUT_QOS) for topic in recording.topics
    }
    clock = node.create_publisher(Clock, CLOCK.name, qos.profile(CLOCK)) if how.clock else None
    try:
        if not await_subscribers(list(publishers.values()), how.wait, how.subscribers):
            node.get_logger().warning(f'no subscriber after {how.wait:g} s; playing anyway')
        count = 0
        while True:
            count += play_once(recording, how, publishers, clock)
            if not how.loop:
                break
        if not await_acknowledgement(list(publishers.values()), TAKING):
            node.get_logger().warning(
                f'a subscriber has not taken all messages {TAKING:g} s after the end'
            )
        return count
    finally:
        node.destroy_node()


def await_subscribers(publishers: list[Publisher], seconds: float, count: int = 1) -> bool:
    """Wait up to `seconds` until every publisher has `count` subscribers; return whether it has."""
    deadline = time.monotonic() + seconds
    while any(publisher.get_subscription_count() < count for publisher in publishers):
        if time.monotonic() >= deadline:
            return False
        time.sleep(0.02)
    time.sleep(min(SETTLING, seconds))
    return True


def await_acknowledgement(publishers: list[Publisher], seconds: float) -> bool:
    """Wait up to `seconds` until subscribers have taken all messages; return whether they have.

    What has not been taken is lost when its publisher goes.
    """
    deadline = time.monotonic() + seconds
    while not all(publisher.wait_for_all_acked(MOMENT) for publisher in publishers):
        if time.monotonic() >= deadline:
            return False
    return True


def play_once(
    recording: Recording,
    how: Playback,
    publishers: dict[str, Publisher],
    clock: Publisher | None,
) -> int:
    """Publish every message once at its time; return their number."""
    begin = recording.start + round(1e9 * how.start_offset)
    started = time.monotonic()
    period = 1.0 / how.clock if how.clock else 0.0
    ticks = count = 0

    def wait_until(played: float) -> None:
        """Sleep until `played` s of the recording have passed, publishing the clock meanwhile."""
        nonlocal ticks
        while clock is not None and ticks * period * how.rate <= played:
            sleep_until(started + ticks * period)
            recorded = begin + round(1e9 * ticks * period * how.rate)
            clock.publish(Clock(clock=time_message(recorded)))
            ticks += 1
        sleep_until(started + played / how.rate)

    for message in recording.messages(how.start_offset):
        wait_until(1e-9 * (message.time - begin))
        publishers[message.topic].publish(message.data)
        count += 1
    wait_until(1e-9 * (recording.end - begin))
    return count


def sleep_until(moment: float) -> None:
    """Sleep until a moment of time.monotonic()."""
    left = moment - time.monotonic()
    if left > 0.0:
        time.sleep(left)


def time_message(nanoseconds: int) -> Time:
    """Return ns since the epoch as a message."""
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    return Time(sec=seconds, nanosec=rest)
