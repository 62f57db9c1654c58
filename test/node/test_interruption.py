# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C at moments that a test cannot choose from outside: while the executables load, and while
the compiler calls back.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from optional import requires
from unhurried import PATIENCE

AT_IMPORT = """
import runpy
import signal
import sys


class Interruption:
    def find_spec(self, name, path=None, target=None):
        if name == 'numpy':  # the first that takes long
            print('interrupted', flush=True)
            signal.raise_signal(signal.SIGINT)


module, *sys.argv[1:] = sys.argv[1:]
sys.meta_path.insert(0, Interruption())
runpy.run_module(module, run_name='__main__', alter_sys=True)
"""
IN_CALLBACK = """
import runpy
import signal
import sys
from llvmlite.binding.executionengine import ExecutionEngine

how = int(sys.argv.pop(1))
find = ExecutionEngine._find_module_ptr  # used in the callbacks of LLVM only


def find_interrupted(*args):
    if callable(signal.getsignal(how)):  # not yet while numba loads
        ExecutionEngine._find_module_ptr = find
        print('interrupted', flush=True)
        signal.raise_signal(how)
    return find(*args)


ExecutionEngine._find_module_ptr = find_interrupted
runpy.run_module('linkedplane_ros.node', run_name='__main__')
"""
IN_TEXT = """
import signal
import rclpy
from linkedplane_ros.node.interruption import interruptible

rclpy.init()
try:
    with interruptible():
        eval('signal.raise_signal(signal.SIGINT)')
except KeyboardInterrupt:
    print('interrupted')
rclpy.try_shutdown()
"""


def run_script(script: str, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a script to its end, with the compiler."""
    environment = {key: v for key, v in os.environ.items() if key != 'LINKEDPLANE_COMPILE'}
    return subprocess.run(
        [sys.executable, '-c', script, *words],
        env=environment | variables,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


@pytest.mark.parametrize(
    ('words', 'status'),
    [
        (['linkedplane_ros.node'], -signal.SIGINT),
        (['linkedplane_ros.node', '--help'], -signal.SIGINT),
        pytest.param(['linkedplane_ros.viewer'], -signal.SIGINT, marks=requires('viser')),
        (['linkedplane_ros.commands.demo'], -signal.SIGINT),
        (['linkedplane_ros.commands', 'info'], 130),
    ],
)
def test_an_interruption_while_an_executable_loads_is_quiet(words: list[str], status: int) -> None:
    ended = run_script(AT_IMPORT, *words)
    assert (ended.stdout, ended.stderr) == ('interrupted\n', '')
    assert ended.returncode == status


@requires('numba')
@pytest.mark.parametrize('how', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_in_a_callback_of_the_compiler_ends_the_node(
    tmp_path: Path, how: signal.Signals
) -> None:
    compiled = tmp_path / 'compiled'
    ended = run_script(IN_CALLBACK, str(int(how)), '--ros-args', NUMBA_CACHE_DIR=str(compiled))
    assert ended.stdout == 'interrupted\n'
    assert 'Exception ignored' not in ended.stderr
    assert 'Traceback' not in ended.stderr
    assert ended.returncode == 0
    assert not list(compiled.rglob('*.nbc')), 'it ended only when all was compiled'


def test_an_interruption_of_text_that_is_evaluated_is_no_end_by_a_signal() -> None:
    """The text of a namedtuple, for instance: the compiler loads modules while it works."""
    ended = run_script(IN_TEXT)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, 'interrupted\n', '')
