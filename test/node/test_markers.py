"""The markers: one for each thing to see, stable from state to state, placed as the solver says."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from scipy.spatial.transform import Rotation
from visualization_msgs.msg import Marker, MarkerArray

from linkedplane_ros import (
    JOINT_CONVENTIONS,
    BroadMuscle,
    LinkedPlaneSolver,
    MuscleState,
    WrapState,
)
from linkedplane_ros.drawing.bones import BONE
from linkedplane_ros.drawing.colours import SHARED, head_colours
from linkedplane_ros.drawing.shapes import upright_turned
from linkedplane_ros.node.markers import MuscleMarkers

EXACT = 1e-12  # m: a marker holds the solver's numbers
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side) for side in ('right', 'left'))
STAMP = Time(sec=12, nanosec=345)
POSES = [
    THESIS.rotation(angles)
    for angles in ((0.0, 0.0, 0.0), (0.0, 1.6, 0.0), (1.4, 0.1, 0.3), (-0.5, 0.4, -0.8), (2, 1, 1))
]
MIRROR = (-1.0, 1.0, 1.0)
Array = np.ndarray
# the machine may be busy: nothing here is about time
unhurried = settings(deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])

# The sphere of the first band is blown up until it holds the band's end where the arm hangs.
WIDE = dataclasses.replace(DELTOID, sphere_radii=np.append(0.1, DELTOID.sphere_radii[1:]))


def pairs(side: LinkedPlaneSolver, points: int = 16) -> Iterator[tuple[MuscleState, MarkerArray]]:
    """Return states and their markers, all made by the same MuscleMarkers."""
    markers = MuscleMarkers(DELTOID, 'scapula', points)
    for rotation in POSES:
        state = side.solve(rotation)
        yield state, markers.at(state, STAMP)


def sent(array: MarkerArray) -> MarkerArray:
    """Return a copy of the markers as the middleware gives it to a receiver."""
    return deserialize_message(serialize_message(array), MarkerArray)


def of(array: MarkerArray, namespace: str) -> list[Marker]:
    """Return the markers of one namespace in order of id."""
    found = sorted((m for m in array.markers if m.ns == namespace), key=lambda marker: marker.id)
    assert [marker.id for marker in found] == list(range(len(found)))
    return found


def place(point: Point) -> Array:
    return np.array((point.x, point.y, point.z))


def places(marker: Marker) -> Array:
    return np.array([(p.x, p.y, p.z) for p in marker.points])


def colour(marker: Marker) -> tuple[float, float, float]:
    return marker.color.r, marker.color.g, marker.color.b


def turned(turn: Quaternion) -> Rotation:
    return Rotation.from_quat((turn.x, turn.y, turn.z, turn.w))


def numbers(marker: Marker) -> list[float]:
    """Return every number that RViz would refuse the marker for if it were not finite."""
    pose, scale = marker.pose, marker.scale
    turn = pose.orientation
    colours = [marker.color, *marker.colors]
    return [
        *place(pose.position), turn.x, turn.y, turn.z, turn.w, scale.x, scale.y, scale.z,
        *places(marker).ravel(), *(x for c in colours for x in (c.r, c.g, c.b, c.a)),
    ]  # fmt: skip


def test_the_namespaces_hold_what_there_is_to_see() -> None:
    array = next(pairs(RIGHT))[1]
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
    assert [len(of(array, namespace)) for namespace in each_band] == [9, 9, 9, 9]
    assert [len(of(array, ns)) for ns in ('attachments', 'interference_spheres')] == [2, 3]


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_no_two_markers_have_one_key_and_the_keys_and_types_never_change(
    side: LinkedPlaneSolver,
) -> None:
    seen = [[(m.ns, m.id, m.type) for m in array.markers] for _, array in pairs(side)]
    assert all(keys == seen[0] for keys in seen)
    assert len({key[:2] for key in seen[0]}) == len(seen[0])


@pytest.mark.parametrize('points', [2, 16, 33])
@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_the_strip_of_a_band_is_its_path(side: LinkedPlaneSolver, points: int) -> None:
    wraps = set()
    for state, array in pairs(side, points):
        wraps |= set(state.wrap.tolist())
        for marker, path in zip(of(array, 'bands'), state.paths(points), strict=True):
            assert marker.action == Marker.ADD
            np.testing.assert_allclose(places(marker), path, rtol=0.0, atol=EXACT)
            assert marker.pose.orientation == Quaternion(w=1.0)
            assert place(marker.pose.position).tolist() == [0.0, 0.0, 0.0]
    assert wraps == {WrapState.WRAPPED, WrapState.CLEAR, WrapState.MISSED}


def test_a_band_that_loses_its_sphere_and_wraps_again_shows_no_old_point() -> None:
    markers = MuscleMarkers(DELTOID, 'scapula', 16)
    sizes = []
    for rotation in (POSES[0], POSES[1], POSES[0]):
        array = sent(markers.at(RIGHT.solve(rotation), STAMP))
        sizes.append([len(marker.points) for marker in of(array, 'bands')])
    assert sizes[0] == sizes[2]
    assert 18 in sizes[0]
    assert 2 in sizes[1]


def test_bands_and_their_ends_and_spheres_have_the_colour_of_their_head() -> None:
    array = next(pairs(RIGHT))[1]
    colours = head_colours(DELTOID)
    by_head = {DELTOID.head_of(band): colours[i] for i, band in enumerate(DELTOID.band_names)}
    assert len(set(by_head.values())) == len(DELTOID.heads) == 3
    for i, band in enumerate(DELTOID.band_names):
        want = by_head[DELTOID.head_of(band)]
        # a colour is stored in single precision
        assert colour(of(array, 'bands')[i]) == pytest.approx(want, abs=1e-6)
        assert colour(of(array, 'obstacle_spheres')[i]) == pytest.approx(want, abs=1e-6)
        for ends in of(array, 'attachments'):
            shown = ends.colors[i]
            assert (shown.r, shown.g, shown.b) == pytest.approx(want, abs=1e-6)
            assert shown.a == 1.0
    for bone in of(array, 'bones'):
        assert colour(bone) == pytest.approx(BONE, abs=1e-6)


def test_bands_are_opaque_and_spheres_let_them_show_through() -> None:
    array = next(pairs(RIGHT))[1]
    assert all(marker.color.a == 1.0 for marker in of(array, 'bands'))
    assert all(0.0 < marker.color.a < 0.5 for marker in of(array, 'obstacle_spheres'))


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_an_obstacle_sphere_stands_at_its_centre_with_its_diameter(side: LinkedPlaneSolver) -> None:
    for state, array in pairs(side):
        for i, marker in enumerate(of(array, 'obstacle_spheres')):
            centre = state.sphere_centres[i]
            np.testing.assert_allclose(place(marker.pose.position), centre, rtol=0.0, atol=EXACT)
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
    markers = sent(MuscleMarkers(shared, 'scapula', 16).at(state, STAMP)).markers
    spheres = [marker for marker in markers if marker.ns == 'obstacle_spheres']
    assert [marker.id for marker in spheres] == [0, 5, 6, 7, 8]
    assert colour(spheres[0]) == pytest.approx(SHARED, abs=1e-6)  # of two heads
    for marker in spheres:
        centre = state.sphere_centres[marker.id]
        np.testing.assert_allclose(place(marker.pose.position), centre, rtol=0.0, atol=EXACT)


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_an_interference_sphere_stands_where_the_thesis_has_it(side: LinkedPlaneSolver) -> None:
    mirror = MIRROR if side is LEFT else (1.0, 1.0, 1.0)
    for _, array in pairs(side):
        for k, marker in enumerate(of(array, 'interference_spheres')):
            centre = DELTOID.interference_centres[k] * mirror
            np.testing.assert_allclose(place(marker.pose.position), centre, rtol=0.0, atol=EXACT)
            assert marker.scale.x == 2.0 * DELTOID.interference_radii[k]


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_a_band_is_marked_just_where_its_path_is_deepest_in_a_sphere(
    side: LinkedPlaneSolver,
) -> None:
    centres = side.mirrored(DELTOID.interference_centres)
    radii = DELTOID.interference_radii
    marked = []
    for state, array in pairs(side):
        # finely drawn: chords over 1/999 of an arc are less than 1e-8 m off it
        paths = [refined(path) for path in state.paths(1000)]
        for path, mark in zip(paths, of(array, 'interferences'), strict=True):
            apart = np.linalg.norm(path[:, np.newaxis] - centres, axis=2).min(axis=0)
            assert (mark.action == Marker.ADD) == bool((radii - apart >= 0.0).any())
            marked.append(mark.action == Marker.ADD)
            if marked[-1]:
                at = place(mark.pose.position)
                k = (radii - apart).argmax()
                # points 1e-4 m apart: 1.6 mm from a centre, the closest is 8e-7 m off
                assert np.linalg.norm(at - centres[k]) == pytest.approx(apart[k], abs=1e-6)
                assert np.linalg.norm(path - at, axis=1).min() < 1e-4
    assert any(marked)
    assert not all(marked)


def refined(path: Array) -> Array:
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
    array = MuscleMarkers(free, 'scapula', 16).at(LinkedPlaneSolver(free).solve(POSES[0]), STAMP)
    assert not {'interferences', 'interference_spheres'} & {marker.ns for marker in array.markers}


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_the_patch_of_a_plane_holds_its_band_and_lies_on_the_side_of_the_bulge(
    side: LinkedPlaneSolver,
) -> None:
    for state, array in pairs(side):
        for marker, path in zip(of(array, 'planes'), state.paths(9), strict=True):
            origin, insertion, beyond = places(marker)[:3]
            aside = beyond - insertion
            assert aside @ (insertion - origin) == pytest.approx(0.0, abs=EXACT)
            normal = np.cross(insertion - origin, aside)
            normal /= np.linalg.norm(normal)
            np.testing.assert_allclose((path - origin) @ normal, 0.0, atol=EXACT)
            assert ((path - origin) @ aside).min() > -EXACT


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_attachments_are_the_origins_and_the_insertions(side: LinkedPlaneSolver) -> None:
    for state, array in pairs(side):
        origins, insertions = of(array, 'attachments')
        np.testing.assert_allclose(places(origins), side.origins, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(places(insertions), state.insertions, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(
            places(of(array, 'bones')[2]), side.origins, rtol=0.0, atol=EXACT
        )


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_the_shaft_lies_along_the_humerus(side: LinkedPlaneSolver) -> None:
    mirror = np.array(MIRROR if side is LEFT else (1.0, 1.0, 1.0))
    for state, array in pairs(side):
        shaft = of(array, 'bones')[1]
        turn = shaft.pose.orientation
        norm = math.hypot(turn.x, turn.y, turn.z, turn.w)
        assert norm == pytest.approx(1.0, abs=1e-9)
        axis = state.rotation[:, 2] * mirror
        np.testing.assert_allclose(turned(turn).apply((0.0, 0.0, 1.0)), axis, atol=1e-9)
        # it goes down from the head, which is at the centre of the joint
        assert place(shaft.pose.position) @ axis == pytest.approx(-0.115, abs=1e-9)
        assert place(of(array, 'bones')[0].pose.position).tolist() == [0.0, 0.0, 0.0]


@unhurried
@given(st.floats(-math.pi, math.pi), st.one_of(st.floats(0.0, math.pi), st.just(math.pi)))
def test_any_axis_is_reached_by_a_unit_quaternion(around: float, down: float) -> None:
    axis = np.array(
        (math.sin(down) * math.cos(around), math.sin(down) * math.sin(around), math.cos(down))
    )
    turn = upright_turned(axis)
    # hanging upside down costs digits: half of them at the worst
    assert np.linalg.norm(turn) == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_allclose(
        Rotation.from_quat(turn).apply((0.0, 0.0, 1.0)), axis, rtol=0.0, atol=1e-4
    )


def test_markers_stay_until_they_are_replaced_and_follow_the_frame() -> None:
    for frame in ('scapula', 'body/right_scapula'):
        markers = MuscleMarkers(DELTOID, frame, 16)
        for k, rotation in enumerate(POSES):
            stamp = Time(sec=100 + k, nanosec=7 * k)
            for marker in markers.at(RIGHT.solve(rotation), stamp).markers:
                assert marker.header.frame_id == frame
                assert marker.header.stamp == stamp
                assert marker.frame_locked
                assert (marker.lifetime.sec, marker.lifetime.nanosec) == (0, 0)


def test_clearing_removes_every_marker_of_every_namespace() -> None:
    [marker] = MuscleMarkers(DELTOID, 'scapula', 16).clear(STAMP).markers
    assert marker.action == Marker.DELETEALL
    assert marker.ns == ''
    assert marker.header.frame_id == 'scapula'
    assert marker.header.stamp == STAMP


def test_the_same_markers_are_moved_from_state_to_state() -> None:
    markers = MuscleMarkers(DELTOID, 'scapula', 16)
    first = list(markers.at(RIGHT.solve(POSES[0]), STAMP).markers)
    points = [id(point) for point in first[-1].points[:2]]
    second = markers.at(RIGHT.solve(POSES[2]), STAMP).markers
    assert all(one is other for one, other in zip(first, second, strict=True))
    assert [id(point) for point in second[-1].points[:2]] == points


def test_two_sets_of_markers_do_not_share_any() -> None:
    one, other = (
        MuscleMarkers(DELTOID, 'scapula', 16).at(RIGHT.solve(rotation), STAMP)
        for rotation in POSES[:2]
    )
    assert not {id(marker) for marker in one.markers} & {id(marker) for marker in other.markers}


def test_a_band_with_an_end_inside_its_sphere_is_deleted_and_comes_back() -> None:
    solver = LinkedPlaneSolver(WIDE)
    markers = MuscleMarkers(WIDE, 'scapula', 16)
    rotations = [np.eye(3), *POSES]
    actions = []
    for rotation in rotations:
        state = solver.solve(rotation)
        for marker, wrap in zip(
            of(markers.at(state, STAMP), 'bands'), state.wrap.tolist(), strict=True
        ):
            inside = wrap == WrapState.INSIDE
            assert marker.action == (Marker.DELETE if inside else Marker.ADD)
        actions.append(of(markers.at(state, STAMP), 'bands')[0].action)
    assert actions[0] == Marker.DELETE
    usual = MuscleMarkers(WIDE, 'scapula', 16)
    usual.at(solver.solve(np.eye(3)), STAMP)
    back = of(usual.at(RIGHT.solve(np.eye(3)), STAMP), 'bands')[0]
    assert back.action == Marker.ADD
    assert len(back.points) >= 2


def test_the_left_shoulder_is_the_mirror_image_of_the_right() -> None:
    for (_, right), (_, left) in zip(pairs(RIGHT), pairs(LEFT), strict=True):
        for one, other in zip(right.markers, left.markers, strict=True):
            assert (one.ns, one.id, one.type) == (other.ns, other.id, other.type)
            assert one.color == other.color
            assert one.scale == other.scale
            assert len(one.points) == len(other.points)
            if one.points:
                np.testing.assert_allclose(
                    places(one) * MIRROR, places(other), rtol=0.0, atol=EXACT
                )
            position = place(one.pose.position) * MIRROR
            np.testing.assert_allclose(position, place(other.pose.position), rtol=0.0, atol=EXACT)


@unhurried
@given(st.tuples(*[st.floats(-6.0, 6.0)] * 3), st.sampled_from([RIGHT, LEFT]))
def test_no_marker_holds_a_number_that_is_not_finite(
    angles: tuple[float, float, float], side: LinkedPlaneSolver
) -> None:
    state = side.solve(THESIS.rotation(angles))
    for marker in MARKERS.at(state, STAMP).markers:
        assert np.isfinite(numbers(marker)).all()
        assert marker.scale.x > 0.0


MARKERS = MuscleMarkers(DELTOID, 'scapula', 16)


def test_the_markers_come_out_of_the_middleware_as_they_went_in() -> None:
    for _, array in pairs(RIGHT):
        for one, other in zip(sent(array).markers, array.markers, strict=True):
            assert (one.header, one.ns, one.id, one.type) == (
                other.header,
                other.ns,
                other.id,
                other.type,
            )
            assert (one.pose, one.scale, one.points) == (other.pose, other.scale, other.points)
            # a colour is stored in single precision
            assert numbers(one) == pytest.approx(numbers(other), abs=1e-6)
