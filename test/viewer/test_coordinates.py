# SPDX-License-Identifier: Apache-2.0
"""Any number of coordinates, rad or m: what is known of them, and how far they may be moved."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from optional import requires
from ros_harness import Reader
from sensor_msgs.msg import JointState
from socket_browser import SocketBrowser
from viewer_stage import ViewerProcess

from linkedplane_ros import LinkedPlaneError, Skeleton
from linkedplane_ros.viewer.newest import DEGREE, MILLIMETRE, MuscleInfo, match_coordinate
from linkedplane_ros.viewer.panels.plots import choose_columns
from linkedplane_ros.viewer.panels.ranges import coordinate_ranges, rest_pose, rounded_ranges

GIRDLE = {'muscle': 'deltoid_girdle', 'skeleton': 'shoulder_girdle'}
URDF = """<robot name="r"><link name="scapula"/><link name="humerus"/><link name="clavicle"/>
<link name="a"/><link name="wheel"/>
<joint name="slide" type="prismatic"><parent link="scapula"/><child link="a"/>
<axis xyz="0 0 1"/><limit lower="0.01" upper="0.05" effort="1" velocity="1"/></joint>
<joint name="turn" type="continuous"><parent link="a"/><child link="humerus"/>
<axis xyz="1 0 0"/></joint>
<joint name="stuck" type="revolute"><parent link="scapula"/><child link="clavicle"/>
<axis xyz="1 0 0"/><limit lower="0.2" upper="0.2" effort="1" velocity="1"/></joint>
<joint name="spin" type="revolute"><parent link="humerus"/><child link="wheel"/>
<axis xyz="1 0 0"/><limit lower="-99" upper="99" effort="1" velocity="1"/></joint></robot>"""


def info_of(coordinates: tuple[str, ...] = (), **parameters: Any) -> MuscleInfo:
    name = parameters.get('muscle', 'deltoid')
    return MuscleInfo.from_parameters(coordinates, (), '/joint_states', parameters, name)


def by_urdf(folder: Path) -> MuscleInfo:
    path = folder / 'arm.urdf'
    path.write_text(URDF)
    return info_of(muscle='deltoid_girdle', skeleton=str(path))


def test_a_skeletons_joints_are_the_coordinates_with_their_limits() -> None:
    skeleton = Skeleton.load('shoulder_girdle')
    info = info_of(**GIRDLE)
    assert info.coordinates == info.joints.names == skeleton.coordinates
    assert info.units == (DEGREE,) * 9
    inside = np.radians(rounded_ranges(info))
    limits = np.array(skeleton.limits)
    assert (inside[:, 0] >= limits[:, 0] - 1e-5).all()
    assert (inside[:, 1] <= limits[:, 1] + 1e-5).all()
    np.testing.assert_allclose(inside, limits, atol=np.radians(0.11))
    with_joints = info_of(**GIRDLE, joint_names=[f'j{k}' for k in range(9)])
    assert with_joints.joints.names[8] == 'j8'


def test_joints_of_any_kind_have_a_range_that_their_node_takes(tmp_path: Path) -> None:
    info = by_urdf(tmp_path)
    ranges = dict(zip(info.coordinates, coordinate_ranges(info), strict=True))
    assert ranges == {
        'slide': (0.01, 0.05),
        'turn': (-math.pi, math.pi),
        'stuck': (0.2, 0.2),
        'spin': (-2 * math.pi, 2 * math.pi),
    }
    units = dict(zip(info.coordinates, info.units, strict=True))
    assert units['slide'] == MILLIMETRE
    assert info.joints.idle == {'spin'}  # it moves no bone
    rest = dict(zip(info.coordinates, rest_pose(info), strict=True))
    assert rest == {'slide': 0.01, 'turn': 0.0, 'stuck': 0.2, 'spin': 0.0}
    shown = dict(zip(info.coordinates, rounded_ranges(info).tolist(), strict=True))
    assert shown['slide'] == [10.0, 50.0]


def test_a_skeleton_that_is_not_known_here_is_shown_and_not_moved() -> None:
    by_topic = {**GIRDLE, 'skeleton': 'robot_description'}
    with pytest.raises(LinkedPlaneError, match='robot_description is not known here'):
        info_of(**by_topic)
    info = info_of(('a', 'b', 'c', 'd'), **by_topic)
    assert info.coordinates == ('a', 'b', 'c', 'd')
    assert 'shown, not moved' in info.obstacle
    assert len(coordinate_ranges(info)) == 4


@pytest.mark.parametrize(
    ('coordinates', 'parameters'),
    [(('a', 'b'), {}), (('a', 'b', 'c', 'd'), {}), (('a', 'b', 'c'), GIRDLE)],
)
def test_labels_that_are_not_those_of_the_node_are_refused(
    coordinates: tuple[str, ...], parameters: dict[str, str]
) -> None:
    with pytest.raises(LinkedPlaneError):
        info_of(coordinates, **parameters)


def test_a_chosen_coordinate_is_that_of_its_name_where_others_have_more() -> None:
    girdle, arm = info_of(**GIRDLE), info_of(muscle='deltoid', joint_convention='isb_yxy')
    assert match_coordinate(arm, girdle, girdle.coordinates.index('elevation')) == 1
    assert match_coordinate(arm, girdle, 0) is None
    assert match_coordinate(girdle, girdle, 8) == 8
    thesis = info_of(muscle='deltoid')
    assert match_coordinate(arm, thesis, 2) == 2
    np.testing.assert_array_equal(
        choose_columns(np.array([[1.0, 2.0]]), [1, None, 0]), [[2.0, np.nan, 1.0]]
    )


@requires('viser')
def test_numbers_beyond_a_joints_limits_are_refused_from_a_socket(
    tmp_path: Path, ros: None
) -> None:
    heard: list[JointState] = []
    listener = Reader('listener')
    listener.keep(JointState, '/muscle_viewer/joint_states', heard.append)
    path = tmp_path / 'arm.urdf'
    path.write_text(URDF)
    given = ('-p', f'skeleton:={path}', '-p', 'muscle:=deltoid_girdle')
    viewer = ViewerProcess(tmp_path / 'viewer.log', '--node', '--ros-args', *given)
    with viewer, SocketBrowser(viewer.url) as page:
        assert page.shows('nothing moves this arm yet')
        for value in (math.nan, 9.9, 50.1, -1.0, 1e9, True, '20', None):
            page.set_control('slide (mm)', value)
        for value in (math.inf, 180.1, -181):
            page.set_control('turn (deg)', value)
        page.set_control('stuck (deg)', 11.6)  # its ends are one: nobody moves it
        page.set_control('turn (deg)', 30.0)
        assert listener.until(lambda: bool(heard))
        page.set_control('slide (mm)', 20.0)
        slide = Skeleton.load(path).coordinates.index('slide')
        assert listener.until(lambda: abs(heard[-1].position[slide] - 0.02) < 1e-12)
        for message in heard:
            at = dict(zip(message.name, message.position, strict=True))
            assert 0.01 <= at['slide'] <= 0.05
            assert abs(at['turn'] - math.radians(30.0)) < 1e-12
            assert abs(at['stuck'] - 0.2) < 1e-12
        assert 'a number from 10 to 50 expected' in viewer.text
        assert 'Traceback' not in viewer.text
    listener.destroy_node()
