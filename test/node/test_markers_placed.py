# SPDX-License-Identifier: Apache-2.0
"""The markers: one for each thing to see, placed and coloured as the solver says."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from shown_markers import (
    POSES,
    in_namespace,
    point_array,
    points_array,
    states_with_markers,
    through_middleware,
)
from unhurried import unhurried
from visualization_msgs.msg import Marker

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.drawing.bones import BONE
from linkedplane_ros.drawing.colours import SHARED, head_colours
from linkedplane_ros.drawing.shapes import quaternion_from_z_axis
from linkedplane_ros.node.markers import MuscleMarkers

EXACT = 1e-12  # m: a marker holds the solver's numbers
DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side) for side in ('right', 'left'))
STAMP = Time(sec=12, nanosec=345)
MIRRORED = (-1.0, 1.0, 1.0)
Array = np.ndarray


def rgb(marker: Marker) -> tuple[float, float, float]:
    return marker.color.r, marker.color.g, marker.color.b


def orientation(turn: Quaternion) -> Rotation:
    return Rotation.from_quat((turn.x, turn.y, turn.z, turn.w))


def test_the_namespaces_hold_what_there_is_to_see() -> None:
    array = next(states_with_markers(RIGHT))[1]
    kinds = {(marker.ns, marker.type) for marker in array.markers}
    assert kinds == {
        ('bands', Marker.LINE_STRIP),
        ('obstacle_spheres', Marker.SPHERE),
        ('interference_spheres', Marker.SPHERE),
        ('interferences', Marker.SPHERE),
        ('planes', Marker.TRIANGLE_LIST),
        ('attachments', Marker.SPHERE_LIST),
        ('bones', Marker.SPHERE),
        ('bones', Marker.CYLINDER),
        ('bones', Marker.LINE_STRIP),
    }
    each_band = ('bands', 'obstacle_spheres', 'planes', 'interferences')
    assert [len(in_namespace(array, namespace)) for namespace in each_band] == [9, 9, 9, 9]
    assert [len(in_namespace(array, ns)) for ns in ('attachments', 'interference_spheres')] == [
        2,
        3,
    ]


@pytest.mark.parametrize('points', [2, 16, 33])
@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_the_strip_of_a_band_is_its_path(side: LinkedPlaneSolver, points: int) -> None:
    wraps = set()
    for state, array in states_with_markers(side, points):
        wraps |= set(state.wrap.tolist())
        for marker, path in zip(in_namespace(array, 'bands'), state.paths(points), strict=True):
            assert marker.action == Marker.ADD
            np.testing.assert_allclose(points_array(marker), path, rtol=0.0, atol=EXACT)
            assert marker.pose.orientation == Quaternion(w=1.0)
            assert point_array(marker.pose.position).tolist() == [0.0, 0.0, 0.0]
    assert wraps == {WrapState.WRAPPED, WrapState.CLEAR, WrapState.MISSED}


def test_bands_and_their_ends_and_spheres_have_the_colour_of_their_head() -> None:
    array = next(states_with_markers(RIGHT))[1]
    colours = head_colours(DELTOID)
    by_head = {DELTOID.find_head(band): colours[i] for i, band in enumerate(DELTOID.band_names)}
    assert len(set(by_head.values())) == len(DELTOID.heads) == 3
    for i, band in enumerate(DELTOID.band_names):
        want = by_head[DELTOID.find_head(band)]
        # a colour is stored in single precision
        assert rgb(in_namespace(array, 'bands')[i]) == pytest.approx(want, abs=1e-6)
        assert rgb(in_namespace(array, 'obstacle_spheres')[i]) == pytest.approx(want, abs=1e-6)
        for ends in in_namespace(array, 'attachments'):
            shown = ends.colors[i]
            assert (shown.r, shown.g, shown.b) == pytest.approx(want, abs=1e-6)
            assert shown.a == 1.0
    for bone in in_namespace(array, 'bones'):
        assert rgb(bone) == pytest.approx(BONE, abs=1e-6)


def test_bands_are_opaque_and_spheres_let_them_show_through() -> None:
    array = next(states_with_markers(RIGHT))[1]
    assert all(marker.color.a == 1.0 for marker in in_namespace(array, 'bands'))
    assert all(0.0 < marker.color.a < 0.5 for marker in in_namespace(array, 'obstacle_spheres'))


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_an_obstacle_sphere_stands_at_its_centre_with_its_diameter(side: LinkedPlaneSolver) -> None:
    for state, array in states_with_markers(side):
        for i, marker in enumerate(in_namespace(array, 'obstacle_spheres')):
            centre = state.sphere_centres[i]
            np.testing.assert_allclose(
                point_array(marker.pose.position), centre, rtol=0.0, atol=EXACT
            )
            scale = np.array((marker.scale.x, marker.scale.y, marker.scale.z))
            np.testing.assert_allclose(scale, 2.0 * DELTOID.sphere_radii[i], rtol=0.0, atol=EXACT)


def test_a_sphere_that_bands_share_is_shown_once() -> None:
    shared = dataclasses.replace(
        DELTOID,
        sphere_frame=('humerus',) * 5 + ('moving',) * 4,
        sphere_centres=np.tile([0.0, 0.001, 0.002], (9, 1)),
        sphere_radii=np.full(9, 0.02),
    )
    state = LinkedPlaneSolver(shared).solve(POSES[1])
    markers = through_middleware(MuscleMarkers(shared, 'scapula', 16).update(state, STAMP)).markers
    spheres = [marker for marker in markers if marker.ns == 'obstacle_spheres']
    assert [marker.id for marker in spheres] == [0, 5, 6, 7, 8]
    assert rgb(spheres[0]) == pytest.approx(SHARED, abs=1e-6)  # of two heads
    for marker in spheres:
        centre = state.sphere_centres[marker.id]
        np.testing.assert_allclose(point_array(marker.pose.position), centre, rtol=0.0, atol=EXACT)


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_an_interference_sphere_stands_where_the_thesis_has_it(side: LinkedPlaneSolver) -> None:
    mirror = MIRRORED if side is LEFT else (1.0, 1.0, 1.0)
    for _, array in states_with_markers(side):
        for k, marker in enumerate(in_namespace(array, 'interference_spheres')):
            centre = DELTOID.interference_centres[k] * mirror
            np.testing.assert_allclose(
                point_array(marker.pose.position), centre, rtol=0.0, atol=EXACT
            )
            assert marker.scale.x == 2.0 * DELTOID.interference_radii[k]


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_a_band_is_marked_just_where_its_path_is_deepest_in_a_sphere(
    side: LinkedPlaneSolver,
) -> None:
    centres = side.to_side(DELTOID.interference_centres)
    radii = DELTOID.interference_radii
    marked = []
    for state, array in states_with_markers(side):
        # finely drawn: chords over 1/999 of an arc are less than 1e-8 m off it
        paths = [finely_sampled(path) for path in state.paths(1000)]
        for path, mark in zip(paths, in_namespace(array, 'interferences'), strict=True):
            apart = np.linalg.norm(path[:, np.newaxis] - centres, axis=2).min(axis=0)
            assert (mark.action == Marker.ADD) == bool((radii - apart >= 0.0).any())
            marked.append(mark.action == Marker.ADD)
            if marked[-1]:
                at = point_array(mark.pose.position)
                k = (radii - apart).argmax()
                # points 1e-4 m apart: 1.6 mm from a centre, the closest is 8e-7 m off
                assert np.linalg.norm(at - centres[k]) == pytest.approx(apart[k], abs=1e-6)
                assert np.linalg.norm(path - at, axis=1).min() < 1e-4
    assert any(marked)
    assert not all(marked)


def finely_sampled(path: Array) -> Array:
    """Return a polyline with a point every 1e-4 m at least."""
    pieces = [np.linspace(a, b, 2 + int(np.linalg.norm(b - a) / 1e-4)) for a, b in pairwise(path)]
    return np.concatenate(pieces)


def test_a_muscle_without_interference_spheres_has_no_marks() -> None:
    free = dataclasses.replace(
        DELTOID,
        interference_centres=np.empty((0, 3)),
        interference_radii=np.empty(0),
        interference_names=(),
    )
    array = MuscleMarkers(free, 'scapula', 16).update(
        LinkedPlaneSolver(free).solve(POSES[0]), STAMP
    )
    assert not {'interferences', 'interference_spheres'} & {marker.ns for marker in array.markers}


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_the_patch_of_a_plane_holds_its_band_and_lies_on_the_side_of_the_bulge(
    side: LinkedPlaneSolver,
) -> None:
    for state, array in states_with_markers(side):
        for marker, path in zip(in_namespace(array, 'planes'), state.paths(9), strict=True):
            origin, insertion, beyond = points_array(marker)[:3]
            aside = beyond - insertion
            assert aside @ (insertion - origin) == pytest.approx(0.0, abs=EXACT)
            normal = np.cross(insertion - origin, aside)
            normal /= np.linalg.norm(normal)
            np.testing.assert_allclose((path - origin) @ normal, 0.0, atol=EXACT)
            assert ((path - origin) @ aside).min() > -EXACT


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_attachments_are_the_origins_and_the_insertions(side: LinkedPlaneSolver) -> None:
    for state, array in states_with_markers(side):
        origins, insertions = in_namespace(array, 'attachments')
        np.testing.assert_allclose(points_array(origins), side.origins, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(points_array(insertions), state.insertions, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(
            points_array(in_namespace(array, 'bones')[2]), side.origins, rtol=0.0, atol=EXACT
        )


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_the_shaft_lies_along_the_humerus(side: LinkedPlaneSolver) -> None:
    mirror = np.array(MIRRORED if side is LEFT else (1.0, 1.0, 1.0))
    for state, array in states_with_markers(side):
        shaft = in_namespace(array, 'bones')[1]
        turn = shaft.pose.orientation
        norm = math.hypot(turn.x, turn.y, turn.z, turn.w)
        assert norm == pytest.approx(1.0, abs=1e-9)
        axis = state.rotation[:, 2] * mirror
        np.testing.assert_allclose(orientation(turn).apply((0.0, 0.0, 1.0)), axis, atol=1e-9)
        # it goes down from the head, which is at the centre of the joint
        assert point_array(shaft.pose.position) @ axis == pytest.approx(-0.115, abs=1e-9)
        assert point_array(in_namespace(array, 'bones')[0].pose.position).tolist() == [
            0.0,
            0.0,
            0.0,
        ]


@unhurried
@given(st.floats(-math.pi, math.pi), st.one_of(st.floats(0.0, math.pi), st.just(math.pi)))
def test_any_axis_is_reached_by_a_unit_quaternion(around: float, down: float) -> None:
    axis = np.array(
        (math.sin(down) * math.cos(around), math.sin(down) * math.sin(around), math.cos(down))
    )
    turn = quaternion_from_z_axis(axis)
    # hanging upside down costs digits: half of them at the worst
    assert np.linalg.norm(turn) == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_allclose(
        Rotation.from_quat(turn).apply((0.0, 0.0, 1.0)), axis, rtol=0.0, atol=1e-4
    )


def test_the_left_shoulder_is_the_mirror_image_of_the_right() -> None:
    for (_, right), (_, left) in zip(
        states_with_markers(RIGHT), states_with_markers(LEFT), strict=True
    ):
        for one, other in zip(right.markers, left.markers, strict=True):
            assert (one.ns, one.id, one.type) == (other.ns, other.id, other.type)
            assert one.color == other.color
            assert one.scale == other.scale
            assert len(one.points) == len(other.points)
            if one.points:
                np.testing.assert_allclose(
                    points_array(one) * MIRRORED, points_array(other), rtol=0.0, atol=EXACT
                )
            position = point_array(one.pose.position) * MIRRORED
            np.testing.assert_allclose(
                position, point_array(other.pose.position), rtol=0.0, atol=EXACT
            )
