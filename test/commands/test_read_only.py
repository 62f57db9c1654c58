# SPDX-License-Identifier: Apache-2.0
"""Nothing beside the package and in the user's folders can be written: all works, in few lines.

A file stands where each folder would be made, so that it holds for root as well.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from optional import requires
from unhurried import PATIENCE

import linkedplane_ros

HOUSE = Path(linkedplane_ros.__file__).parent
FOLDERS = ('HOME', 'XDG_CACHE_HOME', 'XDG_CONFIG_HOME', 'MPLCONFIGDIR', 'NUMBA_CACHE_DIR')
KERNELS = 'kernels are compiled at each start: no folder to keep them can be written\n'


@pytest.fixture(scope='module')
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy the package to where nothing can be kept beside it."""
    folder = tmp_path_factory.mktemp('read_only')
    package = folder / HOUSE.name
    shutil.copytree(HOUSE, package, ignore=shutil.ignore_patterns('__pycache__'))
    for each in [package, *package.rglob('*')]:
        if each.is_dir():
            (each / '__pycache__').touch()
    return folder


def run(installed: Path, *words: str, compiled: bool) -> subprocess.CompletedProcess[str]:
    """Run the command line where no folder can be made."""
    nowhere = installed / 'file'
    nowhere.touch()
    given = {**os.environ, **dict.fromkeys(FOLDERS, str(nowhere)), 'PYTHONPATH': str(installed)}
    given['LINKEDPLANE_COMPILE'] = '1' if compiled else '0'
    return subprocess.run(
        [sys.executable, '-m', 'linkedplane_ros.commands', *words],
        env=given,
        cwd=installed,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


@requires('matplotlib')
def test_a_picture_is_drawn_without_lines_of_the_library(installed: Path) -> None:
    file = installed / 'muscle.png'
    ended = run(installed, 'info', '--png', str(file), compiled=False)
    assert (ended.returncode, ended.stderr) == (0, '')
    assert file.read_bytes().startswith(b'\x89PNG')


def test_a_model_is_printed_without_a_line(installed: Path) -> None:
    ended = run(installed, 'info', compiled=False)
    assert (ended.returncode, ended.stderr) == (0, '')
    assert ended.stdout.startswith('deltoid: 9 bands')


@requires('numba')
def test_a_pose_is_solved_and_one_line_says_that_kernels_cannot_be_kept(installed: Path) -> None:
    convention = 'flexion_abduction_rotation'
    ended = run(installed, 'solve', '--convention', convention, '0', '0', '0', compiled=True)
    assert (ended.returncode, ended.stderr) == (0, KERNELS)
    assert 'anterior_1' in ended.stdout
