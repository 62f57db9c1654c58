# SPDX-License-Identifier: Apache-2.0
"""What cannot be played is refused in one line that says why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from played_bags import Player, joint_states, notes, write_bag

from linkedplane_ros.commands.main import main
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.recordings.bags.recording import Recording


def nothing(path: Path) -> Path:
    return path


def a_text(path: Path) -> Path:
    path.write_text('not a bag at all')
    return path


def an_empty_file(path: Path) -> Path:
    path.touch()
    return path


def an_empty_folder(path: Path) -> Path:
    path.mkdir()
    return path


def a_folder_of_rubbish(path: Path) -> Path:
    path.mkdir()
    (path / 'metadata.yaml').write_text('rosbag2_bagfile_information: [1, 2]')
    return path


def a_bag_without_its_file(path: Path) -> Path:
    write_bag(path, joint_states())
    next(path.glob('*.mcap')).unlink()
    return path


def of_other_things(path: Path) -> Path:
    return write_bag(path, notes())


def of_nothing(path: Path) -> Path:
    return write_bag(path, [])


def cut_short(path: Path) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])


def a_truncated_mcap(path: Path) -> Path:
    write_bag(path, joint_states(count=2000))
    cut_short(next(path.glob('*.mcap')))
    return path


def a_truncated_mcap_alone(path: Path) -> Path:
    return next(a_truncated_mcap(path).glob('*.mcap'))


def a_truncated_sqlite3(path: Path) -> Path:
    write_bag(path, joint_states(count=2000), 'sqlite3')
    cut_short(next(path.glob('*.db3')))
    return path


def a_sqlite3_with_a_hole(path: Path) -> Path:
    write_bag(path, joint_states(count=2000), 'sqlite3')
    make_a_hole(next(path.glob('*.db3')))
    return path


def an_mcap_with_a_hole(path: Path) -> Path:
    write_bag(path, joint_states(count=2000))
    make_a_hole(next(path.glob('*.mcap')))
    return path


def make_a_hole(path: Path) -> None:
    content = bytearray(path.read_bytes())
    third = len(content) // 3
    content[third : 2 * third] = b'\xff' * third
    path.write_bytes(content)


FAULTY = [
    (nothing, 'bag', 'no such file or folder'),
    (nothing, 'bag.mcap', 'no such file or folder'),
    (a_text, 'notes.txt', 'text by its ending; if it is a table'),
    (a_text, 'notes.mcap', 'not a readable rosbag2'),
    (a_text, 'notes.db3', 'not a readable rosbag2'),
    (a_text, 'old.bag', 'a ROS 1 bag; convert it with rosbags-convert first'),
    (an_empty_file, 'empty.mcap', 'the file is empty '),
    (an_empty_file, 'empty.db3', 'the file is empty '),
    (an_empty_folder, 'empty', 'no metadata.yaml in it'),
    (a_folder_of_rubbish, 'rubbish', 'metadata.yaml: not the metadata of a rosbag2'),
    (a_bag_without_its_file, 'bag', 'bag.mcap is listed in metadata.yaml and not there'),
    (of_other_things, 'bag', 'no sensor_msgs/msg/JointState in it, but std_msgs/msg/String'),
    (of_nothing, 'bag', 'no sensor_msgs/msg/JointState in it, but nothing'),
    (a_truncated_mcap, 'bag', 'no message before is whole'),
    (
        a_truncated_mcap_alone,
        'bag',
        'no message before is whole',
    ),
    (a_truncated_sqlite3, 'bag', 'the file is cut short'),
]


@pytest.mark.parametrize(
    ('make', 'name', 'reason'), FAULTY, ids=[f'{make.__name__}-{name}' for make, name, _ in FAULTY]
)
def test_what_is_no_recording_of_joint_states_is_refused_in_one_line(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    make: Callable[[Path], Path],
    name: str,
    reason: str,
) -> None:
    path = make(tmp_path / name)
    with pytest.raises(RecordingError, match=reason):
        Recording.from_bag(path)
    assert main(['play', str(path)]) == 1
    out, err = capsys.readouterr()
    assert out == ''
    assert err.count('\n') == 1
    assert err.startswith(f'linkedplane: {path}')
    assert reason in err


@pytest.mark.parametrize('make', [a_sqlite3_with_a_hole, an_mcap_with_a_hole])
def test_damage_that_is_met_on_the_way_ends_it_in_one_line(
    ros: None, tmp_path: Path, make: Callable[[Path], Path]
) -> None:
    path = make(tmp_path / 'bag')
    status, out, err = Player(path, '--wait', 0, '--rate', 1000).result()
    lines = [line for line in err.splitlines() if 'no subscriber after' not in line]
    assert status == 1
    assert len(lines) == 1, err
    assert lines[0].startswith(f'linkedplane: {path}')
    assert 'published' not in out


def test_a_start_offset_beyond_the_end_is_refused_in_one_line(tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', joint_states())
    status, out, err = Player(path, '--start-offset', 1.5).result()
    assert (status, out) == (1, '')
    assert err == 'linkedplane: --start-offset: 1.5 s given, the recording lasts 1.0 s\n'
