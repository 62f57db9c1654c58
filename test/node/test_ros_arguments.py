# SPDX-License-Identifier: Apache-2.0
"""The arguments of the executables: help, and one line for what is wrong."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from optional import requires
from rclpy.node import Node
from unhurried import PATIENCE

from linkedplane_ros.commands import demo
from linkedplane_ros.commands.main import main as linkedplane
from linkedplane_ros.errors import ArgumentError
from linkedplane_ros.node import __main__ as muscle_state_publisher
from linkedplane_ros.node.command_line import split_ros_arguments
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.ros_arguments import (
    argument_errors,
    check_ros_arguments,
)
from linkedplane_ros.viewer import __main__ as muscle_viewer
from linkedplane_ros.viewer.node import ViewerNode

ARM_RAISE = str(Path(__file__).parents[2] / 'msg_examples' / 'arm_raise')
Run = Callable[[Sequence[str]], tuple[int, str, str]]
EXECUTABLES: dict[str, tuple[Callable[[], Any], list[str]]] = {
    'muscle_state_publisher': (muscle_state_publisher.main, []),
    'muscle_viewer': (muscle_viewer.main, ['--port', '0']),
    'linkedplane': (lambda: sys.exit(linkedplane()), ['play', ARM_RAISE]),
    'linkedplane_demo': (lambda: sys.exit(demo.main()), []),
}
FILES = {
    'broken': 'a: [\n',
    'shapeless': 'hello: 3\n',
    'mixed': '/**:\n  ros__parameters:\n    joint_offsets: [1, 2.5, 0]\n',
}
WRONG = [  # arguments behind --ros-args, and what the line says
    (('--params-file', '/absent.yaml'), '--params-file /absent.yaml: a file that can be read'),
    (('--params-file', '{broken}'), 'Error at line 1'),
    (('--params-file', '{shapeless}'), 'Cannot have a value before ros__parameters at line 1'),
    (('--params-file', '{mixed}'), 'a list of one type'),
    (('--params-file',), '--params-file flag'),
    (('--log-level', 'nonsense'), '--log-level nonsense: debug, info, warn, error or fatal'),
    (('--log-level',), '--log-level'),
    (('-r', '__node:=a/b'), "-r __node:=a/b: a node's name expected: letters, digits and '_'"),
    (('-r', '__node:=9a'), "a node's name expected"),
    (('-r', '__ns:=left'), "-r __ns:=left: a namespace expected: it starts with '/'"),
    (('-r', 'joint_states:=a b'), '-r joint_states:=a b: FROM:=TO expected'),
    (('-r', 'joint_states'), '-r joint_states: FROM:=TO expected'),
    (('-r',), '-r flag'),
    (
        ('-p', 'joint_offsets:=[1, 2.5, 0]'),
        'offsets:=[1, 2.5, 0]: a list of one type expected',
    ),
    (('-p', 'side'), '-p side: NAME:=VALUE expected'),
    (('-p', 'side:='), '-p side:=: NAME:=VALUE expected'),
    (('-p',), '-p flag'),
    (('--nonsense',), "'--nonsense' behind --ros-args: no argument of ROS"),
    (('--help',), "'--help' behind --ros-args: no argument of ROS"),
]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the executable in front of the arguments, in this process; it must end by itself."""

    def run_executable(words: Sequence[str]) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, 'argv', list(words))
        with pytest.raises(SystemExit) as ended:
            EXECUTABLES[words[0]][0]()
        assert isinstance(ended.value.code, int)
        return ended.value.code, *capsys.readouterr()

    return run_executable


def prepare_nothing() -> None:
    """ROS is prepared in the tests' process, whose signals are its own."""


def forbid() -> None:
    raise AssertionError('ROS is not needed')


def replace_preparation(monkeypatch: pytest.MonkeyPatch, by: Callable[[], None]) -> None:
    for module in (muscle_state_publisher, muscle_viewer, demo):
        monkeypatch.setattr(module, 'end_quietly_on_interrupt', prepare_nothing)
        monkeypatch.setattr(module, 'prepare', by)


@pytest.mark.parametrize('behind', [[], ['--ros-args'], ['--ros-args', '-p', 'side:=left']])
@pytest.mark.parametrize('program', EXECUTABLES)
def test_help_is_usage_and_status_0_and_needs_no_ros(
    program: str, behind: list[str], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace_preparation(monkeypatch, forbid)
    status, out, err = run([program, '--help', *behind])
    assert (status, err) == (0, '')
    assert out.startswith(f'usage: {program} [-h]')
    assert '--ros-args' in out


@pytest.mark.parametrize('words', [['--sidde'], ['--sidde', 'left'], ['side:=left'], ['--help=x']])
@pytest.mark.parametrize('program', ['muscle_state_publisher', 'muscle_viewer', 'linkedplane_demo'])
def test_an_unknown_argument_is_named_in_one_line(
    program: str, words: list[str], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace_preparation(monkeypatch, forbid)
    status, out, err = run([program, *words, '--ros-args', '-p', 'side:=left'])
    assert (status, out, err.count('\n')) == (2, '', 1)
    assert err.startswith(f'{program}: ')
    assert words[0].partition('=x')[0] in err


def test_commands_that_are_no_node_refuse_ros_arguments_but_not_the_flag_alone(
    run: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, err = run(['linkedplane', 'info', '--ros-args', '-r', 'a:=b'])
    assert (status, out) == (2, '')
    assert 'no ROS arguments expected: --ros-args -r a:=b' in err
    assert linkedplane(['info', '--ros-args']) == 0
    assert capsys.readouterr().out


@pytest.mark.parametrize(('words', 'right'), WRONG, ids=lambda part: str(part)[:30])
def test_a_wrong_ros_argument_is_named_in_one_line_with_what_would_be_right(
    words: tuple[str, ...], right: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    paths = {name: str(tmp_path / name) for name in FILES}
    for name, text in FILES.items():
        Path(paths[name]).write_text(text)
    given = [word.format_map(paths) if word[0] == '{' else word for word in words]
    with pytest.raises(ArgumentError) as caught:
        check_ros_arguments(['--ros-args', *given])
    assert right in str(caught.value)
    assert '\n' not in str(caught.value)
    assert '/src/' not in str(caught.value)  # of rcl
    assert capfd.readouterr() == ('', '')


@pytest.mark.parametrize('program', EXECUTABLES)
@pytest.mark.parametrize('words', [('-r', '__node:=a/b'), ('--params-file', '/absent')])
def test_every_executable_ends_with_status_2_and_one_line_for_a_wrong_ros_argument(
    program: str, words: tuple[str, ...], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    if program == 'muscle_viewer':
        pytest.importorskip('viser')
    replace_preparation(monkeypatch, prepare_nothing)
    status, out, err = run([program, *EXECUTABLES[program][1], '--ros-args', *words])
    assert (status, out, err.count('\n')) == (2, '', 1)
    assert err.startswith(f'{program}: {" ".join(words)}: ')


@pytest.mark.parametrize('kind', [MuscleStatePublisher, ViewerNode])
@pytest.mark.parametrize('name', ['use_sim_time', 'start_type_description_service'])
def test_a_value_that_ros_itself_refuses_is_named_in_one_line(
    kind: type[Node], name: str, ros: None
) -> None:
    with pytest.raises(ArgumentError) as caught, argument_errors():
        kind(cli_args=['--ros-args', '-p', f'{name}:=maybe'])
    assert str(caught.value) == (
        f"Trying to set parameter '{name}' to 'maybe' of type 'STRING', expecting type 'BOOL'"
    )


@pytest.mark.parametrize(('word', 'name'), [('__node:=', 'node name'), ('joint_states:=', 'topic')])
def test_a_name_that_is_too_long_is_refused_in_one_line(word: str, name: str, ros: None) -> None:
    with pytest.raises(ArgumentError) as caught, argument_errors():
        MuscleStatePublisher(cli_args=['--ros-args', '-r', word + 300 * 'a'])
    assert f'{name} length should not exceed' in str(caught.value)
    assert '\n' not in str(caught.value)


NODE = ['linkedplane_ros.node']
LATE = [  # what ROS refuses only when it, or the node, starts
    (NODE, '-p', 'use_sim_time:=maybe', "'use_sim_time' to 'maybe'"),
    (
        NODE,
        '-p',
        'qos_overrides./joint_states.subscription.depth:=x',
        "subscription.depth' to 'x' of type 'STRING', expecting type 'INTEGER'\n",
    ),
    (NODE, '--enclave', 'abc', 'Enclave name is not valid'),
    (NODE, '--log-config-file', '/absent', 'external configuration'),
    (
        ['linkedplane_ros.commands', 'play', ARM_RAISE, '--wait', '0'],
        '-p',
        'use_sim_time:=maybe',
        "'use_sim_time' to 'maybe'",
    ),
    (['linkedplane_ros.commands.demo'], '-p', 'use_sim_time:=1', "'use_sim_time' to '1'"),
]


@pytest.mark.parametrize(('words', 'option', 'value', 'said'), LATE)
def test_what_ros_refuses_as_it_starts_ends_an_executable_in_one_line(
    words: list[str], option: str, value: str, said: str
) -> None:
    done = subprocess.run(
        [sys.executable, '-m', *words, '--ros-args', option, value],
        capture_output=True,
        text=True,
        timeout=120.0,
    )
    assert done.returncode == 2
    # a node that compiles its solver for the first time says so before
    lines = [line for line in done.stderr.splitlines() if '[INFO]' not in line]
    assert len(lines) == 1, done.stderr
    assert said in done.stderr


def test_parameters_that_the_node_does_not_have_are_named_with_what_they_are_like(
    ros: None, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / 'parameters.yaml'
    file.write_text('/**:\n  ros__parameters:\n    marker:\n      rate: 5.0\n')
    typos = ['sidde:=left', 'qos_overrides./joint_states.subscription.dept:=5', 'zzz:=1']
    given = [part for typo in typos for part in ('-p', typo)]
    MuscleStatePublisher(cli_args=['--ros-args', '--params-file', str(file), *given]).destroy_node()
    [line] = [line for line in capfd.readouterr().err.splitlines() if 'no parameter' in line]
    assert '[WARN]' in line
    assert line.endswith(
        'given, but no parameter of this node: marker.rate (did you mean markers.rate?), '
        'qos_overrides./joint_states.subscription.dept (did you mean '
        'qos_overrides./joint_states.subscription.depth?), sidde (did you mean side?), zzz'
    )


def test_without_a_parameter_too_many_nothing_is_warned_of(
    ros: None, capfd: pytest.CaptureFixture[str]
) -> None:
    known = ['-p', 'side:=left', '-p', 'use_sim_time:=true', '-p', 'joint_names:=[]']
    known += ['-p', 'qos_overrides./deltoid/markers.publisher.depth:=5']
    MuscleStatePublisher(cli_args=['--ros-args', *known]).destroy_node()
    assert 'no parameter' not in capfd.readouterr().err  # ROS may warn of another test's node


PLAY = (
    'from linkedplane_ros.commands.main import main; '
    f"main(['play', {ARM_RAISE!r}, '--wait', '0', '--rate', '1000', *words])"
)
DEMO = (  # as far as the node that it feeds
    'from linkedplane_ros.node import demo; demo.subprocess.Popen = sys.exit; demo.main(words)'
)
VIEWER = (
    'from linkedplane_ros.viewer import main; main.subprocess.Popen = sys.exit; '
    'main.Thread = sys.exit; '
    "main.main(['muscle_viewer', '--port', '0', *words])"
)


@pytest.mark.parametrize('code', [PLAY, DEMO, VIEWER], ids=['play', 'demo', 'viewer'])
def test_the_other_executables_name_unknown_parameters_too(code: str) -> None:
    if code == VIEWER:
        pytest.importorskip('viser')
    begin = (
        "import sys; words = ['--ros-args', '-p', 'use_sim_tim:=true']; "
        'from linkedplane_ros.node.environment import prepare; prepare(); '
    )
    text = subprocess.run(
        [sys.executable, '-c', begin + code], capture_output=True, text=True, timeout=PATIENCE
    ).stderr
    assert 'no parameter of this node: use_sim_tim (did you mean use_sim_time?)' in text


def test_ros_arguments_begin_at_their_flag_and_end_at_two_dashes() -> None:
    assert split_ros_arguments([]) == ([], [])
    assert split_ros_arguments(['a', '--', '-b']) == (['a', '--', '-b'], [])
    words = ['a', '--ros-args', '-p', 'x:=1', '--', 'b', '--ros-args', '-r', 'c:=d']
    own, ros_arguments = split_ros_arguments(words)
    assert own == ['a', 'b']
    assert ros_arguments == ['--ros-args', '-p', 'x:=1', '--', '--ros-args', '-r', 'c:=d']
    check_ros_arguments(ros_arguments)


@requires('viser')
def test_the_viewer_hands_its_ros_arguments_on_and_ends_with_a_node_that_refuses_them() -> None:
    command = ['linkedplane_ros.viewer', '--port', '0', '--node', '--ros-args']
    done = subprocess.run(
        [sys.executable, '-m', *command, '-p', 'muscle:=biceps'],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("muscle_state_publisher: muscle: 'biceps' is neither a bundled")
    assert done.stderr.count('\n') == 1
