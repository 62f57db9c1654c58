# SPDX-License-Identifier: Apache-2.0
"""The bundled girdle is the thoracoscapular model's, as far as a tree can be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import thoracoscapular as tsm
from girdle_recordings import RECORDINGS, THORACIC, angles_from_poses, girdle_poses
from optional import requires
from random_urdfs import joint, link, robot

from linkedplane_ros import JOINT_CONVENTIONS, Skeleton
from linkedplane_ros.types import Floats

X, Y, Z = np.eye(3)


@pytest.fixture
def girdle() -> Skeleton:
    return Skeleton.load('shoulder_girdle')


@pytest.fixture
def against_thorax(girdle: Skeleton) -> Skeleton:
    """Return the girdle seen from the thorax, its bones in the frames of their links."""
    return Skeleton(girdle.tree, THORACIC, THORACIC)


def test_the_girdle_has_nine_hinges_and_the_deltoid_s_bones(girdle: Skeleton) -> None:
    assert girdle.bones == ('scapula', 'clavicle', 'humerus')
    assert len(girdle.coordinates) == 9
    assert girdle.coordinates[6:] == JOINT_CONVENTIONS['isb_yxy'].coordinates
    assert girdle.moving == girdle.coordinates[3:]  # nothing of the SC joint, seen from the scapula
    assert girdle.screws(np.zeros(9)).shape == (9, 2, 6)


def test_all_is_the_identity_at_rest(girdle: Skeleton) -> None:
    for R, t in girdle.pose(np.zeros(9)).values():
        np.testing.assert_allclose(R, np.eye(3), atol=1e-15)
        np.testing.assert_allclose(t, 0.0, atol=1e-15)  # m


def test_joint_centres_are_those_of_the_model(against_thorax: Skeleton) -> None:
    pose = against_thorax.pose(np.zeros(9))
    R, sc = pose['clavicle']
    np.testing.assert_allclose(sc, tsm.THORAX @ (tsm.SC - tsm.IJ), atol=1e-9)  # m: nine digits
    ac = sc + R @ (np.linalg.norm(tsm.AC_IN_CLAVICLE) * X)
    R, gh = pose['scapula']
    np.testing.assert_allclose(ac, gh + R @ tsm.SCAPULA @ (tsm.AC_IN_SCAPULA - tsm.GH), atol=2e-9)
    np.testing.assert_allclose(pose['humerus'][1], gh, atol=1e-15)


def test_rest_is_the_default_posture_of_the_model(shared: Path) -> None:
    first = tsm.girdle_poses(shared)[0]
    q = angles_from_poses(first)
    # 0.1 deg to which the turns are rounded, and as much again from the pose's two digits
    assert np.abs(np.degrees(q[:6])).max() < 0.1


@pytest.mark.parametrize('i', range(4))
def test_angles_found_from_its_poses_reproduce_them(
    against_thorax: Skeleton, shared: Path, i: int
) -> None:
    golden = tsm.girdle_poses(shared)[i]
    pose = against_thorax.pose(angles_from_poses(golden))
    for bone, (R, t) in golden.items():
        np.testing.assert_allclose(pose[bone][0], R, atol=1e-8)  # the file's nine digits
        np.testing.assert_allclose(pose[bone][1], t, atol=3e-9)  # m: both files nine


@requires('rosbags', 'scipy')
@pytest.mark.parametrize('recording', RECORDINGS)
def test_angles_found_from_recorded_poses_reproduce_how_another_subject_s_bones_turn(
    girdle: Skeleton, against_thorax: Skeleton, shared: Path, recording: str
) -> None:
    poses = girdle_poses(shared / 'recordings' / recording)
    frames = range(0, len(poses['humerus'][0]), 10)
    q = np.array([
        angles_from_poses({bone: (R[i], t[i]) for bone, (R, t) in poses.items()}) for i in frames
    ])  # fmt: skip
    lower, upper = np.array(girdle.limits).T
    assert (lower < q).all()
    assert (q < upper).all()
    found = against_thorax.pose_batch(q)
    for bone, (R, t) in poses.items():
        np.testing.assert_allclose(found[bone][0], R[::10], atol=1e-11)  # R^T R of quaternions
        off = 1e3 * np.linalg.norm(found[bone][1] - t[::10], axis=1)  # mm: a subject's own size
        assert off.max() < (6.0 if bone == 'clavicle' else 28.0)
        assert np.ptp(off) < 2.0


def test_hinges_about_the_model_s_axes_are_its_shoulder_and_clavicle(
    shared: Path,
) -> None:
    def hinge(name: str, parent: str, child: str, axis: str, xyz: str = '0 0 0') -> str:
        inside = f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        return joint(name, 'revolute', parent, child, inside)

    text = robot(
        *map(link, ('thorax', 'c', 'clavicle', 'scapula', 'h', 'i', 'humerus')),
        hinge('clav_prot', 'thorax', 'c', '0.0153 0.9892987 -0.14509996',
              '0.0063249765 0.0069300434 0.025464432'),
        hinge('clav_elev', 'c', 'clavicle', '-0.99447254 0 -0.10499695'),
        joint('held', 'fixed', 'clavicle', 'scapula'),
        hinge('plane_elv', 'scapula', 'h', '0 1 0', '-0.0095499448 -0.034001364 0.0089968219'),
        hinge('shoulder_elv', 'h', 'i', '-1 0 0'),
        hinge('axial_rot', 'i', 'humerus', '-0.0846 0.9947 -0.0584'),
    )  # fmt: skip
    whole = Skeleton.from_urdf(text)
    joint_angles = [
        (0, 0.3, 0),
        (0.3, 0.8, 0.2),
        (1, 1.2, -0.3),
        (0, 0, 0),
    ]  # as the file names them
    for pose, angles in zip(tsm.golden_poses(shared), joint_angles, strict=True):
        (S, s), (H, h), (C, c) = pose['scapula'], pose['humerus'], pose['clavicle']
        shoulder = Skeleton(whole.tree, ('scapula', 'humerus'), ('scapula', 'humerus'))
        R, t = shoulder.pose([0, 0, *angles])['humerus']
        np.testing.assert_allclose(R, S.T @ H, atol=1e-8)  # nine digits
        np.testing.assert_allclose(t, S.T @ (h - s), atol=2e-9)  # m
        # elevation and protraction from where the first axis and the last point
        first, second = whole.tree.joints[0].axis, whole.tree.joints[1].axis
        prot, elev = clavicle_angles(C, tsm.unit(np.array(first)), tsm.unit(np.array(second)))
        R, t = whole.pose([prot, elev, 0, 0, 0])['clavicle']
        np.testing.assert_allclose(R, C, atol=1e-8)
        np.testing.assert_allclose(t, c, atol=2e-9)  # m


def clavicle_angles(rotation: Floats, first: Floats, second: Floats) -> tuple[float, float]:
    """Return the angles of R(first, a) R(second, b): the second axis shows a, the first b."""

    def about(axis: Floats, start: Floats, end: Floats) -> float:
        across = start - (axis @ start) * axis
        return float(np.arctan2(end @ np.cross(axis, across), end @ across))

    return about(first, second, rotation @ second), -about(second, first, rotation.T @ first)


def test_each_coordinate_moves_its_bone_the_way_that_its_name_says(
    against_thorax: Skeleton,
) -> None:
    names = against_thorax.coordinates
    rest = against_thorax.pose(np.zeros(9))

    def shift(name: str, bone: str, point: Floats) -> Floats:
        """Return how a point of a bone moves in the thorax when a coordinate grows."""
        R, t = against_thorax.pose(0.1 * np.eye(9)[names.index(name)])[bone]
        return R @ point + t - rest[bone][0] @ point - rest[bone][1]

    acromion, inferior_angle, spine = 0.125 * X, -0.1 * Z, -0.1 * X
    assert shift('sc_protraction', 'clavicle', acromion) @ Y > 0
    assert shift('sc_elevation', 'clavicle', acromion) @ Z > 0
    assert shift('sc_backward_rotation', 'clavicle', 0.01 * Z) @ Y < 0
    assert shift('ac_protraction', 'scapula', spine) @ Y < 0  # its medial border goes backwards
    assert shift('ac_upward_rotation', 'scapula', inferior_angle) @ X > 0
    assert shift('ac_posterior_tilt', 'scapula', inferior_angle) @ Y > 0
    for i, name in enumerate(names[6:]):
        R, _ = Skeleton.load('shoulder_girdle').pose(np.eye(9)[6 + i])['humerus']
        expected = JOINT_CONVENTIONS['isb_yxy'].rotation(np.eye(3)[i])
        np.testing.assert_allclose(R, expected, atol=1e-15, err_msg=name)


def test_the_hip_turns_as_opensim_s() -> None:
    flexed, adducted, turned = (
        Skeleton.load('hip').pose(0.1 * each)['femur'][0] for each in np.eye(3)
    )
    knee, toes = -Z, Y
    assert (flexed @ knee) @ Y > 0  # forward
    assert (adducted @ knee) @ X < 0  # to the middle of the body
    assert (turned @ toes) @ X < 0  # inward


def test_every_number_of_the_files_has_a_source() -> None:
    for name in ('shoulder_girdle', 'hip'):
        text = (Path(tsm.__file__).parents[2] / f'linkedplane_ros/models/{name}.urdf').read_text()
        assert 'SPDX-License-Identifier' in text
        assert '.osim' in text
        for element in Skeleton.load(name).tree.joints:
            assert element.kind == 'fixed' or element.limits[0] < 0.0 < element.limits[1]
