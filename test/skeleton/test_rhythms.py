# SPDX-License-Identifier: Apache-2.0
"""Rhythms of the girdle: by SciPy's rotations, by differences, and on real motion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from girdle_recordings import RECORDINGS, girdle_poses
from optional import requires
from reference import Array
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneError, LinkedPlaneSolver, Skeleton
from linkedplane_ros.joints.conventions import JOINT_CONVENTIONS
from linkedplane_ros.skeleton.girdle import Rest
from linkedplane_ros.skeleton.rhythm import LinearRhythm, Rhythm
from linkedplane_ros.skeleton.rhythms import RHYTHMS, rhythm_from

DELFT = np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))  # of the model's axes
MEAN_SCAPULA, MEAN_CLAVICLE = (32.047376, 10.669100, -10.320259), (-28.573324, 11.679804, 7.4820950)
REST = Rest((0.4, -0.1, -0.2), (-0.6, 0.1, 0.05), (-0.3, 0.25))
ISB = JOINT_CONVENTIONS['isb_yxy']


def random_angles(count: int, seed: int) -> Array:
    """Return angles (count, 3), away from the arm at the side."""
    return np.random.default_rng(seed).uniform([-3.1, 0.1, -3.1], [3.1, 1.5, 3.1], (count, 3))


POSES = [ISB.rotation(each) for each in random_angles(30, seed=8)]


def from_delft(sequence: str, angles: Any, degrees: bool = True) -> Array:
    """Return a rotation in the model's axes from Euler angles in Delft's, by SciPy."""
    return DELFT.T @ Rotation.from_euler(sequence, angles, degrees).as_matrix() @ DELFT


def to_delft(sequence: str, rotations: Array, degrees: bool = True) -> Array:
    """Return Euler angles in Delft's axes of rotations in the model's, by SciPy."""
    return Rotation.from_matrix(DELFT @ rotations @ DELFT.T).as_euler(sequence, degrees)


def regression(shared: Path) -> dict[str, Array]:
    """Return the coefficients of de Groot and Brand by the angle's name; deg."""
    rows = [
        line.split(',')
        for line in (shared / 'literature/girdle/de_groot_brand2001_rhythm.csv')
        .read_text(encoding='utf-8')
        .splitlines()
        if not line.startswith(('#', 'angle'))
    ]
    return {name: np.array(numbers, dtype=float) for name, *numbers in rows}


def test_the_regression_is_the_published_one(shared: Path) -> None:
    by_name = regression(shared)
    at_rest = from_delft('YZX', MEAN_SCAPULA).T @ from_delft('YZX', MEAN_CLAVICLE)
    for H in POSES:
        plane, elevation, _ = to_delft('YZY', H)
        if elevation < 0.0:
            plane, elevation = (plane + 360.0) % 360.0 - 180.0, -elevation
        known = np.array((1.0, plane, elevation))

        def predict(name: str, rest: float, known: Array = known) -> float:
            return float(by_name[name] @ (*known, rest))

        pose = RHYTHMS['de_groot_brand_2001'].pose(H)
        names = 'scapula_y_protraction', 'scapula_z_lateral_rotation', 'scapula_x_tilt'
        S = from_delft('YZX', [predict(*each) for each in zip(names, MEAN_SCAPULA, strict=True)])
        np.testing.assert_allclose(pose.scapula, S, rtol=0, atol=1e-6)
        names = 'clavicle_y_protraction', 'clavicle_z_elevation'
        two = [predict(*each) for each in zip(names, MEAN_CLAVICLE[:2], strict=True)]

        def turn_of_the_joint(axial: float, two: Any = two, S: Array = S) -> float:
            C = from_delft('YZX', (*two, axial))
            return float(Rotation.from_matrix(C.T @ S @ at_rest).magnitude())

        coarse = min(range(-180, 180, 5), key=turn_of_the_joint)
        axial = minimize_scalar(
            turn_of_the_joint, (coarse - 5.0, coarse + 5.0), options={'xtol': 1e-12}
        ).x
        assert turn_of_the_joint(axial) <= turn_of_the_joint(coarse)
        C = from_delft('YZX', (*two, axial))
        np.testing.assert_allclose(pose.clavicle, C, rtol=0, atol=1e-5)  # a flat minimum


@pytest.mark.parametrize('rhythm', RHYTHMS.values(), ids=list(RHYTHMS))
@pytest.mark.parametrize('rest', [None, REST], ids=['mean', 'own'])
@pytest.mark.parametrize('convention', ['isb_yxy', 'flexion_abduction_rotation', 'opensim_mobl'])
def test_the_axes_are_differences_of_the_pose(
    rhythm: Rhythm, rest: Rest | None, convention: str
) -> None:
    meaning = JOINT_CONVENTIONS[convention]

    def at(angles: Array) -> Any:
        return rhythm.pose(*meaning.rotation_and_axes(angles), rest)

    def turn(read: Callable[[Any], Array], angles: Array, j: int) -> Array:
        step = 1e-5 * np.eye(3)[j]
        ahead, behind = read(at(angles + step)), read(at(angles - step))
        return np.asarray(Rotation.from_matrix(ahead @ behind.T).as_rotvec() / 2e-5)

    for angles in random_angles(10, seed=9):
        pose = at(angles)
        for j in range(3):
            for read, axes in (
                (lambda pose: pose.scapula, pose.scapula_axes),
                (lambda pose: pose.clavicle, pose.clavicle_axes),
                (lambda pose: pose.humerus, pose.humerus_axes),
                (lambda pose: pose.rotation, pose.axes),
            ):
                difference = turn(read, angles, j)
                np.testing.assert_allclose(axes[:, j], difference, rtol=1e-6, atol=1e-7)


def test_the_constant_ratio_takes_its_share_in_the_plane_of_elevation() -> None:
    for H in POSES:
        plane, elevation, axial = ISB.angles(H)
        pose = rhythm_from('3').pose(H)
        expected = from_delft('YZY', (plane, 0.75 * elevation, axial), degrees=False)
        np.testing.assert_allclose(pose.rotation, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize('rhythm', RHYTHMS.values(), ids=list(RHYTHMS))
def test_at_rest_the_girdle_is_as_it_was_measured(rhythm: Rhythm) -> None:
    S, C = from_delft('YZX', (30.0, 5.0, -8.0)), from_delft('YZX', (-30.0, 8.0, 5.0))
    H = from_delft('YZY', (170.0, 15.0, -20.0))
    pose = rhythm.pose(H, rest=Rest.measured(S, C, H))
    np.testing.assert_allclose(pose.scapula, S, rtol=0, atol=1e-12)
    if isinstance(rhythm, LinearRhythm):
        np.testing.assert_allclose(pose.clavicle, C, rtol=0, atol=1e-12)
    # a plane of elevation that crosses 180 deg is no jump
    beyond = rhythm.pose(
        from_delft('YZY', (-170.0, 15.0, -20.0)), rest=Rest.measured(S, C, H)
    ).scapula
    assert Rotation.from_matrix(beyond @ S.T).magnitude() < 0.1


@pytest.mark.parametrize('rhythm', RHYTHMS.values(), ids=list(RHYTHMS))
def test_the_bones_hang_together_at_the_joints_of_the_girdle(rhythm: Rhythm) -> None:
    tree = Skeleton.load('shoulder_girdle').tree
    places = {joint.name: np.array(joint.xyz) for joint in tree.joints}
    for angles in random_angles(10, seed=4):
        bones, pose = rhythm.bones(angles, REST), rhythm.pose(ISB.rotation(angles), rest=REST)
        (C, c), (S, s), (H, h) = (bones[bone] for bone in ('clavicle', 'scapula', 'humerus'))
        np.testing.assert_allclose(C, pose.clavicle, rtol=0, atol=1e-12)
        np.testing.assert_allclose(S, pose.scapula, rtol=0, atol=1e-12)
        np.testing.assert_allclose(H, ISB.rotation(angles), rtol=0, atol=1e-15)
        np.testing.assert_allclose(c, places['sc_protraction'], rtol=0, atol=0)
        acromion = c + C @ places['ac_protraction']
        from_scapula = s - S @ places['acromion_to_glenoid']
        np.testing.assert_allclose(from_scapula, acromion, rtol=0, atol=1e-15)  # m
        np.testing.assert_allclose(h, s, rtol=0, atol=0)
    assert rhythm.source
    assert rhythm.range[0] < rhythm.range[1]


def test_the_bones_of_what_are_no_angles_are_refused() -> None:
    for angles in ((1.0, 2.0), (1.0, np.nan, 0.0), 'abc', None):
        with pytest.raises(LinkedPlaneError, match=r'^angles'):
            RHYTHMS['mobl'].bones(angles)


@requires('rosbags')
@pytest.mark.parametrize(
    ('recording', 'name', 'worth'),
    [  # ../shared/spec/bones.md, section 7: deg, mean; mm, mean and worst
        ('girdle_abduction_mcap', 'de_groot_brand_2001', (12.7, 3.5, 20.5)),
        ('girdle_abduction_mcap', 'mobl', (10.7, 3.5, 18.0)),
        ('girdle_abduction_mcap', 'third', (11.7, 4.0, 17.3)),
        ('girdle_shrug_mcap', 'de_groot_brand_2001', (5.5, 1.6, 9.5)),
        ('girdle_shrug_mcap', 'mobl', (5.3, 1.5, 9.3)),
        ('girdle_shrug_mcap', 'third', (5.1, 1.5, 9.1)),
    ],
)
def test_what_a_rhythm_is_worth_on_real_motion(
    shared: Path, recording: str, name: str, worth: tuple[float, float, float]
) -> None:
    none, third = (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1 / 3, 1.0)
    rhythm = RHYTHMS.get(name) or LinearRhythm(name, '', '', (0.0, 3.0), '', (none, third, none))
    poses = girdle_poses(shared / 'recordings' / recording)
    found = errors(rhythm, {bone: R[::4] for bone, (R, _) in poses.items()})
    assert found == pytest.approx(worth, abs=0.0501)


@requires('rosbags')
@pytest.mark.parametrize('rhythm', RHYTHMS.values(), ids=list(RHYTHMS))
def test_what_a_rhythm_says_of_itself_is_so(shared: Path, rhythm: Rhythm) -> None:
    for recording in RECORDINGS:
        poses = girdle_poses(shared / 'recordings' / recording)
        turn, mean, worst = errors(rhythm, {bone: R for bone, (R, _) in poses.items()})
        assert f'{turn:.1f} deg, {mean:.1f} mm, {worst:.1f} mm' in rhythm.tested


def errors(rhythm: Rhythm, poses: dict[str, Array]) -> tuple[float, float, float]:
    """Return how far the scapula (deg, mean) and the lengths (mm, mean and worst) are off."""
    S, C, H = (poses[bone] for bone in ('scapula', 'clavicle', 'humerus'))
    rest = Rest.measured(S[0], C[0], H[0])
    predicted = np.array([rhythm.pose(each, rest=rest).scapula for each in H])
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
    true, made = (solver.solve_batch(each.transpose(0, 2, 1) @ H) for each in (S, predicted))
    off = np.degrees(Rotation.from_matrix(S.transpose(0, 2, 1) @ predicted).magnitude())
    in_length = 1e3 * np.abs(made.lengths - true.lengths)
    return off.mean(), in_length.mean(), in_length.max()


@pytest.mark.parametrize('given', ['inman', '0', '-2', 'nan', 'inf', ''])
def test_another_rhythm_is_refused(given: str) -> None:
    with pytest.raises(LinkedPlaneError, match=r'^rhythm: .* one of constant_ratio, .* expected$'):
        rhythm_from(given)


def test_a_rest_that_is_no_numbers_is_refused() -> None:
    with pytest.raises(LinkedPlaneError, match='rest: scapula'):
        Rest((0.0, np.nan, 0.0))


@pytest.mark.parametrize(
    ('angles', 'bone'),
    [
        ({'scapula': (32, 10.7, -10.3)}, 'scapula'),
        ({'scapula': (0.3, 0.1, -10.3)}, 'scapula'),
        ({'clavicle': (-28.57, 11.68, 7.48)}, 'clavicle'),
        ({'humerus': (-26.0, 0.24)}, 'humerus'),
        ({'humerus': (-0.45, 14.0)}, 'humerus'),
    ],
)
def test_a_rest_in_degrees_is_refused(angles: dict[str, Any], bone: str) -> None:
    with pytest.raises(LinkedPlaneError, match=f'^rest: {bone}: .* given, degrees[?] rad expected'):
        Rest(**angles)


def test_a_rest_s_numbers_in_degrees_are_refused_by_the_name_they_were_given_under() -> None:
    for numbers in (32, 10.7, -10.3), (0.5, 0.2, -0.2, -26, 14):
        with pytest.raises(LinkedPlaneError, match=r'^parameter rest: (scap|hum).*: .*degrees'):
            Rest.from_numbers(numbers, 'parameter rest')


def test_a_rest_may_have_any_plane_of_elevation_and_a_steep_scapula() -> None:
    for plane in (3.1416, -np.pi):
        assert Rest((1.5, -1.5, 1.5), humerus=(plane, 1.5)).humerus == (plane, 1.5)
