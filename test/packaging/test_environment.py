# SPDX-License-Identifier: Apache-2.0
"""What the executables stand on: each repair of the environment, and each that cannot be made."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from minimal_python import TOP, run_python

from linkedplane_ros.node import environment

PREPARE = (  # without what the package itself imports: NumPy is not there in every test
    "import sys, types; package = types.ModuleType('linkedplane_ros'); "
    f'package.__path__ = [{str(TOP / "linkedplane_ros")!r}]; '
    'sys.modules[package.__name__] = package; '
    'from linkedplane_ros.node.environment import prepare; prepare(); '
)
RCLPY_RUNS = PREPARE + "import rclpy; rclpy.init(); rclpy.shutdown(); print('rclpy runs')"
from_pypi = pytest.mark.skipif(
    not environment.library_folders(), reason='ROS is not from PyPI here: nothing to repair'
)


@from_pypi
def test_libraries_are_found_where_only_the_bootstrappers_mark_was_inherited(
    tmp_path: Path,
) -> None:
    variables = {'HOME': str(tmp_path), environment.BOOTSTRAPPED: '1'}
    assert run_python('import rclpy', **variables).returncode != 0
    result = run_python(RCLPY_RUNS, **variables)
    assert (result.returncode, result.stdout) == (0, 'rclpy runs\n'), result.stderr


@from_pypi
def test_libraries_are_found_where_no_bootstrapper_ran(tmp_path: Path) -> None:
    packages = str(environment.library_folders()[1].parent)
    result = run_python(RCLPY_RUNS, '-S', HOME=str(tmp_path), PYTHONPATH=packages)
    assert (result.returncode, result.stdout) == (0, 'rclpy runs\n'), result.stderr


@from_pypi
def test_python_is_not_started_again_for_ever() -> None:
    """As if a wrapper had cleared LD_LIBRARY_PATH after the restart."""
    code = f'import os; os.environ["{environment.RESTARTED}"] = str(os.getpid()); ' + PREPARE
    result = run_python(code, **{environment.BOOTSTRAPPED: '1', 'HOME': '/tmp'})
    assert result.returncode == 1
    assert re.fullmatch(r'the libraries of ROS are not found: LD_LIBRARY_PATH .*\n', result.stderr)


@from_pypi
@pytest.mark.parametrize(
    'variables',
    [{}, {'HOME': ''}, {'HOME': '/dev/null'}, {'HOME': '/', 'ROS_LOG_DIR': '/dev/null/log'}],
    ids=['no home', 'empty home', 'home not writable', 'log folder not writable'],
)
def test_logs_go_to_a_temporary_folder_where_they_have_no_home(
    variables: dict[str, str], tmp_path: Path
) -> None:
    result = run_python(RCLPY_RUNS, TMPDIR=str(tmp_path), **variables)
    assert (result.returncode, result.stdout) == (0, 'rclpy runs\n'), result.stderr
    assert [path.name[:8] for path in tmp_path.iterdir()] == ['ros_log_']


@from_pypi
def test_logs_stay_where_the_user_wants_them(tmp_path: Path) -> None:
    folder = tmp_path / 'deep' / 'logs'
    code = PREPARE + "import os; print(os.environ['ROS_LOG_DIR'])"
    result = run_python(code, TMPDIR=str(tmp_path), ROS_LOG_DIR=str(folder))
    assert result.stdout.strip() == str(folder), result.stderr


@from_pypi
def test_a_middleware_that_is_not_installed_is_named_in_one_line() -> None:
    result = run_python(RCLPY_RUNS, HOME='/tmp', RMW_IMPLEMENTATION='rmw_cyclonedds_cpp')
    assert result.returncode == 1
    assert re.fullmatch(
        r'RMW_IMPLEMENTATION=rmw_cyclonedds_cpp is not installed: .*\n', result.stderr
    )


def test_a_machine_without_ros_is_told_how_to_get_it() -> None:
    result = run_python(PREPARE, '-S', '-E')
    assert result.returncode == 1
    assert re.fullmatch(
        r'rclpy is not installed: source /opt/ros/jazzy/setup\.bash, or pip install '
        r'ros-jazzy-rclpy ros-jazzy-common-interfaces ros-jazzy-rmw-fastrtps-cpp '
        r'\(rosdep keys: rclpy, .*\)\n',
        result.stderr,
    )


def test_no_folder_for_the_log_at_all_is_one_line() -> None:
    code = 'import tempfile\ntempfile.tempdir = "/dev/null/tmp"\n' + PREPARE
    result = run_python(code, HOME='/dev/null')
    assert result.returncode == 1
    assert re.fullmatch(
        r'no folder for the log of ROS can be written \(.+\): set ROS_LOG_DIR to one, or TMPDIR\n',
        result.stderr,
    )


def test_a_ros_installation_is_left_alone(tmp_path: Path) -> None:
    """Stand-ins suffice: only where the packages lie matters."""
    for name in environment.NEEDED:
        (tmp_path / name).mkdir()
        (tmp_path / name / '__init__.py').touch()
    code = 'import os; before = dict(os.environ); '
    code += PREPARE + "print('unchanged' if dict(os.environ) == before else os.environ)"
    result = run_python(
        code, '-S', PYTHONPATH=str(tmp_path), RMW_IMPLEMENTATION='rmw_cyclonedds_cpp'
    )
    assert result.stdout == 'unchanged\n', result.stderr
