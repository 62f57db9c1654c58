# SPDX-License-Identifier: Apache-2.0
"""The launch files run by the real `launch`, in a process group of their own, as in a terminal."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from unhurried import PATIENCE

TOP = Path(__file__).parents[1]
NAME = 'linkedplane_ros'
RUN = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import AnyLaunchDescriptionSource
file, *arguments = sys.argv[1:]
include = IncludeLaunchDescription(
    AnyLaunchDescriptionSource(file),
    launch_arguments=[tuple(text.split(':=', 1)) for text in arguments],
)
service = LaunchService()
service.include_launch_description(LaunchDescription([include]))
sys.exit(service.run())
"""


def requires_executable(package: str, executable: str) -> pytest.MarkDecorator:
    """Return a mark that skips a test unless a ROS package with an executable is sourced."""
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    found = any(Path(prefix, 'lib', package, executable).exists() for prefix in prefixes)
    return pytest.mark.skipif(not found, reason=f'not installed: {executable} of {package}')


def write_prefix(folder: Path) -> Path:
    """Return a prefix, as colcon installs one, in which this source tree is the package.

    Its `bin` has a stand-in for `ros2 bag play`, which does not come from PyPI.
    """
    share = folder / 'share'
    index = share / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / NAME).touch()
    (share / NAME).mkdir()
    (share / NAME / 'package.xml').symlink_to(TOP / 'package.xml')
    for each in ('launch', 'config'):
        (share / NAME / each).symlink_to(TOP / each)
    write_script(
        folder / 'lib' / NAME / 'muscle_state_publisher',
        'from linkedplane_ros.node.__main__ import main\nmain()\n',
    )
    write_script(folder / 'bin' / 'ros2', (TOP / 'test' / 'bag_play_stand_in.py').read_text())
    return folder


def write_script(path: Path, code: str) -> None:
    """Write an executable that runs with this Python and finds this source tree."""
    path.parent.mkdir(parents=True, exist_ok=True)
    start = f'#!{sys.executable}\nimport sys\nsys.path.insert(0, {str(TOP)!r})\n'
    path.write_text(start + code.replace('from __future__ import annotations\n', ''))
    path.chmod(0o755)


class Launch:
    """A launch file that runs until it is interrupted."""

    def __init__(self, prefix: Path, file: Path | str, *arguments: str) -> None:
        """Start it: a file of ours by its name, or any file by its path, with arguments."""
        if isinstance(file, str):
            file = prefix / 'share' / NAME / 'launch' / file
        environment = os.environ | {'LINKEDPLANE_COMPILE': '0'}
        for variable, path in (('AMENT_PREFIX_PATH', prefix), ('PATH', prefix / 'bin')):
            before = environment.get(variable)
            environment[variable] = f'{path}{os.pathsep}{before}' if before else str(path)
        self.log = prefix / 'launch.log'
        with self.log.open('wb') as log:
            self.process = subprocess.Popen(
                [sys.executable, '-c', RUN, str(file), *arguments],
                stdout=log,
                stderr=log,
                env=environment,
                cwd=prefix,
                start_new_session=True,
            )

    @property
    def text(self) -> str:
        """All that it has written."""
        return self.log.read_text()

    def left_over(self) -> list[int]:
        """Return the processes that are still there of those that it started."""
        found = []
        for status in Path('/proc').glob('[0-9]*/stat'):
            try:
                fields = status.read_text().rpartition(')')[2].split()
            except OSError:
                continue
            if int(fields[3]) == self.process.pid and fields[0] != 'Z':
                found.append(int(status.parent.name))
        return found

    def interrupt(self) -> int:
        """Press Ctrl-C; return the exit status."""
        os.killpg(self.process.pid, signal.SIGINT)
        return self.wait()

    def wait(self) -> int:
        """Return the exit status."""
        return self.process.wait(PATIENCE)

    def end(self) -> None:
        """Kill what is left."""
        deadline = time.monotonic() + PATIENCE
        while (left := self.left_over()) and time.monotonic() < deadline:
            for each in left:
                os.kill(each, signal.SIGKILL)
            time.sleep(0.1)
        self.process.wait(PATIENCE)
