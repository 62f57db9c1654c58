# SPDX-License-Identifier: Apache-2.0
"""A list of whole and other numbers, which ROS cannot read, is one line that says so."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from unhurried import PATIENCE

FILE = '/**:\n  ros__parameters:\n    joint_offsets: [0, 1.5708, 0]\n'


@pytest.mark.parametrize(
    'given',
    [
        ('-p', 'joint_offsets:=[0,1.5708,0]'),  # the case node_args_traceback
        ('-p', 'joint_signs:=[1,-1.0,1]'),
        ('--params-file', 'mixed.yaml'),
    ],
)
def test_case_node_args_traceback(tmp_path: Path, given: tuple[str, str]) -> None:
    (tmp_path / 'mixed.yaml').write_text(FILE)
    command = [sys.executable, '-m', 'linkedplane_ros.node', '--ros-args', *given]
    ended = subprocess.run(
        command, capture_output=True, text=True, timeout=PATIENCE, check=False, cwd=tmp_path
    )
    assert ended.returncode == 2  # as all wrong arguments
    assert ended.stderr.count('\n') == 1, ended.stderr
    assert 'Traceback' not in ended.stderr
    assert 'a list of one type expected, as [1.0, 2.5]' in ended.stderr
