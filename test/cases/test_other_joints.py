# SPDX-License-Identifier: Apache-2.0
"""A gripper, a hand or another arm that publishes its own joints on the topic of ours."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticStatus
from ros_harness import Peer

from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

NAMES = ('flexion', 'abduction', 'rotation')
OURS, GRIPPER = (0.3, 0.5, 0.1), ('finger_left', 'finger_right')


def level_and_line(peer: Peer) -> tuple[bytes, str]:
    status = peer.diagnostics[-1].status[0]
    return status.level, status.message


def logged(capfd: pytest.CaptureFixture[str]) -> list[str]:
    return [line for line in capfd.readouterr().err.splitlines() if 'muscle_state_pub' in line]


def test_case_node_gripper_beside(
    cases: Path, node: MuscleStatePublisher, peer: Peer, capfd: pytest.CaptureFixture[str]
) -> None:
    """All of ours are answered: the status is OK, and the log has one line of information."""
    folder = cases / 'node_gripper_beside'
    ours = yaml.safe_load((folder / 'ours.yaml').read_text())
    gripper = yaml.safe_load((folder / 'gripper.yaml').read_text())
    capfd.readouterr()
    peer.send(ours['name'], ours['position'])
    assert peer.answers(1)
    before = len(peer.diagnostics)
    sent = 1
    while len(peer.diagnostics) < before + 4:
        for each in (ours, gripper):
            peer.send(each['name'], each['position'])
        sent += 1
        peer.until(lambda: False, 0.02)
    assert peer.answers(sent)
    levels = {array.status[0].level for array in peer.diagnostics[before + 1 :]}
    assert levels == {DiagnosticStatus.OK}
    assert peer.until(lambda: peer.values()['messages of other joints'] == str(sent - 1))
    assert peer.values()['messages answered'] == str(sent)
    lines = logged(capfd)
    assert not any('WARN' in line for line in lines)
    [line] = [line for line in lines if 'other joints' in line]
    assert line.endswith("passed over: 'finger_left', 'finger_right'")


def test_ours_that_fail_beside_a_gripper_warn(node: MuscleStatePublisher, peer: Peer) -> None:
    peer.send(NAMES, OURS)
    assert peer.answers(1)
    peer.send(GRIPPER, (0.01, 0.01))
    peer.send(NAMES, (0.0, 90.0, 0.0))
    assert peer.until(
        lambda: bool(peer.diagnostics) and level_and_line(peer)[0] == DiagnosticStatus.WARN
    )
    assert level_and_line(peer)[1].startswith("1 rejected in the last second: joint 'abduction'")


def test_a_gripper_does_not_hide_that_ours_have_ended(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    peer.send(NAMES, OURS)
    assert peer.answers(1)

    def stale() -> bool:
        peer.send(GRIPPER, (0.01, 0.01))
        return bool(peer.diagnostics) and 'no joint states for' in level_and_line(peer)[1]

    assert peer.until(stale)


def test_where_ours_never_came_the_names_that_did_are_an_error_in_one_line(
    node: MuscleStatePublisher, peer: Peer, capfd: pytest.CaptureFixture[str]
) -> None:
    peer.send(('finger\n[ERROR] forged', 'x' * 500), (0.1, 0.2))
    assert peer.until(
        lambda: bool(peer.diagnostics) and level_and_line(peer)[0] == DiagnosticStatus.ERROR
    )
    assert "but 'finger\\n[ERROR] forged', 'xxx" in level_and_line(peer)[1]
    assert len(level_and_line(peer)[1]) < 350
    logs: list[str] = []

    def warned() -> bool:
        logs.extend(capfd.readouterr().err.splitlines())
        return any('none of the joints' in line for line in logs)

    assert peer.until(warned)
    assert not any(line.startswith('[ERROR]') for line in logs)
