# SPDX-License-Identifier: Apache-2.0
"""Where outputs go: nothing that was recorded is lost, and no run takes the place of another."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import Any

import pytest
from bags import exit_status, odd_motion, refusal_line, write_bag

from linkedplane_ros import files
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.files import claim_output, find_abandoned, replace_when_complete, workshop_of

ROWS = 'time,flexion,abduction,rotation\n0,0.1,0.2,0.3\n0.01,0.1,0.2,0.3\n'
CLAIM = """
import sys, time
from pathlib import Path
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.files import replace_when_complete

with replace_when_complete(Path(sys.argv[1]), RecordingError) as new:
    new.write_text('half')
    print(flush=True)
    time.sleep(600)
"""


def table(path: Path) -> Path:
    """Write a short recording."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(ROWS)
    return path


@contextmanager
def another_run(path: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Let another process write an output until the end of the block, or until it is killed."""
    with subprocess.Popen([sys.executable, '-c', CLAIM, path], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.parametrize('force', [[], ['--force']])
def test_a_target_that_is_the_source_of_another_task_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], force: list[str]
) -> None:
    a, b = table(tmp_path / 'in' / 'a.csv'), table(tmp_path / 'out' / 'a.csv')
    arguments = [str(a), str(b), str(tmp_path / 'out'), '--format', 'csv', *force]
    assert exit_status(arguments) == 1
    assert f'{a}: its output {b} is, holds or lies in the recording' in capsys.readouterr().err
    assert a.read_text() == b.read_text() == ROWS


def test_a_link_does_not_hide_that_a_target_is_a_source(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = table(tmp_path / 'in' / 'a.csv')
    (tmp_path / 'out').symlink_to(tmp_path / 'in')
    target = tmp_path / 'out' / 'a.csv'
    assert 'is, holds or lies in' in refusal_line(capsys, str(source), str(target), '--force')
    assert source.read_text() == ROWS


def test_a_target_that_lies_in_a_source_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = write_bag(tmp_path / 'bag', odd_motion())
    before = sorted(bag.iterdir())
    for target in (bag / 'out.csv', bag / 'deeper'):
        assert 'is, holds or lies in' in refusal_line(capsys, str(bag), str(target), '--force')
    assert sorted(bag.iterdir()) == before


def test_a_safe_task_beside_an_unsafe_one_is_done(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / 'a', odd_motion())
    other = table(tmp_path / 'in' / 'b.csv')
    assert exit_status([str(bag), str(other), str(tmp_path), '--force']) == 1
    assert (tmp_path / 'b' / 'metadata.yaml').is_file()
    assert (bag / 'a.mcap').is_file()


@pytest.mark.parametrize('force', [[], ['--force']])
def test_two_runs_onto_one_name_do_not_both_write_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], force: list[str]
) -> None:
    source, out = table(tmp_path / 'in.csv'), tmp_path / 'out.csv'
    with another_run(out):
        line = refusal_line(capsys, str(source), str(out), *force)
        assert line == f'linkedplane: {out}: another run is writing it\n'
        assert (workshop_of(out) / 'out.csv').read_text() == 'half'
        assert not out.exists()


def test_what_appears_meanwhile_stays(tmp_path: Path) -> None:
    def write(path: Path, folder: bool) -> None:
        with replace_when_complete(path, RecordingError, may_replace=False) as new:
            for each, text in ((new, 'ours'), (path, 'precious')):
                if folder:
                    each.mkdir()
                (each / 'file' if folder else each).write_text(text)

    for out, folder in ((tmp_path / 'out.csv', False), (tmp_path / 'out', True)):
        with pytest.raises(RecordingError, match=rf'{out.name}: exists; --force'):
            write(out, folder)
        assert (out / 'file' if folder else out).read_text() == 'precious'
        assert not workshop_of(out).exists()


def test_a_file_never_takes_the_place_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / 'out').mkdir()
    with (
        pytest.raises(RecordingError, match=r'out: cannot be written: Is a directory'),
        replace_when_complete(tmp_path / 'out', RecordingError) as new,
    ):
        new.write_text('ours')
    assert list(tmp_path.iterdir()) == [tmp_path / 'out']


@pytest.mark.parametrize('kind', ['csv', 'bag'])
def test_an_output_is_on_the_disk_before_it_appears(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    out = tmp_path / ('out.csv' if kind == 'csv' else 'out')
    safe: list[tuple[str, bool]] = []
    fsync = os.fsync

    def note(descriptor: int) -> None:
        safe.append((os.readlink(f'/proc/self/fd/{descriptor}'), out.exists()))
        fsync(descriptor)

    monkeypatch.setattr(files.os, 'fsync', note)
    assert exit_status([str(table(tmp_path / 'in.csv')), str(out)]) == 0
    before = {path for path, appeared in safe if not appeared}
    new = workshop_of(out) / out.name
    written = [new] if kind == 'csv' else [new, *(new / each.name for each in out.iterdir())]
    assert {str(path) for path in written} <= before
    assert (str(tmp_path), True) in safe  # its name, too


def test_what_a_killed_run_left_is_named_with_the_way_to_remove_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out, other = table(tmp_path / 'in.csv'), tmp_path / 'out.csv', tmp_path / "o'ther.csv"
    for path in (out, other):
        with another_run(path) as process:
            process.send_signal(signal.SIGKILL)
            process.wait()
    with another_run(tmp_path / 'going_on.csv'):
        assert exit_status([str(source), str(out)]) == 0
        left = workshop_of(other)
        assert sorted(capsys.readouterr().err.splitlines()) == [
            f'linkedplane: warning: {left}: left by a run that was killed; '
            f'remove it: rm -r {quote(str(left))}',
            f'linkedplane: warning: {workshop_of(out)}: left by a run that was killed; '
            'it is removed now',
        ]
        assert find_abandoned([tmp_path]) == [left]
    assert left.exists()
    assert not workshop_of(out).exists()


def test_a_run_that_ends_meanwhile_leaves_its_name_free(tmp_path: Path) -> None:
    out = tmp_path / 'out.csv'
    for _ in range(3):
        with claim_output(out, RecordingError) as workshop:
            assert workshop.stat().st_mode & 0o777 == 0o700
            with (
                pytest.raises(RecordingError, match='another run'),
                claim_output(out, RecordingError),
            ):
                pass
    assert not list(tmp_path.iterdir())


def test_no_workshop_is_entered_through_a_link(tmp_path: Path) -> None:
    precious = tmp_path / 'precious'
    precious.mkdir()
    (precious / 'file').touch()
    workshop_of(tmp_path / 'out.csv').symlink_to(precious)
    with (
        pytest.raises(RecordingError, match=r'out\.csv: cannot be written: '),
        claim_output(tmp_path / 'out.csv', RecordingError),
    ):
        pass
    assert (precious / 'file').exists()


@pytest.mark.parametrize('place', ['mkdir', 'open', 'flock', 'rmtree'])
@pytest.mark.parametrize('interruption', [KeyboardInterrupt, SystemExit])
def test_an_interruption_at_any_place_leaves_no_part(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    place: str,
    interruption: type[BaseException],
) -> None:
    module = {'mkdir': Path, 'open': os, 'flock': files.fcntl, 'rmtree': files.shutil}[place]
    true = getattr(module, place)

    def interrupt_once(*arguments: Any, **options: Any) -> Any:
        monkeypatch.undo()
        done = true(*arguments, **options) if place != 'rmtree' else None
        if place == 'open':
            os.close(done)
        raise interruption

    monkeypatch.setattr(module, place, interrupt_once)
    with (
        pytest.raises(interruption),
        replace_when_complete(tmp_path / 'out.csv', RecordingError) as new,
    ):
        new.write_text('half')
    assert [path for path in tmp_path.iterdir() if path.name != 'out.csv'] == []
