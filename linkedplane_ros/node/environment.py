# SPDX-License-Identifier: Apache-2.0
"""Prepare the process for rclpy, or say in one line why it cannot run; called before its import.

The ROS packages from PyPI find their libraries through LD_LIBRARY_PATH, which their bootstrapper
sets by starting Python a second time. It does not notice where its mark was inherited without the
libraries (a filtered environment) and does not run at all in another environment's interpreter.
A ROS installation of the usual kind needs none of this and is left alone.
"""

from __future__ import annotations

import os
import signal
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from ..libraries import advise_install

NEEDED = ('rclpy', 'sensor_msgs', 'std_msgs', 'visualization_msgs', 'diagnostic_msgs')
MIDDLEWARE = 'rmw_fastrtps_cpp'  # the one that the packages from PyPI are linked with
BOOTSTRAPPED = '_ROS_WHEELS_BOOTSTRAP_COMPLETE'
RESTARTED = '_LINKEDPLANE_ROS_RESTARTED'  # a process id: a restart keeps it, a child has another


def end_quietly_on_interrupt() -> None:
    """Let Ctrl-C end an executable at once and without a traceback, until ROS handles signals.

    It is called before anything is imported that takes long to load.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def prepare() -> None:
    """Set the environment of this process up for rclpy.

    It may start Python again with the same arguments, so call it before anything else.

    Raises
    ------
    SystemExit
        With one line: what is missing, and how to get it.

    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise SystemExit(
            f'{missing[0]} is not installed: source /opt/ros/jazzy/setup.bash, or '
            f'{advise_install(*missing, MIDDLEWARE)}'
        )
    folders = library_folders()
    if not folders:
        return
    wanted = os.environ.get('RMW_IMPLEMENTATION') or MIDDLEWARE
    if wanted != MIDDLEWARE:
        raise SystemExit(
            f'RMW_IMPLEMENTATION={wanted} is not installed: ROS from PyPI has only {MIDDLEWARE}; '
            'unset RMW_IMPLEMENTATION, or source a ROS installation that has it'
        )
    if not any((folder / f'lib{MIDDLEWARE}.so').exists() for folder in folders):
        raise SystemExit(f'{MIDDLEWARE} is not installed: {advise_install(MIDDLEWARE)}')
    if not is_log_folder_writable():
        use_temporary_log_folder()
    restart_python(folders)


def library_folders() -> list[Path]:
    """Return the folders with the libraries of ROS from PyPI; none for a ROS installation."""
    spec = find_spec('rclpy')
    if spec is None or spec.origin is None:
        return []
    site_packages = Path(spec.origin).resolve().parents[1]
    bundled = sorted(site_packages.glob('ros_*.libs'))
    return [site_packages.parents[1], *bundled] if bundled else []


def is_log_folder_writable() -> bool:
    """Return whether rclpy.init can create and write its log folder (rcl_logging's rule)."""
    for variable, below in (('ROS_LOG_DIR', ''), ('ROS_HOME', 'log'), ('HOME', '.ros/log')):
        if os.environ.get(variable):
            folder = os.path.expanduser(os.path.join(os.environ[variable], below))
            break
    else:
        return False
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def use_temporary_log_folder() -> None:
    """Let ROS log into a new folder; SystemExit with one line if there can be none."""
    try:
        os.environ['ROS_LOG_DIR'] = tempfile.mkdtemp(prefix='ros_log_')
    except OSError as error:
        raise SystemExit(
            f'no folder for the log of ROS can be written ({error.strerror or error}): set '
            'ROS_LOG_DIR to one, or TMPDIR'
        ) from None


def restart_python(folders: list[Path]) -> None:
    """Start Python again with the folders in LD_LIBRARY_PATH, unless they are in it."""
    found = [path for path in os.environ.get('LD_LIBRARY_PATH', '').split(os.pathsep) if path]
    if {os.path.realpath(folder) for folder in folders} <= {os.path.realpath(p) for p in found}:
        return
    if os.environ.get(RESTARTED) == str(os.getpid()):
        raise SystemExit(
            'the libraries of ROS are not found: LD_LIBRARY_PATH does not reach Python; '
            f'start {sys.executable} itself, not a wrapper that clears it'
        )
    os.environ['LD_LIBRARY_PATH'] = os.pathsep.join([*map(str, folders), *found])
    os.environ[BOOTSTRAPPED] = '1'
    os.environ[RESTARTED] = str(os.getpid())
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])
