# SPDX-License-Identifier: Apache-2.0
"""The commands at a subject's size."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.commands.main import main

DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def test_the_commands_take_a_scale(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(['info', '--scale', '1.1']) == 0
    assert '; scaled by 1.1\n' in capsys.readouterr().out
    pose = ['--convention', THESIS.name, '0.3', '0.8', '-0.2']
    assert main(['solve', '--json', '--scale', '1.1,0.9,1.3', *pose]) == 0
    want = LinkedPlaneSolver(DELTOID.scaled((1.1, 0.9, 1.3))).solve(
        THESIS.rotation((0.3, 0.8, -0.2))
    )
    assert json.loads(capsys.readouterr().out)['lengths_m'] == want.lengths.tolist()
    table = tmp_path / 'motion.csv'
    table.write_text('time,flexion,abduction,rotation\n0.0,0.3,0.8,-0.2\n0.1,0.3,0.8,-0.2\n')
    out = tmp_path / 'out.csv'
    assert main(['process', str(table), str(out), '--scale', '1.1,0.9,1.3']) == 0
    text = out.read_text()
    assert '# scale: 1.1,0.9,1.3\n' in text
    assert repr(float(want.lengths[0])) in text
    assert main(['info', '--scale', 'two']) == 1
    captured = capsys.readouterr()
    assert captured.err.startswith("linkedplane: scale: 'two' given; one factor")
