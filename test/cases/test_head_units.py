# SPDX-License-Identifier: Apache-2.0
"""The unit of a CSV, as the comments above its names say it, or refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bags import NAMES, exit_status, read_csv, refusal_line

ROWS = 'time,flexion,abduction,rotation\n0.0,1.0,2.0,-3.0\n0.01,1.5,2.5,-3.0\n'
DEGREES = [
    'en degrés', 'en degre\u0301s', 'EN DEGRÉS', 'grados', 'Winkel in Grad', 'in Graden', 'gradi',
    'unità: gradi', 'em graus', 'um grau', 'un grado', 'degré', 'degree', 'all in deg',
    'InDegree=yes', 'DataInDegrees=yes', 'dataindegrees=1', 'inDegrees: yes', 'in_degrees=yes',
    'all (°), 3 of them', 'x' * 400 + ' degrees',
]  # fmt: skip
NO_DEGREES = [
    'a model with 7 degrees of freedom', '7 degrees-of-freedom', 'degrés de liberté',
    '3 gradi di libertà', 'grados de libertad', 'graus de liberdade', 'Freiheitsgrade',
    'Freiheitsgrad', 'an upgrade',
    'gradient', 'graduated', 'upgraded', 'degraded', 'Gradient', 'at 23 °C', '23 degrees Celsius',
    'sujeto nº 3', 'convert with deg2rad', 'all in rad',
]  # fmt: skip


def write_table(folder: Path, head: str, name: str = 'in.csv') -> tuple[str, str]:
    """Write a table with this head; return its path, and that of an output beside it."""
    (folder / name).write_text(f'{head}{ROWS}', encoding='utf-8')
    return str(folder / name), str(folder / 'o.csv')


@pytest.mark.parametrize(
    ('word', 'unit'),
    [
        ('inDegrees=yes', 'deg'), ('inDegrees=y', 'deg'), ('inDegrees = YES', 'deg'),
        ('inDegrees yes', 'deg'), ('inDegrees==yes', 'deg'), ('InDegrees=Yes,,,', 'deg'),
        ('"inDegrees=yes"', 'deg'), ('inDegrees=yes;;', 'deg'), ('inDegrees\tyes', 'deg'),
        ('inDegrees=no', 'rad'), ('inDegrees = N', 'rad'), ('inDegrees no,,', 'rad'),
    ],
)  # fmt: skip
@pytest.mark.parametrize('mark', ['# ', '#', '## '])
def test_in_degrees_in_a_comment_is_obeyed(tmp_path: Path, word: str, unit: str, mark: str) -> None:
    source, out = write_table(tmp_path, f'# swing\n{mark}{word}\n')
    assert exit_status([source, out]) == 0
    facts, names, values = read_csv(Path(out))
    assert facts['read_in'] == f'{unit}: inDegrees in the file'
    angles = np.array([1.0, 2.0, -3.0])
    np.testing.assert_allclose(
        values[0, [names.index(f'angles/{name}') for name in NAMES]],
        np.radians(angles) if unit == 'deg' else angles,
        rtol=0.0,
        atol=1e-15,  # a rounding
    )


@pytest.mark.parametrize('word', DEGREES)
def test_a_comment_on_degrees_in_other_words_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], word: str
) -> None:
    source, out = write_table(tmp_path, f'# swing\n# {word}\n')
    line = refusal_line(capsys, source, out)
    assert 'in line 2: are the angles in degrees? --degrees or --radians settles it' in line
    assert exit_status([source, out, '--radians']) == 0


@pytest.mark.parametrize('word', NO_DEGREES)
def test_degrees_of_others_are_no_unit_of_angles(tmp_path: Path, word: str) -> None:
    source, out = write_table(tmp_path, f'# {word}\n')
    assert exit_status([source, out]) == 0
    assert read_csv(Path(out))[0]['read_in'] == 'rad: nothing says otherwise'


@pytest.mark.parametrize('value', ['=true', '=1', '='])
def test_in_degrees_of_no_value_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], value: str
) -> None:
    source, out = write_table(tmp_path, f'# inDegrees{value}\n')
    assert 'in.csv:1: inDegrees is' in refusal_line(capsys, source, out)


@pytest.mark.parametrize(
    'head',
    ['# inDegrees=no\n# en degrés\n', '# angles in rad\n# inDegrees=yes\n', '# rad\n# gradi\n'],
)
def test_comments_that_contradict_each_other_are_refused(tmp_path: Path, head: str) -> None:
    source, out = write_table(tmp_path, head)
    assert exit_status([source, out]) == 1
    assert exit_status([source, out, '--degrees']) == 0


def test_a_csv_is_no_motion_of_simm_whatever_its_name(tmp_path: Path) -> None:
    source, out = write_table(tmp_path, '', 'swing.mot.csv')
    assert exit_status([source, out]) == 0
    assert read_csv(Path(out))[0]['read_in'] == 'rad: nothing says otherwise'
