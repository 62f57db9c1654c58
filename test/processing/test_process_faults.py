"""What is wrong with a recording is said in a line; what was good is done."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from bags import (
    BAG,
    MCAP,
    SQLITE3,
    contents,
    exit_status,
    joint_state,
    note,
    odd_motion,
    refused,
    rows,
    write,
)
from rosbags.rosbag2 import StoragePlugin

from linkedplane_ros.processing.inputs import recordings
from linkedplane_ros.processing.task import Task, run


def test_an_output_that_exists_is_left_alone_without_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / 'out.csv'
    out.write_text('precious')
    assert '--force' in refused(capsys, str(BAG), str(out))
    assert out.read_text() == 'precious'
    assert exit_status([str(BAG), str(out), '--force']) == 0
    assert out.read_text() != 'precious'


def truncated(tmp_path: Path) -> Path:
    """Return a bag whose file ends early."""
    bag = write(tmp_path / 'short', [joint_state(k) for k in range(4000)])
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
        'no joint states': (write(tmp_path / 'notes', [note(k) for k in range(3)]), 'std_msgs'),
        'empty file': (tmp_path / 'empty.csv', 'empty.csv'),
        'missing column': (tmp_path / 'columns.csv', 'no column for flexion (near: flex)'),
        'no number': (tmp_path / 'cell.csv', 'cell.csv:2'),
        'nothing usable': (tmp_path / 'all_bad.csv', 'degrees?'),
        'missing file': (tmp_path / 'nowhere.mot', 'nowhere.mot'),
    }


@pytest.mark.parametrize('kind', ['csv', 'parquet', 'bag'])
def test_a_faulty_input_is_one_line_and_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    (tmp_path / 'out').mkdir()
    for source, word in faulty(tmp_path).values():
        line = refused(capsys, str(source), str(tmp_path / 'out' / 'x'), '--format', kind)
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
    good = write(folder / 'good', [joint_state(k) for k in range(9)])
    assert exit_status([str(folder), str(tmp_path / 'out'), '--format', 'csv']) == 1
    told = capsys.readouterr()
    assert sorted(each.name for each in (tmp_path / 'out').iterdir()) == ['good.csv']
    assert told.err.count('\n') == len(list(folder.iterdir())) - 1
    assert f'{good} -> ' in told.out
    assert '1 of 7 recordings processed' in told.out


def test_refused_frames_are_counted_with_their_first_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'out.csv')]) == 0
    told = capsys.readouterr().out
    assert '36 frames' in told
    assert '4 refused' in told
    assert "1 refused as degrees, first at message 5, 0.04 s: joint 'abduction' is 90" in told


def test_frames_outside_the_models_range_are_counted(tmp_path: Path) -> None:
    inside, outside = (0.5, 0.4, 0.2), (-1.0, 0.2, 0.1)
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{k},{",".join(map(str, outside if k < 3 else inside))}' for k in range(10)]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    assert run(Task(tmp_path / 'in.csv', tmp_path / 'out.csv')).outside == 3


@pytest.mark.parametrize('storage', [MCAP, SQLITE3])
@pytest.mark.parametrize('name', ['out', 'out.csv', 'out.parquet'])
def test_a_full_disk_is_one_line(tmp_path: Path, name: str, storage: StoragePlugin) -> None:
    pytest.importorskip('resource')
    source = write(tmp_path / 'in', [joint_state(k % 100) for k in range(2000)], storage)
    code = (
        'import resource, signal, sys; from linkedplane_ros.commands.main import main\n'
        'signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n'
        'resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n'
        f'sys.exit(main(["process", {str(source)!r}, {str(tmp_path / name)!r}]))'
    )
    ended = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert ended.returncode == 1
    assert ended.stderr.count('\n') == 1, ended.stderr
    assert f'{name}: not written: ' in ended.stderr
    assert [each.name for each in tmp_path.iterdir()] == ['in']


def test_a_recording_is_not_its_own_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('time,flexion,abduction,rotation\n0,0.1,0.2,0.3\n')
    before = source.read_bytes()
    assert 'its own output' in refused(capsys, str(source), str(source), '--force')
    assert source.read_bytes() == before


def test_a_folder_that_is_no_bag_is_not_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'arm_raise').mkdir()
    (tmp_path / 'arm_raise' / 'thesis.txt').write_text('precious')
    line = refused(capsys, str(BAG), str(BAG.parent), str(tmp_path), '--force')
    assert 'a folder; only a bag is replaced' in line
    assert (tmp_path / 'arm_raise' / 'thesis.txt').read_text() == 'precious'


@pytest.mark.parametrize('kind', ['csv', 'bag'])
def test_force_does_not_replace_the_folder_that_the_source_lies_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    bag = write(tmp_path / 'rec', odd_motion())
    inner = bag / 'rec.mcap'
    before = inner.read_bytes()
    refused(capsys, str(inner), str(bag), '--force', '--format', kind)
    refused(capsys, str(BAG), str(bag), '--force', '--format', 'csv')
    assert inner.read_bytes() == before


def test_a_bag_is_replaced_by_a_bag_with_force(tmp_path: Path) -> None:
    source = write(tmp_path / 'in', odd_motion())
    target = write(tmp_path / 'old', [note(0)])
    assert exit_status([str(source), str(target), '--force']) == 0
    assert {topic for topic, *_ in contents(target)} >= {'/joint_states', '/deltoid/band_states'}


def test_a_bags_file_alone_becomes_an_annotated_bag(tmp_path: Path) -> None:
    sent = odd_motion()
    source = write(tmp_path / 'in', sent) / 'in.mcap'
    assert run(Task(source, tmp_path / 'out')).fault == ''
    found = contents(tmp_path / 'out')
    assert [each for each in found if each[0] in ('/joint_states', '/notes')] == sent


def test_times_before_zero_keep_their_values(tmp_path: Path) -> None:
    lines = ['time,flexion,abduction,rotation', *(f'{t},0.1,0.2,0.3' for t in (-1.5, -0.4, 0.25))]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    run(Task(tmp_path / 'in.csv', tmp_path / 'out.csv'))
    assert rows(tmp_path / 'out.csv')[2][:, 0].tolist() == [-1.5, -0.4, 0.25]


def test_times_that_cannot_be_seconds_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('timestamp,flexion,abduction,rotation\n1700000000000,0.1,0.2,0.3\n')
    assert 'ms?' in refused(capsys, str(source), str(tmp_path / 'out.csv'))


@pytest.mark.parametrize(
    ('options', 'word'),
    [
        (('--joints', 'flexion', 'flexion', 'rotation'), '3 different joints'),
        (('--offsets', 'nan', '0', '0'), 'finite numbers expected'),
        (('--rate', '1e13'), 'in: '),
        (('--humerus', '', '--thorax', 'b'), 'a name expected'),
        (('--humerus', '/h', '--scapula', '/s'), '/h is neither a topic'),
        (('--rhythm', '2'), '--thorax'),
        (('--topic', '/other'), 'on /other'),
    ],
)
def test_odd_options_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], word: str
) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert word in refused(capsys, str(source), str(tmp_path / 'out.csv'), *options)


def test_patterns_are_matched_where_the_shell_has_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for k in range(3):
        write(tmp_path / f'walk_{k}', odd_motion())
    command = [str(tmp_path / 'walk_*'), str(tmp_path / 'out'), '--format', 'csv']
    assert exit_status(command) == 0
    assert '3 of 3 recordings' in capsys.readouterr().out
    assert 'run_*: nothing matches' in refused(capsys, str(tmp_path / 'run_*'), 'out')


def test_folders_with_a_dot_in_their_names_keep_them(tmp_path: Path) -> None:
    sources = [write(tmp_path / f'walk.0{k}', odd_motion()) for k in (1, 2)]
    assert exit_status([*map(str, sources), str(tmp_path / 'out')]) == 0
    assert sorted(each.name for each in (tmp_path / 'out').iterdir()) == ['walk.01', 'walk.02']


def test_a_bag_is_not_processed_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'once')]) == 0
    assert 'in it already' in refused(capsys, str(tmp_path / 'once'), str(tmp_path / 'twice'))


def test_a_bag_is_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, str(BAG), str(tmp_path / 'out.mcap'))
    assert f'{tmp_path / "out.mcap"}: a bag is a folder; name it without .mcap' in line


def test_what_cannot_be_used_does_not_keep_the_others_from_being_done(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = write(tmp_path / 'good', odd_motion())
    (tmp_path / 'empty').mkdir()
    out = tmp_path / 'out'
    named = [str(good), str(tmp_path / 'empty'), str(tmp_path / 'no*thing'), str(good) + '/*.mcap']
    assert exit_status([*named, str(out)]) == 1
    error = capsys.readouterr().err
    assert error.splitlines() == [
        f'linkedplane: {tmp_path / "empty"}: no recordings in it '
        '(bags, .mot, .sto, .csv, .mcap, .db3)',
        f'linkedplane: {tmp_path / "no*thing"}: nothing matches',
        f'linkedplane: {good / "good.mcap"}: would become {out / "good"}, as {good} does; '
        'process them into folders of their own',
    ]
    assert [each.name for each in out.iterdir()] == ['good']


def test_a_pattern_stands_for_the_recordings_in_it(tmp_path: Path) -> None:
    write(tmp_path / 'lab' / 'deep' / 'walk', odd_motion())
    (tmp_path / 'lab' / 'notes.txt').touch()
    assert exit_status([str(tmp_path / 'lab' / '**'), str(tmp_path / 'out')]) == 0
    assert [each.name for each in (tmp_path / 'out').iterdir()] == ['walk']


def test_several_recordings_need_a_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sources = [str(write(tmp_path / f'in{k}', odd_motion())) for k in range(2)]
    line = refused(capsys, *sources, str(tmp_path / 'x.csv'))
    assert 'x.csv: a folder expected for several recordings; --format csv?' in line


@pytest.mark.parametrize(
    ('options', 'line'),
    [
        (('--joints', 'a', 'b', 'c'), '--joints: for joint angles alone, not for poses'),
        (('--signs', '1', '-1', '1'), '--signs: for joint angles alone, not for poses'),
        (('--degrees',), '--degrees: for joint angles alone, not for poses'),
    ],
)
def test_options_that_would_do_nothing_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], line: str
) -> None:
    poses = ('--humerus', '/h', '--scapula', '/s')
    assert line in refused(capsys, str(BAG), str(tmp_path / 'out'), *poses, *options)
    assert '--frame-axes: for poses alone' in refused(
        capsys, str(BAG), str(tmp_path / 'out'), '--frame-axes', 'isb'
    )


def test_a_bag_has_no_times_before_zero(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('time,flexion,abduction,rotation\n-1.5,0.1,0.2,0.3\n')
    line = refused(capsys, str(source), str(tmp_path / 'out'))
    assert 'time -1.5 s: a bag has none before 0 s' in line


def test_a_file_is_not_replaced_by_a_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'out').touch()
    line = refused(capsys, str(BAG), str(tmp_path / 'out'), '--force')
    assert f'{tmp_path / "out"}: a file; a bag is a folder' in line


def test_a_folder_holds_bags_and_tables_in_the_order_of_their_names(tmp_path: Path) -> None:
    write(tmp_path / 'b', [joint_state(0)])
    for name in ('c.mot', 'a.sto', 'notes.txt', 'd.CSV'):
        (tmp_path / name).touch()
    found, faults = recordings([str(tmp_path)])
    assert ([each.name for each in found], faults) == (['a.sto', 'b', 'c.mot', 'd.CSV'], [])
