# SPDX-License-Identifier: Apache-2.0
"""The packages import only in the way of the data; a wrong import on purpose is found."""

from __future__ import annotations

import shutil
from pathlib import Path
from xml.etree import ElementTree

import house
import pytest

SVG = '{http://www.w3.org/2000/svg}'


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """Return a copy of the package's sources, to be spoilt."""
    ignored = shutil.ignore_patterns('__pycache__', 'models', 'literature')
    return Path(shutil.copytree(house.SOURCES, tmp_path / 'linkedplane_ros', ignore=ignored))


def test_no_package_imports_a_later_one() -> None:
    assert list(house.faults()) == []


@pytest.mark.parametrize(
    ('file', 'line', 'fault'),
    [
        (
            'linked_planes/band.py',
            'from ..solver import kernels',
            'imports solver, a later',
        ),
        ('joints/conventions.py', 'from .. import muscle', 'imports muscle, a later package'),
        ('muscle/file.py', 'import linkedplane_ros.node.qos', 'imports node, a later package'),
        (
            'study/chapters/parts.py',
            'from ...viewer.scene.wire import read_markers',
            'imports viewer, a',
        ),
        ('drawing/plot.py', 'def late():\n    from ..commands import fit', 'imports commands, a'),
        ('solver/range_check.py', 'from sensor_msgs.msg import JointState', 'ROS belongs in node'),
        ('drawing/plot.py', 'import matplotlib.pyplot', 'imports matplotlib at its top'),
        ('types.py', 'from .node import qos', 'imports node, a later package'),
        ('files.py', 'import rclpy', 'ROS belongs in node'),
        ('fit/search/swarm.py', 'if True:\n    import scipy', 'imports scipy at its top'),
        ('fit/search/swarm.py', 'class Late:\n    import pymoo', 'imports pymoo at its top'),
        ('fit/search/swarm.py', 'from scipy import optimize', 'imports scipy at its top'),
        ('node/play.py', 'import viser', 'imports viser at its top'),
    ],
)
def test_a_wrong_import_is_found(sources: Path, file: str, line: str, fault: str) -> None:
    with (sources / file).open('a') as spoilt:
        spoilt.write(f'\n\n{line}\n')
    (found,) = set(house.faults(sources))
    assert found.startswith(f'linkedplane_ros/{file}:')
    assert fault in found


def test_a_package_that_has_no_place_in_the_order_is_found(sources: Path) -> None:
    (sources / 'helpers').mkdir()
    (sources / 'helpers' / '__init__.py').touch()
    (fault,) = house.faults(sources)
    assert fault == 'helpers: a package or module that doc/house.py does not know'


def test_arrows_count_the_modules_that_import(sources: Path) -> None:
    before = house.arrows(sources)
    (sources / 'rivals' / 'wires.py').write_text(
        'from ..recordings import bags\nfrom .. import rivals\n'
    )
    after = house.arrows(sources)
    assert after - before == {('rivals', 'recordings'): 1}
    order = list(house.PACKAGES)
    assert all(order.index(other) < order.index(package) for package, other in before)


def test_the_picture_has_every_package_and_no_arrow_that_follows_from_others() -> None:
    pairs = house.Counter(
        {('solver', 'muscle'): 3, ('muscle', 'joints'): 1, ('solver', 'joints'): 2}
    )
    assert house.direct(pairs) == [('muscle', 'joints'), ('solver', 'muscle')]
    floors = house.floors(pairs)
    assert [floors[name] for name in ('joints', 'muscle', 'solver')] == [0, 1, 2]
    picture = ElementTree.fromstring(house.picture())
    names = [text.text for text in picture.iter(SVG + 'text') if text.get('class') == 'name']
    assert names == list(house.PACKAGES)
    assert len(list(picture.iter(SVG + 'title'))) == len(house.direct(house.arrows()))
