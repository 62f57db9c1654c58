# SPDX-License-Identifier: Apache-2.0
"""Times since the epoch keep their nanoseconds, and a rate keeps the last frame."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import pytest
from bags import exit_status

ANGLES = ',flexion,abduction,rotation\n'


def written(tmp_path: Path, table: str, *options: str) -> list[list[str]]:
    """Process a table; return time and angles of the output's rows, as they stand in it."""
    (tmp_path / 'in.csv').write_text(table)
    out = tmp_path / 'out.csv'
    assert exit_status([str(tmp_path / 'in.csv'), str(out), '--plain', *options]) == 0
    return [line.split(',')[:4] for line in out.read_text().splitlines()[1:]]


@pytest.mark.parametrize(
    ('name', 'unit', 'point'),
    [('time', 9, '.'), ('time [ms]', 6, '.'), ('t_us', 3, '.'), ('timestamp_ns', 0, '.'),
     ('time', 9, ',')],
)  # fmt: skip
def test_no_nanosecond_is_lost(tmp_path: Path, name: str, unit: int, point: str) -> None:
    stamps = [1717000000 * 10**9 + 10_000_001 * k + 7 * k * k for k in range(40)]
    times = [f'{Decimal(stamp).scaleb(-unit):f}'.replace('.', point) for stamp in stamps]
    mark = ';' if point == ',' else ','
    rows = [mark.join((each, f'0{point}1', f'0{point}2', f'0{point}3')) for each in times]
    table = '\n'.join([(name + ANGLES.rstrip()).replace(',', mark), *rows, ''])
    found = [Decimal(row[0]) for row in written(tmp_path, table)]
    assert found == [Decimal(stamp).scaleb(-9) for stamp in stamps]


def test_stamps_in_two_columns_are_added_exactly(tmp_path: Path) -> None:
    table = 'header.stamp.sec,header.stamp.nanosec' + ANGLES
    table += '1717000000,999999999,.1,.2,.3\n1717000001,1,.1,.2,.3\n'
    assert [row[0] for row in written(tmp_path, table)] == [
        '1717000000.999999999',
        '1717000001.000000001',
    ]


@pytest.mark.parametrize('rate', [100, 200, 1000])
def test_a_rate_keeps_the_last_frame_and_the_angles(tmp_path: Path, rate: int) -> None:
    table = 'time' + ANGLES
    table += ''.join(f'1717000000.{40 + 10 * k:03d},.{14 + k},.3,.05\n' for k in range(4))
    found = written(tmp_path, table, '--rate', str(rate))
    assert len(found) == 1 + 3 * rate // 100
    assert [row[0] for row in found[:: rate // 100]] == [
        f'1717000000.0{each}0000000' for each in (4, 5, 6, 7)
    ]
    for row, flexion in zip(found[:: rate // 100], (0.14, 0.15, 0.16, 0.17), strict=True):
        assert float(row[1]) == pytest.approx(flexion, abs=1e-12)
