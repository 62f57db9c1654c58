# SPDX-License-Identifier: Apache-2.0
"""Tables of measurements: what they say, how they are read, and what is wrong with them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.fit.data import read_data
from linkedplane_ros.fit.measurements import Data

DELTOID = BroadMuscle.load('deltoid')
ACKLAND = Path(__file__).parents[3] / 'shared/literature/ackland2008_deltoid_moment_arms.csv'
BY_MOTION = 'motion,angle_deg,band,length_mm,moment_arm_mm,weight\n'
ROUNDING = 1e-15


def data(folder: Path, text: str, **options: object) -> Data:
    path = folder / 'data.csv'
    path.write_text(text, encoding='utf-8')
    return read_data(path, DELTOID, **options)  # type: ignore[arg-type]


def fault(folder: Path, text: str, **options: object) -> str:
    """Return what is said of a table, in one line, after its path."""
    with pytest.raises(RecordingError) as caught:
        data(folder, text, **options)
    (line,) = str(caught.value).splitlines()
    assert line.startswith(str(folder / 'data.csv'))
    return line.removeprefix(str(folder / 'data.csv'))


def test_a_row_by_motion_is_a_turn_about_an_axis_of_the_scapula(tmp_path: Path) -> None:
    (row,) = data(tmp_path, BY_MOTION + 'abduction,30,middle,140.5,20.1,2\n').measurements
    assert (row.part, row.motion, row.weight) == ('middle', 'abduction', 2.0)
    assert DELTOID.band_names[row.band] == 'middle_1'  # what represents the head
    assert (row.length, row.arm) == pytest.approx((0.1405, 0.0201), rel=ROUNDING)
    rotation, axis = row.pose()
    np.testing.assert_array_equal(axis, (0.0, -1.0, 0.0))
    convention = JOINT_CONVENTIONS['flexion_abduction_rotation']
    np.testing.assert_allclose(
        rotation, convention.rotation((0.0, math.radians(30.0), 0.0)), atol=ROUNDING
    )


def test_a_row_by_angles_is_a_pose_of_the_convention(tmp_path: Path) -> None:
    text = (
        'plane_of_elevation_deg,elevation_rad,axial_rotation_deg,about,head,moment_arm_m\n'
        '10,0.5,-20,elevation,posterior_3,-0.02\n'
    )
    (row,) = data(tmp_path, text, convention='isb_yxy').measurements
    assert DELTOID.band_names[row.band] == 'posterior_3'
    assert math.isnan(row.length)
    assert row.angle == 0.5
    convention = JOINT_CONVENTIONS['isb_yxy']
    angles = (math.radians(10.0), 0.5, math.radians(-20.0))
    rotation, axis = row.pose()
    np.testing.assert_array_equal(rotation, convention.rotation(angles))
    np.testing.assert_array_equal(axis, convention.axes(angles)[:, 1])


def test_an_empty_cell_was_not_measured(tmp_path: Path) -> None:
    rows = data(tmp_path, BY_MOTION + 'flexion,0,anterior,150,,1\nflexion,10,anterior,,9,1\n')
    assert [math.isnan(row.arm) for row in rows.measurements] == [True, False]
    assert [math.isnan(row.length) for row in rows.measurements] == [False, True]


def test_a_curve_is_taken_at_the_steps_within_it_after_its_angles_are_scaled(
    tmp_path: Path,
) -> None:
    text = 'motion,angle_deg,head,moment_arm_mm\nflexion,60,middle,30\nflexion,3,middle,1.5\n'
    found = data(tmp_path, text, angle_scale=0.5, step=math.radians(10.0))
    assert [math.degrees(row.angle) for row in found.measurements] == pytest.approx([10, 20, 30])
    assert [1e3 * row.arm for row in found.measurements] == pytest.approx([10, 20, 30])
    assert found.reading == 'angles times 0.5, every 10 deg'


def test_the_measurements_of_the_literature_are_read_as_they_are() -> None:
    if not ACKLAND.is_file():
        pytest.skip(f'{ACKLAND} is not here')
    found = read_data(ACKLAND, DELTOID, step=math.radians(10.0))
    assert len(found.measurements) == 66  # 3 heads, 2 motions, 10 to 110 deg
    assert {row.motion for row in found.measurements} == {'flexion', 'abduction'}


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', ':1: empty; a header and rows of numbers expected'),
        ('a,b\n', ":1: a column 'motion' (with angle_deg) or 'about'"),
        ('motion,angle_deg,band\n', ':1: a column length_mm or moment_arm_mm expected'),
        ('motion,angle,band,length_mm\n', ':1: one column angle_deg or angle_rad expected'),
        ('motion,angle_deg,length_mm\n', ":1: 0 columns are named 'band'; one expected"),
        ('motion,angle_deg,band,length_mm,lenght_mm\n', ":1: unknown column 'lenght_mm'"),
        (BY_MOTION, ':1: no rows of measurements after the names'),
        (BY_MOTION + 'yaw,1,middle,150,,1\n', ":2: column 'motion': 'yaw'; one of flexion,"),
        ('# Source\n' + BY_MOTION + 'flexion,1,\n', ':3: 3 cells; 6 expected'),
        (BY_MOTION + 'flexion,1,back,150,,1\n', ":2: 'back' is neither a head of deltoid"),
        (BY_MOTION + 'flexion,1,middle,150,,\n', ':2: a weight of nan; 0 or more expected'),
        (BY_MOTION + 'flexion,,middle,150,,1\n', ':2: an angle is missing or not finite'),
        (BY_MOTION + 'flexion,x,middle,150,,1\n', ":2: column 'angle_deg': 'x' is not a number"),
        (BY_MOTION + 'flexion,1,middle,,,1\n', ':2: neither a length nor a moment arm'),
        (BY_MOTION + 'flexion,1,middle,0.15,,1,2\n', ':2: 7 cells; 6 expected'),
        (BY_MOTION + 'flexion,1,middle,-150,,1\n', ':2: a length of -0.15 m; above 0 expected'),
        (BY_MOTION + 'flexion,500,middle,150,,1\n', ':2: an angle of more than a full turn'),
        (
            'motion,angle_deg,band,length_m\nflexion,1,middle,150\n',
            ':2: a length of 150 m; in mm, or in m?',
        ),
    ],
)
def test_what_is_wrong_with_a_table_is_told_in_one_line(
    tmp_path: Path, text: str, said: str
) -> None:
    assert fault(tmp_path, text).startswith(said)


def test_a_step_that_no_curve_reaches_is_a_fault(tmp_path: Path) -> None:
    text = BY_MOTION + 'flexion,1,middle,150,,1\nflexion,9,middle,150,,1\n'
    said = ': flexion, middle: no multiple of 10 deg between 1 and 9 deg'
    assert fault(tmp_path, text, step=math.radians(10.0)) == said


def test_lengths_and_moment_arms_are_each_stepped_between_their_own_rows(tmp_path: Path) -> None:
    rows = ('0,,20', '2,150,', '18,134,', '25,,45')
    text = BY_MOTION + ''.join(
        f'flexion,{q},middle,{v},1\n' for q, v in (r.split(',', 1) for r in rows)
    )
    found = data(tmp_path, text, step=math.radians(10.0)).measurements
    assert [round(math.degrees(row.angle)) for row in found] == [0, 10, 20]
    assert [1e3 * row.length for row in found] == pytest.approx(
        [math.nan, 142.0, math.nan], nan_ok=True
    )
    assert [1e3 * row.arm for row in found] == pytest.approx([20.0, 30.0, 40.0])


def test_of_two_rows_at_an_angle_no_curve_is_made(tmp_path: Path) -> None:
    text = BY_MOTION + 'flexion,0,middle,,20,1\nflexion,20,middle,,24,1\nflexion,0,middle,,40,1\n'
    assert len(data(tmp_path, text).measurements) == 3
    said = ': flexion, middle: two rows at 0 deg, one expected of a curve that is taken at steps'
    assert fault(tmp_path, text, step=math.radians(10.0)) == said


@pytest.mark.parametrize('how', [{'step': math.radians(10.0)}, {'angle_scale': 0.5}])
def test_poses_are_neither_scaled_nor_stepped(tmp_path: Path, how: dict[str, float]) -> None:
    text = (
        'about,flexion_deg,abduction_deg,rotation_deg,band,moment_arm_mm\nflexion,10,0,0,middle,5\n'
    )
    said = ': has poses; only angles of a motion are scaled or stepped'
    assert fault(tmp_path, text, **how) == said
    assert data(tmp_path, text).reading == 'angles in flexion_abduction_rotation'
