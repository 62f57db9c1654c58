# SPDX-License-Identifier: Apache-2.0
"""Motion tables: what OpenSim and CSV files hold."""

from __future__ import annotations

import math
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_tables import CSV, JOINTS, MOT, read_all, write_table
from unhurried import unhurried

from linkedplane_ros.recordings.tables.columns import find_joint_columns
from linkedplane_ros.recordings.tables.table import Table
from linkedplane_ros.recordings.tables.times import TimeColumns


@pytest.mark.parametrize('motion', ['abduction', 'flexion'])
def test_a_mot_in_degrees_is_the_csv_in_radians(shared: Path, motion: str) -> None:
    mot = Table.from_file(shared / 'recordings' / f'{motion}.mot')
    csv = Table.from_file(shared / 'recordings' / f'{motion}.csv')
    assert (mot.time.names, csv.time.names) == (('time',), ('time_s',))
    assert len(mot.columns) == 17
    assert csv.columns == tuple(f'{joint}_rad' for joint in JOINTS)
    times, degrees = read_all(mot, find_joint_columns(mot.columns, JOINTS))
    seconds, radians = read_all(csv, csv.columns)
    np.testing.assert_array_equal(times, seconds)
    # rad: the CSV is rounded to 8 decimals
    np.testing.assert_allclose(np.radians(degrees), radians, rtol=0.0, atol=0.51e-8)


def test_a_recording_has_the_rows_that_its_header_tells_of(shared: Path) -> None:
    times, values = read_all(Table.from_file(shared / 'recordings' / 'abduction.mot'), JOINTS)
    assert times.shape == (1091,)
    assert values.shape == (1091, 3)


def test_a_long_recording_comes_in_order(shared: Path) -> None:
    table = Table.from_file(shared / 'recordings' / 'daily_motion.csv')
    times, values = read_all(table, table.columns, rows=1000)
    assert values.shape == (9800, 3)
    np.testing.assert_allclose(np.diff(times), 0.01, rtol=0.0, atol=1e-9)  # s: 100 Hz


@pytest.mark.parametrize(
    'header', ['Coordinates\nversion=1\n', '', '\nA line of prose.\n', '\ufeffinDegrees=no\n']
)
def test_an_opensim_header_ends_with_a_line_of_its_own(tmp_path: Path, header: str) -> None:
    for name in ('motion.mot', 'MOTION.STO'):
        rows = '\nTime\ta b\n 0 \t1  2\t\n0.1 3 4'
        path = write_table(tmp_path, name, f'{header}EndHeader \n{rows}')
        table = Table.from_file(path)
        head = f'{header.removeprefix(chr(0xFEFF))}EndHeader \n'.splitlines(keepends=True)
        assert table == Table(path, ('a', 'b'), TimeColumns(('Time',), (1.0,)), tuple(head))
        times, values = read_all(table, ('b', 'a'))
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
        CSV.replace('\n', '\r'),
        'sep=;\n' + CSV.replace(',', ';'),
        '"sep=,"\r\n' + CSV,
        CSV.replace(',', ';').replace('.', ','),
        CSV.replace(',', '\t').replace('.', ','),
        'time;a;b\n0;1;2\n0,1;3,000;4\n',
        CSV + ',,\n,,\n',
        b'time,a,b,elbow (\xb0)\n0,1,2,3\n0.1,3,4,5\n',
        'Time (ms),a,b\n0,1,2\n100,3,4\n',
        'timestampNs,a,b\n0,1,2\n100000000,3,4\n',
        'a,b,header.stamp.sec,header.stamp.nanosec\n1,2,0,0\n3,4,0,100000000\n',
    ],
)
def test_a_csv_may_be_written_in_any_usual_way(tmp_path: Path, content: str | bytes) -> None:
    table = Table.from_file(write_table(tmp_path, 'motion.csv', content))
    assert table.columns[:2] == ('a', 'b')
    times, values = read_all(table, ('a', 'b'))
    assert times.tolist() == [0.0, 0.1]
    assert values.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(
    'time',
    [
        'time',
        'T',
        'time_s',
        'Timestamp',
        'Time (s)',
        'Time (Seconds)',
        'time [s]',
        't(s)',
        '__time',
        'Time, s',
        'Elapsed Time (sec)',
        'time/s',
    ],
)
def test_the_time_of_a_csv_has_a_usual_name(tmp_path: Path, time: str) -> None:
    table = Table.from_file(write_table(tmp_path, 'motion.csv', f'"{time}",a,b\n0,1,2\n'))
    assert (table.time.names, table.columns) == ((time,), ('a', 'b'))


def test_of_two_times_the_plainer_name_counts(tmp_path: Path) -> None:
    table = Table.from_file(write_table(tmp_path, 'motion.csv', 'timestamp,time,a\n9,0,1\n'))
    assert (table.time.names, table.columns) == (('time',), ('timestamp', 'a'))
    times, values = read_all(table, ('timestamp',))
    assert (times.tolist(), values.tolist()) == ([0.0], [[9.0]])


@pytest.mark.parametrize(
    'gap',
    ['-nan(ind)', '1.#QNAN', '1.#IND', '-1.#IND00', 'nan(snan)', 'NA', 'N/A', 'null', '#N/A',
     '-1,#IND', 'NULL', '#DIV/0!', '+NaN'],
)  # fmt: skip
def test_a_gap_has_many_spellings(tmp_path: Path, gap: str) -> None:
    path = write_table(tmp_path, 'motion.csv', f'time;a;b\n0;{gap};1\n0.1; {gap} ;2\n')
    _, values = read_all(Table.from_file(path), ('a', 'b'))
    np.testing.assert_array_equal(values, [[math.nan, 1.0], [math.nan, 2.0]])


@pytest.mark.parametrize('word', ['inf', '-Infinity', '1.#INF', '-1.#INF00', '1e999'])
def test_what_is_infinite_is_no_gap(tmp_path: Path, word: str) -> None:
    path = write_table(tmp_path, 'motion.csv', f'time,a\n0,{word}\n')
    [[value]] = read_all(Table.from_file(path), ('a',))[1]
    assert math.isinf(value)
    assert (value < 0.0) == word.startswith('-')


@pytest.mark.parametrize(
    ('name', 'second'),
    [('time_ms', 1e3), ('Time (ms)', 1e3), ('t [us]', 1e6), ('timestamp_ns', 1e9), ('timeMs', 1e3),
     ('Time (µs)', 1e6), ('TIME_MS', 1e3), ('timems', 1e3), ('TIMEMS', 1e3), ('milliseconds', 1e3),
     ('%time', 1e9),
     ('Zeit [ms]', 1e3), ('elapsed time (milliseconds)', 1e3), ('__time_s', 1.0)],
)  # fmt: skip
def test_the_unit_in_the_name_of_the_time_is_obeyed(
    tmp_path: Path, name: str, second: float
) -> None:
    path = write_table(
        tmp_path, 'motion.csv', f'{name},a\n0,1\n{0.25 * second:.0f},2\n{second},3\n'
    )
    assert read_all(Table.from_file(path), ('a',))[0].tolist() == [
        0.0,
        (0.25 * second // 1) / second,
        1.0,
    ]


@pytest.mark.parametrize(
    ('name', 'second'),
    [
        ('frame_clock', 1.0),
        ('frame_clock_ms', 1e3),
        ('clock (ns)', 1e9),
        ('millis', 1e3),
        ('stampNs', 1e9),
    ],
)
def test_the_time_can_be_named(tmp_path: Path, name: str, second: float) -> None:
    path = write_table(tmp_path, 'motion.csv', f'time,{name},a\n7,0,1\n8,{second},2\n')
    table = Table.from_file(path, name)
    assert table.columns == ('time', 'a')
    assert read_all(table, ('a',))[0].tolist() == [0.0, 1.0]


def test_a_gap_is_nan(tmp_path: Path) -> None:
    path = write_table(tmp_path, 'motion.csv', 'time,a,b\n0,,NaN\n0.1, ,4\n0.2,nan,\n')
    _, values = read_all(Table.from_file(path), ('a', 'b'))
    np.testing.assert_array_equal(values, [[math.nan, math.nan], [math.nan, 4.0], [math.nan] * 2])
    path = write_table(tmp_path, 'motion.sto', MOT.replace('3', 'nan'))
    np.testing.assert_array_equal(read_all(Table.from_file(path), ('a',))[1], [[1.0], [math.nan]])


def test_columns_that_nobody_asks_for_may_hold_anything(tmp_path: Path) -> None:
    path = write_table(tmp_path, 'motion.csv', 'time,note,a,note,\n0,gähn,1,,x\n0.1,"1_0",2,5,\n')
    table = Table.from_file(path)
    assert table.columns == ('note', 'a', 'note', '')
    assert read_all(table, ('a',))[1].tolist() == [[1.0], [2.0]]


def test_the_times_can_be_had_alone(tmp_path: Path) -> None:
    times, values = read_all(Table.from_file(write_table(tmp_path, 'motion.csv', CSV)), ())
    assert (times.tolist(), values.shape) == ([0.0, 0.1], (2, 0))


@pytest.mark.parametrize('name', ['motion.csv', 'motion.mot'])
@pytest.mark.parametrize('rows', [1, 3, 6, 7, 8, 10**9])
def test_where_chunks_end_does_not_matter(tmp_path: Path, name: str, rows: int) -> None:
    numbers = np.random.default_rng(1).normal(size=(7, 3))
    text = '\n'.join(','.join(map(repr, row)) for row in numbers.tolist())
    content = f'time,a,b\n{text}\n'
    if name.endswith('.mot'):
        content = 'endheader\n' + content.replace(',', '\t')
    chunks = list(Table.from_file(write_table(tmp_path, name, content)).chunks(('b', 'a'), rows))
    assert [len(times) for times, _, _ in chunks[:-1]] == [rows] * (len(chunks) - 1)
    assert 0 < len(chunks[-1][0]) <= rows
    np.testing.assert_array_equal(np.concatenate([times for times, _, _ in chunks]), numbers[:, 0])
    np.testing.assert_array_equal(
        np.concatenate([values for _, values, _ in chunks]), numbers[:, [2, 1]]
    )


def test_a_chunk_has_at_least_a_row(tmp_path: Path) -> None:
    table = Table.from_file(write_table(tmp_path, 'motion.csv', CSV))
    with pytest.raises(ValueError, match='chunks of 0 rows; at least 1 expected'):
        next(table.chunks(('a',), 0))


def test_a_long_file_takes_no_more_memory_than_a_short_one(tmp_path: Path) -> None:
    def peak(count: int) -> int:
        text = 'time,a\n' + ''.join(f'{i},{i}.5\n' for i in range(count))
        table = Table.from_file(write_table(tmp_path, 'motion.csv', text))
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
    times, values = read_all(Table.from_file(path), ('a', 'b'), rows)
    np.testing.assert_array_equal(times, [row[0] for row in numbers])
    np.testing.assert_array_equal(values, [row[1:] for row in numbers])
    if delimiter == '\t':
        path = path.with_suffix('.sto')
        path.write_bytes(''.join(line + end for line in ['endheader', *lines]).encode())
        for one, other in zip(
            read_all(Table.from_file(path), ('a', 'b'), rows), (times, values), strict=True
        ):
            np.testing.assert_array_equal(one, other)
