# SPDX-License-Identifier: Apache-2.0
"""What colcon makes of the package: executables and files of a built workspace."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from unhurried import PATIENCE

TOP = Path(__file__).resolve().parents[2]
SOURCES = TOP / 'linkedplane_ros'


SCRIPTS = ('muscle_state_publisher', 'muscle_viewer', 'linkedplane', 'linkedplane_demo')


@pytest.fixture
def prefix() -> Path:
    """Return where colcon has installed the package."""
    for entry in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        if Path(entry, 'lib', 'linkedplane_ros').is_dir():
            return Path(entry)
    pytest.skip('no built workspace is sourced; `make workspace` builds one and runs this')


@pytest.mark.workspace
def test_the_workspace_has_all_executables(prefix: Path) -> None:
    found = {path.name for path in (prefix / 'lib' / 'linkedplane_ros').iterdir()}
    assert found == set(SCRIPTS)


@pytest.mark.workspace
def test_executables_run_from_a_sourced_workspace_with_the_python_that_built_it(
    prefix: Path, tmp_path: Path
) -> None:
    executable = prefix / 'lib' / 'linkedplane_ros' / 'linkedplane'
    shebang = executable.read_text().splitlines()[0]
    assert Path(shebang.removeprefix('#!')).samefile(sys.executable)
    command = f'. "{prefix}/share/linkedplane_ros/package.sh" && cd / && "{executable}" info'
    result = subprocess.run(
        ['sh', '-c', command],
        env={'PATH': os.defpath, 'HOME': str(tmp_path), 'LINKEDPLANE_COMPILE': '0'},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert result.returncode == 0, result.stderr
    assert 'deltoid' in result.stdout


@pytest.mark.workspace
def test_the_workspace_has_all_shared_files(prefix: Path) -> None:
    share = prefix / 'share' / 'linkedplane_ros'
    for pattern in ('config/*', 'launch/*.py', 'msg_examples/*.yaml', 'msg_examples/*/*'):
        for source in TOP.glob(pattern):
            if source.is_file() and '__pycache__' not in source.parts:
                assert (share / source.relative_to(TOP)).is_file(), source
    assert (share / 'package.xml').is_file()
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    assert (index / 'linkedplane_ros').is_file()


@pytest.mark.workspace
@pytest.mark.parametrize('folder', ['literature', 'models'])
def test_the_workspace_has_the_models_and_the_literature(prefix: Path, folder: str) -> None:
    (installed,) = prefix.glob(f'lib/python*/site-packages/linkedplane_ros/{folder}')
    names = {path.name for path in (SOURCES / folder).iterdir()}
    assert {path.name for path in installed.iterdir()} == names
