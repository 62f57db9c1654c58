# SPDX-License-Identifier: Apache-2.0
"""The end of a terminal ends the executables as SIGTERM does; two nodes of one name are named."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from rclpy.node import Node
from ros_harness import NodeProcess, Peer, hear_hangup, together
from unhurried import PATIENCE

from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

ENDED = """
import signal
import sys
from linkedplane_ros.node.ros_arguments import initialise_ros
import rclpy

initialise_ros([])
node = rclpy.create_node('any')
node.create_timer(0.1, lambda: print('turns', flush=True))
try:
    rclpy.spin(node)
except Exception:  # by a signal in the middle of a call
    assert not rclpy.ok()
print('ended', flush=True)
"""


@pytest.mark.parametrize('how', [signal.SIGTERM, signal.SIGHUP])
def test_the_end_of_its_terminal_ends_the_node_as_sigterm_does(
    tmp_path: Path, peer: Peer, how: signal.Signals
) -> None:
    node = NodeProcess(tmp_path / 'log')
    peer.connect(node)
    assert node.stop(how) == 0
    assert 'Traceback' not in node.text


@pytest.mark.parametrize(('before', 'ends'), [(signal.SIG_DFL, True), (signal.SIG_IGN, False)])
def test_what_initialises_ros_ends_by_a_hangup_unless_nohup_ignores_it(
    before: signal.Handlers, ends: bool
) -> None:
    process = subprocess.Popen(
        [sys.executable, '-c', ENDED],
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, before),
    )
    assert process.stdout is not None
    assert process.stdout.readline() == 'turns\n'
    process.send_signal(signal.SIGHUP)
    for _ in range(20):
        line = process.stdout.readline()
        if line != 'turns\n':
            break
    assert line == ('ended\n' if ends else 'turns\n')
    if not ends:
        process.terminate()
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 0


@pytest.mark.parametrize('how', [signal.SIGTERM, signal.SIGHUP])
def test_the_demonstration_ends_and_leaves_no_node_behind(how: signal.Signals) -> None:
    process = subprocess.Popen(
        [sys.executable, '-m', 'linkedplane_ros.commands.demo'],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=hear_hangup,
    )
    assert process.stdout is not None
    try:
        assert process.stdout.readline()
        process.send_signal(how)
        _, errors = process.communicate(timeout=PATIENCE)
        assert 'Traceback' not in errors
        assert process.returncode == 143
        with pytest.raises(ProcessLookupError):
            os.killpg(process.pid, 0)
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def test_two_nodes_of_one_name_are_a_warning_by_name(
    peer: Peer, capfd: pytest.CaptureFixture[str]
) -> None:
    node = MuscleStatePublisher()
    other = Node('muscle_state_publisher', namespace='elsewhere')
    with together(peer, node):
        peer.connect()
        assert peer.until(lambda: len(peer.diagnostics) > 1)
        assert 'in the graph' not in peer.diagnostics[-1].status[0].message
        twin = Node('muscle_state_publisher')
        seen = len(peer.diagnostics)
        assert peer.until(lambda: len(peer.diagnostics) > seen + 1)
        peer.send(('flexion', 'abduction', 'rotation'), (0.1, 0.2, 0.3))
        assert peer.until(
            lambda: (
                '1 more of the name /muscle_state_publisher in the graph'
                in peer.diagnostics[-1].status[0].message
            )
        )
        twin.destroy_node()
        seen = len(peer.diagnostics)
        assert peer.until(lambda: 'in the graph' not in peer.diagnostics[-1].status[0].message)
    for each in (node, other):
        each.destroy_node()
    assert capfd.readouterr().err.count('more of the name /muscle_state_publisher') == 1
