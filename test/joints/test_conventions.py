"""Joint conventions: the interface's table, its axes, its inverse and its anatomical meaning."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS
from linkedplane_ros.joints.conventions import sine_of_singularity

EXACT = 1e-12  # entries of a rotation matrix: rounding of a few products
ELEVATING = ('isb_yxy', 'opensim_tsm', 'opensim_mobl', 'rep155')
NAMES = ('flexion_abduction_rotation', *ELEVATING)
TSM_AXIAL = np.array([-0.0584, -0.0846, 0.9947])
LATERAL, ANTERIOR, SUPERIOR = np.eye(3)
HANGING = -SUPERIOR  # the humerus, from the shoulder to the elbow


def about(axis: Array, angle: float) -> Array:
    return Rotation.from_rotvec(angle * np.asarray(axis) / np.linalg.norm(axis)).as_matrix()


def by_the_table(name: str, angles: Array) -> Array:
    """Return the rotation as the table of the interface writes it."""
    q1, q2, q3 = angles
    X, Y, Z = np.eye(3)
    return {
        'flexion_abduction_rotation': about(X, q1) @ about(-Y, q2) @ about(Z, q3),
        'isb_yxy': about(Z, q1) @ about(-Y, q2) @ about(Z, q3),
        'opensim_tsm': about(Z, q1) @ about(-Y, q2) @ about(TSM_AXIAL, q3),
        'opensim_mobl': about(Z, q1) @ about(-Y, q2) @ about(Z, q3 - q1),
        'rep155': about(Z, q1) @ about(-Y, q2) @ about(Z, -q3),
    }[name]


def random_angles(count: int, seed: int) -> Array:
    """Return angles (count, 3) with the second one where every convention answers it: 0..90 deg."""
    rng = np.random.default_rng(seed)
    return rng.uniform([-3.1, 0.1, -3.1], [3.1, 1.5, 3.1], (count, 3))


ANGLES = random_angles(200, seed=5)
angle = st.floats(-10.0, 10.0, allow_subnormal=False)


def same_turn(one: Array, other: Array) -> bool:
    return bool(np.abs(np.mod(one - other + np.pi, 2.0 * np.pi) - np.pi).max() < 1e-9)


def test_the_conventions_are_those_of_the_interface() -> None:
    coordinates = {name: convention.coordinates for name, convention in JOINT_CONVENTIONS.items()}
    assert coordinates == {
        'flexion_abduction_rotation': ('flexion', 'abduction', 'rotation'),
        'isb_yxy': ('plane_of_elevation', 'elevation', 'axial_rotation'),
        'opensim_tsm': ('plane_elv', 'shoulder_elv', 'axial_rot'),
        'opensim_mobl': ('elv_angle', 'shoulder_elv', 'shoulder_rot'),
        'rep155': ('y_shoulder', 'p_shoulder', 'r_shoulder'),
    }


@pytest.mark.parametrize('name', NAMES)
def test_a_rotation_is_the_one_of_the_table(name: str) -> None:
    for angles in ANGLES:
        found = JOINT_CONVENTIONS[name].rotation(angles)
        np.testing.assert_allclose(found, by_the_table(name, angles), atol=EXACT)


@pytest.mark.parametrize(
    ('name', 'sequence', 'signs'),
    [
        ('flexion_abduction_rotation', 'XYZ', (1, -1, 1)),
        ('isb_yxy', 'ZYZ', (1, -1, 1)),
        ('rep155', 'ZYZ', (1, -1, -1)),
    ],
)
def test_a_rotation_is_scipys_intrinsic_one(
    name: str, sequence: str, signs: tuple[int, int, int]
) -> None:
    found = [JOINT_CONVENTIONS[name].rotation(angles) for angles in ANGLES]
    scipys = Rotation.from_euler(sequence, ANGLES * signs).as_matrix()
    np.testing.assert_allclose(found, scipys, atol=EXACT)


@pytest.mark.parametrize('name', NAMES)
def test_axes_are_those_about_which_the_coordinates_turn_the_humerus(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    h = 1e-4  # rad
    for angles in ANGLES[:50]:
        axes = convention.axes(angles)
        for j, step in enumerate(h * np.eye(3)):
            one = by_the_table(name, angles + step) @ by_the_table(name, angles - step).T
            omega = Rotation.from_matrix(one).as_rotvec() / (2.0 * h)
            np.testing.assert_allclose(axes[:, j], omega, atol=1e-8)  # h^2 and rounding over h


def test_axes_are_unit_vectors_but_where_a_coordinate_enters_two_turns() -> None:
    for name in NAMES:
        sizes = np.linalg.norm(JOINT_CONVENTIONS[name].axes(ANGLES[0]), axis=0)
        np.testing.assert_allclose(sizes[1:], 1.0, atol=EXACT)
        assert (abs(sizes[0] - 1.0) < EXACT) == (name != 'opensim_mobl')


@pytest.mark.parametrize('name', NAMES)
def test_axes_of_the_left_are_mirrored_as_axes_of_rotation_are(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    mirror = np.diag([-1.0, 1.0, 1.0])
    h = 1e-4
    for angles in ANGLES[:10]:
        axes = convention.axes(angles, side='left')
        for j, step in enumerate(h * np.eye(3)):
            after, before = (
                mirror @ by_the_table(name, angles + s) @ mirror for s in (step, -step)
            )
            omega = Rotation.from_matrix(after @ before.T).as_rotvec() / (2.0 * h)
            np.testing.assert_allclose(axes[:, j], omega, atol=1e-8)


@pytest.mark.parametrize('name', NAMES)
def test_angles_are_the_inverse_of_the_rotation(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    for angles in ANGLES:
        if name == 'opensim_tsm' and angles[1] < 0.2:
            continue  # near the arm at the side either of two triples may be answered
        found = convention.angles(convention.rotation(angles))
        assert same_turn(found, angles), angles


@pytest.mark.parametrize('name', [name for name in NAMES if name != 'opensim_tsm'])
@settings(deadline=None, max_examples=150, derandomize=True)
@given(angles=st.tuples(angle, angle, angle))
@example(angles=(0.0, 0.0, 0.0))
@example(angles=(0.0, np.pi, 0.0))
@example(angles=(0.0, np.pi / 2.0, 0.0))
@example(angles=(np.pi, np.pi, np.pi))
def test_any_angles_rotation_has_angles_that_give_it_back(
    name: str, angles: tuple[float, float, float]
) -> None:
    convention = JOINT_CONVENTIONS[name]
    R = convention.rotation(angles)
    found = convention.angles(R)
    np.testing.assert_allclose(convention.rotation(found), R, atol=EXACT)


@settings(deadline=None, max_examples=150, derandomize=True)
@given(angles=st.tuples(angle, angle, angle))
@example(angles=(0.0, 0.0, 0.0))
@example(angles=(0.0, np.pi, 0.0))
@example(angles=(0.5, 1e-9, 0.5))
def test_any_opensim_tsm_angles_rotation_has_angles_that_give_it_back(
    angles: tuple[float, float, float],
) -> None:
    convention = JOINT_CONVENTIONS['opensim_tsm']
    R = convention.rotation(angles)
    found = convention.angles(R)
    np.testing.assert_allclose(convention.rotation(found), R, atol=EXACT)


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize('near', [0.0, 1e-3, 1e-6, 1e-8, 2e-9, 1e-9, 5e-10, 1e-12, 1e-15, 1e-300])
def test_a_rotation_near_the_singularity_comes_back(name: str, near: float) -> None:
    convention = JOINT_CONVENTIONS[name]
    singular = (0.0, np.pi) if name in ELEVATING else (np.pi / 2.0, -np.pi / 2.0)
    for second in (*(s + near for s in singular), *(s - near for s in singular)):
        for first, third in ((0.4, -1.1), (-2.5, 0.0), (3.0, 3.0)):
            R = convention.rotation([first, second, third])
            found = convention.angles(R)
            np.testing.assert_allclose(convention.rotation(found), R, atol=EXACT)


@pytest.mark.parametrize('name', ELEVATING)
def test_the_elevation_answered_is_not_negative(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    for angles in ANGLES * [1.0, -1.0, 1.0]:  # elevations -6 to -86 deg
        if name == 'opensim_tsm' and angles[1] > -0.2:
            continue  # some of these have no angles of an elevation >= 0
        found = convention.angles(convention.rotation(angles))
        assert 0.0 <= found[1] <= np.pi
        np.testing.assert_allclose(
            convention.rotation(found), convention.rotation(angles), atol=EXACT
        )


@pytest.mark.parametrize('name', [name for name in ELEVATING if name != 'opensim_tsm'])
@pytest.mark.parametrize('elevation', [0.0, 1e-12, -1e-12, np.pi, np.pi - 1e-12, np.pi + 1e-12])
def test_nor_is_it_negative_with_the_arm_at_the_side_or_overhead(
    name: str, elevation: float
) -> None:
    convention = JOINT_CONVENTIONS[name]
    for first, third in ((0.0, 0.0), (0.4, -1.1), (3.0, 3.0)):
        found = convention.angles(convention.rotation([first, elevation, third]))
        assert 0.0 <= found[1] <= np.pi
        assert found[1] == pytest.approx(elevation, abs=1e-11)


def test_abduction_is_answered_within_a_quarter_turn() -> None:
    convention = JOINT_CONVENTIONS['flexion_abduction_rotation']
    found = convention.angles(convention.rotation([0.2, 2.0, 0.3]))
    assert abs(found[1]) <= np.pi / 2.0


def test_scipys_other_branch_is_the_same_rotation() -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    for angles in ANGLES[:50]:
        R = convention.rotation(angles)
        p, e, r = Rotation.from_matrix(R).as_euler('ZYZ') * [1, -1, 1]
        assert e <= 0.0  # SciPy's middle angle is about +y and not negative
        np.testing.assert_allclose(convention.rotation([p, e, r]), R, atol=EXACT)
        assert same_turn(convention.angles(R), np.array([p + np.pi, -e, r - np.pi]))


def test_a_rotation_out_of_the_reach_of_opensim_tsm_is_told() -> None:
    # its axial axis leans 4.8 deg off the plane of the others: the arm cannot hang along z
    convention = JOINT_CONVENTIONS['opensim_tsm']
    lean = np.arcsin(0.0846 / np.linalg.norm(TSM_AXIAL))
    with pytest.raises(ValueError, match='opensim_tsm'):
        convention.angles(about(-TSM_AXIAL - SUPERIOR, np.pi))
    reached = convention.rotation([0.3, 0.0, 0.1])
    assert np.arccos(reached[2] @ TSM_AXIAL / np.linalg.norm(TSM_AXIAL)) >= lean


def test_flexion_lifts_the_arm_forward() -> None:
    R = JOINT_CONVENTIONS['flexion_abduction_rotation'].rotation([np.pi / 2, 0.0, 0.0])
    np.testing.assert_allclose(R @ HANGING, ANTERIOR, atol=EXACT)


def test_abduction_lifts_the_arm_sideways() -> None:
    R = JOINT_CONVENTIONS['flexion_abduction_rotation'].rotation([0.0, np.pi / 2, 0.0])
    np.testing.assert_allclose(R @ HANGING, LATERAL, atol=EXACT)


def test_positive_axial_rotation_is_internal() -> None:
    for name in ('flexion_abduction_rotation', 'isb_yxy', 'opensim_mobl', 'opensim_tsm'):
        R = JOINT_CONVENTIONS[name].rotation([0.0, 0.0, 0.2])
        assert (R @ LATERAL) @ ANTERIOR > 0.1, name
    R = JOINT_CONVENTIONS['rep155'].rotation([0.0, 0.0, 0.2])
    assert (R @ LATERAL) @ ANTERIOR < -0.1  # REP 155 counts the roll the other way


@pytest.mark.parametrize('name', ELEVATING)
def test_elevation_lifts_the_arm_into_its_plane(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    for plane, towards in ((0.0, LATERAL), (np.pi / 2, ANTERIOR), (-np.pi / 2, -ANTERIOR)):
        R = convention.rotation([plane, np.pi / 2, 0.0])
        np.testing.assert_allclose(R @ HANGING, towards, atol=EXACT)
    np.testing.assert_allclose(
        convention.rotation([0.3, np.pi, 0.0]) @ HANGING, SUPERIOR, atol=EXACT
    )


def test_the_plane_of_mobl_leaves_the_hanging_arm_alone() -> None:
    R = JOINT_CONVENTIONS['opensim_mobl'].rotation([0.7, 0.0, 0.0])
    np.testing.assert_allclose(R, np.eye(3), atol=EXACT)


def test_the_sine_of_singularity_is_zero_where_two_axes_are_one() -> None:
    for name in ELEVATING:
        convention = JOINT_CONVENTIONS[name]
        at_side = sine_of_singularity(convention.axes([0.3, 0.0, 0.2]))
        assert at_side < (0.11 if name == 'opensim_tsm' else EXACT)
        axes = convention.axes([0.3, 1.0, 0.2])
        third = axes[:, 2]
        expected = np.linalg.norm(np.cross(SUPERIOR, third))
        for side in ('right', 'left'):
            found = sine_of_singularity(convention.axes([0.3, 1.0, 0.2], side))
            assert found == pytest.approx(expected, abs=EXACT)


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize(
    'angles', [[0.0, 0.0], [[0.0, 0.0, 0.0]], 0.0, [0.0, np.nan, 0.0], [0.0, np.inf, 0.0], 'abc']
)
def test_wrong_angles_are_refused(name: str, angles: object) -> None:
    convention = JOINT_CONVENTIONS[name]
    for use in (convention.rotation, convention.axes):
        with pytest.raises(ValueError, match=r'angles: .*3 finite numbers in rad expected'):
            use(angles)


@pytest.mark.parametrize(
    'rotation', [np.eye(2), np.eye(4), np.zeros(3), np.full((3, 3), np.nan), np.eye(3)[np.newaxis]]
)
def test_a_rotation_of_another_shape_is_refused(rotation: Array) -> None:
    for name in NAMES:
        with pytest.raises(ValueError, match=r'rotation: .*\(3, 3\)'):
            JOINT_CONVENTIONS[name].angles(rotation)


@pytest.mark.parametrize(
    'rotation', [np.zeros((3, 3)), 2.0 * np.eye(3), np.diag([1.0, 1.0, -1.0])],
    ids=['zero', 'scaled', 'reflection'],
)  # fmt: skip
def test_a_matrix_that_is_no_rotation_has_no_angles(rotation: Array) -> None:
    for name in NAMES:
        with pytest.raises(ValueError, match='rotation'):
            JOINT_CONVENTIONS[name].angles(rotation)


def test_an_unknown_side_is_refused() -> None:
    with pytest.raises(ValueError, match="side: 'up' given, 'right' or 'left' expected"):
        JOINT_CONVENTIONS['isb_yxy'].axes([0.0, 0.0, 0.0], side='up')


@pytest.mark.parametrize(
    ('recording', 'name'),
    [
        ('abduction', 'opensim_tsm'),
        ('flexion', 'opensim_tsm'),
        ('daily_motion', 'isb_yxy'),
    ],
)
def test_recorded_motion_comes_back(recording: str, name: str, shared: Path) -> None:
    with (shared / 'recordings' / f'{recording}.csv').open(newline='') as file:
        rows = [[float(cell) for cell in row] for row in list(csv.reader(file))[1:]]
    samples = np.array(rows)[:, 1:]
    convention = JOINT_CONVENTIONS[name]
    for angles in samples[:: max(1, len(samples) // 500)]:
        R = convention.rotation(angles)
        found = convention.angles(R)
        np.testing.assert_allclose(convention.rotation(found), R, atol=EXACT)
        if sine_of_singularity(convention.axes(angles)) > 0.2:
            assert same_turn(found, angles)
