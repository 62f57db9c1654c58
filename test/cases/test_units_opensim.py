# SPDX-License-Identifier: Apache-2.0
"""The unit of a .mot and a .sto, as OpenSim reads it, or refused.

What OpenSim reads stands here as OpenSim 4.6 gave it, by `Storage(path).isInDegrees()`; where its
`TimeSeriesTable` or the head itself has another word, the file is refused; so is a .sto without
`version` and `inDegrees`, which Storage takes for radians, and its kin in a .mot for degrees.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bags import NAMES, exit_status, read_csv, refusal_line

FIRST = np.radians([1.0, 2.0, -3.0])
CLOSE = 1e-15  # rad: a rounding of angles below 0.1
TABLE = f'time {" ".join(NAMES)}\n0.0 1.0 2.0 -3.0\n0.01 1.5 2.5 -3.0\n0.02 2.0 3.0 -3.0\n'
SIZE = 'nRows=3\nnColumns=4\n'


DEG, RAD, REFUSED = 'deg', 'rad', 'refused'
V1 = f'swing\nversion=1\n{SIZE}'
V0 = f'swing\n{SIZE}'
BOTH = (  # as OpenSim writes it
    "If the header above contains a line with 'inDegrees', this indicates whether rotational "
    'values are in degrees (yes) or radians (no).\n'
)
HEADS = {  # head: as OpenSim reads a .mot and a .sto, where it is not refused
    V0: (DEG, REFUSED),
    V1: (RAD, RAD),
    V1 + 'inDegrees=yes\n': (DEG, DEG),
    V1 + 'inDegrees=no\n': (RAD, RAD),
    V1 + 'inDegrees=n\n': (RAD, RAD),
    V1 + 'inDegrees=y\n': (DEG, DEG),
    V1 + 'inDegrees=YES\n': (DEG, DEG),
    V1 + 'inDegrees = yes\n': (DEG, DEG),
    V1 + 'inDegrees yes\n': (DEG, DEG),
    V1 + 'inDegrees==yes\n': (DEG, DEG),
    V1 + 'inDegrees=yes\t\t\t\n': (DEG, DEG),
    'inDegrees=yes\nversion=1\n' + SIZE: (DEG, DEG),
    V0 + 'inDegrees=yes\n': (DEG, DEG),
    V0.replace('nRows', 'version=0\nnRows'): (DEG, REFUSED),
    V0.replace('nRows', 'version=one\nnRows'): (DEG, REFUSED),
    V0.replace('nRows', 'Version=1\nnRows'): (DEG, REFUSED),
    V0.replace('nRows', 'version = 1\nnRows'): (RAD, RAD),
    V0.replace('nRows', 'version=1.0\nnRows'): (RAD, RAD),
    V0.replace('nRows', 'version=2\nnRows') + 'inDegrees=yes\n': (DEG, DEG),
    'swing\nDataType=double\nversion=3\nOpenSimVersion=4.1\ninDegrees=yes\n': (DEG, DEG),
    'swing\nDataType=double\nversion=3\n': (RAD, RAD),
    V0 + 'Angles are in degrees.\n': (DEG, DEG),
    V0 + 'Angles are in degrees.\nversion=1\n': (DEG, DEG),
    V1 + 'inDegrees=yes\nAngles are in degrees.\n': (DEG, DEG),
    V1 + 'inDegrees=no\nAngles are in radians.\n': (RAD, RAD),
    V1 + BOTH: (RAD, RAD),
    V1 + 'inDegrees=no\n' + BOTH: (RAD, RAD),
    V1 + 'inDegrees=yes\n' + BOTH: (DEG, DEG),
    V1 + 'inDegrees=no\nmodel with 18 degrees of freedom\n': (RAD, RAD),
    V1 + 'an upgrade of the gradient, at 23 °C\n': (RAD, RAD),
    # a spreadsheet's leftovers, which OpenSim takes for no: the file says yes
    V1 + 'inDegrees=yes,,,,\n': (DEG, DEG),
    V1 + '"inDegrees=yes"\n': (DEG, DEG),
    V1 + 'inDegrees=yes;;\n': (DEG, DEG),
    V1 + 'inDegrees=no,,,\n': (RAD, RAD),
    # Storage goes by inDegrees, the words say the other: refused
    V1 + 'inDegrees=no\nAngles are in degrees.\n': (REFUSED, REFUSED),
    V1 + 'inDegrees=yes\nAngles are in radians.\n': (REFUSED, REFUSED),
    V1 + 'inDegrees=yes\n#angles in rad\n': (REFUSED, REFUSED),
    V1 + 'inDegrees=no\nnote: Winkel in Grad\n': (REFUSED, REFUSED),
    V1 + 'inDegrees=yes\nall in radians\n': (REFUSED, REFUSED),
    # Storage passes these words over, and reads radians: refused
    V1 + 'InDegree=yes\n': (REFUSED, REFUSED),
    V1 + 'DataInDegrees=yes\n': (REFUSED, REFUSED),
    V1 + 'inDegrees: yes\n': (REFUSED, REFUSED),
    V1 + '# inDegrees=yes\n': (REFUSED, REFUSED),
    V1 + 'note: Winkel in Grad\n': (REFUSED, REFUSED),
    # OpenSim's two readers differ, or a reader and the words: refused
    V0 + 'inDegrees=no\n': (REFUSED, RAD),
    V0 + 'Angles are in radians.\n': (REFUSED, RAD),
    V1 + 'inDegrees=true\n': (REFUSED, REFUSED),
    V1 + 'inDegrees=1\n': (REFUSED, REFUSED),
    V1 + 'inDegrees=\n': (REFUSED, REFUSED),
    V1 + 'inDegrees=yes\ninDegrees=no\n': (REFUSED, REFUSED),
    V0 + 'inDegrees=no\nAngles are in degrees.\n': (REFUSED, REFUSED),
}


@pytest.mark.parametrize('ending', [0, 1], ids=['mot', 'sto'])
@pytest.mark.parametrize('head', HEADS)
def test_a_head_is_read_as_opensim_reads_it(tmp_path: Path, head: str, ending: int) -> None:
    source, out = tmp_path / f'in.{("mot", "sto")[ending]}', tmp_path / 'o.csv'
    source.write_text(f'{head}endheader\n{TABLE.replace(" ", chr(9))}')
    want = HEADS[head][ending]
    status = exit_status([str(source), str(out)])
    if want is REFUSED:
        assert status == 1
        assert not out.exists()
        return
    assert status == 0
    facts, names, values = read_csv(out)
    assert facts['read_in'][:3] == want
    angles = FIRST if want is DEG else [1.0, 2.0, -3.0]
    np.testing.assert_allclose(
        values[0, [names.index(f'angles/{name}') for name in NAMES]], angles, rtol=0.0, atol=CLOSE
    )


@pytest.mark.parametrize(
    ('head', 'flag', 'unit'),
    [
        (V1 + 'inDegrees=yes\n', '--radians', ''),
        (V1 + 'inDegrees=no\n', '--degrees', ''),
        (V0, '--radians', ''),
        (V1, '--degrees', 'deg: --degrees'),
        (V0 + 'inDegrees=no\n', '--radians', 'rad: --radians'),
        (V0 + 'inDegrees=no\n', '--degrees', 'deg: --degrees'),
    ],
)
def test_a_flag_settles_what_the_file_does_not_and_contradicts_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], head: str, flag: str, unit: str
) -> None:
    source, out = tmp_path / 'in.mot', tmp_path / 'o.csv'
    source.write_text(f'{head}endheader\n{TABLE}')
    if not unit:
        line = refusal_line(capsys, str(source), str(out), flag)
        assert flag in line
        assert 'inDegrees' in line or 'version=' in line
        return
    assert exit_status([str(source), str(out), flag]) == 0
    assert read_csv(out)[0]['read_in'] == unit


@pytest.mark.parametrize(
    ('head', 'one', 'other'),
    [
        ('inDegrees=no\nAngles are in degrees.\n', "'Angles are in degrees.'", 'inDegrees in'),
        ('inDegrees=yes\nAngles are in radians.\n', 'inDegrees in', "'Angles are in radians.'"),
        ('inDegrees=yes\n#angles in rad\n', 'inDegrees in', "'#angles in rad'"),
        ('inDegrees=no\nangoli in gradi\n', "'angoli in gradi' in line 6", 'inDegrees in'),
    ],
)
def test_a_flag_settles_a_head_that_contradicts_itself(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], head: str, one: str, other: str
) -> None:
    source, out = tmp_path / 'in.sto', tmp_path / 'o.csv'
    source.write_text(f'{V1}{head}endheader\n{TABLE}')
    line = refusal_line(capsys, str(source), str(out))
    assert f'degrees by {one}' in line
    assert f'but radians by {other}' in line
    assert '--degrees or --radians settles it' in line
    for flag in ('degrees', 'radians'):
        assert exit_status([str(source), str(out), f'--{flag}', '--force']) == 0
        assert read_csv(out)[0]['read_in'] == f'{flag[:3]}: --{flag}'


def test_a_sto_without_version_and_unit_is_refused_unless_a_flag_or_its_names_say_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, out = tmp_path / 'in.sto', tmp_path / 'o.csv'
    source.write_text(f'{V0}endheader\n{TABLE}')
    line = refusal_line(capsys, str(source), str(out))
    assert 'without version= and inDegrees' in line
    assert '--degrees or --radians settles it' in line
    assert exit_status([str(source), str(out), '--degrees']) == 0
    source.write_text(f'{V0}endheader\n{TABLE.replace("ion", "ion_rad")}')
    assert exit_status([str(source), str(out), '--force']) == 0
    assert read_csv(out)[0]['read_in'] == 'rad: the names of the columns'


def test_names_against_the_head_are_refused_with_both(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.mot'
    source.write_text(f'{V1}inDegrees=no\nendheader\n{TABLE.replace("ion ", "ion_deg ")}')
    source.write_text(source.read_text().replace('rotation\n', 'rotation_deg\n'))
    line = refusal_line(capsys, str(source), str(tmp_path / 'o.csv'))
    assert 'degrees by the names of the columns, but radians by inDegrees in the file' in line
