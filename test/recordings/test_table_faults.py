# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a motion table, in one line that says where."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from motion_tables import CSV, MOT, read_all, read_fault, write_table

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.recordings.tables.lines import LONGEST_LINE
from linkedplane_ros.recordings.tables.table import Table

NOBODY = 65534  # a user without rights

FAULTS = {
    'an empty mot': ('m.mot', '', 'm.mot:1: empty; a header and rows of numbers expected'),
    'an empty csv': ('m.csv', '', 'm.csv:1: empty; a header and rows of numbers expected'),
    'nothing but a byte order mark': ('m.csv', '\ufeff', 'm.csv:1: names of columns expected'),
    'nothing but comments': (
        'm.csv',
        '# a\n# time,a,b\n',
        'm.csv:2: names of columns expected, a time among them '
        '(time, t, time_s, timestamp, time (s), or another unit; else --time NAME); found nothing',
    ),
    'nothing but blank lines': ('m.csv', '\n \n\n', 'm.csv:3: names of columns expected'),
    'no header row': (
        'm.csv',
        '0,1,2\n0.1,3,4\n',
        'm.csv:1: names of columns expected, a time among them '
        '(time, t, time_s, timestamp, time (s), or another unit; else --time NAME); found 0, 1, 2',
    ),
    'no table at all': ('m.csv', '{' + 'x' * 9999, 'found {' + 'x' * 99),
    'no time': ('m.csv', '#\nx,y\n0,1\n', 'found x, y'),
    'no time in a mot': ('m.mot', MOT.replace('time', 'x'), 'm.mot:5: names of columns expected'),
    'two times': ('m.csv', 'time,time,a\n', "m.csv:1: 2 columns are named 'time'; one expected"),
    'no endheader': (
        'm.sto',
        MOT.replace('endheader\n', ''),
        "m.sto:6: the file ends, but a line 'endheader' was expected before",
    ),
    'a mot named csv': (
        'm.csv',
        MOT,
        "m.csv:4: 'endheader', as in OpenSim's tables; rename this .csv to .mot or .sto",
    ),
    'a mot named tsv, by a spreadsheet': (
        'm.tsv',
        MOT.replace('\n', '\t\t\n').removeprefix('Coordinates\t\t\n'),
        "m.tsv:3: 'endheader', as in OpenSim's tables; rename this .tsv to .mot or .sto",
    ),
    'a mot with prose named csv': (
        'm.csv',
        MOT.replace('endheader', '\nUnits are S.I. units (second, meters, ...)\n\n"EndHeader"'),
        "m.csv:7: 'endheader', as in OpenSim's tables",
    ),
    'no names': ('m.mot', 'endheader\n\n', 'found nothing'),
    'no rows in a mot': (
        'm.mot',
        'endheader\ntime a b\n \n',
        'm.mot:2: no rows of numbers after the names',
    ),
    'no rows in a csv': ('m.csv', '#\ntime,a,b\n\n', 'm.csv:2: no rows of numbers after the names'),
    'a row too short': (
        'm.mot',
        MOT.replace('\t4', ''),
        'm.mot:7: 2 cells; 3, as the names, expected',
    ),
    'a row too long': (
        'm.csv',
        '#\n' + CSV.replace('3', '3,3'),
        'm.csv:4: 4 cells; 3, as the names, expected',
    ),
    'a comment among the rows': (
        'm.csv',
        CSV + '# end\n',
        'm.csv:4: 1 cells; 3, as the names, expected; a comment among the rows? leave it out',
    ),
    'a row that is a comment': (
        'm.csv',
        CSV + '#1,2,3\n',
        "m.csv:4: column 'time': '#1' is not a number; a comment among the rows? leave it out",
    ),
    'cells apart by spaces': (
        'm.csv',
        CSV.replace(',', ' '),
        'found time a b; commas, semicolons or tabs expected between them',
    ),
    'a date of ISO': (
        'm.csv',
        CSV.replace('0.1', '2024-05-01T12:00:00Z'),
        'a date or a time of day?',
    ),
    'an end within a row': ('m.csv', CSV[:-3], 'm.csv:3: 2 cells; 3, as the names, expected'),
    'a word': (
        'm.csv',
        CSV.replace('4', 'four'),
        "m.csv:3: column 'b': 'four' is not a number; one like -0.5 expected",
    ),
    'a word in a mot': ('m.mot', MOT.replace('1\t2', 'x\t2'), "m.mot:6: column 'a': 'x' is no"),
    'a decimal comma between commas': (
        'm.csv',
        'time,a,b\n0,1,2\n1,3,5,4\n',
        'm.csv:3: 4 cells; 3, as the names, expected',
    ),
    'decimal commas and points': (
        'm.csv',
        'time;a;b\n0.5;1;2\n1;3,5;4\n',
        "m.csv:3: '3,5' has a comma, '0.5' in line 2 a point; one mark of decimals expected",
    ),
    'a point after decimal commas': (
        'm.csv',
        'time;a;b\n' + '0,5;1;2\n' * 300 + '1;3.5;4\n',
        "m.csv:302: column 'a': '3.5' is not a number; one like -0,5 expected: decimals have "
        'commas in this table, as its first 200 rows show',
    ),
    'a decimal comma after points': (
        'm.csv',
        'time;a;b\n' + '0.5;1;2\n' * 250 + '1;0,5;4\n',
        "m.csv:252: column 'a': '0,5' is not a number; one like -0.5 expected: decimals have "
        'points in this table, as its first 200 rows show',
    ),
    'a decimal comma after points in a mot': (
        'm.mot',
        MOT + '0.2\t5\t6\n' * 250 + '0.3\t-1,25\t6\n',
        "m.mot:258: column 'a': '-1,25' is not a number; one like -0.5 expected: decimals have "
        'points in this table',
    ),
    'decimals or thousands': (
        'm.csv',
        'time;a;b\n0;1,234;2\n1;3,500;4\n',
        "m.csv:2: '1,234' can be read in two ways, with decimals or with thousands",
    ),
    'thousands': (
        'm.csv',
        'time;a;b\n0;1,234.5;2\n',
        "m.csv:2: column 'a': '1,234.5' is not a number; one like -0.5 expected",
    ),
    'as many commas as semicolons': (
        'm.csv',
        'time,a;b\n0,1;2\n',
        'm.csv:1: as many commas as semicolons between the names; a first line sep=, or sep=;',
    ),
    'a separator that is not known': ('m.csv', 'sep=|\ntime|a|b\n', 'm.csv:1: sep=|: a comma,'),
    'a number of India': ('m.csv', CSV.replace('4', '\u0664'), "column 'b': '\u0664' is not a"),
    'a date': (
        'm.csv',
        CSV.replace('0.1', '2024-05-01 12:00:00.5'),
        "'2024-05-01 12:00:00.5' is not a number; a date or a time of day? seconds as a plain",
    ),
    'a row of units': (
        'm.csv',
        CSV.replace('b\n', 'b\ns,deg,deg\n'),
        "m.csv:2: column 'time': 's' is not a number; a row of units? leave it out",
    ),
    'minutes': (
        'm.csv',
        CSV.replace('time', 'Time (min)'),
        "m.csv:1: the time 'Time (min)' is in 'min'; s, ms, us or ns expected",
    ),
    'two usual times': (
        'm.csv',
        'time_ms,Time [s],a\n0,1,2\n',
        'm.csv:1: 2 columns can be the time: time_ms, Time [s]; one expected, or --time NAME',
    ),
    'stamps that are no stamps': (
        'm.csv',
        'time_sec,time_nanosec,a,b\n0.5,500000000,1,2\n',
        "m.csv:1: 'time_sec' and 'time_nanosec' are not whole seconds and nanoseconds below 1e9",
    ),
    'zero bytes': ('m.csv', CSV.replace('4', '4\0'), 'm.csv:1: UTF-16, or bytes that are zero'),
    'zero bytes later': (
        'm.csv',
        CSV + '0.2,5,6\n' * 1000 + '0.3,\0,\0\n',
        'm.csv:1004: ',
    ),
    'a number only to Python': (
        'm.csv',
        CSV.replace('0.1', '2_0'),
        "m.csv:3: column 'time': '2_0' is",
    ),
    'a long cell': (
        'm.csv',
        CSV.replace('4', 'x' * 999),
        f"column 'b': '{'x' * 40}' is not a number",
    ),
    'lines counted within quotes': (
        'm.csv',
        'time,a,b,c\n0,1,2,"one\ntwo"\n1,2,"x\ny",3\n',
        "m.csv:4: column 'b': 'x\\ny' is not a number",
    ),
    'a quote that does not end': ('m.csv', CSV.replace('3', '"3'), 'm.csv:3: not CSV: '),
    'a quote that takes a row in': (
        'm.csv',
        'time,a,b,note\n0,1,2,"x"\n1,3,4,"x\n2,5,6,"x"\n3,7,8,"x"\n',
        'm.csv:3: not CSV: ',
    ),
    'a quote in the last cell': (
        'm.csv',
        'time,a,b,note\n0,1,2,x\n1,3,4,"5\n2,5,6,x\n',
        'm.csv:3: not CSV: ',
    ),
    'a quote over half the file': (
        'm.csv',
        CSV + '0.2,"5' + ',6\n0.3,5' * 20_000,
        'm.csv:4: not CSV: field larger than field limit',
    ),
    'no time in a row': ('m.csv', CSV.replace('0.1', ''), "m.csv:3: its time is ''; a finite"),
    'a time that is nan': (
        'm.mot',
        MOT.replace('0.1', 'nan'),
        "m.mot:7: its time is 'nan'; a finite number expected",
    ),
    'a time that is inf': ('m.csv', CSV.replace('0.1', '1e999'), "m.csv:3: its time is '1e999'"),
    'a column chosen that stands twice': (
        'm.csv',
        '#\ntime,a,b,a\n0,1,2,3\n',
        "m.csv:2: 2 columns are named 'a'; one expected",
    ),
    'a column that is not there': (
        'm.csv',
        'time,a\n0,1\n',
        "m.csv:1: 0 columns are named 'b'; one expected",
    ),
    'not utf-8': (
        'm.csv',
        '# Mitte\ntime,a,b\n0,1,ä\n'.encode('latin-1'),
        "m.csv:3: column 'b': 'ä' is not a number",
    ),
    'utf-16': (
        'm.csv',
        CSV.encode('utf-16'),
        'm.csv:1: UTF-16, or bytes that are zero; save the table as UTF-8',
    ),
    'a spreadsheet': ('m.csv', b'PK\x03\x04\x14\x00\x06\xb5', 'm.csv: an archive (ZIP'),
    'a line without end': (
        'm.csv',
        b'time,a,b\n' + b'0' * 3 * LONGEST_LINE,
        f'm.csv:2: a line of {LONGEST_LINE} bytes or more; not a table?',
    ),
}


@pytest.mark.parametrize('case', FAULTS)
def test_a_fault_is_named_in_one_line_with_its_place(tmp_path: Path, case: str) -> None:
    name, content, reason = FAULTS[case]
    text = read_fault(write_table(tmp_path, name, content))
    assert reason in text
    assert text.startswith(f'{name}:')
    assert len(text) < 300


def test_a_decimal_comma_between_commas_is_no_matter_of_the_first_rows(tmp_path: Path) -> None:
    text = read_fault(write_table(tmp_path, 'm.csv', CSV.replace('4', '"0,5"')))
    assert text.endswith("'0,5' is not a number; one like -0.5 expected")


@pytest.mark.parametrize('row', [1, 2, 500, 2500])
def test_a_fault_is_found_in_whatever_chunk_it_is(tmp_path: Path, row: int) -> None:
    lines = ['time,a', *(f'{i},{i}' for i in range(2500))]
    lines[row] = '7,seven'
    table = Table.from_file(write_table(tmp_path, 'motion.csv', '\n'.join(lines)))
    for rows in (1, 1000, 10_000):
        with pytest.raises(RecordingError, match=rf"motion\.csv:{row + 1}: column 'a': 'seven' is"):
            read_all(table, ('a',), rows)


def test_the_rows_before_a_faulty_chunk_are_given(tmp_path: Path) -> None:
    chunks = Table.from_file(write_table(tmp_path, 'motion.csv', CSV + '0.2,x,5\n')).chunks(
        ('a',), rows=2
    )
    assert next(chunks)[1].tolist() == [[1.0], [3.0]]
    with pytest.raises(RecordingError, match=r"motion\.csv:4: column 'a': 'x' is not a number"):
        next(chunks)


def test_a_header_is_read_without_the_rows(tmp_path: Path) -> None:
    for name, content in (('motion.csv', CSV), ('motion.mot', MOT)):
        path = write_table(tmp_path, name, content.encode() + b'\xff\n')
        assert Table.from_file(path).columns == ('a', 'b')


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    assert read_fault(tmp_path / 'm.csv') == 'm.csv: cannot be read: No such file or directory'


def test_a_file_that_went_away_is_named(tmp_path: Path) -> None:
    table = Table.from_file(write_table(tmp_path, 'm.csv', CSV))
    table.path.unlink()
    with pytest.raises(RecordingError, match=r'm\.csv: cannot be read: No such file or directory'):
        next(table.chunks(('a',)))


@pytest.mark.parametrize('name', ['folder', 'folder.mot'])
def test_a_folder_is_no_table(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    assert read_fault(tmp_path / name) == f'{name}: cannot be read: Is a directory'


@contextmanager
def unprivileged() -> Iterator[None]:
    """Be nobody for a while: root may read whatever it likes."""
    if os.geteuid():
        yield
        return
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)


def test_a_file_without_permission_is_named(tmp_path: Path) -> None:
    path = write_table(tmp_path, 'm.csv', CSV)
    path.chmod(0)
    with unprivileged():
        assert read_fault(path) == 'm.csv: cannot be read: Permission denied'


@pytest.mark.parametrize('name', ['time_min', 'Frame', 'minutes', 'clock (h)', 'sample'])
def test_a_time_that_is_named_is_not_taken_for_seconds_against_its_name(
    tmp_path: Path, name: str
) -> None:
    path = write_table(tmp_path, 'm.csv', CSV.replace('time', name))
    with pytest.raises(RecordingError, match=r'is in .*; s, ms, us or ns expected'):
        Table.from_file(path, name)
