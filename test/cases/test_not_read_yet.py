# SPDX-License-Identifier: Apache-2.0
"""What people ask for and is not read yet is refused or counted, in a line that is true."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import command_fault, command_output

POSES = ('--convention', 'isb_yxy')


def test_velocities_in_messages_of_their_own_are_counted(
    cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = command_output(capsys, 'process', cases / 'bag_velocity_apart/bag', tmp_path / 'o.csv')
    assert '10 frames' in told
    assert '10 refused as sizes, first at message 2, ' in told


def test_imus_are_named_as_what_they_are(
    cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = '--humerus', '/imu/arm', '--scapula', '/imu/scapula'
    bag = cases / 'bag_imu/bag'
    line = command_fault(capsys, 'process', bag, tmp_path / 'o.csv', *frames, *POSES)
    assert '/imu/arm is not a topic of geometry_msgs/msg/PoseStamped or ' in line
    assert '/imu/arm (sensor_msgs/msg/Imu)' in line


def test_poses_without_one_of_the_other_bone_at_their_stamp_are_no_frames(
    cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = '--humerus', '/hum', '--scapula', '/scap'
    bag = cases / 'bag_poses_jitter/bag'
    line = command_fault(capsys, 'process', bag, tmp_path / 'o.csv', *frames, *POSES)
    assert 'nothing was usable: poses of /hum or /scap without the other at their stamp' in line
