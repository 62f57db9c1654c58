# SPDX-License-Identifier: Apache-2.0
"""Messages that a bag should have and has not are counted, by reason and with a place, or refused.

Python's sqlite3 writes the databases, and judges how many messages they hold.
"""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import yaml
from bags import (
    MCAP,
    SQLITE3,
    count_frames,
    exit_status,
    joint_state,
    read_csv,
    refusal_line,
    text_note,
    write_bag,
)

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.recordings.bags.opening import open_bag

HEAD = 'rosbag2_bagfile_information'


def change_metadata(bag: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """Change what a bag's metadata.yaml says; return the bag."""
    path = bag / 'metadata.yaml'
    content = yaml.safe_load(path.read_text())
    change(content[HEAD])
    path.write_text(yaml.safe_dump(content))
    return bag


@pytest.mark.parametrize('storage', [MCAP, SQLITE3])
def test_messages_that_metadata_counts_and_no_file_has_are_refused_frames(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], storage: Any
) -> None:
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)], storage)

    def count_more(content: dict[str, Any]) -> None:
        content['topics_with_message_count'][0]['message_count'] = 12

    change_metadata(bag, count_more)
    assert count_frames(bag, tmp_path / 'out.csv') == 10
    assert (
        '  2 refused as missing, first at /joint_states: metadata.yaml counts 12, 10 are there\n'
    ) in capsys.readouterr().out


def test_messages_of_other_topics_that_are_missing_are_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = [each for k in range(10) for each in (joint_state(k), text_note(k))]
    bag = write_bag(tmp_path / 'bag', sent, SQLITE3)
    database = sqlite3.connect(bag / 'bag.db3')
    database.execute('DELETE FROM messages WHERE topic_id = 2 AND id > 15')
    database.commit()
    database.close()
    assert count_frames(bag, tmp_path / 'out.csv') == 10
    told = capsys.readouterr().out
    assert 'messages not read: 3: /notes: metadata.yaml counts 10, 7 are there\n' in told
    assert 'refused' not in told


def test_messages_that_metadata_does_not_count_are_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)], SQLITE3)

    def count_less(content: dict[str, Any]) -> None:
        content['topics_with_message_count'][0]['message_count'] = 6

    change_metadata(bag, count_less)
    assert count_frames(bag, tmp_path / 'out.csv') == 10
    assert 'metadata.yaml counts 6 on /joint_states, 10 are there: all are read\n' in (
        capsys.readouterr().out
    )


def test_messages_of_no_topic_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)], SQLITE3)
    database = sqlite3.connect(bag / 'bag.db3')
    database.execute('UPDATE messages SET topic_id = 9 WHERE id > 6')
    database.commit()
    database.close()
    assert count_frames(bag / 'bag.db3', tmp_path / 'out.csv') == 6
    assert 'messages not read: 4: topic 9, which bag.db3 does not define' in capsys.readouterr().out


def split(tmp_path: Path, storage: Any, ending: str) -> Path:
    """Return a bag of two files, 10 messages each."""
    parts = [
        write_bag(
            tmp_path / f'part_{n}', [joint_state(k) for k in range(10 * n, 10 * n + 10)], storage
        )
        for n in range(2)
    ]
    shutil.move(parts[1] / f'part_1{ending}', parts[0])

    def join(content: dict[str, Any]) -> None:
        content['relative_file_paths'].append(f'part_1{ending}')
        content['topics_with_message_count'][0]['message_count'] = 20

    return change_metadata(parts[0], join)


@pytest.mark.parametrize(('storage', 'ending'), [(MCAP, '.mcap'), (SQLITE3, '.db3')])
def test_a_split_bag_with_a_file_missing_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], storage: Any, ending: str
) -> None:
    bag = split(tmp_path, storage, ending)
    assert count_frames(bag, tmp_path / 'out.csv') == 20
    capsys.readouterr()
    (bag / f'part_1{ending}').unlink()
    line = refusal_line(capsys, str(bag), str(tmp_path / 'lost.csv'))
    assert f'part_1{ending} is listed in metadata.yaml and not there' in line


@pytest.mark.parametrize(('storage', 'ending'), [(MCAP, '.mcap'), (SQLITE3, '.db3')])
def test_a_file_that_metadata_does_not_list_is_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], storage: Any, ending: str
) -> None:
    bag = split(tmp_path, storage, ending)

    def forget(content: dict[str, Any]) -> None:
        content['relative_file_paths'].pop()
        content['topics_with_message_count'][0]['message_count'] = 10

    change_metadata(bag, forget)
    assert count_frames(bag, tmp_path / 'out.csv') == 10
    assert (
        f'  10 refused as unlisted, first at part_1{ending}, which metadata.yaml does not list\n'
    ) in capsys.readouterr().out


@pytest.mark.parametrize(('storage', 'ending'), [(MCAP, '.mcap'), (SQLITE3, '.db3')])
@pytest.mark.parametrize(('counted', 'missing'), [(20, 0), (23, 3), (15, 0)])
def test_a_message_in_a_file_that_is_not_listed_is_not_missing(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    storage: Any,
    ending: str,
    counted: int,
    missing: int,
) -> None:
    bag = split(tmp_path, storage, ending)

    def forget(content: dict[str, Any]) -> None:
        content['relative_file_paths'].pop()
        content['topics_with_message_count'][0]['message_count'] = counted

    change_metadata(bag, forget)
    status = exit_status([str(bag), str(tmp_path / 'out.csv')])
    assert status == int(10 + missing > 10)  # refused, of 10 that were read
    said = capsys.readouterr().out
    assert '  10 refused as unlisted, first at part_1' in said
    lines = [line.split(', first at ')[1] for line in said.splitlines() if 'missing' in line]
    counts = f'/joint_states: metadata.yaml counts {counted}, 20 are there'
    assert lines == [counts] * bool(missing)


@pytest.mark.parametrize('named', ['bag', 'b*', 'bag/*'])
@pytest.mark.parametrize('storage', [MCAP, SQLITE3])
def test_a_folder_of_one_file_without_metadata_becomes_one_table(
    tmp_path: Path, storage: Any, named: str
) -> None:
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)], storage)
    (bag / 'metadata.yaml').unlink()
    assert exit_status([str(tmp_path / named), str(tmp_path / 'o.csv')]) == 0
    assert len(read_csv(tmp_path / 'o.csv')[2]) == 10
    assert exit_status([str(tmp_path / named), str(tmp_path / 'out')]) == 0
    [made] = (tmp_path / 'out').iterdir()  # a folder of outputs
    assert made.name == 'bag'
    [file] = bag.iterdir()
    with pytest.raises(RecordingError) as caught:  # where a folder has to be a bag
        open_bag(bag)
    assert str(caught.value) == f'{bag}: no metadata.yaml in it; name {file}'
    shutil.copyfile(file, file.with_name('second' + file.suffix))
    assert exit_status([str(tmp_path / named), str(tmp_path / 'p.csv')]) == 1


@pytest.mark.parametrize('name', ['a.mcap', 'a.db3', 'A.MCAP'])
@pytest.mark.parametrize('inside', [False, True])
def test_an_empty_file_is_called_empty(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, inside: bool
) -> None:
    path = source = tmp_path / name
    if inside:
        source = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)])
        path = source / name
    path.touch()
    line = refusal_line(capsys, str(source), str(tmp_path / 'o.csv'))
    assert line == f'linkedplane: {path}: the file is empty (0 bytes); a recording expected\n'


def set_version(version: int, path: str) -> Callable[[dict[str, Any]], None]:
    """Return what makes a metadata.yaml an older one, with a path in its style."""

    def change(content: dict[str, Any]) -> None:
        content |= {'version': version, 'relative_file_paths': [path]}
        newer = {3: ['compression_format', 'compression_mode'], 5: ['files']}
        newer |= {6: ['custom_data'], 8: ['ros_distro']}
        for since, keys in newer.items():
            for key in keys if version < since else ():
                content.pop(key)
        for each in content['topics_with_message_count']:
            facts = each['topic_metadata']
            if version < 9:
                facts['offered_qos_profiles'] = ''
            if version < 7:
                facts.pop('type_description_hash')
            if version < 4:
                facts.pop('offered_qos_profiles')

    return change


@pytest.mark.parametrize('version', range(1, 10))
@pytest.mark.parametrize('style', ['relative', 'below', 'absolute', 'moved'])
def test_every_version_of_metadata_is_read(tmp_path: Path, version: int, style: str) -> None:
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)])
    path = {
        'relative': 'bag/bag.mcap' if version < 4 else 'bag.mcap',
        'below': 'bag/parts/bag.mcap' if version < 4 else 'parts/bag.mcap',
        'absolute': str(bag / 'bag.mcap'),
        'moved': '/home/somebody/bag/bag.mcap',
    }[style]
    if style == 'below':
        (bag / 'parts').mkdir()
        (bag / 'bag.mcap').rename(bag / 'parts' / 'bag.mcap')
    with_version = change_metadata(bag, set_version(version, path))
    with closing(open_bag(with_version)) as opened:
        assert sum(1 for _ in opened.messages()) == 10
        assert list(opened.losses()) == []


@pytest.mark.parametrize('storage', [MCAP, SQLITE3])
@pytest.mark.parametrize('identifier', ['', 'own_plugin', None])
def test_a_file_is_known_by_its_content(
    tmp_path: Path, storage: Any, identifier: str | None
) -> None:
    bag = write_bag(tmp_path / 'bag', [joint_state(k) for k in range(10)], storage)
    change_metadata(bag, lambda content: content.update(storage_identifier=identifier))
    assert count_frames(bag, tmp_path / 'out.csv') == 10


def test_the_case_of_an_empty_storage_identifier(tmp_path: Path, cases: Path) -> None:
    assert count_frames(cases / 'bag_empty_storage_id' / 'bag', tmp_path / 'out.csv') == 10
