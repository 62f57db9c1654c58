# SPDX-License-Identifier: Apache-2.0
"""Small motion tables, written and read."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.recordings.tables.table import Table
from linkedplane_ros.types import Floats

JOINTS = ('plane_elv', 'shoulder_elv', 'axial_rot')
MOT = 'Coordinates\nversion=1\ninDegrees=yes\nendheader\ntime\ta\tb\n0\t1\t2\n0.1\t3\t4\n'
CSV = 'time,a,b\n0,1,2\n0.1,3,4\n'


def write_table(folder: Path, name: str, content: str | bytes) -> Path:
    """Return the path of a file with this content, its line ends as they are given."""
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def read_all(table: Table, names: tuple[str, ...], rows: int = 10_000) -> tuple[Floats, Floats]:
    """Return all that a table holds of some columns, read in chunks, as float64."""
    times, values, shares = zip(*table.chunks(names, rows), strict=True)
    assert list(shares) == sorted(shares)
    assert shares[-1] == 1.0
    return np.concatenate(times).astype(float), np.concatenate(values)


def read_fault(path: Path, names: tuple[str, ...] = ('a', 'b')) -> str:
    """Return the line with which reading a file has to fail, without the folder."""
    with pytest.raises(RecordingError) as caught:
        read_all(Table.from_file(path), names)
    text = str(caught.value)
    assert text.startswith(f'{path}:')
    assert '\n' not in text
    return text.removeprefix(f'{path.parent}{os.sep}')
