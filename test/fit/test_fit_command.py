# SPDX-License-Identifier: Apache-2.0
"""The command `linkedplane fit`: its files, its words, and how it ends."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import PROGRAM, command_fault, command_output
from fits import QUICK_OPTIONS
from optional import requires

from linkedplane_ros import BroadMuscle

pytestmark = requires('pymoo', 'matplotlib')
DELTOID = BroadMuscle.load('deltoid')
# Ctrl-C as soon as there is a checkpoint
INTERRUPTED_PROGRAM = """
import signal, sys
from linkedplane_ros.commands.main import main
from linkedplane_ros.fit.search.checkpoint import Checkpoint

write_if_due = Checkpoint.write_if_due

def write_and_stop(checkpoint, search):
    write_if_due(checkpoint, search)
    if checkpoint.written:
        signal.raise_signal(signal.SIGINT)

Checkpoint.write_if_due = write_and_stop
sys.exit(main(sys.argv[1:]))
"""


def test_a_fit_leaves_a_model_a_report_and_a_picture(
    tmp_path: Path, task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    out = command_output(capsys, *task, *QUICK_OPTIONS)
    assert '26 parameters, 78 rows (angles as they stand): criterion 459.91 -> ' in out
    fitted = BroadMuscle.load(tmp_path / 'fitted.yaml')
    assert fitted.name == 'fitted'
    assert fitted.source.endswith('; fitted to data.csv (angles as they stand)')
    report = (tmp_path / 'fitted.md').read_text(encoding='utf-8')
    assert '![Measured and modelled](fitted.png)' in report
    for row in ('| anterior, flexion | 9 |', '| posterior, scaption | 7 |', '| **all** | 78 |'):
        assert report.count(row) == 2  # lengths, moment arms
    assert '| poses with measurements | 24 | 24 |' in report
    assert (tmp_path / 'fitted.png').read_bytes().startswith(b'\x89PNG')
    assert not list(tmp_path.glob('*.checkpoint'))
    # a model that fits nearly as well as the one that simulated: lengths 0.1, moment arms 0.2 mm
    means = [float(line.split()[-2]) for line in out.splitlines() if 'mean deviation' in line]
    assert means[0] < 0.1
    assert means[1] < 0.2


def test_the_same_seed_writes_the_same_files(
    tmp_path: Path, task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    files = []
    for _ in range(2):
        command_output(capsys, *task, '--every', '40', *QUICK_OPTIONS, '--polish', '2', '--force')
        files.append([(tmp_path / f'fitted.{kind}').read_bytes() for kind in ('yaml', 'png')])
    assert files[0] == files[1]


def test_a_fit_that_was_interrupted_is_taken_up(
    tmp_path: Path, task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    options = ['--every', '20', '--particles', '6', '--generations', '60', '--polish', '0']
    straight = tmp_path / 'straight.yaml'
    command_output(capsys, *task[:-1], straight, *options, '--name', 'fitted')
    checkpoint = tmp_path / 'fitted.checkpoint'
    command = [sys.executable, '-c', INTERRUPTED_PROGRAM, *task, *options]
    stopped = subprocess.run(command, capture_output=True, text=True)
    assert stopped.returncode == 130, stopped.stderr
    assert stopped.stderr == f'linkedplane: stopped; {checkpoint} is there for --resume\n'
    assert '--resume continues it, --force starts again' in command_fault(capsys, *task, *options)
    command_output(capsys, *task, *options, '--resume', '--jobs', '2')
    assert (tmp_path / 'fitted.yaml').read_text() == straight.read_text()
    assert not checkpoint.exists()


@pytest.mark.parametrize(
    ('more', 'said_of_it'),
    [
        (['--free', 'sphere.rad'], "free: 'sphere.rad' matches nothing of deltoid; it has"),
        (['--bound', 'sphere.radius'], "bound 'sphere.radius': PATTERN=LOW:HIGH"),
        (['--bound', 'origin=+-1'], "bound: 'origin' matches nothing that is free"),
        (
            ['--tighten', '2', '4'],
            'tighten: 2 4, then clearance 0; each smaller than',
        ),
        (['--resume'], 'fitted.checkpoint: cannot be read: No such file'),
    ],
)
def test_what_cannot_be_fitted_is_told_in_one_line(
    task: list[str], more: list[str], said_of_it: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert said_of_it in command_fault(capsys, *task, *more)


def test_there_is_nothing_to_tighten_without_bones(
    task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    boneless = replace(
        DELTOID,
        interference_names=(),
        interference_centres=np.empty((0, 3)),
        interference_radii=np.empty(0),
    )
    boneless.to_yaml(task[1])
    assert 'tighten: deltoid has no interference spheres' in command_fault(
        capsys, *task, '--tighten', '4'
    )
    report = command_output(capsys, *task, *QUICK_OPTIONS, '--polish', '2', '--over', 'range')
    assert ' 0 bands enter a sphere' in report


def test_a_fit_that_tightens_draws_the_trade_off(
    tmp_path: Path, task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    command_output(
        capsys,
        *task,
        *QUICK_OPTIONS,
        '--polish',
        '2',
        '--weights',
        'interference=1',
        '--tighten',
        '20',
        '9',
    )
    assert (tmp_path / 'fitted_trade_off.png').read_bytes().startswith(b'\x89PNG')
    report = (tmp_path / 'fitted.md').read_text(encoding='utf-8')
    assert '![Deviation and interference](fitted_trade_off.png)' in report
    rows = report.partition('| let in, mm |')[2].splitlines()[2:5]
    assert [row.split('|')[1].strip() for row in rows] == ['20', '9', '0']


def test_nothing_is_replaced_unasked(
    tmp_path: Path, task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'fitted.yaml').write_text('mine')
    assert 'fitted.yaml: exists already; --force replaces it' in command_fault(capsys, *task)
    assert (tmp_path / 'fitted.yaml').read_text() == 'mine'
    assert 'ends in .yaml' in command_fault(capsys, *task[:-1], tmp_path / 'fitted.txt')


def test_a_name_that_no_model_can_have_is_told_before_the_fit(
    tmp_path: Path, task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    said_of_it = command_fault(capsys, *task[:-1], tmp_path / '2nd.yaml')
    assert "2nd.yaml: name: '2nd' given; a letter, then letters" in said_of_it
    command_output(
        capsys, *task[:-1], tmp_path / '2nd.yaml', *QUICK_OPTIONS, '--polish', 2, '--name', 'second'
    )
    assert BroadMuscle.load(tmp_path / '2nd.yaml').name == 'second'


def test_a_fault_of_the_data_names_file_and_line(
    tmp_path: Path, task: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    Path(task[2]).write_text('motion,angle_deg,head,length_mm\nflexion,10,biceps,150\n')
    assert "data.csv:2: 'biceps' is neither a head of deltoid" in command_fault(capsys, *task)


@pytest.mark.parametrize('option', ['--weights mass=1', '--particles 1', '--seed -1'])
def test_an_option_that_is_none_is_a_matter_of_usage(task: list[str], option: str) -> None:
    run = subprocess.run([*PROGRAM, *task, *option.split()], capture_output=True, text=True)
    assert run.returncode == 2
