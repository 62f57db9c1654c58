# SPDX-License-Identifier: Apache-2.0
"""What several folders share: a ROS domain of this process, its node, the recordings."""

from __future__ import annotations

import fcntl
import gc
import os
import re
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from ros_harness import Peer

    from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

FEWEST = 4800  # tests in all
SHARED_MEMORY = Path('/dev/shm')
SEGMENT = re.compile(r'fastrtps_[0-9a-f]{16}')  # Fast DDS; each has a lock file beside it, .._el


def lock(path: Path, mode: str) -> IO[str] | None:
    """Return the file, locked until it is closed; None if another process has it."""
    try:
        file = path.open(mode)
    except OSError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        return None
    return file


def own_domain() -> tuple[int, IO[str]]:
    """Return a ROS domain that no other test process of this machine has, and what holds it."""
    for step in range(101):
        domain = 1 + (os.getpid() + step) % 101  # 0 is everyone's default; above 101 ports collide
        file = lock(Path(tempfile.gettempdir(), f'linkedplane_ros_domain_{domain}.lock'), 'a')
        if file is not None:
            return domain, file
    raise pytest.UsageError('all 101 ROS domains are taken by other test runs on this machine')


def pytest_configure() -> None:
    """Let what the tests start be interrupted, also where a shell runs them in the background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Fail a run of all tests that found too few: another plugin may end the collection early.

    Before `-m` and `-k` choose; a run that names files or folders, or ignores some, is not judged.
    """
    whole = config.args_source is pytest.Config.ArgsSource.TESTPATHS
    chosen = config.getoption('ignore') or config.getoption('ignore_glob')
    if whole and not chosen and len(items) < FEWEST:
        raise pytest.UsageError(f'{len(items)} tests collected; there are {FEWEST} at the least')


# Before any test module imports rclpy:
DOMAIN, DOMAIN_LOCK = own_domain()
os.set_inheritable(DOMAIN_LOCK.fileno(), True)  # a node that outlives its test keeps the domain
LOGS = tempfile.TemporaryDirectory(prefix='linkedplane_ros_log_')
os.environ['ROS_DOMAIN_ID'] = str(DOMAIN)
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['ROS_PYTHON_CHECK_FIELDS'] = '1'
os.environ['ROS_LOG_DIR'] = LOGS.name


@pytest.fixture(autouse=True)
def no_node_outlives_its_test() -> Iterator[None]:
    """End what a failed test has left: it would answer the tests that follow."""
    yield
    if 'ros_harness' in sys.modules:
        sys.modules['ros_harness'].end_what_is_left()


@pytest.fixture(scope='module')
def ros() -> Iterator[None]:
    """Initialise ROS in this process."""
    import rclpy

    rclpy.init()
    yield
    gc.collect()  # a node that could not be made lives on in the error
    rclpy.try_shutdown()


@pytest.fixture
def peer(ros: None) -> Iterator[Peer]:
    """Read and feed the node."""
    from ros_harness import Peer

    made = Peer()
    yield made
    made.destroy_node()


@pytest.fixture
def node(peer: Peer) -> Iterator[MuscleStatePublisher]:
    """Run the node in this process, beside its peer."""
    from ros_harness import running

    with running(peer) as made:
        yield made


@pytest.fixture(scope='session')
def shared() -> Path:
    """Return the folder of recordings, golden values and literature beside the repository."""
    folder = Path(__file__).resolve().parents[2] / 'shared'
    if not folder.is_dir():
        pytest.skip('../shared is not there: no recordings, golden values or literature')
    return folder


def segments() -> set[Path]:
    """Return Fast DDS's shared-memory segments on this machine."""
    if not SHARED_MEMORY.is_dir():
        return set()
    return {path for path in SHARED_MEMORY.iterdir() if SEGMENT.fullmatch(path.name)}


@pytest.fixture(scope='session', autouse=True)
def no_segments_of_killed_processes() -> Iterator[None]:
    """Remove the segments of processes that the tests killed.

    A process holds its segment's lock as long as it lives, and the system drops the lock when it
    dies (as in `fastdds shm clean`). A segment is created after its lock is taken.
    """
    before = segments()
    yield
    for segment in segments() - before:
        path = segment.with_name(segment.name + '_el')
        file = lock(path, 'r')
        if file is not None:
            segment.unlink(missing_ok=True)
            path.unlink(missing_ok=True)
            file.close()
