# SPDX-License-Identifier: Apache-2.0
"""A table is read as the program that wrote it means it, or it is refused."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from command_line import command_fault, command_output

DEG = np.pi / 180.0
FRAMES = [[0.1, 0.2, 0.3], [0.11, 0.2, 0.3], [0.12, 0.2, 0.3]]
IN_DEGREES = [[k * DEG for k in row] for row in ([1, 2, -3], [1.5, 2.5, -3], [2, 3, -3])]

CASES = {  # what each README says; the numbers in the files, multiplied by pi/180 for a .mot
    'sep_commas_mot/a.mot': ([0.0, 0.01, 0.02], IN_DEGREES),
    'sep_decimal_comma/a.csv': ([0.0, 0.01, 0.02], FRAMES),
    'sep_decimal_comma/b.csv': ([0.0, 0.01], FRAMES[:2]),
    'time_names/motive.csv': ([0.0, 0.1], [[0.1, 0.2, 0.3], [0.15, 0.2, 0.3]]),
    'time_names/bracket.csv': ([0.0, 0.1], [[0.1, 0.2, 0.3], [0.15, 0.2, 0.3]]),
}

NAMES = 'time,flexion,abduction,rotation'
CSV = f'{NAMES}\n0.0,0.1,0.2,0.3\n0.01,0.11,0.2,0.3\n0.02,0.12,0.2,0.3\n'
MOT = (
    f'Coordinates\nversion=1\nnRows=3\ninDegrees=no\n\nUnits are S.I. units (second, meters, ...)\n'
    f'endheader\n{CSV}'
)
BY_A_SPREADSHEET = MOT.replace('no\n', 'no,,,\n').replace('endheader', '"endheader",,,')
SIBLINGS = {
    'semicolons and decimal commas.mot': BY_A_SPREADSHEET.replace(CSV, '')
    + CSV.replace(',', ';').replace('.', ','),
    'by a spreadsheet, with its mark.sto': '\ufeff' + BY_A_SPREADSHEET,
    'tabs and decimal commas.mot': MOT.replace(CSV, '') + CSV.replace(',', '\t').replace('.', ','),
    'tabs.tsv': CSV.replace(',', '\t'),
    'plotjuggler.csv': CSV.replace('time', '__time'),
    'milliseconds.csv': CSV.replace('time', 'Time (ms)')
    .replace('0.01,', '10,').replace('0.02,', '20,'),
    'stamps.csv': CSV.replace('time', 'header.stamp.sec,header.stamp.nanosec')
    .replace('0.0,', '0,0,').replace('0.01,', '0,10000000,').replace('0.02,', '0,20000000,'),
    'sep.csv': 'sep=\t\r\n' + CSV.replace(',', '\t').replace('\n', '\r\n'),
    'old macintosh.csv': CSV.replace('\n', '\r'),
    'padded.csv': CSV + ',,,\n,,,\n',
}  # fmt: skip


def processed(capsys: pytest.CaptureFixture[str], path: Path, target: Path, *options: str) -> str:
    """Return what the command prints for a table that is read whole."""
    return command_output(capsys, 'process', path, target, *options)


def read_output(path: Path) -> tuple[list[float], list[list[float]]]:
    """Return the times and angles of an output, by Python's own reader."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith('#')]
    rows = list(csv.reader(lines))[1:]
    return [float(row[0]) for row in rows], [[float(cell) for cell in row[1:4]] for row in rows]


@pytest.mark.parametrize('name', CASES)
def test_a_case_is_read_as_its_readme_says(
    capsys: pytest.CaptureFixture[str], cases: Path, tmp_path: Path, name: str
) -> None:
    processed(capsys, cases / name, tmp_path / 'o.csv')
    times, angles = read_output(tmp_path / 'o.csv')
    assert times == CASES[name][0]
    np.testing.assert_allclose(angles, CASES[name][1], rtol=1e-15)  # rad: one rounding


@pytest.mark.parametrize('name', SIBLINGS)
def test_a_dialect_changes_nothing(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    (tmp_path / name).write_bytes(SIBLINGS[name].encode())
    processed(capsys, tmp_path / name, tmp_path / 'o.csv')
    assert read_output(tmp_path / 'o.csv') == ([0.0, 0.01, 0.02], FRAMES)


def test_the_time_can_be_named_and_its_unit_stands_in_the_head(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    table, out = tmp_path / 'a.csv', tmp_path / 'o.csv'
    table.write_text('clock_ms,flexion,abduction,rotation\n0,0.1,0.2,0.3\n10,0.11,0.2,0.3\n')
    assert 'or another unit; else --time NAME); found clock_ms, flexion' in command_fault(
        capsys, 'process', table, out
    )
    processed(capsys, table, out, '--time', 'clock_ms')
    assert read_output(out) == ([0.0, 0.01], FRAMES[:2])
    assert '# times: clock_ms in ms\n' in out.read_text()
    fault = command_fault(capsys, 'process', table, out, '--force', '--time', 'clock')
    assert "a.csv:1: 0 columns are named 'clock'; one expected" in fault


def test_a_bag_has_no_column_of_time(
    capsys: pytest.CaptureFixture[str], shared: Path, tmp_path: Path
) -> None:
    bag = shared / 'recordings' / 'abduction_mcap'
    fault = command_fault(capsys, 'process', bag, tmp_path / 'o.csv', '--time', 't')
    assert 'a bag has stamps; --time is for tables' in fault


def test_gaps_are_counted_however_they_are_spelt(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    table = tmp_path / 'a.csv'
    gaps = ('-nan(ind)', '1.#QNAN', 'NA', '#N/A', '', 'inf', '-1.#INF')
    rows = [f'{k},{gap},0.2,0.3\n' for k, gap in enumerate(['0.1'] * 20 + list(gaps))]
    table.write_text(f'{NAMES}\n{"".join(rows)}')
    printed = processed(capsys, table, tmp_path / 'o.csv')
    assert '20 frames' in printed
    assert '7 refused as not_finite, first at row 21, 20.00 s' in printed


@pytest.mark.parametrize('key', ['nRows=5', 'nRows = 5,,,', 'datarows 5'])
def test_rows_that_are_counted_and_not_there_are_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, key: str
) -> None:
    table = tmp_path / 'cut.mot'
    table.write_text(MOT.replace('nRows=3', key))
    printed = processed(capsys, table, tmp_path / 'o.csv')
    assert '3 frames' in printed
    assert '3 rows are there, but its head says 5' in printed
