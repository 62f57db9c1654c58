# SPDX-License-Identifier: Apache-2.0
"""A reader of a page, who does what its blocks say: in order, in a folder of their own.

Files that the page says to save are saved, Python and `linkedplane` run, and what they print is
compared. What needs a ROS installation, another program or minutes is checked against what there
is: executables, parameters, launch arguments, topics, targets, options.
"""

from __future__ import annotations

import argparse
import contextlib
import doctest
import importlib.metadata
import io
import re
import shlex
import subprocess
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from bag_play_stand_in import parse_arguments
from launch_stand_ins import DeclareLaunchArgument, describe
from pages import TOP
from sensor_msgs.msg import JointState

from linkedplane_ros.commands.main import build_parser, main
from linkedplane_ros.node.messages import message_class
from linkedplane_ros.node.parameters import SPECS
from linkedplane_ros.node.settings import Settings
from linkedplane_ros.node.topics import OUTPUTS
from linkedplane_ros.viewer.arguments import TOPIC
from linkedplane_ros.viewer.arguments import parse_arguments as parse_viewer_arguments

PACKAGE = 'linkedplane_ros'
SCRIPTS = importlib.metadata.distribution(PACKAGE).entry_points.names
RUNS = ('info', 'solve', 'process', 'plot')  # commands of some seconds, that need no node
TOPICS = {f'/deltoid/{topic.name}': topic for topic in OUTPUTS}
QOS = re.compile(
    rf'qos_overrides\.(/joint_states\.subscription|({"|".join(TOPICS)})\.publisher)'
    r'\.(reliability|durability|depth)'
)
LISTENING = '-r', f'joint_states:={TOPIC}'
CLONE = ['git', 'clone', '<this', 'repository>', PACKAGE]
OTHERS = (  # what a reader does with programs that are not ours
    ['cd', '~/ros2_ws/src'],
    ['cd', '..'],
    ['cd', PACKAGE],
    ['source', 'install/setup.bash'],
    ['source', '.venv/bin/activate'],
    ['rosdep', 'install', '--from-paths', 'src', '--ignore-src', '-r', '-y'],
    ['sudo', 'apt', 'install', 'python3-numba'],
    ['colcon', 'build', '--packages-select', PACKAGE],
    ['colcon', 'test', '--packages-select', PACKAGE],
    ['sudo', 'apt', 'install', 'ros-jazzy-plotjuggler-ros'],
    ['kill', '$!'],
    ['wait', '$!'],
)


class Block(NamedTuple):
    """A block of code of a page."""

    language: str
    text: str
    line: int
    file: str
    """What the sentence before it says to save it as, if it does."""


def blocks(page: Path) -> list[Block]:
    """Return the blocks of code of a page, in order."""
    text = page.read_text(encoding='utf-8')
    found = []
    for match in re.finditer(r'^```([\w-]+)\n(.*?)^```$', text, re.DOTALL | re.MULTILINE):
        before = text[: match.start()].rstrip().rpartition('\n\n')[2]
        [file] = re.findall(r'Save this as `([\w.]+)`', before)[-1:] or ['']
        line = text.count('\n', 0, match.start()) + 2
        found.append(Block(match[1], match[2], line, file))
    return found


def commands(block: Block) -> Iterator[tuple[list[str], str]]:
    """Yield the words of each command of a console block, and what it prints."""
    text = block.text.replace('\\\n', ' ')
    for match in re.finditer(r'^\$ (.*)\n((?:(?!\$ ).*\n)*)', text, re.MULTILINE):
        *first, last = re.split(r' && ', match[1])
        for part in first:
            yield shlex.split(part, comments=True), ''
        yield shlex.split(last, comments=True), match[2]


def lay_out(folder: Path) -> None:
    """Put into a folder what pages take for granted: the examples, a reader's own files."""
    (folder / 'msg_examples').symlink_to(TOP / 'msg_examples')
    model = TOP / PACKAGE / 'models' / 'example_shared_sphere.yaml'
    (folder / 'my_muscle.yaml').write_text(model.read_text(encoding='utf-8'), encoding='utf-8')
    rows = '\n'.join(f'{0.1 * k:.1f}\t0\t{10 * k}\t0' for k in range(10))
    head = 'ABD01\nversion=1\nnRows=10\nnColumns=4\ninDegrees=yes\nendheader\n'
    names = 'time\tplane_elv\tshoulder_elv\taxial_rot\n'
    (folder / 'ABD01.mot').write_text(f'{head}{names}{rows}\n')


def printed(do: Callable[[], object]) -> str:
    """Return what something prints."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        do()
    return out.getvalue()


class Reader:
    """Reads a page in the current folder; an AssertionError says which of its lines is wrong."""

    def __init__(self, page: Path) -> None:
        """Open the page; nothing is done yet."""
        self.page = page
        self.names: dict[str, object] = {}
        self.output = ''
        """What the last block, or its last command, has printed."""

    def read(self) -> None:
        """Do what all blocks say."""
        for block in blocks(self.page):
            try:
                with np.printoptions():
                    self.do(block)
            except (Exception, SystemExit) as error:
                raise AssertionError(f'{self.page.name}:{block.line}: {error}') from error

    def do(self, block: Block) -> None:
        """Do what a block says."""
        if block.file:
            Path(block.file).write_text(block.text, encoding='utf-8')
        elif block.language == 'python':
            self.output = self.session(block) if '>>> ' in block.text else self.script(block.text)
        elif block.language == 'console':
            for words, output in commands(block):
                self.output = self.command(words)
                assert not output or steady(self.output) == steady(output), self.output
        elif block.language == 'text' and self.output:
            assert steady(self.output).endswith(steady(block.text)), self.output

    def session(self, block: Block) -> str:
        """Run a session of Python as a doctest, with the names of the page so far."""
        parser, runner, faults = doctest.DocTestParser(), doctest.DocTestRunner(verbose=False), []
        test = parser.get_doctest(block.text, self.names, self.page.name, None, block.line - 1)
        runner.run(test, out=faults.append, clear_globs=False)
        assert not faults, ''.join(faults)
        self.names = test.globs
        return ''

    def script(self, text: str) -> str:
        """Run a piece of a program with the names of the page so far."""
        return printed(lambda: exec(text, self.names))

    def command(self, words: list[str]) -> str:
        """Run a command, or check what it names; return what it has printed, if it ran."""
        if words[-1] == '&':  # in the background, or into a file: the same command
            words = words[:-1]
        if '>' in words:
            words = words[: words.index('>')]
        program, *rest = words
        if program == 'linkedplane':
            return linkedplane(rest)
        if program == 'python':
            return self.script(Path(rest[0]).read_text(encoding='utf-8'))
        if words[:3] == ['.venv/bin/python', '-m', 'pytest']:
            return ''
        if program == 'make':
            subprocess.run(['make', '-n', *rest], cwd=TOP, check=True, capture_output=True)
        elif program == 'ros2':
            ros2(rest)
        elif program == 'until':
            loop = ['|', 'grep', '-q', 'Subscription count: 1;', 'do', 'sleep', '0.2;', 'done']
            assert rest[:3] == ['ros2', 'topic', 'info']
            assert rest[3] in TOPICS
            assert rest[4:] == loop
        elif program in SCRIPTS:
            node(program, rest)
        elif words[:2] == ['pip', 'install']:
            extras = importlib.metadata.metadata(PACKAGE).get_all('Provides-Extra') or []
            unknown = set(rest[1].removeprefix('.[').removesuffix(']').split(',')) - set(extras)
            assert not unknown, f'{unknown}: no such extra'
        else:
            assert words == CLONE or words in OTHERS, f'{shlex.join(words)}: not known to the tests'
        return ''


def steady(text: str) -> str:
    """Return a text without what differs from computer to computer."""
    return re.sub(r'[\d,]+ a second', 'some a second', text)


def linkedplane(words: list[str]) -> str:
    """Run a command of ours; check its words alone if it takes long, or needs a node."""
    build_parser().parse_args(words)
    if words[0] not in RUNS or '--jobs' in words:
        return ''
    status = []
    output = printed(lambda: status.append(main(words)))
    assert status == [0], shlex.join(words)
    return output


def ros2(words: list[str]) -> None:
    """Check a command of ROS 2: what it names of ours is there."""
    kind, *rest = words
    if words[:3] == ['run', 'plotjuggler', 'plotjuggler']:
        for option, file in zip(words[3::2], words[4::2], strict=True):
            assert option in ('--layout', '--datafile')  # plotjuggler_app/main.cpp
            assert in_clone(file).is_file() or Path(file).is_file()
    elif kind == 'run':
        assert rest[0] == PACKAGE
        assert rest[1] in SCRIPTS
        node(rest[1], rest[2:])
    elif kind == 'launch':
        assert rest[0] == PACKAGE
        declared = {
            each.name
            for each in describe(TOP / 'launch' / rest[1]).entities
            if isinstance(each, DeclareLaunchArgument)
        }
        unknown = {word.partition(':=')[0] for word in rest[2:]} - declared
        assert not unknown, f'{unknown}: no such argument'
        for word in rest[2:]:
            assert not word.startswith('bag:=') or in_clone(word.removeprefix('bag:=')).is_dir()
    elif words[:2] == ['param', 'dump']:
        assert words[2] == '/muscle_state_publisher'
    elif words[:2] == ['topic', 'echo']:
        echo(words[2:])
    elif words[:2] == ['topic', 'pub']:
        *how, topic, kind, message = words[2:]
        assert how in (['--once'], ['--rate', '2'])
        assert (topic, kind) == ('/joint_states', 'sensor_msgs/msg/JointState')
        file = re.fullmatch(r'\$\(cat (.*)\)', message)
        content = in_clone(file[1]).read_text(encoding='utf-8') if file else message
        JointState(**yaml.safe_load(content))
    else:
        assert words[:2] == ['bag', 'play'], shlex.join(words)
        given = parse_arguments(words)
        assert in_clone(given.bag_path).is_dir() or Path(given.bag_path).is_dir()
        assert set(given.topics) <= {'/joint_states'}


def echo(words: Sequence[str]) -> None:
    """Check what follows `ros2 topic echo`, with those of its options that the pages use."""
    parser = argparse.ArgumentParser(exit_on_error=False)
    for flag in ('--once', '--csv', '--full-length'):
        parser.add_argument(flag, action='store_true')
    parser.add_argument('--timeout', type=float)
    parser.add_argument('--field')
    parser.add_argument('--qos-durability', choices=('transient_local', 'volatile'))
    parser.add_argument('--qos-reliability', choices=('reliable', 'best_effort'))
    parser.add_argument('topic', type=lambda name: name.replace('/my_muscle/', '/deltoid/'))
    parser.add_argument('type', nargs='?')
    given = parser.parse_args(words)
    kind = TOPICS[given.topic].type
    assert given.type in (None, kind)
    assert given.field is None or hasattr(message_class(kind)(), given.field)
    assert (given.qos_durability is None) == (given.qos_reliability is None)


def in_clone(path: str) -> Path:
    """Return the place in this repository of a path in a reader's workspace."""
    return TOP / path.removeprefix(f'src/{PACKAGE}/')


def node(script: str, words: Sequence[str]) -> None:
    """Check what follows an executable: options of the viewer, parameters of the node."""
    if script == 'muscle_viewer':
        parse_viewer_arguments([script, *words])
        return
    given = {}
    for option, word in zip(words[1::2], words[2::2], strict=True):
        if option == '--params-file' or (option, word) == LISTENING:
            continue
        name, is_parameter, value = word.partition(':=')
        assert (words[0], option, is_parameter) == ('--ros-args', '-p', ':='), word
        if not QOS.fullmatch(name):
            given[name] = yaml.safe_load(value)
    defaults = {spec.name: spec.default for spec in SPECS}
    assert set(given) <= set(defaults)
    Settings.from_values(defaults | given)
