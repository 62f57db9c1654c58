# SPDX-License-Identifier: Apache-2.0
"""The command line: its help, what it refuses, and how it ends."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import PROGRAM, command_fault

import linkedplane_ros
from linkedplane_ros.commands.main import COMMANDS, build_parser, main

THESIS = 'flexion_abduction_rotation'
MODEL = (Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml').read_text()
BROKEN = {
    'not there': (None, 'cannot be read: No such file or directory'),
    'empty': ('', 'the file: a mapping of keys expected, nothing given'),
    'not yaml': ('a: [', 'not valid YAML at line 1'),
    'a key missing': (MODEL.replace('version: 1', ''), 'version: missing'),
    'a radius below zero': (MODEL.replace('37.294653]', '-37.294653]'), 'sphere.radius: '),
}


@pytest.mark.parametrize('case', BROKEN)
def test_a_model_that_is_no_good_is_refused_in_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, case: str
) -> None:
    content, reason = BROKEN[case]
    path = tmp_path / 'broken.yaml'
    if content is not None:
        path.write_text(content)
    pose = ('solve', '--convention', THESIS, 0, 0, 0, '--muscle')
    for command in (('info',), pose):
        line = command_fault(capsys, *command, path)
        assert str(path) in line
        assert reason in line


def test_a_name_that_is_no_model_is_refused_with_those_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = command_fault(capsys, 'info', 'biceps')
    known = 'deltoid, deltoid_ackland2008, deltoid_girdle, example_humerus_spheres, example_'
    known += 'shared_sphere'
    assert f"'biceps' is neither a bundled model ({known}) nor a path to a .yaml file" in line


@pytest.mark.parametrize(
    'arguments',
    [
        (),
        ('dance',),
        ('info', 'deltoid', 'deltoid'),
        ('solve', '0', '0', '0'),
        ('solve', '--convention', 'euler', '0', '0', '0'),
        ('solve', '--convention', THESIS),
        ('solve', '--convention', THESIS, '0', '0'),
        ('solve', '--convention', THESIS, '0', '0', '0', '0'),
        ('solve', '--convention', THESIS, '0', 'x', '0'),
        ('solve', '--convention', THESIS, '--side', 'up', '0', '0', '0'),
        ('play',),
        ('play', 'bag', '--rate', '0'),
        ('play', 'bag', '--rate', 'nan'),
        ('play', 'bag', '--clock', '-1'),
        ('play', 'bag', '--start-offset', '-1'),
        ('play', 'bag', '--wait', 'inf'),
    ],
)
def test_wrong_usage_ends_with_2_and_says_what_is_wrong(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]
) -> None:
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('usage: linkedplane')
    assert 'error: ' in err.splitlines()[-1]


def test_help_lists_the_commands_with_what_they_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['--help']) == 0
    text = capsys.readouterr().out
    for command, does in (
        ('info', 'Print a muscle model.'),
        ('solve', 'Print the muscle at one pose.'),
        ('play', "Play a recording's joint states."),
        ('study', "Do the thesis's case study again, with a report."),
    ):
        assert any(line.split(None, 1) == [command, does] for line in text.splitlines())


@pytest.mark.parametrize('command', COMMANDS)
def test_each_command_has_its_help(capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert main([command, '--help']) == 0
    assert capsys.readouterr().out.startswith(f'usage: linkedplane {command}')


@pytest.mark.parametrize('command', COMMANDS)
def test_every_option_says_what_it_is_for(command: str) -> None:
    (commands,) = (each for each in build_parser()._actions if each.choices)
    assert isinstance(commands.choices, dict)
    for action in commands.choices[command]._actions:
        assert action.help, f'{command}: {action.dest}'


def test_the_version_is_the_packages(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['--version']) == 0
    assert capsys.readouterr().out.strip() == linkedplane_ros.__version__


def test_it_needs_no_ros_but_for_play() -> None:
    check = (
        'import sys; from linkedplane_ros.commands.main import COMMANDS, build_parser, main; '
        f"main(['solve', '--convention', {THESIS!r}, '0', '0', '0']); "
        "sys.exit('rclpy' in sys.modules or 'rosbags' in sys.modules)"
    )
    assert subprocess.run([sys.executable, '-c', check], stdout=subprocess.DEVNULL).returncode == 0


@pytest.mark.parametrize('unbuffered', [False, True])
def test_a_reader_that_takes_one_line_does_no_harm(unbuffered: bool) -> None:
    environment = {key: v for key, v in os.environ.items() if key != 'PYTHONUNBUFFERED'}
    if unbuffered:
        environment['PYTHONUNBUFFERED'] = '1'
    with (
        subprocess.Popen(
            [*PROGRAM, 'info'], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment
        ) as program,
        subprocess.Popen(['head', '-1'], stdin=program.stdout, stdout=subprocess.PIPE) as head,
    ):
        assert program.stdout is not None
        program.stdout.close()
        assert head.communicate()[0] == b'deltoid: 9 bands, 3 heads\n'
        assert program.stderr is not None
        assert program.stderr.read() == b''


@pytest.mark.parametrize('unbuffered', [False, True])
def test_a_reader_that_has_gone_does_no_harm(unbuffered: bool) -> None:
    environment = {key: v for key, v in os.environ.items() if key != 'PYTHONUNBUFFERED'}
    if unbuffered:
        environment['PYTHONUNBUFFERED'] = '1'
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run(
            [*PROGRAM, 'info'], stdout=writing, stderr=subprocess.PIPE, env=environment
        )
    finally:
        os.close(writing)
    assert done.stderr == b''
    assert done.returncode in (0, 1)
