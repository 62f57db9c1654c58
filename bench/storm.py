# SPDX-License-Identifier: Apache-2.0
"""Storm and flood: 1,000 batches of parameters while data flow, and messages as fast as can be.

`make soak` runs it; `python bench/storm.py BATCHES SECONDS` for less. It ends with status 1 if an
answer is of no set of parameters or of two, if memory grows, or if the node is not well afterwards.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from typing import Any

from soak import resident_memory  # it prepares ROS

import numpy as np  # isort: skip
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver

COMMAND = [sys.executable, '-m', 'linkedplane_ros.node', '--ros-args']
for name, value in (
    ('joint_names', '[a, b, c]'),
    ('qos_overrides./joint_states.subscription.reliability', 'reliable'),
    ('qos_overrides./joint_states.subscription.depth', '500'),
):
    COMMAND += ['-p', f'{name}:={value}']
CLIENTS = 4
WAITING = 5  # joint states without an answer at a time, so that none is lost in the storm
GROWTH = 2.0  # MiB, of the node's memory over the later three quarters
EXACT = 1e-12  # m
JOINTS = ['a', 'b', 'c']
POSE = (0.3, 0.8, 0.2)  # rad
PATIENCE = 60.0  # s
FLOOD = (  # what comes as fast as can be
    JointState(name=JOINTS, position=POSE, velocity=(0.1, 0.2, 0.3)),
    JointState(name=JOINTS, position=(0.0, math.nan, 0.0)),
    JointState(name=JOINTS, position=(0.0, 90.0, 0.0)),
    JointState(name=JOINTS, position=(0.0, 0.1)),
    JointState(name=[f'finger_{k}' for k in range(1000)], position=[0.0] * 1000),
)


def make_sets() -> dict[str, dict[str, Any]]:
    """Return sets of parameters by the frame that each of them names; their answers differ."""
    conventions = ('flexion_abduction_rotation', 'isb_yxy')
    return {
        f'set_{k}': {
            'frame_id': f'set_{k}',
            'side': ('right', 'left')[k % 2],
            'joint_convention': conventions[k // 2 % 2],
            'joint_offsets': [0.02 * k, 0.01 * k, -0.03 * k],
        }
        for k in range(8)
    }


def solve_set(values: dict[str, Any]) -> tuple[Any, Any]:
    """Return the lengths and moment arms, m, that a set gives at the pose."""
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'), values['side'])
    angles = np.add(POSE, values['joint_offsets'])
    answer = solver.answer(JOINT_CONVENTIONS[values['joint_convention']], angles, (0.0, 0.0, 0.0))
    return answer.state.lengths, answer.moment_arms.ravel()


class Storm(Node):
    """Sends joint states, and compares what comes back with what each set gives."""

    def __init__(self) -> None:
        super().__init__('storm')
        deep = QoSProfile(depth=10000)
        self.sets = make_sets()
        self.expected = {frame: solve_set(values) for frame, values in self.sets.items()}
        self.sent = 0
        self.answers: dict[str, dict[int, str]] = {'band_states': {}, 'moment_arm_states': {}}
        self.wrong: list[str] = []
        self.status: dict[str, str] = {}
        self.reports = 0
        self.joints = self.create_publisher(JointState, 'joint_states', deep)
        for part, topic in enumerate(self.answers):
            take = self._make_check(topic, part)
            self.create_subscription(JointState, f'deltoid/{topic}', take, deep)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def _make_check(self, topic: str, part: int) -> Any:
        def check(message: JointState) -> None:
            frame = message.header.frame_id
            self.answers[topic][message.header.stamp.sec] = frame
            if frame in self.expected:
                off = np.abs(np.array(message.position) - self.expected[frame][part]).max()
                if not off <= EXACT:
                    self.wrong.append(f'{topic} of {frame} is off by {off:g} m')

        return check

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.reports += 1
        self.status = {item.key: item.value for item in message.status[0].values}

    def send(self) -> None:
        """Publish the pose; its stamp is its number."""
        self.sent += 1
        message = JointState(name=JOINTS, position=POSE)
        message.header.stamp.sec = self.sent
        self.joints.publish(message)


class Client(Node):
    """Sets batches of parameters, one after the other; every fifth is one that must be refused."""

    def __init__(self, number: int, sets: dict[str, dict[str, Any]], batches: int) -> None:
        super().__init__(f'client_{number}')
        self._service = self.create_client(
            SetParametersAtomically, 'muscle_state_publisher/set_parameters_atomically'
        )
        self._sets, self._number, self.left = list(sets.values()), number, batches
        self._future: Any = None
        self.counts: Counter[str] = Counter()

    def work(self) -> None:
        """Take the answer to the last batch, and send the next."""
        if self._future is not None:
            if not self._future.done():
                return
            taken, right = self._future.result().result.successful, bool(self.left % 5)
            self.counts['taken' if taken else 'refused'] += 1
            self.counts['mistaken'] += taken != right
            self._future = None
            self.left -= 1
        if self.left and self._service.service_is_ready():
            values = self._sets[(3 * self.left + self._number) % len(self._sets)]
            values = values if self.left % 5 else {**values, 'markers.points': 1}
            batch = [Parameter(name, value=value).to_parameter_msg() for name, value in
                     values.items()]  # fmt: skip
            request = SetParametersAtomically.Request(parameters=batch)
            self._future = self._service.call_async(request)


def wait(spinner: SingleThreadedExecutor, condition: Any) -> bool:
    """Work until a condition holds, PATIENCE at most; return whether it does."""
    end = time.perf_counter() + PATIENCE
    while not condition():
        if time.perf_counter() > end:
            return False
        spinner.spin_once(timeout_sec=0.05)
    return True


def run_storm(
    node: Storm, spinner: SingleThreadedExecutor, process: Any, batches: int
) -> tuple[bool, list[float]]:
    """Set parameters from all clients while data flow; return whether all was right, and memory."""
    clients = [Client(k, node.sets, batches // CLIENTS) for k in range(CLIENTS)]
    for client in clients:
        spinner.add_node(client)
    memory: list[float] = []
    begin = time.perf_counter()
    total = sum(client.left for client in clients)
    while left := sum(client.left for client in clients):
        if process.poll() is not None:
            raise SystemExit('storm: the node ended')
        if (total - left) * 100 // total >= len(memory):
            memory.append(resident_memory(process))
        if node.sent < len(node.answers['moment_arm_states']) + WAITING:
            node.send()
        for client in clients:
            client.work()
        spinner.spin_once(timeout_sec=0.001)
    lengths, arms = node.answers.values()
    wait(spinner, lambda: len(lengths) == len(arms) == node.sent)
    counts = sum((client.counts for client in clients), Counter())
    split = sum(lengths[k] != arms[k] for k in lengths.keys() & arms.keys())
    met = len(set(lengths.values()))
    print(f'storm: {total} batches from {CLIENTS} clients in {time.perf_counter() - begin:.0f} s, '
          f'{counts["taken"]} taken, {counts["refused"]} refused, {counts["mistaken"]} mistaken; '
          f'{node.sent} joint states, {len(lengths)} answered, of {met} sets; {split} of two sets, '
          f'{len(node.wrong)} of none {node.wrong[:1] or ""}')  # fmt: skip
    for client in clients:
        spinner.remove_node(client)
        client.destroy_node()
    good = len(lengths) == len(arms) == node.sent and met > len(node.sets) // 2
    return good and not (split or node.wrong or counts['mistaken']), memory


def run_flood(node: Storm, spinner: SingleThreadedExecutor, seconds: float) -> bool:
    """Send messages as fast as can be; return whether the node is well afterwards."""
    flood = node.create_publisher(JointState, 'joint_states', 10)
    sent, reports, end = 0, node.reports, time.perf_counter() + seconds
    while time.perf_counter() < end:
        for message in FLOOD:
            flood.publish(message)
        sent += len(FLOOD)
        spinner.spin_once(timeout_sec=0.0)
    reports = node.reports - reports

    def is_answered() -> bool:
        node.send()
        return node.answers['band_states'].get(node.sent - 20) is not None

    well = wait(spinner, is_answered)
    seen = node.reports
    well = wait(spinner, lambda: node.reports > seen + 1) and well
    number = {key: int(value) for key, value in node.status.items() if value.isdecimal()}
    rejected = sum(value for key, value in number.items() if key.startswith('rejected: '))
    received, answered = number['messages received'], number['messages answered']
    others = number['messages of other joints']
    print(f'flood: {sent:,} messages in {seconds:g} s, {reports} diagnostics meanwhile; in all '
          f'{received:,} received, {answered:,} answered, {rejected:,} rejected, {others:,} of '
          f'other joints; {"well" if well else "not well"} afterwards')  # fmt: skip
    return well and received == answered + rejected + others and reports > 0.5 * seconds - 2


def main() -> int:
    """Run both and print the figures; return the exit status."""
    batches = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 30.0
    os.environ.update(ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', '103')
    process = subprocess.Popen(COMMAND, stderr=subprocess.DEVNULL)
    rclpy.init()
    node, spinner = Storm(), SingleThreadedExecutor()
    spinner.add_node(node)
    try:
        if not wait(spinner, lambda: node.joints.get_subscription_count() and node.reports):
            raise SystemExit('storm: the node does not report')
        right, memory = run_storm(node, spinner, process, batches)
        start = len(memory) // 4
        growth = max(memory[start:]) - memory[start]
        before = resident_memory(process)
        well = run_flood(node, spinner, seconds)
        after = resident_memory(process)
    finally:
        process.send_signal(signal.SIGINT)
        status = process.wait(10)
        rclpy.try_shutdown()
    print(f'memory: {memory[start]:.1f} MiB after a quarter of the storm, then {growth:.2f} more '
          f'at most (bound: {GROWTH:g}); {before:.1f} before the flood, {after:.1f} after it; '
          f'exit status {status}')  # fmt: skip
    return 0 if right and well and growth < GROWTH and status == 0 else 1


if __name__ == '__main__':
    sys.exit(main())
