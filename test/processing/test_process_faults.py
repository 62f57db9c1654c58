# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a recording is said in a line; what was good is done."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from bags import (
    MCAP,
    SQLITE3,
    exit_status,
    joint_state,
    odd_motion,
    read_csv,
    read_messages,
    refusal_line,
    text_note,
    write_bag,
)
from optional import requires
from rosbags.rosbag2 import StoragePlugin

from linkedplane_ros.processing.task import Task, run_task


def truncated(tmp_path: Path) -> Path:
    """Return a bag whose file ends early."""
    bag = write_bag(tmp_path / 'short', [joint_state(k) for k in range(4000)])
    data = (bag / 'short.mcap').read_bytes()
    (bag / 'short.mcap').write_bytes(data[: len(data) // 2])
    return bag


def faulty(tmp_path: Path) -> dict[str, tuple[Path, str]]:
    """Return inputs that are no good, and a word of the line that says why."""
    (tmp_path / 'empty.csv').touch()
    (tmp_path / 'columns.csv').write_text('time,flex,abduction,rotation\n0,0.1,0.2,0.3\n')
    (tmp_path / 'cell.csv').write_text('time,flexion,abduction,rotation\n0,0.1,x,0.3\n')
    (tmp_path / 'all_bad.csv').write_text('time,flexion,abduction,rotation\n0,90,20,30\n')
    return {
        'truncated bag': (truncated(tmp_path), 'short'),
        'no joint states': (
            write_bag(tmp_path / 'notes', [text_note(k) for k in range(3)]),
            'std_msgs',
        ),
        'empty file': (tmp_path / 'empty.csv', 'empty.csv'),
        'missing column': (tmp_path / 'columns.csv', 'no column for flexion (near: flex)'),
        'no number': (tmp_path / 'cell.csv', 'cell.csv:2'),
        'nothing usable': (tmp_path / 'all_bad.csv', 'degrees?'),
        'missing file': (tmp_path / 'nowhere.mot', 'nowhere.mot'),
    }


@pytest.mark.parametrize('kind', ['csv', pytest.param('parquet', marks=requires('pyarrow')), 'bag'])
def test_a_faulty_input_is_one_line_and_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    (tmp_path / 'out').mkdir()
    for source, word in faulty(tmp_path).values():
        line = refusal_line(capsys, str(source), str(tmp_path / 'out' / 'x'), '--format', kind)
        assert word in line
        assert str(source) in line
        assert list((tmp_path / 'out').iterdir()) == []


def test_the_other_recordings_are_still_done(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / 'lab'
    folder.mkdir()
    for _, (source, _) in faulty(tmp_path).items():
        if source.exists():
            shutil.move(source, folder / source.name)
    good = write_bag(folder / 'good', [joint_state(k) for k in range(9)])
    assert exit_status([str(folder), str(tmp_path / 'out'), '--format', 'csv']) == 1
    told = capsys.readouterr()
    assert sorted(each.name for each in (tmp_path / 'out').iterdir()) == ['good.csv']
    assert told.err.count('\n') == len(list(folder.iterdir())) - 1
    assert f'{good} -> ' in told.out
    assert '1 of 7 recordings processed' in told.out


def test_refused_frames_are_counted_with_their_first_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = odd_motion()
    sent[8] = joint_state(4, position=[0.1, 90.0, 0.2])
    source = write_bag(tmp_path / 'in', sent)
    assert exit_status([str(source), str(tmp_path / 'out.csv'), '--radians']) == 0
    told = capsys.readouterr().out
    assert '36 frames' in told
    assert '3 refused' in told
    assert '1 message of other joints passed over, first at message 6' in told
    assert "1 refused as degrees, first at message 5, 0.04 s: joint 'abduction' is 90" in told


def test_a_message_with_one_of_the_joints_twice_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = odd_motion()
    names = ('flexion', 'abduction', 'rotation', 'flexion')
    sent[8] = joint_state(4, names, position=[0.1, 0.2, 0.3, 0.4])
    source = write_bag(tmp_path / 'in', sent)
    assert exit_status([str(source), str(tmp_path / 'out.csv'), '--radians']) == 0
    told = capsys.readouterr().out
    assert "refused as duplicate, first at message 5, 0.04 s: joint 'flexion' is in it 2" in told


def test_frames_outside_the_models_range_are_counted(tmp_path: Path) -> None:
    inside, outside = (0.5, 0.4, 0.2), (-1.0, 0.2, 0.1)
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{k},{",".join(map(str, outside if k < 3 else inside))}' for k in range(10)]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    assert run_task(Task(tmp_path / 'in.csv', tmp_path / 'out.csv')).outside == 3


@requires('resource')
@pytest.mark.parametrize('storage', [MCAP, SQLITE3])
@pytest.mark.parametrize(
    'name', ['out', 'out.csv', pytest.param('out.parquet', marks=requires('pyarrow'))]
)
def test_a_full_disk_is_one_line(
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    name: str,
    storage: StoragePlugin,
) -> None:
    source = write_bag(tmp_path / 'in', [joint_state(k % 100) for k in range(2000)], storage)
    # kernels that cannot be kept would be a second line: here they are, before the disk is full
    assert run_task(Task(source, tmp_path_factory.mktemp('before') / name)).fault == ''
    code = (
        'import resource, signal, sys; from linkedplane_ros.commands.main import main\n'
        'signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n'
        'resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n'
        f'sys.exit(main(["process", {str(source)!r}, {str(tmp_path / name)!r}]))'
    )
    ended = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert ended.returncode == 1
    assert ended.stderr.count('\n') == 1, ended.stderr
    assert f'{name}: cannot be written: ' in ended.stderr
    assert [each.name for each in tmp_path.iterdir()] == ['in']


def test_a_bags_file_alone_becomes_an_annotated_bag(tmp_path: Path) -> None:
    sent = odd_motion()
    source = write_bag(tmp_path / 'in', sent) / 'in.mcap'
    assert run_task(Task(source, tmp_path / 'out')).fault == ''
    found = read_messages(tmp_path / 'out')
    assert [each for each in found if each[0] in ('/joint_states', '/notes')] == sent


def test_times_before_zero_keep_their_values(tmp_path: Path) -> None:
    lines = ['time,flexion,abduction,rotation', *(f'{t},0.1,0.2,0.3' for t in (-1.5, -0.4, 0.25))]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    run_task(Task(tmp_path / 'in.csv', tmp_path / 'out.csv'))
    assert read_csv(tmp_path / 'out.csv')[2][:, 0].tolist() == [-1.5, -0.4, 0.25]


def test_times_that_cannot_be_seconds_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('timestamp,flexion,abduction,rotation\n1700000000000,0.1,0.2,0.3\n')
    assert 'ms?' in refusal_line(capsys, str(source), str(tmp_path / 'out.csv'))


def test_a_bag_is_not_processed_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'once')]) == 0
    assert 'in it already' in refusal_line(capsys, str(tmp_path / 'once'), str(tmp_path / 'twice'))


def test_what_cannot_be_used_does_not_keep_the_others_from_being_done(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = write_bag(tmp_path / 'good', odd_motion())
    (tmp_path / 'empty').mkdir()
    out = tmp_path / 'out'
    named = [str(good), str(tmp_path / 'empty'), str(tmp_path / 'no*thing'), str(good) + '/*.mcap']
    assert exit_status([*named, str(out)]) == 1
    error = capsys.readouterr().err
    assert error.splitlines() == [
        f'linkedplane: {tmp_path / "empty"}: no recordings in it '
        '(bags, .mot, .sto, .csv, .tsv, .mcap, .db3)',
        f'linkedplane: {tmp_path / "no*thing"}: nothing matches',
        f'linkedplane: {good / "good.mcap"}: would become {out / "good"}, as {good} does; '
        'process them into folders of their own',
    ]
    assert [each.name for each in out.iterdir()] == ['good']


def test_a_bag_has_no_times_before_zero(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('time,flexion,abduction,rotation\n-1.5,0.1,0.2,0.3\n')
    line = refusal_line(capsys, str(source), str(tmp_path / 'out'))
    assert 'time -1.5 s: a bag has none before 0 s' in line
