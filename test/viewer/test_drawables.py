# SPDX-License-Identifier: Apache-2.0
"""From the bytes of a message to what is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Vector3
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from scipy.spatial.transform import Rotation
from std_msgs.msg import ColorRGBA
from unhurried import unhurried
from visualization_msgs.msg import Marker, MarkerArray

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.drawing.colours import head_colours
from linkedplane_ros.node.markers import MuscleMarkers
from linkedplane_ros.viewer.scene import wire
from linkedplane_ros.viewer.scene.geometry import (
    Bodies,
    Lines,
    Markers,
    Sheets,
    apply_message,
    drawables,
)

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
STATE = SOLVER.solve(THESIS.rotation((0.9, 0.3, 0.1)))
ARRAY = MuscleMarkers(DELTOID, 'scapula', 16).update(STATE, Time(sec=3))


def kept(*arrays: MarkerArray) -> Markers:
    """Return the markers that are left of messages."""
    markers: Markers = {}
    for array in arrays:
        apply_message(markers, wire.read_markers(serialize_message(array)))
    return markers


# Bytes to arrays

reals = st.floats(-1e3, 1e3)
singles = st.floats(0.0, 1.0, width=32)
words = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)
places = st.builds(lambda x, y, z: Point(x=x, y=y, z=z), reals, reals, reals)
paints = st.builds(lambda r, g, b, a: ColorRGBA(r=r, g=g, b=b, a=a), *[singles] * 4)


@st.composite
def any_markers(draw: st.DrawFn) -> Marker:
    marker = Marker(
        ns=draw(words),
        id=draw(st.integers(-(2**31), 2**31 - 1)),
        type=draw(st.integers(0, 12)),
        action=draw(st.sampled_from([0, 2, 3])),
        color=draw(paints),
        points=draw(st.lists(places, max_size=4)),
        colors=draw(st.lists(paints, max_size=3)),
        scale=draw(st.builds(lambda x, y, z: Vector3(x=x, y=y, z=z), reals, reals, reals)),
        frame_locked=draw(st.booleans()),
        text=draw(words),
        mesh_resource=draw(words),
        texture_resource=draw(words),
    )
    marker.header.frame_id = draw(words)
    marker.texture.format = draw(words)
    marker.texture.data = draw(st.binary(max_size=5))
    marker.mesh_file.data = draw(st.binary(max_size=5))
    marker.pose.position = draw(places)
    marker.pose.orientation = Quaternion(x=draw(reals), w=draw(reals))
    return marker


@unhurried
@given(st.lists(any_markers(), max_size=4))
def test_a_marker_array_is_read_as_rclpy_reads_it(sent: list[Marker]) -> None:
    found = wire.read_markers(serialize_message(MarkerArray(markers=sent)))
    for one, other in zip(found, sent, strict=True):
        turn, scale, colour = other.pose.orientation, other.scale, other.color
        position = other.pose.position
        assert (one.namespace, one.number) == (other.ns, other.id)
        assert (one.kind, one.action) == (other.type, other.action)
        assert one.position.tolist() == [position.x, position.y, position.z]
        assert one.orientation.tolist() == [turn.x, turn.y, turn.z, turn.w]
        assert one.scale.tolist() == [scale.x, scale.y, scale.z]
        assert one.colour.tolist() == [colour.r, colour.g, colour.b, colour.a]
        assert one.points.tolist() == [[p.x, p.y, p.z] for p in other.points]
        assert one.colours.tolist() == [[c.r, c.g, c.b, c.a] for c in other.colors]


@pytest.mark.parametrize('size', [0, 3, 20, 200])
def test_a_torn_message_is_refused(size: int) -> None:
    with pytest.raises(ValueError, match='not a serialised MarkerArray'):
        wire.read_markers(serialize_message(ARRAY)[:size])


# Markers to drawables


def test_a_marker_is_replaced_by_its_like_and_removed_by_name_or_all_at_once() -> None:
    one = Marker(ns='a', id=1, type=Marker.SPHERE)
    gone = Marker(ns='a', id=1, action=Marker.DELETE)
    other = Marker(ns='b', id=1, type=Marker.SPHERE)
    both = MarkerArray(markers=[one, other])
    assert set(kept(both, both)) == {('a', 1), ('b', 1)}
    assert set(kept(both, MarkerArray(markers=[gone]))) == {('b', 1)}
    assert set(kept(both, MarkerArray(markers=[Marker(action=Marker.DELETEALL)]))) == set()


def test_the_lines_of_the_bands_are_the_paths_of_the_solver() -> None:
    drawn = drawables(kept(ARRAY))['bands/lines']
    assert isinstance(drawn, Lines)
    pieces = [np.stack((path[:-1], path[1:]), axis=1) for path in STATE.paths(16)]
    np.testing.assert_array_equal(drawn.points, np.concatenate(pieces))
    own = np.repeat(head_colours(DELTOID), [len(piece) for piece in pieces], axis=0)
    np.testing.assert_array_equal(drawn.colours[:, 0], np.rint(255 * own))
    assert drawn.width == 0.004


def test_bands_take_colours_that_are_given_and_nothing_else_does() -> None:
    paint = {i: (i, 100, 200) for i in range(9)}
    plain, painted = drawables(kept(ARRAY)), drawables(kept(ARRAY), paint)
    counts = [len(path) - 1 for path in STATE.paths(16)]
    np.testing.assert_array_equal(
        painted['bands/lines'].colours[:, 1, 0], np.repeat(np.arange(9), counts)
    )
    for name in set(plain) - {'bands/lines', 'planes'}:
        if hasattr(plain[name], 'colours'):
            np.testing.assert_array_equal(plain[name].colours, painted[name].colours)


def test_spheres_and_cylinders_are_bodies_where_they_were_put() -> None:
    drawn = drawables(kept(ARRAY))
    spheres, head, shaft = (
        drawn[name] for name in ('obstacle_spheres/balls', 'bones/balls', 'bones/rods')
    )
    assert isinstance(spheres, Bodies)
    np.testing.assert_array_equal(spheres.positions, STATE.sphere_centres)
    np.testing.assert_array_equal(spheres.sizes[:, 0], 2.0 * DELTOID.sphere_radii)
    assert spheres.opacity == pytest.approx(0.12)
    assert head.opacity == 1.0
    w, x, y, z = shaft.orientations[0]
    down = Rotation.from_quat((x, y, z, w)).apply((0.0, 0.0, 1.0))
    np.testing.assert_allclose(down, STATE.rotation[:, 2], atol=1e-9)


def test_the_two_lists_of_attachments_are_one_with_the_colours_of_their_heads() -> None:
    ends = drawables(kept(ARRAY))['attachments/balls']
    np.testing.assert_array_equal(
        ends.positions, np.concatenate((SOLVER.origins, STATE.insertions))
    )
    np.testing.assert_array_equal(ends.colours[:9], np.rint(255 * np.array(head_colours(DELTOID))))


def test_the_planes_of_a_head_are_one_sheet() -> None:
    sheets = [each for each in drawables(kept(ARRAY)).values() if isinstance(each, Sheets)]
    assert [each.points.shape for each in sheets] == [(18, 3)] * 3


def test_points_are_placed_by_the_pose_of_their_marker() -> None:
    turn = Rotation.from_rotvec((0.3, -0.5, 1.1))
    x, y, z, w = turn.as_quat().tolist()
    marker = Marker(ns='a', type=Marker.LINE_LIST, points=[Point(x=0.1, y=0.2), Point(z=0.3)])
    marker.pose.position = Point(x=1.0, y=2.0, z=3.0)
    marker.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
    [drawn] = drawables(kept(MarkerArray(markers=[marker]))).values()
    moved = np.array((1.0, 2.0, 3.0))
    expected = turn.apply([(0.1, 0.2, 0.0), (0.0, 0.0, 0.3)]) + moved
    np.testing.assert_allclose(drawn.points[0], expected, atol=1e-12)


def test_markers_that_the_viewer_does_not_know_are_not_drawn() -> None:
    assert drawables(kept(MarkerArray(markers=[Marker(ns='a', type=Marker.CUBE)]))) == {}
