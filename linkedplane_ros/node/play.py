"""Publish a recording's joint states at their recorded times, where there is no ros2 bag."""

from __future__ import annotations

import time
from dataclasses import dataclass

import rclpy
from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from ..recordings.bags import Recording

SETTLING = 0.3  # s: a subscriber is known here a little before it knows this publisher
OUTPUT_QOS = QoSProfile(depth=10000)
CLOCK_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass(frozen=True)
class Pace:
    """How a recording is played."""

    rate: float = 1.0
    """Times its own speed."""
    loop: bool = False
    start_offset: float = 0.0
    """s into the recording."""
    clock: float = 0.0
    """Messages a second on /clock, Hz; 0: none."""
    wait: float = 10.0
    """s to wait for subscribers at most."""
    subscribers: int = 1
    """How many to wait for."""


def play(recording: Recording, pace: Pace) -> int:
    """Play a recording; return the number of messages published. rclpy must be initialised."""
    node = rclpy.create_node('linkedplane_play')
    publishers = {
        topic: node.create_publisher(JointState, topic, OUTPUT_QOS) for topic in recording.topics
    }
    clock = node.create_publisher(Clock, '/clock', CLOCK_QOS) if pace.clock else None
    try:
        if not await_subscriber(list(publishers.values()), pace.wait, pace.subscribers):
            node.get_logger().warning(f'no subscriber after {pace.wait:g} s; playing all the same')
        count = 0
        while True:
            count += play_once(recording, pace, publishers, clock)
            if not pace.loop:
                break
        for publisher in publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=5.0))
        return count
    finally:
        node.destroy_node()


def await_subscriber(publishers: list[Publisher], seconds: float, count: int = 1) -> bool:
    """Wait until every publisher has so many subscribers, at most so many s; return whether."""
    deadline = time.monotonic() + seconds
    while any(publisher.get_subscription_count() < count for publisher in publishers):
        if time.monotonic() >= deadline:
            return False
        time.sleep(0.02)
    time.sleep(min(SETTLING, seconds))
    return True


def play_once(
    recording: Recording,
    pace: Pace,
    publishers: dict[str, Publisher],
    clock: Publisher | None,
) -> int:
    """Publish every message once at its time; return how many."""
    begin = recording.start + round(1e9 * pace.start_offset)
    started = time.monotonic()
    tick = 1.0 / pace.clock if pace.clock else 0.0
    ticks = count = 0

    def wait_until(played: float) -> None:
        """Sleep until so many seconds of the recording have passed, ticking the clock."""
        nonlocal ticks
        while clock is not None and ticks * tick * pace.rate <= played:
            sleep_until(started + ticks * tick)
            clock.publish(Clock(clock=stamp(begin + round(1e9 * ticks * tick * pace.rate))))
            ticks += 1
        sleep_until(started + played / pace.rate)

    for message in recording.messages(pace.start_offset):
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


def stamp(nanoseconds: int) -> Time:
    """Return ns since the epoch as a message."""
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    return Time(sec=seconds, nanosec=rest)
