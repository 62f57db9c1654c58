# SPDX-License-Identifier: Apache-2.0
"""The demonstration: the node in a process of its own, fed over DDS from a recording."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy._rclpy_pybind11 import RCLError
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from ..errors import LinkedPlaneError
from ..muscle.broad_muscle import BroadMuscle
from ..processing.topics import ANSWERS
from ..recordings.bags.recording import Recording
from .messages import message_class
from .ros_arguments import argument_errors, initialise_ros, warn_of_unknown_parameters
from .topics import DIAGNOSTICS, OUTPUTS

NAMES = tuple(topic.name for topic in ANSWERS)
STARTING = 300.0  # s for the node to start; the first time it compiles the solver
PATIENCE = 120.0  # s for the recording to be played and answered
RELIABLE_INPUT = [
    '--ros-args',
    '-p',
    'qos_overrides./joint_states.subscription.reliability:=reliable',
]
TERMINATED = 143  # exit status
ROWS_EVERY = 0.5  # s of the recording between rows of the table


class Listener(Node):
    """Listens to the input and the outputs of the muscle node, and prints a table."""

    def __init__(self, muscle: BroadMuscle) -> None:
        """Subscribe to all topics."""
        super().__init__('linkedplane_demo')
        self._muscle = muscle
        self.counts: dict[str, int] = defaultdict(int)
        self._inputs: dict[int, JointState] = {}
        self._arms: list[np.ndarray[Any, Any]] = []
        self._states: list[JointState] = []
        self._rows = 0
        self._next_row: float | None = None
        qos = QoSProfile(depth=1000)
        self._listening = [
            self.create_subscription(JointState, 'joint_states', self._count_input, qos)
        ]
        for topic in OUTPUTS:
            self._listening.append(
                self.create_subscription(
                    message_class(topic.type),
                    f'{muscle.name}/{topic.name}',
                    self._make_counter(topic.name),
                    qos,
                )
            )

        # the last: a node whose diagnostics come knows this listener's other subscriptions, too
        self._listening.append(
            self.create_subscription(
                DiagnosticArray, DIAGNOSTICS.name, self._make_counter(DIAGNOSTICS.name), qos
            )
        )

    def is_connected(self) -> bool:
        """Return whether the node and this listener have found each other, both ways."""
        return self.counts[DIAGNOSTICS.name] > 0 and all(
            one.get_publisher_count() for one in self._listening[1:]
        )

    def _count_input(self, message: JointState) -> None:
        self.counts['joint_states'] += 1
        self._inputs[read_stamp(message)] = message

    def _make_counter(self, topic: str) -> Any:
        def count(message: Any) -> None:
            self.counts[topic] += 1
            if topic == 'moment_arms':
                self._arms.append(np.array(message.data).reshape(-1, 3))
            if topic == 'band_states':
                self._states.append(message)
            while self._rows < min(len(self._arms), len(self._states)):
                self._print_row(self._states[self._rows], self._arms[self._rows])
                self._rows += 1

        return count

    def _print_row(self, message: JointState, arms: np.ndarray[Any, Any]) -> None:
        """Print a row of the table, twice a second of the recording."""
        now = 1e-9 * read_stamp(message)
        if self._next_row is None:
            self._print_header(now)
        pose = self._inputs.get(read_stamp(message))
        if now + 1e-6 < (self._next_row or 0.0) or pose is None:
            return
        self._next_row = (self._next_row or 0.0) + ROWS_EVERY
        cells = [f'{now - self._begin:5.1f}']
        cells += [f'{round(np.degrees(q)) + 0:6d}' for q in pose.position]
        for head in self._muscle.heads:
            band = self._muscle.band_names.index(head.represented_by)
            cells.append(f' {1e3 * message.position[band]:7.1f}')
            cells += [f'{1e3 * arm:6.1f}' for arm in arms[band]]
        print(' '.join(cells), flush=True)

    def _print_header(self, now: float) -> None:
        self._begin = self._next_row = now
        heads = ''.join(f'{head.name + " head (mm)":^30}' for head in self._muscle.heads)
        print(f'\n{"":5} {"pose (deg)":^20} {heads}')
        length_and_arms = f' {"length":>7} {"r_flx":>6} {"r_abd":>6} {"r_rot":>6}'
        print(f'{"t(s)":>5} {"flex":>6} {"abd":>6} {"rot":>6}' +
              length_and_arms * len(self._muscle.heads))  # fmt: skip


def read_stamp(message: JointState) -> int:
    """Return the stamp of a message, ns since the epoch."""
    stamp = message.header.stamp
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def sample_folder() -> Path:
    """Return the folder of sample messages: of the source tree, or as installed."""
    sources = Path(__file__).resolve().parents[2] / 'msg_examples'
    prefixes = [sys.prefix, *os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)]
    installed = [Path(p) / 'share' / 'linkedplane_ros' / 'msg_examples' for p in prefixes if p]
    for folder in [sources, *installed]:
        if (folder / 'arm_raise').is_dir():
            return folder
    raise LinkedPlaneError(f'the sample recording arm_raise is neither in {sources} nor installed')


def main(ros_arguments: Sequence[str] = ()) -> int:
    """Run the demonstration; return 0 if every joint state was answered on every topic.

    SIGTERM, or the end of the terminal, ends it with 143.
    """
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', str(os.getpid() % 100 + 1))
    recording = Recording.from_bag(sample_folder() / 'arm_raise')
    muscle = BroadMuscle.load('deltoid')
    run = [sys.executable, '-m']
    initialise_ros(ros_arguments)
    with argument_errors():
        listener = Listener(muscle)
    warn_of_unknown_parameters(listener)
    node = subprocess.Popen([*run, 'linkedplane_ros.node', *RELIABLE_INPUT])
    player = None
    try:
        if not spin_until(listener, listener.is_connected, node, STARTING):
            print('demo: the node did not start', file=sys.stderr)
            return 1
        print(
            f'An arm raised in scaption and lowered, {recording.count} joint states over DDS;\n'
            'each head by one band; r_* the moment arms about flexion, abduction and internal '
            'rotation,\npositive where shortening turns the joint that way.',
            flush=True,
        )
        player = subprocess.Popen(
            # the node and this listener; discovery takes up to some seconds
            [
                *run,
                'linkedplane_ros.commands',
                'play',
                str(recording.path),
                '--subscribers',
                '2',
                '--wait',
                f'{PATIENCE:g}',
            ],
            stdout=subprocess.DEVNULL,
        )
        done = spin_until(listener, lambda: all_answered(listener, recording.count), node, PATIENCE)
        return print_summary(listener, recording.count) if done else print_summary(listener, -1)
    except (ExternalShutdownException, RCLError, InvalidHandle):
        if rclpy.ok():  # otherwise a signal came
            raise
        return TERMINATED
    finally:
        for process in (node, player):
            if process is not None:
                process.send_signal(signal.SIGINT)
                process.wait(PATIENCE)
        listener.destroy_node()
        rclpy.try_shutdown()


def all_answered(listener: Listener, count: int) -> bool:
    """Return whether `count` joint states and all answers to them have arrived."""
    return all(listener.counts[topic] >= count for topic in ('joint_states', *NAMES))


def spin_until(
    listener: Listener, condition: Any, node: subprocess.Popen[bytes], patience: float
) -> bool:
    """Read messages until a condition holds, at most `patience` s; return whether it does.

    It ends early if the node ends.
    """
    deadline = time.monotonic() + patience
    while not condition():
        if time.monotonic() > deadline or node.poll() is not None:
            return False
        rclpy.spin_once(listener, timeout_sec=0.05)
    return True


def print_summary(listener: Listener, expected: int) -> int:
    """Print the counts of inputs and answers; return 0 if they are equal."""
    counts = listener.counts
    print(f'\nin:  joint_states {counts["joint_states"]}')
    answers = ', '.join(f'{topic} {counts[topic]}' for topic in NAMES)
    print(f'out: {answers}; markers {counts["markers"]} (30 Hz at most)')
    equal = all(counts[topic] == counts['joint_states'] == expected for topic in NAMES)
    if not equal:
        print('the counts differ: not every joint state was answered once on every topic')
        return 1
    print('every joint state was answered once on every topic')
    return 0
