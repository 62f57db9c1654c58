# SPDX-License-Identifier: Apache-2.0
"""Studies that take little time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from linkedplane_ros.commands.main import main
from linkedplane_ros.study import report
from linkedplane_ros.study.pictures import charts, poses


@pytest.fixture(scope='module')
def coarse() -> Iterator[None]:
    """Draw with fewer pixels, in half of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, 'DPI', 50)
        yield


@pytest.fixture(scope='module')
def study(coarse: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a study of the published deltoid, without the animation."""
    folder = tmp_path_factory.mktemp('studies') / 'study'
    assert main(['study', str(folder), '--no-animation']) == 0
    return folder


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write only text and tables, for tests that do not look at the pictures."""
    monkeypatch.setattr(report, 'CHAPTERS', report.CHAPTERS[2:4])
    monkeypatch.setattr(charts, 'depths_figure', lambda readings: empty_figure())
    monkeypatch.setattr(charts, 'fidelity_figure', lambda subject: empty_figure())
    monkeypatch.setattr(poses, 'entries_figure', lambda readings: empty_figure())


def empty_figure() -> object:
    """Return an empty figure."""
    from matplotlib.figure import Figure

    return Figure(figsize=(0.1, 0.1))
