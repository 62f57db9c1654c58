# SPDX-License-Identifier: Apache-2.0
"""The advice on libraries that are not installed: each name in it is one that exists."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from minimal_python import TOP

from linkedplane_ros.drawing.figure_files import import_matplotlib
from linkedplane_ros.fit.search import swarm
from linkedplane_ros.libraries import REQUIREMENTS, ROSDEP_KEYS, advise_install
from linkedplane_ros.processing.outputs import ParquetOutput
from linkedplane_ros.processing.reading import read_parquet
from linkedplane_ros.processing.workers import run_on_cluster
from linkedplane_ros.recordings.bags.opening import open_bag
from linkedplane_ros.recordings.filters import filter_lowpass

KEYS = {  # in rosdistro's rosdep/python.yaml; pyarrow, pymoo, viser and dask have none there
    'python3-matplotlib',
    'python3-rosbags-pip',
    'python3-scipy',
}
PACKAGES = {  # in rosdistro's jazzy/distribution.yaml: their names are keys
    'diagnostic_msgs',
    'rclpy',
    'rmw_fastrtps_cpp',
    'sensor_msgs',
    'std_msgs',
    'visualization_msgs',
}
FILE = Path('any')
ADVICE: dict[str, tuple[str, Callable[[], Any], str]] = {
    'a bag': (
        'rosbags.typesys',
        lambda: open_bag(FILE),
        'pip install rosbags (rosdep key: python3-rosbags-pip)',
    ),
    'a filter': (
        'scipy.signal',
        lambda: filter_lowpass(np.zeros((20, 1)), 100.0, 6.0),
        'pip install scipy (rosdep key: python3-scipy)',
    ),
    'a picture': (
        'matplotlib',
        import_matplotlib,
        'pip install matplotlib (rosdep key: python3-matplotlib)',
    ),
    'Parquet read': ('pyarrow.parquet', lambda: read_parquet(FILE), 'pip install pyarrow'),
    'Parquet written': (
        'pyarrow',
        lambda: ParquetOutput(FILE, None),  # type: ignore[arg-type]  # not looked at
        'pip install pyarrow',
    ),
    'a cluster': (
        'dask.distributed',
        lambda: next(run_on_cluster([], 'any')),
        "pip install 'dask[distributed]'",
    ),
}


@pytest.mark.parametrize('case', ADVICE)
def test_a_library_that_is_not_there_is_named_with_its_rosdep_key(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, use, advice = ADVICE[case]
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ValueError, match='needs') as caught:
        use()
    assert str(caught.value).endswith(f': {advice}')


def test_a_fit_names_its_libraries_and_the_keys_that_there_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(swarm, 'find_spec', lambda name: None if name == 'pymoo' else name)
    with pytest.raises(ValueError, match='a fit needs') as caught:
        swarm.require_libraries()
    assert str(caught.value).endswith(
        "pip install 'pymoo>=0.6.2' scipy matplotlib "
        '(rosdep keys: python3-scipy, python3-matplotlib)'
    )


def test_every_rosdep_key_exists_and_every_requirement_is_that_of_setup_py() -> None:
    assert set(ROSDEP_KEYS.values()) == KEYS | PACKAGES
    extras = (TOP / 'setup.py').read_text()
    for library in {*REQUIREMENTS, *ROSDEP_KEYS}:
        requirement = re.escape(REQUIREMENTS.get(library, library))
        assert re.search(rf"'{requirement}(>=[\d.]+)?'", extras), library


def test_no_message_names_a_distribution_that_is_not_on_pypi() -> None:
    """Whoever came by rosdep has the package from ROS: pip does not find it."""
    for path in (TOP / 'linkedplane_ros').rglob('*.py'):
        text = path.read_text()
        assert 'linkedplane_ros[' not in text, path
        if path.name != 'libraries.py':
            assert not re.search(r'pip install', text), path
    assert advise_install('viser') == "pip install 'viser>=1.1,<2'"
