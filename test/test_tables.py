"""Motion tables: what OpenSim and CSV files hold, what is wrong with them, and where."""

from __future__ import annotations

import math
import os
import sys
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from linkedplane_ros.recordings import RecordingError
from linkedplane_ros.tables import (
    LONGEST,
    Floats,
    Table,
    choose,
    differentiated,
    lowpassed,
    resampled,
)

JOINTS = ('plane_elv', 'shoulder_elv', 'axial_rot')
MOT = 'Coordinates\nversion=1\ninDegrees=yes\nendheader\ntime\ta\tb\n0\t1\t2\n0.1\t3\t4\n'
CSV = 'time,a,b\n0,1,2\n0.1,3,4\n'
NOBODY = 65534
# the machine may be busy: nothing here is about time
unhurried = settings(deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])


def written(folder: Path, name: str, content: str | bytes) -> Path:
    """Return the path of a file with this content, its line ends as they are given."""
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def whole(table: Table, names: tuple[str, ...], rows: int = 10_000) -> tuple[Floats, Floats]:
    """Return all that a table holds of some columns, read in chunks."""
    times, values, shares = zip(*table.chunks(names, rows), strict=True)
    assert list(shares) == sorted(shares)
    assert shares[-1] == 1.0
    return np.concatenate(times), np.concatenate(values)


def fault(path: Path, names: tuple[str, ...] = ('a', 'b')) -> str:
    """Return the line with which reading a file has to fail, without the folder."""
    with pytest.raises(RecordingError) as caught:
        whole(Table.open(path), names)
    text = str(caught.value)
    assert text.startswith(f'{path}:')
    assert '\n' not in text
    return text.removeprefix(f'{path.parent}{os.sep}')


# what a file holds


@pytest.mark.parametrize('motion', ['abduction', 'flexion'])
def test_a_mot_in_degrees_is_the_csv_in_radians(shared: Path, motion: str) -> None:
    mot = Table.open(shared / 'recordings' / f'{motion}.mot')
    csv = Table.open(shared / 'recordings' / f'{motion}.csv')
    assert (mot.time_column, csv.time_column) == ('time', 'time_s')
    assert (mot.in_degrees, csv.in_degrees) == (True, None)
    assert len(mot.columns) == 17
    assert csv.columns == tuple(f'{joint}_rad' for joint in JOINTS)
    times, degrees = whole(mot, choose(mot.columns, JOINTS))
    seconds, radians = whole(csv, csv.columns)
    np.testing.assert_array_equal(times, seconds)
    # rad: the CSV is rounded to 8 decimals
    np.testing.assert_allclose(np.radians(degrees), radians, rtol=0.0, atol=0.51e-8)


def test_a_recording_has_the_rows_that_its_header_tells_of(shared: Path) -> None:
    times, values = whole(Table.open(shared / 'recordings' / 'abduction.mot'), JOINTS)
    assert times.shape == (1091,)
    assert values.shape == (1091, 3)


def test_a_long_recording_comes_in_order(shared: Path) -> None:
    table = Table.open(shared / 'recordings' / 'daily_motion.csv')
    times, values = whole(table, table.columns, rows=1000)
    assert values.shape == (9800, 3)
    np.testing.assert_allclose(np.diff(times), 0.01, rtol=0.0, atol=1e-9)  # s: 100 Hz


@pytest.mark.parametrize(
    ('header', 'in_degrees'),
    [
        ('Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\n', True),
        ('INDEGREES = No\nnColumns=3\nCoordinates\n', False),
        ('motion\nversion=1\n', None),
        ('', None),
        ("\nA line with 'inDegrees', which indicates degrees (yes) or radians (no).\n", None),
        ('name old\ndatacolumns 3\ndatarows 2\notherdata 1\nrange 0 0.1\n', None),
        ('\ufeffinDegrees=no\n', False),
    ],
)
def test_an_opensim_header_says_what_it_says_in_any_order(
    tmp_path: Path, header: str, in_degrees: bool | None
) -> None:
    for name in ('motion.mot', 'MOTION.STO'):
        path = written(tmp_path, name, f'{header}EndHeader \n\nTime\ta b\n 0 \t1  2\t\n0.1 3 4')
        table = Table.open(path)
        assert table == Table(path, ('a', 'b'), 'Time', in_degrees)
        times, values = whole(table, ('b', 'a'))
        assert times.tolist() == [0.0, 0.1]
        assert values.tolist() == [[2.0, 1.0], [4.0, 3.0]]


@pytest.mark.parametrize(
    'content',
    [
        CSV,
        CSV.replace('\n', '\r\n'),
        CSV.rstrip('\n'),
        CSV.replace(',', ';'),
        CSV.replace(',', '\t'),
        CSV.replace(',', ', '),
        CSV.replace('0.1', '1e-1').replace('4', ' +4. '),
        '\ufeff' + CSV,
        '\ufeff# by hand; on a Monday; in May\n\n# at last,\n' + CSV,
        '"time","a","b"\n"0","1","2"\n"0.1","3","4"\n',
        '"time" , "a", "b"\n0, "1", 2\n0.1, "3" ,4\n',
        'a,time,b\n1,0,2\n\n3,0.1,4\n\n',
        'time;"a";"b";"c, d, e, f"\n0;1;2;x\n0.1;3;4;"y\nz"\n',
    ],
)
def test_a_csv_may_be_written_in_any_usual_way(tmp_path: Path, content: str) -> None:
    table = Table.open(written(tmp_path, 'motion.csv', content))
    assert table.columns[:2] == ('a', 'b')
    times, values = whole(table, ('a', 'b'))
    assert times.tolist() == [0.0, 0.1]
    assert values.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize('time', ['time', 'T', 'time_s', 'Timestamp', 'Time (s)'])
def test_the_time_of_a_csv_has_a_usual_name(tmp_path: Path, time: str) -> None:
    table = Table.open(written(tmp_path, 'motion.csv', CSV.replace('time', time)))
    assert (table.time_column, table.columns) == (time, ('a', 'b'))


def test_of_two_times_the_plainer_name_counts(tmp_path: Path) -> None:
    table = Table.open(written(tmp_path, 'motion.csv', 'timestamp,time,a\n9,0,1\n'))
    assert (table.time_column, table.columns) == ('time', ('timestamp', 'a'))
    times, values = whole(table, ('timestamp',))
    assert (times.tolist(), values.tolist()) == ([0.0], [[9.0]])


def test_a_gap_is_nan(tmp_path: Path) -> None:
    path = written(tmp_path, 'motion.csv', 'time,a,b\n0,,NaN\n0.1, ,4\n0.2,nan,\n')
    _, values = whole(Table.open(path), ('a', 'b'))
    np.testing.assert_array_equal(values, [[math.nan, math.nan], [math.nan, 4.0], [math.nan] * 2])
    path = written(tmp_path, 'motion.sto', MOT.replace('3', 'nan'))
    np.testing.assert_array_equal(whole(Table.open(path), ('a',))[1], [[1.0], [math.nan]])


def test_columns_that_nobody_asks_for_may_hold_anything(tmp_path: Path) -> None:
    path = written(tmp_path, 'motion.csv', 'time,note,a,note,\n0,gähn,1,,x\n0.1,"1_0",2,5,\n')
    table = Table.open(path)
    assert table.columns == ('note', 'a', 'note', '')
    assert whole(table, ('a',))[1].tolist() == [[1.0], [2.0]]


def test_the_times_can_be_had_alone(tmp_path: Path) -> None:
    times, values = whole(Table.open(written(tmp_path, 'motion.csv', CSV)), ())
    assert (times.tolist(), values.shape) == ([0.0, 0.1], (2, 0))


@pytest.mark.parametrize('name', ['motion.csv', 'motion.mot'])
@pytest.mark.parametrize('rows', [1, 3, 6, 7, 8, 10**9])
def test_where_chunks_end_does_not_matter(tmp_path: Path, name: str, rows: int) -> None:
    numbers = np.random.default_rng(1).normal(size=(7, 3))
    text = '\n'.join(','.join(map(repr, row)) for row in numbers.tolist())
    content = f'time,a,b\n{text}\n'
    if name.endswith('.mot'):
        content = 'endheader\n' + content.replace(',', '\t')
    chunks = list(Table.open(written(tmp_path, name, content)).chunks(('b', 'a'), rows))
    assert [len(times) for times, _, _ in chunks[:-1]] == [rows] * (len(chunks) - 1)
    assert 0 < len(chunks[-1][0]) <= rows
    np.testing.assert_array_equal(np.concatenate([times for times, _, _ in chunks]), numbers[:, 0])
    np.testing.assert_array_equal(
        np.concatenate([values for _, values, _ in chunks]), numbers[:, [2, 1]]
    )


def test_a_chunk_has_at_least_a_row(tmp_path: Path) -> None:
    table = Table.open(written(tmp_path, 'motion.csv', CSV))
    with pytest.raises(ValueError, match='chunks of 0 rows; at least 1 expected'):
        next(table.chunks(('a',), 0))


def test_a_long_file_takes_no_more_memory_than_a_short_one(tmp_path: Path) -> None:
    def peak(count: int) -> int:
        text = 'time,a\n' + ''.join(f'{i},{i}.5\n' for i in range(count))
        table = Table.open(written(tmp_path, 'motion.csv', text))
        del text
        tracemalloc.start()
        for _ in table.chunks(('a',), rows=500):
            pass
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return size

    peak(2_000)  # what is made once for all
    # the tenfold file in one piece would take the tenfold; half as much again is for chance
    assert peak(20_000) < 1.5 * peak(2_000)


@unhurried
@given(
    st.lists(
        st.tuples(
            st.floats(allow_nan=False, allow_infinity=False), st.floats(), st.floats(width=32)
        ),
        min_size=1,
        max_size=20,
    ),
    st.sampled_from([',', ';', '\t', ', ']),
    st.sampled_from(['\n', '\r\n']),
    st.integers(1, 25),
)
def test_what_is_written_is_read_to_the_bit(
    tmp_path_factory: pytest.TempPathFactory,
    numbers: list[tuple[float, float, float]],
    delimiter: str,
    end: str,
    rows: int,
) -> None:
    lines = [delimiter.join(row) for row in [('time', 'a', 'b'), *(map(repr, n) for n in numbers)]]
    path = tmp_path_factory.getbasetemp() / 'written.csv'
    path.write_bytes(''.join(line + end for line in lines).encode())
    times, values = whole(Table.open(path), ('a', 'b'), rows)
    np.testing.assert_array_equal(times, [row[0] for row in numbers])
    np.testing.assert_array_equal(values, [row[1:] for row in numbers])
    if delimiter == '\t':
        path = path.with_suffix('.sto')
        path.write_bytes(''.join(line + end for line in ['endheader', *lines]).encode())
        for one, other in zip(
            whole(Table.open(path), ('a', 'b'), rows), (times, values), strict=True
        ):
            np.testing.assert_array_equal(one, other)


# what is wrong with it


FAULTS = {
    'an empty mot': ('m.mot', '', 'm.mot:1: empty; a header and rows of numbers expected'),
    'an empty csv': ('m.csv', '', 'm.csv:1: empty; a header and rows of numbers expected'),
    'nothing but a byte order mark': ('m.csv', '\ufeff', 'm.csv:1: names of columns expected'),
    'nothing but comments': (
        'm.csv',
        '# a\n# time,a,b\n',
        'm.csv:1: names of columns expected, a time among them '
        '(time, t, time_s, timestamp, time (s)); found nothing',
    ),
    'nothing but blank lines': ('m.csv', '\n \n\n', 'm.csv:1: names of columns expected'),
    'no header row': (
        'm.csv',
        '0,1,2\n0.1,3,4\n',
        'm.csv:1: names of columns expected, a time among them '
        '(time, t, time_s, timestamp, time (s)); found 0, 1, 2',
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
    'no names': ('m.mot', 'endheader\n\n', 'found nothing'),
    'neither degrees nor radians': (
        'm.mot',
        MOT.replace('yes', 'maybe'),
        "m.mot:3: inDegrees is 'maybe'; yes or no expected",
    ),
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
    'a comment among the rows': ('m.csv', CSV + '# end\n', 'm.csv:4: 1 cells; 3, as the names'),
    'an end within a row': ('m.csv', CSV[:-3], 'm.csv:3: 2 cells; 3, as the names, expected'),
    'a word': (
        'm.csv',
        CSV.replace('4', 'four'),
        "m.csv:3: column 'b': 'four' is no number; one like -0.5 expected",
    ),
    'a word in a mot': ('m.mot', MOT.replace('1\t2', 'x\t2'), "m.mot:6: column 'a': 'x' is no"),
    'a decimal comma': (
        'm.csv',
        'time;a;b\n0;1;2\n1;3,5;4\n',
        "m.csv:3: column 'a': '3,5' is no number; one like -0.5 expected",
    ),
    'a number only to Python': (
        'm.csv',
        CSV.replace('0.1', '2_0'),
        "m.csv:3: column 'time': '2_0' is",
    ),
    'a long cell': ('m.csv', CSV.replace('4', 'x' * 999), f"column 'b': '{'x' * 40}' is no number"),
    'lines counted within quotes': (
        'm.csv',
        'time,a,b,c\n0,1,2,"one\ntwo"\n1,2,"x\ny",3\n',
        "m.csv:4: column 'b': 'x\\ny' is no number",
    ),
    'a quote that does not end': ('m.csv', CSV.replace('3', '"3'), 'm.csv:3: 2 cells; 3'),
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
        'm.csv:3: not UTF-8; save the table as UTF-8',
    ),
    'utf-16': ('m.csv', CSV.encode('utf-16'), 'm.csv:1: not UTF-8; save the table as UTF-8'),
    'a spreadsheet': ('m.csv', b'PK\x03\x04\x14\x00\x06\xb5', 'm.csv:1: not UTF-8'),
    'a line without end': (
        'm.csv',
        b'time,a,b\n' + b'0' * 3 * LONGEST,
        f'm.csv:2: a line of {LONGEST} bytes or more; not a table?',
    ),
}


@pytest.mark.parametrize('case', FAULTS)
def test_a_fault_is_named_in_one_line_with_its_place(tmp_path: Path, case: str) -> None:
    name, content, reason = FAULTS[case]
    text = fault(written(tmp_path, name, content))
    assert reason in text
    assert text.startswith(f'{name}:')
    assert len(text) < 300


@pytest.mark.parametrize('row', [1, 2, 500, 2500])
def test_a_fault_is_found_in_whatever_chunk_it_is(tmp_path: Path, row: int) -> None:
    lines = ['time,a', *(f'{i},{i}' for i in range(2500))]
    lines[row] = '7,seven'
    table = Table.open(written(tmp_path, 'motion.csv', '\n'.join(lines)))
    for rows in (1, 1000, 10_000):
        with pytest.raises(RecordingError, match=rf"motion\.csv:{row + 1}: column 'a': 'seven' is"):
            whole(table, ('a',), rows)


def test_the_rows_before_a_faulty_chunk_are_given(tmp_path: Path) -> None:
    chunks = Table.open(written(tmp_path, 'motion.csv', CSV + '0.2,x,5\n')).chunks(('a',), rows=2)
    assert next(chunks)[1].tolist() == [[1.0], [3.0]]
    with pytest.raises(RecordingError, match=r"motion\.csv:4: column 'a': 'x' is no number"):
        next(chunks)


def test_a_header_is_read_without_the_rows(tmp_path: Path) -> None:
    for name, content in (('motion.csv', CSV), ('motion.mot', MOT)):
        path = written(tmp_path, name, content.encode() + b'\xff\n')
        assert Table.open(path).columns == ('a', 'b')


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    assert fault(tmp_path / 'm.csv') == 'm.csv: cannot be read: No such file or directory'


def test_a_file_that_went_away_is_named(tmp_path: Path) -> None:
    table = Table.open(written(tmp_path, 'm.csv', CSV))
    table.path.unlink()
    with pytest.raises(RecordingError, match=r'm\.csv: cannot be read: No such file or directory'):
        next(table.chunks(('a',)))


@pytest.mark.parametrize('name', ['folder', 'folder.mot'])
def test_a_folder_is_no_table(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    assert fault(tmp_path / name) == f'{name}: cannot be read: Is a directory'


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
    path = written(tmp_path, 'm.csv', CSV)
    path.chmod(0)
    with unprivileged():
        assert fault(path) == 'm.csv: cannot be read: Permission denied'


# which columns are the joints


OPENSIM = (
    '/jointset/shoulder/plane_elv/value',
    '/jointset/shoulder/plane_elv/speed',
    '/jointset/shoulder/shoulder_elv/value',
    '/jointset/shoulder/shoulder_elv/speed',
    '/jointset/acromioclavicular/axial_rot',
    '/forceset/DELT1/activation',
)


def test_a_joint_is_the_column_of_its_name() -> None:
    columns = ('axial_rot', 'other/plane_elv', 'plane_elv', 'shoulder_elv')
    assert choose(columns, JOINTS) == JOINTS
    assert choose(columns, ('plane_elv',) * 2) == ('plane_elv',) * 2
    assert choose(columns, ()) == ()


def test_a_joint_is_the_end_of_an_opensim_path() -> None:
    assert choose(OPENSIM, JOINTS) == (OPENSIM[0], OPENSIM[2], OPENSIM[4])
    assert choose(OPENSIM, ('shoulder/plane_elv', 'activation')) == (OPENSIM[0], OPENSIM[5])
    assert choose(('plane_elv/value',), ('plane_elv',)) == ('plane_elv/value',)


@pytest.mark.parametrize(
    'column', ['my_plane_elv', 'plane_elv_rad', 'plane_elv/speed', 'Plane_elv']
)
def test_a_name_that_is_only_like_it_is_not_chosen_but_offered(column: str) -> None:
    with pytest.raises(RecordingError) as caught:
        choose(('x', column), ('plane_elv',))
    hint = '' if column.endswith('speed') else f' (near: {column})'
    assert str(caught.value) == f'no column for plane_elv{hint}; the file has x, {column}'


def test_what_is_near_comes_first_even_of_a_path() -> None:
    with pytest.raises(RecordingError) as caught:
        choose(OPENSIM, ('plane_elev', 'shoulder_elv', 'axial_rotation'))
    assert str(caught.value).startswith(
        f'no column for plane_elev, axial_rotation (near: {OPENSIM[0]}, {OPENSIM[4]}'
    )


def test_of_many_columns_twelve_are_listed() -> None:
    with pytest.raises(RecordingError) as caught:
        choose([f'c\n{i}' for i in range(20)], ('plane_elv',))
    listed = ', '.join(f'c {i}' for i in range(12))
    assert str(caught.value) == f'no column for plane_elv; the file has {listed} and 8 more'


def test_of_no_columns_nothing_is_listed() -> None:
    with pytest.raises(RecordingError, match='no column for a; the file has nothing'):
        choose((), ('a',))


@pytest.mark.parametrize(
    'columns', [('a', 'a'), ('/left/a', '/right/a'), ('/left/a/value', '/right/a/value')]
)
def test_a_joint_that_may_be_two_columns_is_refused(columns: tuple[str, str]) -> None:
    with pytest.raises(RecordingError) as caught:
        choose(columns, ('a',))
    assert str(caught.value) == f'2 columns for a: {columns[0]}, {columns[1]}; one expected'


# what is made of them


def sine(frequency: float, times: Floats) -> Floats:
    """Return a sine (m, 1) of a frequency (Hz)."""
    return np.sin(2.0 * math.pi * frequency * times)[:, None]


def test_at_its_own_rate_a_motion_stays_as_it_is(shared: Path) -> None:
    table = Table.open(shared / 'recordings' / 'abduction.mot')
    times, values = whole(table, JOINTS)
    new, there = resampled(times, values, 100.0)
    np.testing.assert_allclose(new, times, rtol=0.0, atol=1e-12)  # s: rounding
    np.testing.assert_allclose(there, values, rtol=0.0, atol=1e-8)  # deg: the file's last decimal


def test_a_line_stays_a_line_at_any_rate() -> None:
    times = np.array([1.0, 1.1, 1.15, 1.4, 2.0])
    values = np.column_stack((3.0 * times, 1.0 - times))
    new, there = resampled(times, values, 8.0)
    np.testing.assert_array_equal(new, 1.0 + np.arange(9) / 8.0)
    # 1: some roundings of numbers up to 6
    np.testing.assert_allclose(there, np.column_stack((3.0 * new, 1.0 - new)), atol=1e-14)


@unhurried
@given(
    st.lists(st.floats(1e-4, 10.0), min_size=1, max_size=30),
    st.floats(-1e4, 1e4),
    st.floats(0.01, 1000.0),
)
def test_no_row_is_made_beyond_the_last_or_left_out(
    steps: list[float], begin: float, rate: float
) -> None:
    times = begin + np.concatenate(([0.0], np.cumsum(steps)))
    new, there = resampled(times, times[:, None], rate)
    assert new[0] == times[0]
    assert times[-1] - (1.0 + 1e-6) / rate - 1e-9 < new[-1] <= times[-1]  # s
    np.testing.assert_allclose(np.diff(new), 1.0 / rate, rtol=2e-6, atol=1e-11)  # s: 1e4 s + 1e-12
    assert there.shape == (len(new), 1)
    assert there.min() >= times[0]
    assert there.max() <= times[-1]


def test_at_its_own_rate_a_motion_keeps_all_its_rows_wherever_it_begins() -> None:
    for begin in range(0, 300, 7):
        for count in range(2, 120):
            times = np.array([float(f'{(begin + k) / 100.0:.6f}') for k in range(count)])  # s
            new, _ = resampled(times, np.zeros((count, 1)), 100.0)
            assert len(new) == count
            assert new[-1] <= times[-1]


def test_a_gap_stays_a_gap() -> None:
    times = np.arange(5.0)
    _, there = resampled(times, np.array([[0.0], [1.0], [math.nan], [3.0], [4.0]]), 2.0)
    assert np.isnan(there[:, 0]).tolist() == [k in (3, 4, 5) for k in range(9)]


@pytest.mark.parametrize(
    ('times', 'rate', 'reason'),
    [
        ([], 10.0, '0 rows at 10 Hz; at least 2 rows'),
        ([0.0], 10.0, '1 rows at 10 Hz; at least 2 rows'),
        ([0.0, 1.0], 0.0, 'a rate above 0 expected'),
        ([0.0, 1.0], math.nan, 'a rate above 0 expected'),
        ([0.0, 1.0], math.inf, 'a rate above 0 expected'),
        ([0.0, 0.5, 0.5, 1.0], 10.0, r'times have to increase, but 0\.5 s follows 0\.5 s'),
        ([0.0, 0.5, 0.25], 10.0, r'times have to increase, but 0\.25 s follows 0\.5 s'),
        ([0.0, math.nan, 1.0], 10.0, 'times have to increase, but nan s follows'),
    ],
)
def test_times_that_cannot_be_resampled_are_refused(
    times: list[float], rate: float, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        resampled(np.array(times), np.zeros((len(times), 2)), rate)


TIMES = np.arange(1000) / 100.0  # s
MIDDLE = slice(200, 800)  # away from the ends, where the filter has little to go by


def test_slow_motion_passes_the_filter_without_lag() -> None:
    slow = sine(1.0, TIMES)
    # 1: the gain at 1 Hz is 1 / (1 + (1/6)^4) = 0.9992
    np.testing.assert_allclose(lowpassed(slow, 100.0, 6.0)[MIDDLE], slow[MIDDLE], atol=0.01)


def test_fast_motion_does_not_pass_the_filter() -> None:
    # 1: the gain at 20 Hz is below 1 / (1 + (20/6)^4) = 0.008
    assert np.abs(lowpassed(sine(20.0, TIMES), 100.0, 6.0)[MIDDLE]).max() < 0.008


@pytest.mark.parametrize('frequency', [3.0, 6.0, 9.0, 12.0])
def test_the_filter_is_of_fourth_order_and_leaves_half_at_the_cutoff(frequency: float) -> None:
    def warped(hertz: float) -> float:  # by the bilinear transform
        return math.tan(math.pi * hertz / 100.0)

    gain = 1.0 / (1.0 + (warped(frequency) / warped(6.0)) ** 4)
    left = lowpassed(sine(frequency, TIMES), 100.0, 6.0)
    expected = gain * sine(frequency, TIMES)
    np.testing.assert_allclose(left[MIDDLE], expected[MIDDLE], atol=1e-6)  # 1: from the ends


def test_each_column_is_filtered_by_itself() -> None:
    both = np.column_stack((sine(1.0, TIMES), sine(20.0, TIMES)))
    for k, column in enumerate(lowpassed(both, 100.0, 6.0).T):
        np.testing.assert_array_equal(column, lowpassed(both[:, [k]], 100.0, 6.0)[:, 0])


def test_rest_stays_at_rest_even_in_the_fewest_rows() -> None:
    rest = np.full((10, 2), 0.7)
    np.testing.assert_allclose(lowpassed(rest, 100.0, 6.0), rest, atol=1e-12)  # rad: rounding


@pytest.mark.parametrize(
    ('rows', 'cutoff', 'reason'),
    [
        (100, 50.0, 'cutoff 50 Hz; above 0 and below 50 Hz expected'),
        (100, 60.0, 'cutoff 60 Hz; above 0 and below 50 Hz expected'),
        (100, 0.0, 'cutoff 0 Hz; above 0'),
        (100, math.nan, 'cutoff nan Hz; above 0'),
        (9, 6.0, '9 rows to filter; at least 10 expected'),
        (0, 6.0, '0 rows to filter; at least 10 expected'),
    ],
)
def test_what_cannot_be_filtered_is_refused_in_one_line(
    rows: int, cutoff: float, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason) as caught:
        lowpassed(np.zeros((rows, 2)), 100.0, cutoff)
    assert '\n' not in str(caught.value)


def test_no_filter_goes_across_a_gap() -> None:
    values = np.zeros((20, 3))
    values[4, 2] = math.nan
    with pytest.raises(ValueError, match='row 5, column 3: a gap; no filter goes across it'):
        lowpassed(values, 100.0, 6.0)


def test_without_scipy_the_filter_says_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'scipy.signal', None)
    with pytest.raises(RecordingError, match='a low-pass filter needs SciPy: pip install scipy'):
        lowpassed(np.zeros((20, 1)), 100.0, 6.0)


def test_the_derivative_of_a_parabola_is_a_line_even_at_uneven_times() -> None:
    times = np.array([0.0, 0.1, 0.3, 0.35, 0.7, 1.0])
    values = np.column_stack((times**2, 1.0 - 3.0 * times**2))
    slopes = np.column_stack((2.0 * times, -6.0 * times))
    found = differentiated(times, values)
    np.testing.assert_allclose(found[1:-1], slopes[1:-1], atol=1e-13)  # 1/s: rounding
    # of first order at the ends: the slope in the middle of the outermost step
    np.testing.assert_allclose(found[0], 0.5 * (slopes[0] + slopes[1]), atol=1e-13)
    np.testing.assert_allclose(found[-1], 0.5 * (slopes[-1] + slopes[-2]), atol=1e-13)


def test_a_single_row_does_not_move() -> None:
    np.testing.assert_array_equal(differentiated(np.zeros(1), np.ones((1, 3))), np.zeros((1, 3)))
    assert differentiated(np.zeros(0), np.ones((0, 3))).shape == (0, 3)


def test_two_rows_have_the_slope_between_them() -> None:
    found = differentiated(np.array([0.0, 0.5]), np.array([[0.0, 1.0], [1.0, 1.0]]))
    assert found.tolist() == [[2.0, 0.0]] * 2


def test_there_is_no_derivative_where_time_stands_still() -> None:
    times = np.array([0.0, 1.0, 2.0, 2.0, 3.0, 4.0])
    with np.errstate(divide='ignore', invalid='ignore'):
        found = differentiated(times, times[:, None])
    assert np.isfinite(found[:, 0]).tolist() == [True, True, False, False, True, True]
