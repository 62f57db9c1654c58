# SPDX-License-Identifier: Apache-2.0
"""Soak the node: 1 kHz for five minutes, markers on; every message answered, memory flat.

`make soak` runs it; `make soak SECONDS=60` for less. It ends with status 1 if a bound is exceeded.
"""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from linkedplane_ros.node import environment

environment.prepare()

import rclpy  # noqa: E402
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from visualization_msgs.msg import MarkerArray  # noqa: E402

RATE = 1000  # Hz
WARM_UP = 60.0  # s after which memory has to be flat
GROWTH = 1.0  # MiB
NAMES = ['flexion', 'abduction', 'rotation']
COMMAND = [sys.executable, '-m', 'linkedplane_ros.node', '--ros-args']
for policy, value in (('reliability', 'reliable'), ('depth', '10000')):
    COMMAND += ['-p', f'qos_overrides./joint_states.subscription.{policy}:={value}']


class Feeder(Node):
    """Publishes joint states and counts what comes back."""

    def __init__(self) -> None:
        """Subscribe the stamped answers, the markers (unread) and the diagnostics."""
        super().__init__('feeder')
        deep = QoSProfile(depth=10000)
        self.sent = self.answered = self.disordered = self.markers = 0
        self.values: dict[str, str] = {}
        self.joints = self.create_publisher(JointState, 'joint_states', deep)
        self.create_subscription(JointState, 'deltoid/band_states', self._on_answer, deep)
        self.create_subscription(MarkerArray, 'deltoid/markers', self._on_markers, 10, raw=True)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def _on_answer(self, message: JointState) -> None:
        stamp = message.header.stamp
        self.disordered += stamp.sec * RATE + stamp.nanosec * RATE // 10**9 != self.answered
        self.answered += 1

    def _on_markers(self, message: bytes) -> None:
        self.markers += 1

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.values = {item.key: item.value for item in message.status[0].values}

    def send(self) -> None:
        """Publish the next joint state; its stamp is its number."""
        swing = (self.sent % 4000) / 2000.0
        message = JointState(name=NAMES, position=[swing, 0.4, 0.2], velocity=[0.5, 0.0, 0.0])
        message.header.stamp.sec, rest = divmod(self.sent, RATE)
        message.header.stamp.nanosec = rest * (10**9 // RATE)
        self.joints.publish(message)
        self.sent += 1


def resident_memory(process: subprocess.Popen[bytes]) -> float:
    """Return the MiB of memory that a process holds."""
    pages = int(Path(f'/proc/{process.pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 2**20


def soak(feeder: Feeder, process: subprocess.Popen[bytes], seconds: float) -> list[float]:
    """Feed the node; return its memory, MiB, once a second."""
    spinner = SingleThreadedExecutor()
    spinner.add_node(feeder)
    while not (feeder.joints.get_subscription_count() and feeder.values):
        if process.poll() is not None:
            raise SystemExit('the node ended')
        spinner.spin_once(timeout_sec=0.1)
    memory: list[float] = []
    begin = time.perf_counter()
    while (now := time.perf_counter() - begin) < seconds:
        if now > len(memory):
            memory.append(resident_memory(process))
        while feeder.sent <= now * RATE:
            feeder.send()
        spinner.spin_once(timeout_sec=max(0.0, feeder.sent / RATE - now))
    end = time.perf_counter() + 30.0
    while time.perf_counter() < end and (
        feeder.answered < feeder.sent or feeder.values['messages answered'] != str(feeder.sent)
    ):
        spinner.spin_once(timeout_sec=0.1)
    return memory


def main() -> int:
    """Run it and print the figures; return the exit status."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 300.0
    os.environ.update(ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST', ROS_DOMAIN_ID='103')
    gc.disable()
    process = subprocess.Popen(COMMAND, stderr=subprocess.DEVNULL)
    rclpy.init()
    feeder = Feeder()
    try:
        memory = soak(feeder, process, seconds)
    finally:
        process.send_signal(signal.SIGINT)
        status = process.wait(10)
        rclpy.try_shutdown()
    start = min(int(WARM_UP), len(memory) // 2)
    growth = max(memory[start:]) - memory[start]
    print(f'{feeder.sent:,} joint states in {seconds:g} s; {feeder.answered:,} answered, '
          f'{feeder.disordered:,} out of order; {feeder.markers:,} marker messages')  # fmt: skip
    for key, value in feeder.values.items():
        if 'messages' in key or 'rejected' in key or 'time' in key:
            print(f'  {key}: {value}')
    print(f'memory: {memory[0]:.1f} MiB at first, {memory[start]:.1f} after {start} s, '
          f'at most {growth:.2f} more since (bound: {GROWTH:g}); exit status {status}')  # fmt: skip
    within = feeder.answered == feeder.sent and not feeder.disordered and growth < GROWTH
    within = within and feeder.markers > 25 * seconds
    return 0 if within and status == 0 else 1


if __name__ == '__main__':
    sys.exit(main())
