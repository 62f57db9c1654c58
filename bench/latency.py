# SPDX-License-Identifier: Apache-2.0
"""Topic to topic: our node, at a ball joint and with a girdle, beside one that passes through.

They take turns in one run.

Each answer is timed in this process, from before the joint state is published to the arrival of the
band states with its stamp; a third process reads the markers.
"""

from __future__ import annotations

import gc
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from linkedplane_ros import Skeleton
from linkedplane_ros.node import environment

environment.prepare()

import rclpy  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from visualization_msgs.msg import MarkerArray  # noqa: E402

HERE = Path(__file__).parent
RATES = (100, 500, 1000)  # Hz
TURN = 1.0  # s of one node's turn
TURNS = 10  # of each node at each rate
MATCH = 60.0  # s to wait for the nodes to be found; the first may have to compile
BALL_JOINT = ('flexion', 'abduction', 'rotation')
GIRDLE = 'deltoid_girdle', 'shoulder_girdle'


class Contender(NamedTuple):
    """A node that is measured."""

    command: list[str]
    muscle: str = 'deltoid'
    joints: tuple[str, ...] = BALL_JOINT


NODES = {
    'ours': Contender([sys.executable, '-m', 'linkedplane_ros.node']),
    'ours with a girdle': Contender(
        [sys.executable, '-m', 'linkedplane_ros.node'],
        GIRDLE[0],
        Skeleton.load(GIRDLE[1]).coordinates,
    ),
    'pass-through': Contender([sys.executable, str(HERE / 'pass_through.py')]),
}


class Stopwatch(Node):
    """Publishes joint states to one node at a time and takes the time of its answers."""

    def __init__(self) -> None:
        """Meet the nodes, by their namespaces."""
        super().__init__('stopwatch')
        deep = QoSProfile(depth=2000)
        self.arrivals: dict[int, float] = {}
        self.publishers_to = {}
        self.readers = []
        for name, node in NODES.items():
            space = namespace(name)
            self.publishers_to[name] = self.create_publisher(
                JointState, f'{space}/joint_states', deep
            )
            self.readers.append(
                self.create_subscription(
                    JointState, f'{space}/{node.muscle}/band_states', self._on_answer, deep
                )
            )
        self.spinner = SingleThreadedExecutor()
        self.spinner.add_node(self)
        self._stamp = 0

    def _on_answer(self, message: JointState) -> None:
        stamp = message.header.stamp
        self.arrivals[stamp.sec * 10**9 + stamp.nanosec] = time.perf_counter()

    def connect(self) -> None:
        """Wait until the nodes are found; RuntimeError if they are not."""
        deadline = time.monotonic() + MATCH
        while not all(p.get_subscription_count() for p in self.publishers_to.values()) or not all(
            r.get_publisher_count() for r in self.readers
        ):
            if time.monotonic() > deadline:
                raise RuntimeError('the nodes did not find each other')
            self.spinner.spin_once(timeout_sec=0.05)

    def feed(self, name: str, rate: int, seconds: float) -> tuple[list[float], int]:
        """Feed one node; return the latencies of its answers, s, and the number missing."""
        publisher, joints = self.publishers_to[name], list(NODES[name].joints)
        others = [0.1] * (len(joints) - 2)
        period = 10**9 // rate
        sent: dict[int, float] = {}
        begin = time.perf_counter()
        for k in range(int(rate * seconds)):
            due = begin + k / rate
            while (left := due - time.perf_counter()) > 0.0:
                self.spinner.spin_once(timeout_sec=left)
            self._stamp += period
            swing = 0.5 + 0.4 * np.sin(1e-9 * self._stamp)
            message = JointState(name=joints, position=[swing, *others, 0.4])
            message.velocity = [0.1] * len(joints)
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(self._stamp, 10**9)
            sent[self._stamp] = time.perf_counter()
            publisher.publish(message)
        end = time.perf_counter() + 0.3
        while time.perf_counter() < end and not sent.keys() <= self.arrivals.keys():
            self.spinner.spin_once(timeout_sec=0.05)
        answered = sent.keys() & self.arrivals.keys()
        return [self.arrivals[k] - sent[k] for k in answered], len(sent) - len(answered)


def namespace(name: str) -> str:
    """Return the namespace of one of the nodes."""
    return '/' + name.replace('-', '_').replace(' ', '_')


def cpu_time(process: subprocess.Popen[bytes]) -> float:
    """Return the processor time of a process so far, s."""
    fields = Path(f'/proc/{process.pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def read_markers() -> None:
    """Receive the markers of all nodes, unread, until interrupted."""
    rclpy.init()
    reader = Node('marker_reader')
    for name, node in NODES.items():
        topic = f'{namespace(name)}/{node.muscle}/markers'
        reader.create_subscription(MarkerArray, topic, lambda _: None, 5, raw=True)
    rclpy.spin(reader)


def measure() -> dict[str, dict[str, dict[str, float]]]:
    """Return each rate's and node's median, p99 and worst latency, s; CPU share; answers lost."""
    os.environ.update(ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST', ROS_DOMAIN_ID='102')
    quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    girdle = ['-p', f'muscle:={GIRDLE[0]}', '-p', f'skeleton:={GIRDLE[1]}']
    processes = {
        name: subprocess.Popen(
            [*node.command, '--ros-args', '-r', f'__ns:={namespace(name)}']
            + girdle * (node.muscle == GIRDLE[0]),
            **quiet,
        )
        for name, node in NODES.items()
    }
    reader = subprocess.Popen([sys.executable, __file__, 'read markers'], **quiet)
    rclpy.init()
    stopwatch = Stopwatch()
    try:
        stopwatch.connect()
        for name in NODES:
            stopwatch.feed(name, 100, 1.0)
        found: dict[str, dict[str, dict[str, float]]] = {}
        for rate in RATES:
            times: dict[str, list[float]] = {name: [] for name in NODES}
            lost = dict.fromkeys(NODES, 0)
            used = dict.fromkeys(NODES, 0.0)
            for _ in range(TURNS):
                for name in NODES:
                    before = cpu_time(processes[name])
                    latencies, missing = stopwatch.feed(name, rate, TURN)
                    times[name] += latencies
                    lost[name] += missing
                    used[name] += cpu_time(processes[name]) - before
            found[f'{rate} Hz'] = {
                name: {
                    'median': float(np.median(times[name])),
                    'p99': float(np.percentile(times[name], 99)),
                    'worst': max(times[name]),
                    'cpu': used[name] / (TURNS * TURN),
                    'lost': lost[name],
                }
                for name in NODES
            }
        return found
    finally:
        for process in (*processes.values(), reader):
            process.send_signal(signal.SIGINT)
            process.wait(10)
        stopwatch.destroy_node()
        rclpy.try_shutdown()


if __name__ == '__main__':
    if sys.argv[1:] == ['read markers']:
        with suppress(KeyboardInterrupt):
            read_markers()
    else:
        gc.disable()  # no stalls of the stopwatch's own
        print(json.dumps(measure()))
