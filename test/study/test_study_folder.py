# SPDX-License-Identifier: Apache-2.0
"""The folder of a study: what is left alone, what is replaced, and how a study ends."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from command_line import command_fault
from optional import requires

from linkedplane_ros.commands.main import main
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.study import report
from linkedplane_ros.study.pictures import charts
from linkedplane_ros.study.subject import Subject

pytestmark = [pytest.mark.usefixtures('coarse'), requires('matplotlib')]


def test_a_folder_with_anything_in_it_is_left_alone(
    quick: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'notes.txt').write_text('mine')
    for options in ((), ('--force',)):
        line = command_fault(capsys, 'study', tmp_path, *options)
        assert f'{tmp_path}: not empty and not a study; only a study is replaced' in line
    assert [path.name for path in tmp_path.iterdir()] == ['notes.txt']


def test_a_study_is_replaced_only_by_force_and_only_if_nothing_else_is_in_it(
    quick: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / 'out'
    out.mkdir()  # an empty folder will do
    assert main(['study', str(out)]) == 0
    before = (out / 'report.md').read_text()
    capsys.readouterr()
    assert f'{out}: holds a study; --force to replace it' in command_fault(capsys, 'study', out)
    assert main(['study', str(out), '--half', '--force']) == 0
    assert (out / 'report.md').read_text() != before
    capsys.readouterr()
    (out / 'figures' / 'mine.svg').write_text('mine')
    assert 'mine.svg: is not a file of the study' in command_fault(capsys, 'study', out, '--force')
    assert (out / 'figures' / 'mine.svg').read_text() == 'mine'
    assert [path.name for path in tmp_path.iterdir()] == ['out']


def test_a_study_may_be_written_where_one_stands(
    quick: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for options in ((), ('--force',)):
        assert main(['study', '.', *options]) == 0
        assert Path.cwd() == tmp_path
        assert {path.name for path in Path().iterdir()} == {'report.md', 'tables', 'figures'}


def test_a_study_that_fails_leaves_what_there_was(
    quick: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(subject: Subject) -> object:
        raise RecordingError('no')

    subject = Subject.load('deltoid')
    report.write_study(subject, tmp_path / 'old')
    before = {path: path.read_bytes() for path in tmp_path.rglob('*') if path.is_file()}
    monkeypatch.setattr(charts, 'fidelity_figure', broken)
    for name, force in (('new', False), ('old', True)):
        with pytest.raises(RecordingError):
            report.write_study(subject, tmp_path / name, force)
    assert before == {path: path.read_bytes() for path in tmp_path.rglob('*') if path.is_file()}
    assert [path.name for path in tmp_path.iterdir()] == ['old']


@pytest.mark.parametrize(
    ('options', 'reason'),
    [
        (('--muscle', 'biceps'), "'biceps' is neither a bundled model"),
        (('--muscle', 'gone.yaml'), 'gone.yaml: cannot be read'),
        (('--spheres', 'gone.yaml'), 'gone.yaml: cannot be read'),
    ],
)
def test_an_input_at_fault_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], reason: str
) -> None:
    assert reason in command_fault(capsys, 'study', tmp_path / 'out', *options)
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'file').write_text('mine')
    assert 'a file; a folder expected' in command_fault(capsys, 'study', tmp_path / 'file')
    assert 'No such file or directory' in command_fault(capsys, 'study', tmp_path / 'gone' / 'out')


def test_wrong_usage_ends_with_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['study']) == 2
    assert 'usage: linkedplane study' in capsys.readouterr().err


def test_without_matplotlib_one_line_says_what_to_install(tmp_path: Path) -> None:
    code = (
        'import sys; sys.modules["matplotlib"] = None; '
        'from linkedplane_ros.commands.main import main; '
        f'sys.exit(main(["study", {str(tmp_path / "o")!r}]))'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr == (
        'linkedplane: a picture needs the matplotlib library: '
        'pip install matplotlib (rosdep key: python3-matplotlib)\n'
    )
    assert not list(tmp_path.iterdir())
