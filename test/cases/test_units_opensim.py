# SPDX-License-Identifier: Apache-2.0
"""The unit of a .mot and a .sto, as OpenSim reads it, or refused.

What OpenSim reads stands here as OpenSim 4.6 gave it, by `Storage(path).isInDegrees()`; where its
`TimeSeriesTable` has another word in the head, the file is refused.
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
HEADS = {  # head: as OpenSim reads a .mot and a .sto, where it is not refused
    V0: (DEG, RAD),
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
    V0.replace('nRows', 'version=0\nnRows'): (DEG, RAD),
    V0.replace('nRows', 'version=one\nnRows'): (DEG, RAD),
    V0.replace('nRows', 'Version=1\nnRows'): (DEG, RAD),
    V0.replace('nRows', 'version = 1\nnRows'): (RAD, RAD),
    V0.replace('nRows', 'version=1.0\nnRows'): (RAD, RAD),
    V0.replace('nRows', 'version=2\nnRows') + 'inDegrees=yes\n': (DEG, DEG),
    'swing\nDataType=double\nversion=3\nOpenSimVersion=4.1\ninDegrees=yes\n': (DEG, DEG),
    'swing\nDataType=double\nversion=3\n': (RAD, RAD),
    V0 + 'Angles are in degrees.\n': (DEG, DEG),
    V0 + 'Angles are in degrees.\nversion=1\n': (DEG, DEG),
    # files in OpenSim's own repository have both: version and inDegrees count
    V1 + 'inDegrees=no\nAngles are in degrees.\n': (RAD, RAD),
    # a spreadsheet's leftovers, which OpenSim takes for no: the file says yes
    V1 + 'inDegrees=yes,,,,\n': (DEG, DEG),
    V1 + '"inDegrees=yes"\n': (DEG, DEG),
    V1 + 'inDegrees=yes;;\n': (DEG, DEG),
    V1 + 'inDegrees=no,,,\n': (RAD, RAD),
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


def test_names_against_the_head_are_refused_with_both(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.mot'
    source.write_text(f'{V1}inDegrees=no\nendheader\n{TABLE.replace("ion ", "ion_deg ")}')
    source.write_text(source.read_text().replace('rotation\n', 'rotation_deg\n'))
    line = refusal_line(capsys, str(source), str(tmp_path / 'o.csv'))
    assert 'degrees by the names of the columns, but radians by inDegrees in the file' in line
