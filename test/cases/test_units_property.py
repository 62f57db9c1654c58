# SPDX-License-Identifier: Apache-2.0
"""Any table, written in any dialect and unit, is read as the same radians, or refused.

The tables are written here, and the radians are NumPy's.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from unhurried import unhurried

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.joints.joint_state import JointMap
from linkedplane_ros.recordings.table_motion import TableMotion

NAMES = ('flexion', 'abduction', 'rotation')
CLOSE = 1e-12  # rad: degrees are written with 17 digits, turned and turned back

degree_names = st.sampled_from(
    ['{}_deg', '{} (deg)', '{} [deg]', '{} (°)', '{}[°]', '{}_degrees', '{}/deg', '{}_DEG', '{}Deg']
)
radian_names = st.sampled_from(['{}_rad', '{} (rad)', '{} [radians]', '{}_RAD', '{} rad', '{}Rad'])
plain_names = st.just('{}')
yes = st.sampled_from(['inDegrees=yes', 'inDegrees = Yes', 'inDegrees\ty', 'inDegrees=YES\t\t'])
no = st.sampled_from(['inDegrees=no', 'inDegrees = No', 'inDegrees\tn', 'inDegrees=NO\t\t'])
prose = st.lists(
    st.sampled_from(['swing', '', 'nRows=3', 'nColumns=4', 'Units are S.I. units (second, ...)']),
    max_size=4,
)
angles = st.lists(
    st.tuples(*(st.floats(-6.2, 6.2, allow_subnormal=False),) * 3), min_size=1, max_size=12
)


@st.composite
def tables(draw: st.DrawFn) -> tuple[str, str, bool, bool]:
    """Return a file's ending, what stands above its rows, its cells' delimiter and its unit.

    The unit is degrees, radians; and whether the file says it.
    """
    degrees, said = draw(st.booleans()), draw(st.booleans())
    names = draw((degree_names if degrees else radian_names) if said else plain_names)
    if draw(st.booleans()):
        delimiter = draw(st.sampled_from(',;\t'))
        head = ''.join(f'# {line}\n' for line in draw(prose))
        columns = delimiter.join(f'"{names.format(name)}"' for name in NAMES)
        return '.csv', f'{head}time{delimiter}{columns}\n', degrees, said
    head = ['version=1', *draw(prose)]
    if said or draw(st.booleans()):
        said = True
        head.append(draw(yes if degrees else no))
    lines = [*draw(st.permutations(head)), 'endheader', '\t'.join(('time', *NAMES))]
    return draw(st.sampled_from(['.mot', '.sto'])), '\n'.join(lines) + '\n', degrees, said


@unhurried
@given(tables(), angles, st.sampled_from([None, True, False]))
def test_a_table_is_read_as_its_radians_or_refused(
    table: tuple[str, str, bool, bool],
    motion: list[tuple[float, float, float]],
    flag: bool | None,
) -> None:
    ending, head, degrees, said = table
    radians = np.array(motion)
    cells = np.degrees(radians) if degrees else radians
    # what neither the file nor a flag says, and no range can tell, is nobody's fault
    assume(said or flag is not None or not degrees or np.abs(cells).max() > 2.0 * np.pi)
    assume(said or flag is None or flag == degrees)  # a user who says the wrong unit
    delimiter = next((each for each in ';,' if f'time{each}' in head), '\t')
    rows = [delimiter.join(map(repr, (0.01 * k, *row))) for k, row in enumerate(cells.tolist())]
    with TemporaryDirectory() as folder:
        source = Path(folder) / f'in{ending}'
        source.write_text(head + '\n'.join(rows) + '\n', encoding='utf-8')
        joints = JointMap(NAMES, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
        try:
            motion_read = TableMotion(source, joints, flag)
            chunks = list(motion_read.chunks())
        except RecordingError:
            assert not said or flag == (not degrees)  # never what is said, and nobody contradicts
            assert flag != degrees
            assert flag is not None or np.abs(cells).max() > 2.0 * np.pi
            return
    read = np.concatenate([chunk.angles for chunk in chunks])
    np.testing.assert_allclose(read, radians, rtol=0.0, atol=CLOSE)
