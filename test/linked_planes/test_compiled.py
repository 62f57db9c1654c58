# SPDX-License-Identifier: Apache-2.0
"""Kernels are compiled once and kept on disk, wherever the package is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from optional import requires

pytestmark = requires('numba')

HOUSE = Path(__file__).parents[2] / 'linkedplane_ros'
KERNEL = """
from .compilation import entry

@entry
def doubled(x):
    return 2.0 * x
"""
REPORT = """
from small.kernel import doubled
print(doubled(1.5), sum(doubled.stats.cache_hits.values()))
"""
# the superuser may write anywhere, unless it gives that right up
BOUND = ('setpriv', '--bounding-set=-dac_override,-dac_read_search')


def report(folder: Path, home: Path) -> str:
    """Run the small package's kernel in a process of its own: its answer, and its cache hits."""
    return report_with_warnings(folder, home)[0]


def report_with_warnings(folder: Path, home: Path) -> tuple[str, str]:
    """Run the kernel, and return what stderr says, too."""
    if os.geteuid() == 0 and shutil.which(BOUND[0]) is None:
        pytest.skip('run as root, and setpriv is not there to give up its rights')
    command = [sys.executable, '-c', REPORT]
    environment = {'PATH': os.environ['PATH'], 'HOME': str(home), 'PYTHONPATH': str(folder)}
    run = subprocess.run(
        [*BOUND, *command] if os.geteuid() == 0 else command,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.strip(), run.stderr


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """Return a folder with a small package that has one kernel."""
    return install(tmp_path / 'installed')


def install(folder: Path) -> Path:
    """Write the small package into a folder, and return that."""
    package = folder / 'small'
    package.mkdir(parents=True)
    (package / '__init__.py').touch()
    (package / 'kernel.py').write_text(KERNEL)
    shutil.copy(HOUSE / 'linked_planes' / 'compilation.py', package)
    return package.parent


def test_a_kernel_is_compiled_once(installed: Path, tmp_path: Path) -> None:
    assert [report(installed, tmp_path) for _ in range(2)] == ['3.0 0', '3.0 1']


def test_a_read_only_installation_keeps_its_kernels_in_the_users_cache(
    installed: Path, tmp_path: Path
) -> None:
    (installed / 'small').chmod(0o555)
    home = tmp_path / 'home'
    home.mkdir()
    assert [report(installed, home) for _ in range(2)] == ['3.0 0', '3.0 1']
    assert list((home / '.cache').rglob('*.nbi'))


def test_with_nowhere_to_keep_it_a_kernel_is_compiled_every_time(
    installed: Path, tmp_path: Path
) -> None:
    for folder in (installed / 'small', home := tmp_path / 'home'):
        folder.mkdir(exist_ok=True)
        folder.chmod(0o555)
    told = 'kernels are compiled at each start: no folder to keep them can be written\n'
    assert [report_with_warnings(installed, home) for _ in range(2)] == [('3.0 0', told)] * 2


CALLED = """
from .compilation import compiled

@compiled
def factor():
    return {}
"""
BETWEEN = """
from .called import factor
from .compilation import compiled

@compiled
def total(x):
    return sum([factor() * each for each in (x, {} * x)])
"""
SCALE = 'SCALE = {}'
CALLING = """
from .between import total
from .compilation import entry
from .scale import SCALE

def make_kernel(called):
    @entry
    def kernel(x):
        return SCALE * called(x)
    return kernel

doubled = make_kernel(total)
"""


def test_a_kernel_is_renewed_when_what_it_uses_changes_and_only_then(
    installed: Path, tmp_path: Path
) -> None:
    package = installed / 'small'
    (package / 'called.py').write_text(CALLED.format('2.0'))
    (package / 'between.py').write_text(BETWEEN.format('0.0'))
    (package / 'scale.py').write_text(SCALE.format('1.0'))
    (package / 'kernel.py').write_text(CALLING)
    assert [report(installed, tmp_path) for _ in range(2)] == ['3.0 0', '3.0 1']
    (package / 'other.py').write_text('x = 1\n')
    assert report(installed, tmp_path) == '3.0 1'
    (package / 'called.py').write_text(CALLED.format('4.0'))
    assert [report(installed, tmp_path) for _ in range(2)] == ['6.0 0', '6.0 1']
    (package / 'between.py').write_text(BETWEEN.format('1.0'))
    assert [report(installed, tmp_path) for _ in range(2)] == ['12.0 0', '12.0 1']
    (package / 'scale.py').write_text(SCALE.format('2.0'))
    assert [report(installed, tmp_path) for _ in range(2)] == ['24.0 0', '24.0 1']


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    'empty': lambda content: b'',
    'half': lambda content: content[: len(content) // 2],
    'of zeros': lambda content: bytes(len(content)),
    'one bit': lambda content: content[:-99] + bytes([content[-99] ^ 16]) + content[-98:],
}


@pytest.fixture(scope='module')
def cached(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the small package, its kernel compiled and kept."""
    folder = tmp_path_factory.mktemp('cached')
    install(folder)
    report(folder, folder)
    return folder


@pytest.mark.parametrize(
    ('ending', 'how'),
    [('nbi', 'empty'), ('nbi', 'half'), ('nbc', 'half'), ('nbc', 'of zeros'), ('nbc', 'one bit')],
)
def test_a_damaged_cache_is_compiled_again_with_one_line(
    ending: str, how: str, cached: Path
) -> None:
    folder = cached / 'small' / '__pycache__'
    (file,) = folder.glob(f'*.{ending}')
    file.write_bytes(DAMAGES[how](file.read_bytes()))
    told = f'{folder}: damaged compiled kernels; they are compiled again\n'
    assert report_with_warnings(cached, cached) == ('3.0 0', told)
    if how == 'half':
        assert report_with_warnings(cached, cached) == ('3.0 1', '')


@pytest.mark.parametrize(
    ('ending', 'told'),
    [
        ('nbi', 'damaged compiled kernels; they are compiled again'),
        ('nbc', 'compiled kernels cannot be kept: Is a directory'),
    ],
)
def test_a_cache_that_cannot_be_replaced_does_no_harm(
    ending: str, told: str, cached: Path, tmp_path: Path
) -> None:
    shutil.copytree(cached, tmp_path / 'copy')
    folder = tmp_path / 'copy' / 'small' / '__pycache__'
    (file,) = folder.glob(f'*.{ending}')
    file.unlink()
    file.mkdir()
    assert report_with_warnings(tmp_path / 'copy', tmp_path) == ('3.0 0', f'{folder}: {told}\n')
