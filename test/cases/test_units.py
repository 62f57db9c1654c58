# SPDX-License-Identifier: Apache-2.0
"""The unit of a recording's angles: one for all of it, or the recording is refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from bags import (
    NAMES,
    exit_status,
    joint_state,
    node_answers,
    read_csv,
    read_messages,
    refusal_line,
    write_bag,
)
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from linkedplane_ros.processing.reading import read_processed

FIRST = np.radians([1.0, 2.0, -3.0])  # of the cases in degrees, as their READMEs have it
CLOSE = 1e-15  # rad: a rounding of angles below 0.1
ROWS = '0.0 1.0 2.0 -3.0\n0.01 1.5 2.5 -3.0\n0.02 2.0 3.0 -3.0\n'


def first_angles(output: Path) -> np.ndarray:
    """Return the first frame's angles in a CSV output, rad."""
    _, names, values = read_csv(output)
    return values[0, [k for k, name in enumerate(names) if name.startswith('angles/')]]


def read_in(output: Path) -> str:
    """Return what a CSV output says of the unit that it was read in."""
    return read_csv(output)[0]['read_in']


def write_csv(path: Path, names: tuple[str, ...], rows: str = ROWS) -> Path:
    """Write a CSV with these names of columns behind the time."""
    lines = [','.join(f'"{name}"' for name in ('time', *names)), *rows.replace(' ', ',').split()]
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    return path


@pytest.mark.parametrize(
    ('case', 'options', 'who'),
    [
        ('units_explicit_names/a.csv', ('--joints', *(f'{n}_deg' for n in NAMES)), 'the names'),
        ('units_in_brackets/a.csv', ('--joints', *(f'{n} (deg)' for n in NAMES)), 'the names'),
        ('units_in_brackets/a.csv', (), 'the names of the columns'),
        ('units_simm_mot/swing.mot', (), 'its head without version='),
    ],
)
def test_a_table_says_its_unit(
    cases: Path, tmp_path: Path, case: str, options: tuple[str, ...], who: str
) -> None:
    out = tmp_path / 'o.csv'
    assert exit_status([str(cases / case), str(out), *options]) == 0
    np.testing.assert_allclose(first_angles(out), FIRST, rtol=0.0, atol=CLOSE)
    assert read_in(out).startswith(f'deg: {who}')


def test_a_raise_in_degrees_is_not_taken_for_radians_row_by_row(
    cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out = cases / 'units_row_by_row' / 'raise.csv', tmp_path / 'o.csv'
    line = refusal_line(capsys, str(source), str(out))
    assert 'flexion 0 to 20, abduction 2 to 2, rotation -3 to -3' in line
    assert '--degrees or --radians' in line
    assert list(tmp_path.iterdir()) == []
    assert exit_status([str(source), str(out), '--degrees']) == 0
    assert read_csv(out)[2].shape[0] == 21
    assert exit_status([str(source), str(out), '--radians', '--force']) == 1  # 14 are refused
    assert read_csv(out)[2].shape[0] == 7
    assert read_in(out) == 'rad: --radians'


def test_a_bag_in_degrees_is_refused_or_read_as_degrees(
    cases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out = cases / 'units_bag_degrees_flag' / 'bag', tmp_path / 'o.csv'
    assert '--degrees or --radians' in refusal_line(capsys, str(source), str(out))
    assert list(tmp_path.iterdir()) == []
    assert exit_status([str(source), str(out), '--degrees']) == 0
    _, _, values = read_csv(out)
    np.testing.assert_allclose(values[:, 1], np.radians(np.arange(21)), rtol=0.0, atol=CLOSE)
    assert read_in(out) == 'deg: --degrees'


def test_a_bag_in_degrees_has_its_angles_in_radians_beside_them(tmp_path: Path) -> None:
    sent = [
        joint_state(k, position=[30.0 + k, 20.0, 10.0], velocity=[100.0, 0.0, 0.0])
        for k in range(9)
    ]
    out = tmp_path / 'out'
    assert exit_status([str(write_bag(tmp_path / 'in', sent)), str(out), '--degrees']) == 0
    found = read_messages(out)
    assert [each for each in found if each[0] == '/joint_states'] == sent
    own = [data for topic, _, _, data in found if topic == '/deltoid/joint_states']
    first = deserialize_message(own[0], JointState)
    np.testing.assert_allclose(first.position, np.radians([30.0, 20.0, 10.0]), atol=CLOSE)
    np.testing.assert_allclose(first.velocity, np.radians([100.0, 0.0, 0.0]), atol=CLOSE)
    np.testing.assert_allclose(
        read_processed(out).angles[:, 0], np.radians(30.0 + np.arange(9)), rtol=0.0, atol=CLOSE
    )


@pytest.mark.parametrize(
    'spelling',
    [
        '{}_deg', '{}_DEG', '{} deg', '{} [deg]', '{}[Deg]', '{} (°)', '{}[°]', '{}°', '{} [º]',
        '{}/deg', '{}_degrees', '{} (degrees)', '{} in degrees', '{}.deg', '{}..deg.', '{}_deg_',
        '{}Deg', '{}-deg', '{}, deg', '{} [Â°]', 'arm/{}_deg',
    ],
)  # fmt: skip
@pytest.mark.parametrize('named', [False, True])
def test_a_name_in_degrees_however_it_is_spelt(tmp_path: Path, spelling: str, named: bool) -> None:
    columns = tuple(map(spelling.format, NAMES))
    source, out = write_csv(tmp_path / 'in.csv', columns), tmp_path / 'o.csv'
    assert exit_status([str(source), str(out), *(('--joints', *columns) if named else ())]) == 0
    np.testing.assert_allclose(first_angles(out), FIRST, rtol=0.0, atol=CLOSE)
    refuse(source, tmp_path, '--radians')


def refuse(source: Path, folder: Path, *options: str) -> None:
    """Run a command that must end with 1 and leave no output."""
    assert exit_status([str(source), str(folder / 'refused.csv'), *options]) == 1
    assert not (folder / 'refused.csv').exists()


@pytest.mark.parametrize('spelling', ['deg_{}', '{}_deg_filtered', 'angle_{}_deg'])
def test_a_unit_anywhere_in_a_name_that_is_given_counts(tmp_path: Path, spelling: str) -> None:
    columns = tuple(map(spelling.format, NAMES))
    source, out = write_csv(tmp_path / 'in.csv', columns), tmp_path / 'o.csv'
    assert exit_status([str(source), str(out), '--joints', *columns]) == 0
    np.testing.assert_allclose(first_angles(out), FIRST, rtol=0.0, atol=CLOSE)


@pytest.mark.parametrize('spelling', ['{}_rad', '{} (rad)', '{}[radians]', '{} / rad', '{}Rad'])
def test_a_name_in_radians_however_it_is_spelt(tmp_path: Path, spelling: str) -> None:
    rows = '0 0.1 0.2 0.3\n0.01 0.11 0.2 0.3\n'
    source = write_csv(tmp_path / 'in.csv', tuple(map(spelling.format, NAMES)), rows)
    out = tmp_path / 'o.csv'
    assert exit_status([str(source), str(out)]) == 0
    assert first_angles(out).tolist() == [0.1, 0.2, 0.3]
    assert read_in(out) == 'rad: the names of the columns'
    refuse(source, tmp_path, '--degrees')


@pytest.mark.parametrize(
    ('names', 'reason'),
    [
        (('flexion_deg', 'abduction_rad', 'rotation_deg'), 'one unit for all 3 expected'),
        (('flexion_deg', 'abduction', 'rotation'), "'abduction' is without a unit"),
        (('flexion_mrad', 'abduction_mrad', 'rotation_mrad'), 'not in mrad'),
        (('flexion (deg/s)', 'abduction (deg/s)', 'rotation (deg/s)'), 'not in deg/s'),
        (('flexion [grad]', 'abduction [grad]', 'rotation [grad]'), 'not in grad'),
    ],
)
def test_names_in_several_units_or_another_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], names: tuple[str, ...], reason: str
) -> None:
    source = write_csv(tmp_path / 'in.csv', names)
    line = refusal_line(capsys, str(source), str(tmp_path / 'o.csv'), '--joints', *names)
    assert reason in line


@pytest.mark.parametrize(
    ('names', 'options', 'reason'),
    [
        (('flexion_deg', 'abduction', 'rotation'), (), "joint 'abduction' is without a unit"),
        (('flexion [grad]', 'abduction', 'rotation'), (), "joint 'flexion [grad]': angles in deg"),
        (('a_deg', 'b_deg', 'c_deg'), ('--radians',), 'by the names of the joints; leave'),
        (('a_deg', 'b_deg', 'c_deg'), (), 'deg: the names of the joints'),
    ],
)
def test_the_names_of_a_bag_are_those_of_joints(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    names: tuple[str, ...],
    options: tuple[str, ...],
    reason: str,
) -> None:
    bag = write_bag(
        tmp_path / 'in', [joint_state(k, names, position=[9.0, 2.0, -3.0]) for k in range(3)]
    )
    command = [str(bag), str(tmp_path / 'o.csv'), '--joints', *names, *options]
    if reason.startswith('deg'):
        assert exit_status(command) == 0
        assert read_in(tmp_path / 'o.csv') == reason
        return
    line = refusal_line(capsys, *command)
    assert reason in line
    assert 'column' not in line


def test_both_flags_are_a_wrong_command_line(tmp_path: Path) -> None:
    assert exit_status(['in.csv', str(tmp_path / 'o.csv'), '--degrees', '--radians']) == 2


def turn(tmp_path: Path, flexion: np.ndarray, others: str = '0.3,0.1') -> list[str]:
    """Write a CSV without a unit at 100 Hz; return the begin of the command."""
    lines = [f'{0.01 * k:.2f},{angle!r},{others}' for k, angle in enumerate(flexion.tolist())]
    source = tmp_path / 'in.csv'
    source.write_text('\n'.join(['time,flexion,abduction,rotation', *lines]) + '\n')
    return [str(source), str(tmp_path / 'o.csv')]


def test_five_degrees_do_not_pass_for_five_radians(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = refusal_line(capsys, *turn(tmp_path, np.linspace(0.0, 5.0, 21), '2.0,-3.0'))
    assert 'flexion 0 to 5' in line
    assert '--degrees or --radians' in line
    assert exit_status([*turn(tmp_path, np.linspace(0.0, 5.0, 21), '2.0,-3.0'), '--radians']) == 0


def test_a_bag_in_small_degrees_is_refused_beside_one_in_radians(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = [joint_state(k, position=[0.25 * k, 2.0, -3.0]) for k in range(21)]
    sources = write_bag(tmp_path / 'small', small), write_bag(tmp_path / 'b', [joint_state(0)])
    out = tmp_path / 'out'
    command = [*map(str, sources), str(out), '--format', 'csv']
    assert 'small: degrees? Nothing says the unit' in refusal_line(capsys, *command, '--jobs', '2')
    assert [each.name for each in out.iterdir()] == ['b.csv']


def test_radians_that_go_on_beyond_pi_are_read(tmp_path: Path) -> None:
    whole = 2.0 * np.pi + np.linspace(-0.6, 0.0, 50)  # as after a turn: a natural posture
    assert exit_status(turn(tmp_path, whole - 1e-9)) == 0


@pytest.mark.parametrize(
    ('name', 'convention'),
    [('abduction', 'opensim_tsm'), ('flexion', 'opensim_tsm'), ('daily_motion', 'isb_yxy')],
)
@pytest.mark.parametrize('shift', [(0, 0, 0), (1, 0, 0), (0, 0, -1), (-1, 0, 1)])
def test_no_real_recording_in_radians_is_refused(
    shared: Path, tmp_path: Path, name: str, convention: str, shift: tuple[int, int, int]
) -> None:
    head, *rows = (shared / 'recordings' / f'{name}.csv').read_text().splitlines()
    names = [each.removesuffix('_rad') for each in head.split(',')]
    numbers = np.array([row.split(',') for row in rows], dtype=float)[::20]
    numbers[:, 1:] += 2.0 * np.pi * np.array(shift)  # as if unwrapped
    numbers = numbers[(np.abs(numbers[:, 1:]) <= 2.0 * np.pi).all(axis=1)]
    lines = [','.join(names), *(','.join(map(repr, row)) for row in numbers.tolist())]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    command = [str(tmp_path / 'in.csv'), str(tmp_path / 'o.csv'), '--convention', convention]
    assert exit_status([*command, '--joints', *names[1:]]) == 0


@pytest.mark.parametrize(
    'comment', ['# flexion abduction rotation in deg', '# units: s, deg, deg, deg', '# angles [°]']
)
def test_a_comment_that_speaks_of_degrees_is_not_passed_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], comment: str
) -> None:
    source = write_csv(tmp_path / 'in.csv', NAMES)
    source.write_text(f'{comment}\n{source.read_text()}', encoding='utf-8')
    line = refusal_line(capsys, str(source), str(tmp_path / 'o.csv'))
    assert f'in.csv: {comment!r} in line 1: are the angles in degrees? --degrees or' in line
    assert exit_status([str(source), str(tmp_path / 'o.csv'), '--degrees']) == 0
    np.testing.assert_allclose(first_angles(tmp_path / 'o.csv'), FIRST, rtol=0.0, atol=CLOSE)


def test_a_copy_of_an_output_is_read_in_radians(tmp_path: Path) -> None:
    once, twice = tmp_path / 'o.csv', tmp_path / 'twice.csv'
    assert exit_status([*turn(tmp_path, np.linspace(0.2, 1.0, 9)), '--radians']) == 0
    shutil.copy(once, tmp_path / 'copy.csv')
    joints = [f'angles/{name}' for name in NAMES]
    assert exit_status([str(tmp_path / 'copy.csv'), str(twice), '--joints', *joints]) == 0
    np.testing.assert_array_equal(read_csv(twice)[2][:, :4], read_csv(once)[2][:, :4])


@pytest.mark.parametrize(('largest', 'lines'), [(90.0, 1), (0.9, 0)])
def test_the_node_says_once_that_a_stream_looks_like_degrees(
    ros: None, capfd: pytest.CaptureFixture[str], largest: float, lines: int
) -> None:
    raised = np.abs(np.sin(np.linspace(0.0, 12.0, 400))) * largest  # some below 2 pi
    node_answers([joint_state(k, position=[each, 0.2, 0.1]) for k, each in enumerate(raised)])
    assert capfd.readouterr().err.count('look like degrees throughout') == lines
