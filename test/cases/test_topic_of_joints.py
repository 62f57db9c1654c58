# SPDX-License-Identifier: Apache-2.0
"""An empty /joint_states, or one of other joints, does not hide the topic that has the joints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from bags import NAMES, Sent, exit_status, joint_state, read_csv, refusal_line, write_bag

ARM = tuple(f'shoulder_{name}' for name in NAMES)


def motion(topic: str, names: Sequence[str]) -> list[Sent]:
    """Return 10 joint states on a topic."""
    return [(topic, *joint_state(k, names)[1:]) for k in range(10)]


@pytest.mark.parametrize('gripper', [['finger'], []])
def test_the_one_topic_that_has_the_joints_is_chosen_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], gripper: list[str]
) -> None:
    sent = motion('/joint_states', gripper) if gripper else []
    empty = [] if gripper else ['/joint_states']
    bag = write_bag(tmp_path / 'bag', sent + motion('/arm/joint_states', NAMES), empty=empty)
    assert exit_status([str(bag), str(tmp_path / 'out.csv')]) == 0
    facts, _, rows = read_csv(tmp_path / 'out.csv')
    assert len(rows) == 10
    assert facts['topic'] == '/arm/joint_states'
    assert 'joint states of /arm/joint_states, not of /joint_states' in capsys.readouterr().out


def test_joints_that_come_one_in_a_message_are_seen(tmp_path: Path) -> None:
    arm = [('/arm/joint_states', *joint_state(k, NAMES[k % 3 :][:1])[1:]) for k in range(12)]
    bag = write_bag(tmp_path / 'bag', motion('/joint_states', ['finger']) + arm)
    assert exit_status([str(bag), str(tmp_path / 'out.csv')]) == 0
    assert len(read_csv(tmp_path / 'out.csv')[2]) == 10  # from the third on


def test_a_hint_names_each_topic_with_its_joints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    odd = ['a\nb', *(f'finger_{k}' for k in range(9))]
    sent = motion('/joint_states', ['finger']) + motion('/arm/joint_states', ARM)
    sent += [('/hand', *joint_state(0, odd, position=[0.0] * 10)[1:])]
    bag = write_bag(tmp_path / 'bag', sent)
    line = refusal_line(capsys, str(bag), str(tmp_path / 'out.csv'))
    assert 'no topic has the joints flexion, abduction, rotation' in line
    assert f'--topic /arm/joint_states: {", ".join(ARM)};' in line
    assert "--topic /hand: 'a\\nb', finger_0, finger_1, finger_2, finger_3, finger_4, ...;" in line
    command = [str(bag), str(tmp_path / 'out.csv'), '--joints', *ARM]
    assert exit_status(command) == 0


def test_an_empty_topic_that_was_asked_for_is_refused_with_the_hint(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = write_bag(tmp_path / 'bag', motion('/arm', NAMES), empty=['/joint_states'])
    line = refusal_line(capsys, str(bag), str(tmp_path / 'o.csv'), '--topic', '/joint_states')
    assert 'on /joint_states in it, but /arm (sensor_msgs/msg/JointState); --topic /arm: ' in line


def test_several_topics_with_the_joints_are_a_choice(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = write_bag(tmp_path / 'bag', motion('/left', NAMES) + motion('/right', NAMES))
    line = refusal_line(capsys, str(bag), str(tmp_path / 'out.csv'))
    assert 'several topics have the joints' in line
    assert '--topic /left: flexion, abduction, rotation' in line


def test_joint_states_come_first_where_several_topics_have_the_joints(tmp_path: Path) -> None:
    sent = motion('/joint_states', NAMES) + motion('/commands', NAMES)
    bag = write_bag(tmp_path / 'bag', sent)
    assert exit_status([str(bag), str(tmp_path / 'out.csv')]) == 0
    assert read_csv(tmp_path / 'out.csv')[0]['topic'] == '/joint_states'
