# SPDX-License-Identifier: Apache-2.0
"""The view holds the root of a skeleton: bones move in it as plain forward kinematics has it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from optional import requires
from sensor_msgs.msg import JointState
from socket_browser import SocketBrowser
from viewer_stage import ViewerProcess

from linkedplane_ros import BroadMuscle, Skeleton
from linkedplane_ros.skeleton.skeleton import bundled_skeletons
from linkedplane_ros.types import Floats
from linkedplane_ros.viewer.heard import HeardJoints
from linkedplane_ros.viewer.newest import MuscleInfo
from linkedplane_ros.viewer.scene.camera import UNIT
from linkedplane_ros.viewer.scene.ground import pose_in_view, root_in_view

GIRDLE = {'muscle': 'deltoid_girdle', 'skeleton': 'shoulder_girdle'}
BONES = BroadMuscle.load('deltoid_girdle').bones.names
TEXT = bundled_skeletons()['shoulder_girdle']
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
STATED = re.compile(r'<linkedplane_ros [^>]*/>')  # bones and side
PLAIN = Skeleton.from_urdf(STATED.sub('', TEXT))
"""Every link seen from the root: no bones, no rest, no side."""
D = len(PLAIN.coordinates)
RANDOM = np.random.default_rng(19).uniform(-0.5, 0.5, size=(5, D))


def info_of(**parameters: Any) -> MuscleInfo:
    name = parameters.get('muscle', 'deltoid')
    return MuscleInfo.from_parameters((), (), '/joint_states', parameters, name)


def as_square(pose: Floats) -> Floats:
    return np.vstack([pose, [0.0, 0.0, 0.0, 1.0]])


def link_in_root(link: str, q: Floats) -> Floats:
    return as_square(np.column_stack(PLAIN.pose(q)[link]))


def moved_since_rest(link: str, q: Floats) -> Floats:
    """Return the pose of a bone in the scapula's frame at rest, which stands still."""
    still, rest = link_in_root('scapula', np.zeros(D)), link_in_root(link, np.zeros(D))
    return np.linalg.inv(still) @ link_in_root(link, q) @ np.linalg.inv(rest) @ still


@pytest.mark.parametrize('side', ['right', 'left'])
@pytest.mark.parametrize('stated', ['right', 'left', ''])
def test_all_bones_stand_in_the_view_where_plain_kinematics_puts_them(
    tmp_path: Path, side: str, stated: str
) -> None:
    path = tmp_path / 'arm.urdf'
    given = f' side="{stated}"' if stated else ''
    path.write_text(STATED.sub(f'<linkedplane_ros bones="{" ".join(BONES)}"{given}/>', TEXT))
    info = info_of(muscle='deltoid_girdle', skeleton=str(path), side=side)
    assert info.skeleton is not None
    mirror = MIRROR if stated and stated != side else np.eye(4)
    for q in RANDOM:
        ground = as_square(pose_in_view(info, q))
        expected = mirror @ moved_since_rest('scapula', q) @ mirror
        np.testing.assert_allclose(ground, expected, rtol=0.0, atol=1e-14)
        seen = info.skeleton.move_bones([q], BONES, side).poses[0]  # right-shoulder form
        flip = MIRROR if side == 'left' else np.eye(4)
        for bone, pose in zip(BONES[1:], seen, strict=True):
            shown = ground @ flip @ as_square(pose) @ flip
            expected = mirror @ moved_since_rest(bone, q) @ mirror
            np.testing.assert_allclose(shown, expected, rtol=0.0, atol=1e-14)


def test_an_elevation_of_the_clavicle_lifts_clavicle_scapula_and_arm_together() -> None:
    info = info_of(**GIRDLE)
    q = np.zeros(D)
    q[PLAIN.coordinates.index('sc_elevation')] = 0.3
    lifted = pose_in_view(info, q)
    assert lifted[2, 3] > 0.02  # m, of the glenohumeral centre
    assert info.skeleton is not None
    for R, t in info.skeleton.pose(q).values():  # nothing moves against the scapula
        np.testing.assert_allclose(np.column_stack([R, t]), np.eye(3, 4), atol=1e-15)


@pytest.mark.parametrize('side', ['right', 'left'])
def test_at_rest_the_ground_stands_where_it_stands_without_a_skeleton(side: str) -> None:
    info = info_of(**GIRDLE, side=side)
    for angles in (None, np.zeros(D)):
        np.testing.assert_allclose(pose_in_view(info, angles), np.eye(3, 4), atol=1e-15)
    root = root_in_view(info)
    assert root is not None
    mirror = MIRROR if side == 'left' else np.eye(4)
    expected = mirror @ np.linalg.inv(link_in_root('scapula', np.zeros(D))) @ mirror
    np.testing.assert_allclose(as_square(root), expected, atol=1e-15)


@pytest.mark.parametrize(
    'parameters',
    [
        {'muscle': 'deltoid'},
        {'muscle': 'deltoid_girdle', 'rhythm': 'mobl'},
        {**GIRDLE, 'input': 'tf'},
        {**GIRDLE, 'bone_links': ['scapula:=thorax']},
    ],
    ids=['no skeleton', 'rhythm', 'tf', 'the ground is the root'],
)
def test_a_ground_that_no_joint_state_moves_holds_still(parameters: dict[str, Any]) -> None:
    info = info_of(**parameters)
    angles = np.full(len(info.coordinates), 0.3)
    np.testing.assert_array_equal(pose_in_view(info, angles), np.eye(3, 4))
    assert root_in_view(info) is None


def test_values_of_a_node_that_was_there_before_move_nothing() -> None:
    np.testing.assert_array_equal(pose_in_view(info_of(**GIRDLE), np.ones(3)), np.eye(3, 4))


def heard_after(*messages: dict[str, float], **parameters: Any) -> dict[str, float] | None:
    """Return the coordinates, by name, after messages that have joints by name."""
    info = info_of(**GIRDLE, **parameters)
    heard, values = HeardJoints(info.joints), None
    for each in messages:
        values = heard.take_message(JointState(name=list(each), position=list(each.values())))
    return None if values is None else dict(zip(info.coordinates, values.tolist(), strict=True))


NEEDED = {name: 0.1 for name in PLAIN.coordinates if not name.startswith('sc_')}


def test_joints_that_the_muscle_does_not_need_are_heard_and_not_waited_for() -> None:
    idle = {name: 0.0 for name in PLAIN.coordinates if name not in NEEDED}
    assert idle.keys() == info_of(**GIRDLE).joints.idle
    raised = {'sc_elevation': 0.3}
    assert heard_after(raised) is None  # the muscle's own have not come
    assert heard_after(NEEDED) == {**NEEDED, **idle}
    assert heard_after({**NEEDED, **raised}) == {**NEEDED, **idle, **raised}
    for alone in ((raised, NEEDED), (NEEDED, raised)):
        assert heard_after(*alone) == {**NEEDED, **idle, **raised}


@pytest.mark.parametrize('wrong', [np.nan, 90.0])
def test_a_value_that_the_node_does_not_read_makes_no_other_joint_unheard(wrong: float) -> None:
    heard = heard_after({**NEEDED, 'sc_elevation': wrong, 'sc_protraction': 0.2})
    assert heard is not None
    assert (heard['sc_elevation'], heard['sc_protraction']) == (0.0, 0.2)
    assert heard['elevation'] == 0.1


def test_joints_that_the_muscle_does_not_need_have_names_signs_and_offsets_as_well() -> None:
    names = [f'robot/{name}' for name in PLAIN.coordinates]
    i = PLAIN.coordinates.index('sc_elevation')
    signs, offsets = [1.0] * D, [0.0] * D
    signs[i], offsets[i] = -1.0, 0.05
    message = {f'robot/{name}': 0.1 for name in NEEDED}
    given = {'joint_names': names, 'joint_signs': signs, 'joint_offsets': offsets}
    heard = heard_after({**message, 'robot/sc_elevation': 0.2}, **given)
    assert heard is not None
    assert heard['sc_elevation'] == pytest.approx(-0.15)
    unheard = heard_after(message, **given)
    assert unheard is not None
    assert unheard['sc_elevation'] == 0.0


@requires('viser')
@pytest.mark.parametrize('side', ['right', 'left'])
def test_the_slider_of_a_joint_under_the_ground_moves_the_scene_of_the_muscle(
    tmp_path: Path, ros: None, side: str
) -> None:
    given = [f'{name}:={value}' for name, value in {**GIRDLE, 'side': side}.items()]
    arguments = [part for each in given for part in ('-p', each)]
    viewer = ViewerProcess(tmp_path / 'viewer.log', '--node', '--ros-args', *arguments)
    q = np.zeros(D)
    with viewer, SocketBrowser(viewer.url) as page:
        assert page.shows('nothing moves this arm yet')
        for name, degrees in (('sc_elevation', 20.0), ('ac_upward_rotation', 15.0)):
            page.set_control(f'{name} (deg)', degrees)
            q[PLAIN.coordinates.index(name)] = np.radians(degrees)
        wanted = pose_in_view(info_of(**GIRDLE, side=side), q)

        def stands_there() -> bool:
            place = page.places.get('/deltoid_girdle', {})
            if place.keys() != {'position', 'wxyz'}:
                return False
            w, *v = place['wxyz']
            turned = (
                2 * np.outer(v, v) + (2 * w * w - 1) * np.eye(3) + 2 * w * np.cross(v, -np.eye(3))
            )
            shown = np.column_stack([turned, np.divide(place['position'], UNIT)])
            return bool(np.abs(shown - wanted).max() < 1e-5)  # the library leaves out less

        assert page.until(stands_there), (page.places, viewer.text)
    assert 'Traceback' not in viewer.text
