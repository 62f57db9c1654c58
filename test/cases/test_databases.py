# SPDX-License-Identifier: Apache-2.0
"""Databases of sqlite3: what stands beside them, what older ROS distributions wrote, odd rows.

Python's sqlite3 writes the databases, and judges how many messages they hold.
"""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from bags import SQLITE3, count_frames, exit_status, joint_state, refusal_line, text_note, write_bag

from linkedplane_ros.processing.reading import read_processed


def count_rows(path: Path) -> int:
    """Return how many messages sqlite3 finds in a database."""
    with closing(sqlite3.connect(path)) as database:
        [(count,)] = database.execute('SELECT COUNT(*) FROM messages')
    return int(count)


def unfinished(tmp_path: Path, journal: str) -> Path:
    """Return a database as a killed recorder leaves it: 10 messages in it, 10 in what is beside."""
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)], SQLITE3)
    path = bag / 'bag.db3'
    database = sqlite3.connect(path, isolation_level=None)
    database.execute(f'PRAGMA journal_mode={journal}')
    database.execute('PRAGMA wal_autocheckpoint=0')
    database.execute('PRAGMA cache_size=1')  # written to the file before the end
    rows = [(1, joint_state(k)[2], joint_state(k)[3]) for k in range(10, 20)]
    database.execute('BEGIN')
    database.executemany('INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)', rows)
    if journal == 'wal':
        database.execute('COMMIT')
    else:
        database.executemany(
            'INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, zeroblob(9000))',
            [(1, 10**19 // 2)] * 9,
        )
    copy = tmp_path / 'copy'
    copy.mkdir()
    for each in bag.iterdir():
        if each.name.startswith('bag.db3') and not each.name.endswith('-shm'):
            shutil.copyfile(each, copy / each.name)
    database.close()
    return copy / 'bag.db3'


@pytest.mark.parametrize(
    ('journal', 'ending', 'count'), [('wal', '-wal', 20), ('delete', '-journal', 10)]
)
def test_what_a_killed_recorder_left_beside_a_database_is_read(
    tmp_path: Path, journal: str, ending: str, count: int
) -> None:
    path = unfinished(tmp_path, journal)
    beside = path.with_name(path.name + ending)
    assert beside.stat().st_size
    before = {each.name: each.read_bytes() for each in path.parent.iterdir()}
    assert count_frames(path, tmp_path / 'out.csv') == count
    assert {each.name: each.read_bytes() for each in path.parent.iterdir()} == before
    # sqlite3 itself, which brings the database to an end
    held = count_rows(path)
    assert held == count


def test_the_case_of_a_wal(tmp_path: Path, cases: Path) -> None:
    assert count_frames(cases / 'bag_wal' / 'run_0.db3', tmp_path / 'out.csv') == 20


def read_rows(path: Path) -> list[tuple[Any, ...]]:
    """Return the messages of a database, with their topics, by sqlite3."""
    with closing(sqlite3.connect(path)) as database:
        rows = database.execute(
            'SELECT name, type, serialization_format, timestamp, data FROM messages '
            'JOIN topics ON topics.id = topic_id ORDER BY timestamp, messages.id'
        ).fetchall()
    return [row for row in rows if not row[0].startswith('/deltoid')]


@pytest.mark.parametrize('case', ['run', 'silent'])
def test_the_case_of_a_type_without_definition_in_a_database_of_humble(
    tmp_path: Path, cases: Path, case: str
) -> None:
    source = cases / 'bag_custom_type_humble' / case
    assert exit_status([str(source), str(tmp_path / 'out')]) == 0
    [file] = source.glob('*.db3')
    rows = read_rows(file)
    assert rows
    assert read_rows(tmp_path / 'out' / 'out.db3') == rows


@pytest.mark.parametrize('fault', ['flip', 'cut', 'rollback'])
def test_what_sqlite_does_not_take_of_a_wal_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], fault: str
) -> None:
    path = unfinished(tmp_path, 'wal')
    wal = path.with_name(path.name + '-wal')
    data = bytearray(wal.read_bytes())
    if fault == 'flip':
        data[-9] ^= 1
    elif fault == 'cut':
        del data[-4000:]
    else:  # the end of a transaction is the size of the database in the head of its last page
        data[-4096 - 24 + 4 : -4096 - 24 + 8] = bytes(4)
    wal.write_bytes(data)
    # sqlite3 judges: none of the transaction is there
    copy = shutil.copytree(path.parent, tmp_path / 'judged')
    held = count_rows(copy / path.name)
    assert count_frames(path, tmp_path / 'out.csv') == held == 10
    assert 'bag.db3-wal: ' in (told := capsys.readouterr().err)
    assert 'pages are damaged or were not committed; messages in them are lost' in told


def test_times_before_zero_are_carried_over(tmp_path: Path) -> None:
    sent = [each for k in range(10) for each in (joint_state(k), text_note(k))]
    bag = write_bag(tmp_path / 'bag', sent, SQLITE3)
    with sqlite3.connect(bag / 'bag.db3') as database:
        database.execute('UPDATE messages SET timestamp = -5 WHERE id = 4')
    database.close()
    assert exit_status([str(bag), str(tmp_path / 'out')]) == 0
    rows = read_rows(bag / 'bag.db3')
    assert rows[0][3] == -5
    assert read_rows(tmp_path / 'out' / 'out.db3') == rows


@pytest.mark.parametrize('change', ["timestamp = 'x'", 'timestamp = 1.5', "data = 'text'"])
def test_a_message_that_is_no_message_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: str
) -> None:
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)], SQLITE3)
    with sqlite3.connect(bag / 'bag.db3') as database:
        database.execute(f'UPDATE messages SET {change} WHERE id = 4')
    database.close()
    line = refusal_line(capsys, str(bag), str(tmp_path / 'out'))
    assert 'bag.db3: ' in line
    assert 'Error' not in line


OLDER = {  # what databases of ROS distributions before Jazzy have not
    'iron': ['DELETE FROM message_definitions'],
    'humble': [
        'DROP TABLE message_definitions',
        'UPDATE schema SET schema_version = 3',
        'ALTER TABLE topics DROP COLUMN type_description_hash',
    ],
    'galactic': ['DROP TABLE schema', 'DROP TABLE metadata'],
    'dashing': ['ALTER TABLE topics DROP COLUMN offered_qos_profiles'],
}


@pytest.mark.parametrize('oldest', OLDER)
def test_databases_of_older_distributions_are_carried_over(tmp_path: Path, oldest: str) -> None:
    sent = [each for k in range(10) for each in (joint_state(k), text_note(k))]
    bag = write_bag(tmp_path / 'bag', sent, SQLITE3)
    database = sqlite3.connect(bag / 'bag.db3')
    database.execute("UPDATE topics SET type = 'my_msgs/msg/Own' WHERE name = '/notes'")
    for name, changes in OLDER.items():
        for change in changes:
            database.execute(change)
        if name == oldest:
            break
    database.commit()
    database.close()
    assert exit_status([str(bag), str(tmp_path / 'out')]) == 0
    rows = read_rows(bag / 'bag.db3')
    assert len(rows) == 20
    assert read_rows(tmp_path / 'out' / 'out.db3') == rows
    assert len(read_processed(tmp_path / 'out').times) == 10
