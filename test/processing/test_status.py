# SPDX-License-Identifier: Apache-2.0
"""The exit status and the warnings of `linkedplane process` mean something."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bags import exit_status, joint_state, refusal_line, write_bag

HEAD = 'time,flexion_rad,abduction_rad,rotation_rad'


def write_rows(path: Path, *rows: tuple[int, str]) -> Path:
    """Write a CSV at 100 Hz: some rows of each text of angles."""
    texts = [text for count, text in rows for _ in range(count)]
    lines = [f'{0.01 * k:.2f},{text}' for k, text in enumerate(texts)]
    path.write_text('\n'.join([HEAD, *lines]) + '\n')
    return path


@pytest.mark.parametrize(
    'ending', ['.xlsx', '.tsv', '.txt', '.json', '.mat', '.h5', '.CSVX', '.bag', '.gz']
)
@pytest.mark.parametrize('count', [1, 2])
def test_an_ending_that_is_not_written_is_refused_with_those_that_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], ending: str, count: int
) -> None:
    sources = [write_rows(tmp_path / f'{k}.csv', (3, '0.5,0.4,0.1')) for k in range(count)]
    out = tmp_path / f'q{ending}'
    line = refusal_line(capsys, *map(str, sources), str(out))
    assert f'{out}: no {ending} is written; .csv, .parquet or a bag' in line
    assert '--format bag' in line
    assert not out.exists()


def test_a_dot_at_the_end_of_a_name_is_no_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_rows(tmp_path / 'in.csv', (3, '0.5,0.4,0.1'))
    line = refusal_line(capsys, str(source), str(tmp_path / 'q.csv.'))
    assert 'q.csv.: no . is written; .csv, .parquet or a bag' in line


@pytest.mark.parametrize('name', ['run_2024.05.01', 'a.1', 'trial.05_left', 'plain'])
def test_a_bags_name_may_have_dots(tmp_path: Path, name: str) -> None:
    source = write_rows(tmp_path / 'in.csv', (3, '0.5,0.4,0.1'))
    assert exit_status([str(source), str(tmp_path / name)]) == 0
    assert (tmp_path / name / 'metadata.yaml').is_file()


def test_a_format_settles_what_a_name_means(tmp_path: Path) -> None:
    source = write_rows(tmp_path / 'in.csv', (3, '0.5,0.4,0.1'))
    assert exit_status([str(source), str(tmp_path / 'v1.final'), '--format', 'bag']) == 0
    assert (tmp_path / 'v1.final' / 'metadata.yaml').is_file()
    assert exit_status([str(source), str(tmp_path / 'q.txt'), '--format', 'csv']) == 0
    assert (tmp_path / 'q.txt').read_text().startswith('# made_by')


@pytest.mark.parametrize('jobs', ['1', '2'])
def test_most_frames_refused_is_status_1_and_the_rest_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], jobs: str
) -> None:
    good = write_rows(tmp_path / 'good.csv', (9, '0.5,0.4,0.1'), (8, 'nan,0.4,0.1'))
    bad = write_rows(tmp_path / 'bad.csv', (2, '0.5,0.4,0.1'), (98, '0.5,nan,0.1'))
    out = tmp_path / 'out'
    command = [str(good), str(bad), str(out), '--format', 'csv', '--jobs', jobs]
    assert exit_status(command) == 1
    told = capsys.readouterr()
    assert told.err == (
        f'linkedplane: warning: {bad}: most frames were refused; {out / "bad.csv"} has only the '
        'others\n'
    )
    assert '98 refused as not_finite' in told.out
    assert '2 of 2 recordings processed' in told.out
    assert (out / 'bad.csv').is_file()
    assert exit_status([str(good), str(tmp_path / 'alone.csv')]) == 0


def test_at_another_rate_most_frames_are_counted_as_they_were_recorded(tmp_path: Path) -> None:
    rows = (60, '0.5,0.4,0.1'), (30, 'nan,0.4,0.1')
    source = write_rows(tmp_path / 'in.csv', *rows)
    assert exit_status([str(source), str(tmp_path / 'o.csv'), '--rate', '10']) == 0  # 6 frames


def test_messages_of_other_joints_are_no_refused_frames(tmp_path: Path) -> None:
    sent = [joint_state(k, ('gripper',) if k % 4 else ('flexion', 'abduction', 'rotation'))
            for k in range(40)]  # fmt: skip
    source = write_bag(tmp_path / 'in', sent)
    assert exit_status([str(source), str(tmp_path / 'o.csv')]) == 0


@pytest.mark.parametrize(
    ('angles', 'options', 'cause'),
    [
        ('0.5,-0.6,0.1', (), '--signs 1 -1 1?'),
        ('0.5,2.9,0.1', (), 'angles against the thorax instead of the scapula?'),
        ('0.2,1.0,-2.0', (), 'flexion 11.46 to 11.46, abduction 57.3 to 57.3, rotation -114.6'),
    ],
)
def test_most_frames_outside_the_range_are_a_warning_with_the_likely_cause(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    angles: str,
    options: tuple[str, ...],
    cause: str,
) -> None:
    source = write_rows(tmp_path / 'in.csv', (11, angles), (9, '0.5,0.4,0.1'))
    assert exit_status([str(source), str(tmp_path / 'o.csv'), *options]) == 0
    told = capsys.readouterr().err
    assert told.startswith(
        f"linkedplane: warning: {source}: 11 of 20 frames lie outside the model's range of motion; "
    )
    assert told.count('\n') == 1
    if 'flexion' not in cause:
        assert cause in told
    assert 'degrees' not in told  # the columns say radians


def test_degrees_are_a_likely_cause_where_nothing_says_the_unit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_rows(tmp_path / 'in.csv', (5, '1.0,2.0,-3.0'))
    source.write_text(source.read_text().replace('_rad', ''))
    assert exit_status([str(source), str(tmp_path / 'o.csv')]) == 0
    assert 'degrees (--degrees)?' in capsys.readouterr().err


def test_some_frames_outside_the_range_are_no_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_rows(tmp_path / 'in.csv', (9, '0.5,-0.6,0.1'), (11, '0.5,0.4,0.1'))
    assert exit_status([str(source), str(tmp_path / 'o.csv')]) == 0
    assert capsys.readouterr().err == ''


def test_a_real_recording_of_the_thorax_is_warned_of(
    shared: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = shared / 'recordings' / 'daily_motion.csv'
    names = [f'th_{each}' for each in ('plane_of_elevation', 'elevation', 'axial_rotation')]
    command = [str(source), str(tmp_path / 'o.csv'), '--convention', 'isb_yxy', '--joints', *names]
    assert exit_status(command) == 0
    told = capsys.readouterr().err
    assert '9,768 of 9,800 frames' in told
    elevation = np.degrees(np.loadtxt(source, delimiter=',', skiprows=1)[:, 2])
    assert f', elevation {elevation.min():.4g} to {elevation.max():.4g},' in told
