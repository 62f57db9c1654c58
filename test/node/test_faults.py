# SPDX-License-Identifier: Apache-2.0
"""What goes wrong: odd messages, signals, publishers that die and come back."""

from __future__ import annotations

import math
import random
import signal
import subprocess
import sys
import time
from array import array
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from optional import requires
from rclpy.node import Node
from ros_harness import NodeProcess, Peer
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from unhurried import PATIENCE
from visualization_msgs.msg import MarkerArray

from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.topics import OUTPUTS

NAMES = ('flexion', 'abduction', 'rotation')
POSE = (0.3, 0.2, 0.1)  # rad


class Catcher:
    """Stands at the end of an output: counts the messages and looks at every number in them."""

    def __init__(self) -> None:
        self.count = 0

    def get_subscription_count(self) -> int:
        return 1

    def publish(self, message: Any) -> None:
        self.count += 1
        assert all(map(math.isfinite, numbers(message)))


def numbers(message: Any) -> Iterator[float]:
    """Yield every floating-point number of an output."""
    if isinstance(message, Float64MultiArray):
        yield from message.data
    elif isinstance(message, JointState):
        yield from (*message.position, *message.velocity, *message.effort)
    elif isinstance(message, MarkerArray):
        for marker in message.markers:
            at, turn, scale = marker.pose.position, marker.pose.orientation, marker.scale
            yield from (at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w, scale.x, scale.y, scale.z)
            for point in marker.points:
                yield from (point.x, point.y, point.z)


ODD = (0.0, -0.0, math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 90.0, 6.283185307179586)
VALUES = st.one_of(st.floats(-3.0, 3.0), st.floats(), st.sampled_from(ODD))
JOINTS = st.one_of(st.sampled_from(NAMES), st.text(max_size=5))
MESSAGES = st.tuples(
    st.one_of(st.permutations(NAMES), st.lists(JOINTS, max_size=6)),
    st.lists(VALUES, max_size=7),
    st.one_of(st.just([]), st.lists(VALUES, max_size=7)),
    st.integers(0, 10**9),
)


def similar_messages(
    drawn: tuple[list[str], list[float], list[float], int], count: int
) -> Iterator[JointState]:
    """Yield a drawn message and so many like it: mostly of fitting sizes, each changed a little."""
    names, positions, velocities, seed = drawn
    start = seed * 10**9  # ns
    chance = random.Random(seed)
    for k in range(count):
        n, q, v = list(names), list(positions), list(velocities)
        if k and n and chance.random() < 0.9:
            q = [chance.choice(q or [0.0]) for _ in n]
            v = [chance.choice(v or [0.0]) for _ in n] if v and chance.random() < 0.9 else []
        if k and n and chance.random() < 0.7:
            q = [chance.uniform(-3.0, 3.0) for _ in n]
            q[chance.randrange(len(n))] = chance.choice((*q, *ODD))
        if k and n and chance.random() < 0.3:
            n[chance.randrange(len(n))] = chance.choice((*n, *NAMES))
        if chance.random() < 0.001:  # a whole body, finger by finger
            n = [f'joint_{i}' for i in range(10_000)] + n
            q = [0.1] * 10_000 + q
            v = []
        # unchecked, as the middleware makes them
        message = JointState(
            name=n, position=array('d', q), velocity=array('d', v), check_fields=False
        )
        # 1 kHz, and now and then a jump
        start += 10**6 if chance.random() < 0.95 else chance.randrange(-(10**9), 10**9)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(start, 10**9)
        yield message


EXAMPLES, EACH = 400, 250


def test_a_hundred_thousand_odd_messages_are_answered_or_counted(ros: None) -> None:
    node = MuscleStatePublisher()
    catchers = {topic.name: Catcher() for topic in OUTPUTS}
    [muscle] = node._muscles
    real, muscle.topics = muscle.topics, catchers
    sent = Counter[str]()

    @settings(
        max_examples=EXAMPLES, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )
    @given(MESSAGES)
    def feed(drawn: Any) -> None:
        for message in similar_messages(drawn, EACH):
            sent['all'] += 1
            node._answer(message)

    feed()
    muscle.topics = real
    tally = muscle.tally
    node.destroy_node()
    assert sent['all'] >= EXAMPLES * EACH
    assert tally.received == sent['all']
    assert tally.answered + tally.others + sum(tally.rejected.values()) == tally.received
    for name, catcher in catchers.items():
        if name != 'markers':
            assert catcher.count == tally.answered
    assert catchers['markers'].count > 1000
    assert min(tally.answered, tally.others, *(tally.rejected[reason] for reason in (
        'sizes', 'not_finite', 'degrees'))) > 1000  # fmt: skip


def wait_for_start(process: NodeProcess) -> None:
    """Wait until the node's own code runs: Python has taken SIGINT, and the node has let it go."""
    status = Path(f'/proc/{process.process.pid}/status')
    if not status.exists():
        pytest.skip('the system does not tell which signals a process catches')
    python_runs = False
    while process.process.poll() is None:
        line = next(x for x in status.read_text().splitlines() if x.startswith('SigCgt'))
        caught = int(line.split()[1], 16)
        interrupt, terminate = (
            bool(caught >> (number - 1) & 1) for number in (signal.SIGINT, signal.SIGTERM)
        )
        if terminate or (python_runs and not interrupt):  # only ROS takes SIGTERM, later
            return
        python_runs = python_runs or interrupt
        time.sleep(0.001)  # the node needs the processor, too


MOMENTS = (0.0, 0.1, 0.3, 0.6, 1.0)  # s


@pytest.mark.parametrize('how', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('moment', MOMENTS)
def test_a_signal_at_any_moment_ends_the_node_without_a_traceback(
    tmp_path: Path, how: signal.Signals, moment: float
) -> None:
    process = NodeProcess(tmp_path / 'node.log')
    wait_for_start(process)
    time.sleep(moment)
    assert process.stop(how) in (0, -how), process.text
    assert 'Traceback' not in process.text


@requires('numba')
@pytest.mark.parametrize('how', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_node_while_its_solver_is_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: signal.Signals
) -> None:
    compiled = tmp_path / 'compiled'
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(compiled))
    node = NodeProcess(tmp_path / 'log')
    deadline = time.monotonic() + PATIENCE
    while 'preparing the solver' not in node.text and node.process.poll() is None:
        assert time.monotonic() < deadline, node.text
        time.sleep(0.05)
    node.process.send_signal(how)  # Ctrl-C reaches a launched node twice
    assert node.stop(how) == 0, node.text
    assert 'Traceback' not in node.text
    assert not list(compiled.rglob('*.nbc')), 'it ended only when all was compiled'


PUBLISHER = """
import time
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
rclpy.init()
publisher = Node('mortal').create_publisher(JointState, 'joint_states', 10)
k = 0
while True:
    k += 1
    message = JointState(name=['flexion', 'abduction', 'rotation'], position=[0.3, 0.2, 0.001 * k])
    publisher.publish(message)
    time.sleep(0.01)
"""


def test_a_publisher_may_die_and_another_may_come(tmp_path: Path, peer: Peer) -> None:
    with NodeProcess(tmp_path / 'node.log') as process:
        peer.connect(process)
        for _ in range(2):
            before = len(peer.got['band_lengths'])
            mortal = subprocess.Popen([sys.executable, '-c', PUBLISHER])
            try:
                assert peer.until(lambda before=before: len(peer.got['band_lengths']) > before + 20)
            finally:
                mortal.kill()
                mortal.wait()
            peer.until(lambda: False, 0.3)
        peer.send(NAMES, POSE, nanoseconds=7)
        assert peer.until(
            lambda: any(state.header.stamp.nanosec == 7 for state in peer.got['band_states'])
        )


def test_of_two_publishers_the_newest_message_counts(node: MuscleStatePublisher, peer: Peer
                                                     ) -> None:  # fmt: skip
    other = Node('other')
    second = other.create_publisher(JointState, 'joint_states', 10)
    assert peer.until(lambda: second.get_subscription_count() > 0)
    poses = [POSE if k % 2 else (0.9, 0.8, 0.7) for k in range(20)]
    for k, pose in enumerate(poses):
        if k % 2:
            peer.send(NAMES, pose)
        else:
            second.publish(JointState(name=NAMES, position=pose))
        assert peer.answers(k + 1)
    other.destroy_node()
    solver, convention = node._settings.solvers[0], node._settings.convention
    for pose, lengths in zip(poses, peer.got['band_lengths'], strict=True):
        want = solver.solve(convention.rotation(pose)).lengths
        assert np.abs(np.array(lengths.data) - want).max() < 1e-12
