# SPDX-License-Identifier: Apache-2.0
"""The arguments of a fit."""

from __future__ import annotations

from pathlib import Path

import pytest
from fits import simulated, ten_percent_off, write_data

from linkedplane_ros import BroadMuscle

DELTOID = BroadMuscle.load('deltoid')


@pytest.fixture
def task(tmp_path: Path) -> list[str]:
    """Return the arguments of a fit that recovers the deltoid's lengths and moment arms."""
    ten_percent_off(0).to_yaml(tmp_path / 'start.yaml')
    data = write_data(tmp_path, simulated(DELTOID))
    return ['fit', str(tmp_path / 'start.yaml'), str(data), str(tmp_path / 'fitted.yaml')]
