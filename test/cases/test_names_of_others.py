# SPDX-License-Identifier: Apache-2.0
"""Names from others (files, columns, frames) in lines and heads: none of them begins a new line."""

from __future__ import annotations

from pathlib import Path

import pytest
from bags import T0, exit_status, joint_state, refusal_line, write_bag

from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.reading import read_csv
from linkedplane_ros.processing.task import Task, run_task

ROWS = 'time,flexion,abduction,rotation\n0,0.1,0.2,0.3\n0.1,0.2,0.2,0.3\n'


@pytest.mark.parametrize(
    'name', ['a\n# side: left\nb', 'a\rb', 'a\u2028b', 'a\x85b', '"a"', ' a', 'a\\nb', 'a: b']
)
def test_a_fact_of_any_text_is_one_line_of_the_head_and_is_read_back(
    tmp_path: Path, name: str
) -> None:
    source = tmp_path / f'{name}.csv'
    source.write_text(ROWS)
    report = run_task(Task(source, tmp_path / 'out.csv', Options()))
    assert report.fault == ''
    facts, columns = read_csv(tmp_path / 'out.csv')
    assert facts['source'] == source.name
    assert facts['side'] == 'right'
    assert len(columns['time']) == 2
    head = [line for line in (tmp_path / 'out.csv').read_text().splitlines() if '#' in line]
    assert len(head) == len(facts)


def test_a_files_name_forges_no_line_of_the_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'a\nlinkedplane: forged\x1b[31m.csv'
    source.write_text('time,x\n0,1\n')
    assert exit_status([str(source), str(tmp_path / 'out.csv')]) == 1
    error = capsys.readouterr().err
    assert error.count('\n') == 1
    assert '\\nlinkedplane: forged\\x1b[31m.csv' in error
    source.write_text(ROWS)
    assert exit_status([str(source), str(tmp_path / 'out.csv')]) == 0
    assert 'a\\nlinkedplane: forged' in capsys.readouterr().out


def test_a_name_of_another_does_not_fill_the_screen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = [('/' + 'a' * 20_000, 'sensor_msgs/msg/JointState', T0, joint_state(0)[3])]
    sent += [(f'/other{k}', *sent[0][1:]) for k in range(1000)]
    bag = write_bag(tmp_path / 'bag', sent)
    line = refusal_line(capsys, str(bag), str(tmp_path / 'out.csv'), '--topic', '/arm')
    assert 'aaa...' in line
    assert len(line) < 8300
