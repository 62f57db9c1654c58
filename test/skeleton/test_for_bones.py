# SPDX-License-Identifier: Apache-2.0
"""A skeleton poses the bones of a muscle, whatever their links are called and how they stand."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from random_urdfs import joint, link, random_urdf, robot
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, LinkedPlaneError, Skeleton, SkeletonError
from linkedplane_ros.skeleton.skeleton import parse_bone_links
from linkedplane_ros.types import Triple

PLACE = '<origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><axis xyz="0 0 2"/>'
ARM = robot(
    *(link(name) for name in ('left/scapula', 'left/humerus', 'left/ulna')),
    joint('left/shoulder', 'revolute', 'left/scapula', 'left/humerus', PLACE),
    joint('left/elbow', 'prismatic', 'left/humerus', 'left/ulna', PLACE),
)
LINKS = {'scapula': 'left/scapula', 'humerus': 'left/humerus'}
# steps of 1e-5 rad or m: errors 1e-10 of the step's square and of rounding
STEP, STEPPED = 1e-5, 1e-9


@pytest.fixture
def arm() -> Skeleton:
    return Skeleton.from_urdf(ARM)


def test_links_of_a_robot_with_a_prefix_are_the_bones(arm: Skeleton) -> None:
    skeleton = arm.for_bones(['scapula', 'humerus'], LINKS)
    assert skeleton.bones == ('scapula', 'humerus')
    assert skeleton.links == ('left/scapula', 'left/humerus')
    assert skeleton.coordinates == ('left/shoulder', 'left/elbow')
    assert skeleton.moving == ('left/shoulder',)
    assert skeleton.screws([0.3, 0.2]).shape == (2, 1, 6)
    assert not skeleton.screws([0.3, 0.2])[1].any()


def test_links_are_taken_as_a_mapping_or_as_the_node_takes_them(arm: Skeleton) -> None:
    entries = [f'{bone}:={link}' for bone, link in LINKS.items()]
    assert arm.for_bones(list(LINKS), entries) == arm.for_bones(list(LINKS), LINKS)
    with pytest.raises(SkeletonError, match='bone_links: 3 given, BONE:=LINK expected'):
        arm.for_bones(list(LINKS), [3])  # type: ignore[list-item]


def test_what_is_not_given_anew_is_kept(arm: Skeleton) -> None:
    links = {**LINKS, 'humerus': 'left/humerus@0.1,0.2,0.3,0.4,0.5,0.6'}
    origin = (0.01, 0.02, 0.03), (0.1, 0.2, 0.3)
    made = arm.for_bones(['scapula', 'humerus'], links, {'left/shoulder': 0.7}, origin)
    again = made.for_bones(['scapula', 'ulna', 'humerus'], {'ulna': 'left/ulna'})
    links['ulna'] = 'left/ulna'
    whole = ['scapula', 'ulna', 'humerus']
    assert again == arm.for_bones(whole, links, {'left/shoulder': 0.7}, origin)
    assert made.for_bones(made.bones) == made
    rested = again.for_bones(whole, rest={'left/elbow': 0.1})
    rest = {'left/shoulder': 0.7, 'left/elbow': 0.1}
    assert rested == arm.for_bones(whole, links, rest, origin)
    # and what is given anew holds
    other = (0.0, 0.0, 0.1), (0.0, 0.0, 0.0)
    assert made.for_bones(made.bones, origin=other).origin == other
    assert made.for_bones(made.bones, rest={'left/shoulder': 0.0}).rest == (0.0, 0.0)
    moved = made.for_bones(made.bones, {'humerus': 'left/ulna'})
    assert (moved.links[1], moved.places) == ('left/ulna', (None,))
    # of another ground the frame is its link's own
    assert made.for_bones(['left/ulna', 'scapula']).origin == ((0.0,) * 3, (0.0,) * 3)


def test_at_rest_all_bones_coincide_wherever_their_links_stand(arm: Skeleton) -> None:
    for rest in ({}, {'left/shoulder': 0.7, 'left/elbow': 0.1}):
        skeleton = arm.for_bones(['ground', 'moves'], dict(zip(
            ('ground', 'moves'), ('left/humerus', 'left/ulna'), strict=True
        )), rest)  # fmt: skip
        q = [rest.get(name, 0.0) for name in skeleton.coordinates]
        R, t = skeleton.pose(q)['moves']
        np.testing.assert_allclose(R, np.eye(3), atol=1e-15)
        np.testing.assert_allclose(t, 0.0, atol=1e-15)


def test_a_bone_slides_along_the_axis_of_its_joint_by_metres(arm: Skeleton) -> None:
    skeleton = arm.for_bones(['h', 'u'], {'h': 'left/humerus', 'u': 'left/ulna'})
    R, t = skeleton.pose([0.9, 0.25])['u']
    axis = np.array(Skeleton.from_urdf(ARM).pose([0.0, 0.0])['left/ulna'][0])[:, 2]
    along = np.array(Skeleton.from_urdf(ARM).pose([0.0, 0.0])['left/humerus'][0]).T @ axis
    np.testing.assert_allclose(R, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(t, 0.25 * along, atol=1e-15)
    assert skeleton.kinds == ('revolute', 'prismatic')


def test_rest_is_finite(arm: Skeleton) -> None:
    with pytest.raises(SkeletonError, match='rest: left/elbow is not a finite number'):
        arm.for_bones(['left/ulna'], rest={'left/elbow': np.nan})


def test_two_bones_may_be_one_link(arm: Skeleton) -> None:
    links = {**LINKS, 'clavicle': 'left/scapula'}
    skeleton = arm.for_bones(['scapula', 'clavicle', 'humerus'], links)
    R, t = skeleton.pose([1.0, 0.0])['clavicle']
    assert (R == np.eye(3)).all()
    assert not t.any()
    assert not skeleton.screws([1.0, 0.0])[:, 0].any()


@pytest.mark.parametrize('angles', [(0.0, 0.0, 0.0), (0.5, 1.2, -0.3), (-1.0, 2.0, 1.0)])
def test_a_ground_frame_stands_where_it_is_said_to_in_its_link(angles: Triple) -> None:
    # the right arm of ros4hri's human_description, and the convention that was made for it
    shoulder = (
        ('y_shoulder', 'torso', 'y', '0 0 1', '0 -0.176 0'),
        ('p_shoulder', 'y', 'p', '-1 0 0', '0 0 0'),
        ('r_shoulder', 'p', 'upper_arm', '0 0 -1', '0 0 0'),
    )
    human = robot(
        *map(link, ('torso', 'y', 'p', 'upper_arm')),
        *(
            joint(name, 'revolute', above, below, f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>')
            for name, above, below, axis, xyz in shoulder
        ),
    )
    links = {'scapula': 'torso', 'humerus': 'upper_arm'}
    origin = (0.0, -0.176, 0.0), (0.0, 0.0, -np.pi / 2)
    skeleton = Skeleton.from_urdf(human).for_bones(links, links, origin=origin)
    R, t = skeleton.pose(angles)['humerus']
    expected, axes = JOINT_CONVENTIONS['rep155'].rotation_and_axes(angles)
    np.testing.assert_allclose(R, expected, atol=1e-15)
    np.testing.assert_allclose(t, 0.0, atol=1e-15)
    np.testing.assert_allclose(skeleton.screws(angles)[:, 0, :3].T, axes, atol=1e-15)
    np.testing.assert_allclose(skeleton.screws(angles)[:, 0, 3:], 0.0, atol=1e-15)


@pytest.mark.parametrize(
    ('origin', 'reason'),
    [
        (3, r'origin: 3 given, \(\(x, y, z\), \(roll, pitch, yaw\)\) expected'),
        ((0, 0, 0), r'origin: \(0, 0, 0\) given'),
        (((0, 0), (0, 0, 0)), r'origin: xyz: \(0, 0\) given, 3 finite numbers in m expected'),
        (((0, 0, 0), (0, 0, np.inf)), 'origin: rpy: '),
    ],
)
def test_an_origin_that_is_no_place_is_refused(arm: Skeleton, origin: Any, reason: str) -> None:
    with pytest.raises(LinkedPlaneError, match=reason):
        arm.for_bones(['left/ulna'], origin=origin)


@pytest.mark.parametrize(
    ('given', 'reason'),
    [
        (
            (['scapula', 'humerus'],),
            "no link of that name for bone 'scapula'; its links are left/scapula; bone_links: "
            'scapula:=LINK names another',
        ),
        (
            (['pelvis'], {'pelvis': 'hip'}),
            "no link 'hip' for bone 'pelvis'; its links are left/scapula, left/humerus, left/ulna; "
            'bone_links: pelvis:=LINK names another',
        ),
        ((['scapula'], {**LINKS}), "bone_links: 'humerus' is no bone; those are scapula"),
        ((['a', 'a'],), 'bones: a, a given, names that differ expected'),
        (([],), 'bones: [] given, a list of names expected'),
        (('scapula',), "bones: 'scapula' given, a list of names expected"),
        ((None,), 'bones: None given, a list of names expected'),
        ((['left/ulna'], {'left/ulna': 3}), 'bone_links: left/ulna: 3 given, the name of a link'),
        ((['left/ulna'], 'left/ulna'), "bone_links: 'left/ulna' given, a mapping of bones to"),
        ((['left/ulna'], 3), 'bone_links: 3 given, a mapping of bones to'),
        ((['left/ulna'], {}, [0, 0]), 'rest: [0, 0] given, a mapping of coordinates to values'),
        ((['left/ulna'], {}, {'elbow': 1}), "rest: 'elbow' is no coordinate; those are left/sho"),
    ],
)
def test_bones_that_it_does_not_have_are_refused(
    arm: Skeleton, given: tuple[Any, ...], reason: str
) -> None:
    with pytest.raises(SkeletonError) as refused:
        arm.for_bones(*given)
    assert str(refused.value).startswith(f'robot_description: {reason}')


@pytest.mark.parametrize(
    ('q', 'reason'),
    [
        ([1.0], r'q: shape \(1,\) given, \(2,\) expected: left/shoulder, left/elbow'),
        ([[1.0, 2.0]], r'q: shape \(1, 2\) given'),
        ([1.0, np.inf], 'q: left/elbow is not a finite number'),
        (['1', '2'], 'q: not an array of numbers'),
        ([1j, 2], 'q: not an array of numbers'),
        ([[1], [1, 2]], 'q: not an array of numbers'),
        (None, 'q: not an array of numbers'),
    ],
)
def test_what_are_no_values_of_the_coordinates_is_refused(
    arm: Skeleton, q: Any, reason: str
) -> None:
    with pytest.raises(LinkedPlaneError, match=reason):
        arm.pose(q)
    with pytest.raises(LinkedPlaneError):
        arm.pose_batch([q])


@pytest.mark.parametrize('seed', range(100, 110))
def test_a_screw_is_the_velocity_of_the_pose(seed: int) -> None:
    whole = Skeleton.from_urdf(random_urdf(seed))
    skeleton = whole.for_bones(whole.bones[:1:-1])
    q = np.random.default_rng(seed).normal(size=len(skeleton.coordinates))
    screws = skeleton.screws(q)
    for i in range(len(q)):
        step = STEP * np.eye(len(q))[i]
        later, sooner, now = (skeleton.pose(q + s) for s in (step, -step, 0 * step))
        for k, bone in enumerate(skeleton.bones[1:]):
            (R1, t1), (R0, t0), (R, t) = later[bone], sooner[bone], now[bone]
            turn, shift = (R1 - R0) / (2 * STEP) @ R.T, (t1 - t0) / (2 * STEP)
            w, v = screws[i, k, :3], screws[i, k, 3:]
            np.testing.assert_allclose(np.cross(w, np.eye(3)).T, turn, atol=STEPPED)
            np.testing.assert_allclose(v + np.cross(w, t), shift, atol=1e-8)


def test_a_batch_is_to_the_bit_its_single_poses() -> None:
    skeleton = Skeleton.from_urdf(random_urdf(5))
    values = np.random.default_rng(5).normal(size=(7, len(skeleton.coordinates)))
    poses, screws = skeleton.pose_batch(values), skeleton.screws_batch(values)
    for m, q in enumerate(values):
        assert (screws[m] == skeleton.screws(q)).all()
        for bone, (R, t) in skeleton.pose(q).items():
            assert (poses[bone][0][m] == R).all()
            assert (poses[bone][1][m] == t).all()
    assert all(R.shape == (0, 3, 3) for R, _ in skeleton.pose_batch([]).values())
    assert skeleton.screws_batch([]).shape == (0, *screws.shape[1:])


def test_a_skeleton_is_its_urdf_and_its_bones(arm: Skeleton) -> None:
    one, other = arm.for_bones(['left/ulna']), arm.for_bones(['left/humerus'])
    assert one == Skeleton.from_urdf(ARM).for_bones(['left/ulna']) != other
    assert len({one, other, pickle.loads(pickle.dumps(one))}) == 2


def test_a_robot_of_one_link_stands_still() -> None:
    skeleton = Skeleton.from_urdf(robot(link('base')))
    assert skeleton.coordinates == ()
    assert skeleton.pose([]) == {}
    assert skeleton.screws([]).shape == (0, 0, 6)


def test_bones_and_links_of_the_node_s_parameter_are_taken_apart() -> None:
    entries = ['scapula:=left/scapula', ' humerus := b:c ']
    assert parse_bone_links(entries) == {'scapula': 'left/scapula', 'humerus': 'b:c'}
    for wrong in ('scapula', 'scapula:=', ':=b', 'a=b', ''):
        with pytest.raises(SkeletonError, match='BONE:=LINK expected'):
            parse_bone_links([wrong])
    with pytest.raises(SkeletonError, match="bone 'a' is given twice"):
        parse_bone_links(['a:=b', 'a:=c'])


def test_limits_and_kinds_stand_beside_the_coordinates() -> None:
    skeleton = Skeleton.load('hip')
    assert skeleton.coordinates == ('hip_flexion', 'hip_adduction', 'hip_rotation')
    assert skeleton.kinds == ('revolute',) * 3
    assert skeleton.limits[0] == (-0.523599, 2.094395)
    spinning = Skeleton.from_urdf(
        robot(link('a'), link('b'), joint('j', 'continuous', 'a', 'b', PLACE))
    )
    assert spinning.limits == ((-np.inf, np.inf),)


def test_a_frame_may_be_given_with_the_link_of_its_bone(arm: Skeleton) -> None:
    place, other = (0.1, -0.2, 0.3), (0.4, -0.5, 0.6)
    written = '0.1,-0.2,0.3,0.4,-0.5,0.6'
    links = {**LINKS, 'scapula': f'left/scapula@{written}'}
    by_link = arm.for_bones(['scapula', 'humerus'], links, rest={'left/shoulder': 0.3})
    by_origin = arm.for_bones(
        ['scapula', 'humerus'], LINKS, rest={'left/shoulder': 0.3}, origin=(place, other)
    )
    for mine, same in zip(by_link.pose([0.7, 0.1])['humerus'],
                          by_origin.pose([0.7, 0.1])['humerus'], strict=True):  # fmt: skip
        np.testing.assert_allclose(mine, same, rtol=0, atol=1e-15)

    # of another bone: in the link's frame, whatever the rest is
    links = {**LINKS, 'humerus': f'left/humerus@{written}'}
    moved = arm.for_bones(['scapula', 'humerus'], links)
    link_R, link_t = plain_pose(arm, [0.7, 0.1])
    R, t = moved.pose([0.7, 0.1])['humerus']
    turn = Rotation.from_euler('xyz', other).as_matrix()  # fixed axes, as a URDF has them
    np.testing.assert_allclose(R, link_R @ turn, rtol=0, atol=1e-15)
    np.testing.assert_allclose(t, link_R @ place + link_t, rtol=0, atol=1e-15)
    q, step = np.array([0.7, 0.1]), STEP * np.array([1.0, 0.0])
    ahead, behind = (moved.pose(q + each)['humerus'][1] for each in (step, -step))
    w, v = np.split(moved.screws([0.7, 0.1])[0, 0], 2)
    np.testing.assert_allclose(v + np.cross(w, t), (ahead - behind) / (2 * STEP), atol=STEPPED)


def plain_pose(arm: Skeleton, q: Any) -> Any:
    """Return the humerus' link in the scapula's, in their own frames."""
    return arm.pose(q)['left/humerus']


def test_a_link_may_have_an_at_in_its_name_and_six_numbers_are_expected_after_others() -> None:
    text = ARM.replace('left/', 'left@1/')
    links = {bone: link.replace('left/', 'left@1/') for bone, link in LINKS.items()}
    skeleton = Skeleton.from_urdf(text).for_bones(['scapula', 'humerus'], links)
    assert skeleton.links == ('left@1/scapula', 'left@1/humerus')
    for wrong in ('', '1,2,3', '1,2,3,4,5,x', '1,2,3,4,5,inf', '1,2,3,4,5,6,7'):
        with pytest.raises(SkeletonError, match=r'^bone_links: scapula: .* expected$'):
            Skeleton.from_urdf(ARM).for_bones(
                ['scapula', 'humerus'], {**LINKS, 'scapula': f'left/scapula@{wrong}'}
            )
    with pytest.raises(SkeletonError, match='no link'):
        Skeleton.from_urdf(ARM).for_bones(
            ['scapula', 'humerus'], {**LINKS, 'scapula': 'other@0,0,0,0,0,0'}
        )
