"""The viewer's parts that need no browser: bytes to drawables, colours, plots, motions."""

from __future__ import annotations

import math
from dataclasses import replace
from threading import Event

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
from linkedplane_ros.viewer.newest import Facts, Newest, Values
from linkedplane_ros.viewer.panels import motions
from linkedplane_ros.viewer.panels.history import Curve, Recent, side_by_side, widened
from linkedplane_ros.viewer.panels.table import table
from linkedplane_ros.viewer.scene import colour_map, wire
from linkedplane_ros.viewer.scene.camera import view
from linkedplane_ros.viewer.scene.geometry import Bodies, Lines, Markers, Sheets, apply, drawables

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
STATE = SOLVER.solve(THESIS.rotation((0.9, 0.3, 0.1)))
ARRAY = MuscleMarkers(DELTOID, 'scapula', 16).at(STATE, Time(sec=3))
LABELS = (THESIS.coordinates, DELTOID.band_names)


def kept(*arrays: MarkerArray) -> Markers:
    """Return the markers that are left of messages."""
    markers: Markers = {}
    for array in arrays:
        apply(markers, wire.markers(serialize_message(array)))
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
    found = wire.markers(serialize_message(MarkerArray(markers=sent)))
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
        wire.markers(serialize_message(ARRAY)[:size])


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
    w, x, y, z = shaft.turns[0]
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


# Colours


def test_equal_steps_of_the_map_look_equally_far_apart() -> None:
    steps = np.linalg.norm(np.diff(colour_map.oklab(np.linspace(-1, 1, 101)), axis=0), axis=1)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)


def test_a_screen_can_show_the_whole_map() -> None:
    shown = colour_map.screen(colour_map.oklab(np.linspace(-1, 1, 501)))
    assert 0.0 <= shown.min()
    assert shown.max() <= 1.0


def test_zero_is_grey_and_the_signs_can_be_told_apart() -> None:
    low, zero, high = colour_map.colours([-60.0, 0.0, 60.0], 60.0).astype(int)
    assert len(set(zero.tolist())) == 1
    assert low[2] - low[0] > 100
    assert high[0] - high[2] > 100


def test_oklab_white_is_white_on_the_screen() -> None:
    # the matrices' published digits are good to 1e-6
    white = colour_map.screen(np.array((1.0, 0.0, 0.0)))
    np.testing.assert_allclose(white, 1.0, atol=1e-6)


@pytest.mark.parametrize(
    ('value', 'rounded'),
    [(0.0, 1.0), (0.3, 0.5), (1.0, 1.0), (1.01, 2.0), (38.2, 50.0), (51.0, 100.0)],
)
def test_the_end_of_a_map_is_a_round_number(value: float, rounded: float) -> None:
    assert colour_map.round_up(value) == pytest.approx(rounded)


def test_the_legend_says_what_which_unit_and_the_ends() -> None:
    text = colour_map.legend('moment arm about flexion', 50.0, 'mm')
    for part in ('moment arm about flexion, mm', '-50', '+50', '>0<', 'linear-gradient'):
        assert part in text


# Plots


def test_the_last_seconds_are_kept_in_order() -> None:
    recent = Recent(1, 5)
    for k in range(8):
        recent.add(0.5 * k, [10.0 * k])
    np.testing.assert_array_equal(recent.last(10.0)[:, 1], [30, 40, 50, 60, 70])
    np.testing.assert_array_equal(recent.last(1.0)[:, 0], [2.5, 3.0, 3.5])
    assert Recent(1, 5).last(1.0).shape == (0, 2)


def test_a_curve_has_one_value_a_degree_whichever_way_it_was_gone() -> None:
    curve = Curve(1, -180.0, 180.0, 1.0)
    there = np.arange(0.0, 60.0, 0.1)
    for angle in [*there, *there[::-1], 400.0]:
        curve.add(angle, [2.0 * angle])
    known = curve.known()
    assert len(known) == 61
    assert (np.diff(known[:, 0]) > 0.0).all()
    np.testing.assert_allclose(known[:, 1], 2.0 * known[:, 0])


def test_curves_side_by_side_share_their_places_and_keep_their_ends() -> None:
    one = np.array(((0.0, 1.0), (2.0, 3.0), (4.0, 5.0)))
    other = np.array(((1.0, -1.0), (3.0, -3.0)))
    table = side_by_side([one, other, np.empty((0, 2))])
    np.testing.assert_array_equal(table[:, :2].T, [[0, 1, 2, 3, 4], [1, 2, 3, 4, 5]])
    np.testing.assert_array_equal(table[:, 2], [np.nan, -1, -2, -3, np.nan])
    assert np.isnan(table[:, 3]).all()
    np.testing.assert_array_equal(side_by_side([one]), one)


def test_a_plot_reaches_round_numbers_and_never_less_far_than_before() -> None:
    assert widened(None, [np.nan, 88.2, 151.0], 10.0) == (80.0, 160.0)
    assert widened((80.0, 160.0), [120.0, 189.5], 10.0) == (80.0, 200.0)  # with room
    assert widened((80.0, 160.0), [np.nan], 10.0) == (80.0, 160.0)
    assert widened(None, [np.nan], 10.0) is None


# Where it is seen from


def test_a_left_shoulder_is_seen_from_the_mirrored_place_and_both_from_the_middle() -> None:
    right, left = view(['right']), view(['left'])
    assert left == replace(
        right, place=(-right.place[0], *right.place[1:]), at=(-right.at[0], *right.at[1:])
    )
    assert right.place[0] > 0.0
    assert view(['left', 'right']).place[0] == 0.0


def test_a_narrow_picture_is_as_wide_as_the_view_needs_it_and_a_wide_one_no_farther() -> None:
    chosen = view(['right'])
    away = np.subtract(chosen.place, chosen.at)
    assert chosen.place_for(2.0) == pytest.approx(chosen.place)
    # half as wide at the same height: twice as far
    np.testing.assert_allclose(chosen.place_for(0.5 * chosen.aspect) - chosen.at, 2.0 * away)


# Motions


@pytest.mark.parametrize('name', JOINT_CONVENTIONS)
def test_the_end_poses_of_the_case_study_are_the_same_in_every_convention(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    found = motions.poses(convention)
    assert list(found) == ['neutral', 'flexion 80', 'abduction 90', 'scaption 60']
    scaption = math.sin(math.radians(30)), -math.cos(math.radians(30)), 0.0
    for (axis, degrees), angles in zip(
        (((1, 0, 0), 0), ((1, 0, 0), 80), ((0, -1, 0), 90), (scaption, 60)),
        found.values(),
        strict=True,
    ):
        expected = Rotation.from_rotvec(np.radians(degrees) * np.array(axis)).as_matrix()
        np.testing.assert_allclose(convention.rotation(angles), expected, atol=1e-9)
    for angles in found.values():
        for angle, (low, high) in zip(
            angles, motions.ranges(convention, DELTOID.range_of_motion), strict=True
        ):
            assert low - 1e-9 <= angle <= high + 1e-9


def test_a_glide_begins_and_ends_at_rest_and_its_speeds_are_its_slope() -> None:
    start, end = np.array((0.1, 0.0, -0.4)), np.array((1.3, 0.5, 0.2))
    glide = motions.Glide(start, end, 100.0)
    for now, place in ((100.0, start), (100.0 + glide.seconds, end), (1e6, end)):
        angles, speeds = glide.at(now)
        np.testing.assert_allclose(angles, place, atol=1e-12)
        np.testing.assert_allclose(speeds, 0.0, atol=1e-12)
    for now in np.linspace(100.01, 99.99 + glide.seconds, 9):
        slope = (glide.at(now + 1e-5)[0] - glide.at(now - 1e-5)[0]) / 2e-5
        np.testing.assert_allclose(glide.at(now)[1], slope, atol=1e-6)


def test_a_sweep_sets_out_from_where_the_arm_is_and_stays_in_its_range() -> None:
    arm = motions.Arm()
    arm.drag(np.array((0.5, 0.2, 0.1)), 0.0)
    arm.sweep(0, -0.7, 2.0, 0.0)
    times = np.arange(0.0, 30.0, 1 / 60)
    speeds, angles = [], []
    for now in times:
        speeds.append(arm.at(now))
        angles.append(arm.angles)
    angles = np.array(angles)
    np.testing.assert_allclose(angles[0], (0.5, 0.2, 0.1))
    np.testing.assert_allclose(angles[:, 1:], [(0.2, 0.1)] * len(times))
    assert angles[:, 0].min() == pytest.approx(-0.7, abs=1e-3)
    assert angles[:, 0].max() == pytest.approx(2.0, abs=1e-3)
    assert np.abs(np.diff(angles[:, 0])).max() < 0.05
    # the mean over a 60th of a second beside the speed at its end: 7 rad/s^2 make 0.06 rad/s
    np.testing.assert_allclose(np.diff(angles, axis=0) * 60, np.array(speeds)[1:], atol=0.1)


def test_a_dragged_arm_has_the_speed_of_the_hand_and_none_at_the_first_touch() -> None:
    arm = motions.Arm()
    assert arm.drag(np.array((0.1, 0.0, 0.0)), 5.0).tolist() == [0.0, 0.0, 0.0]
    assert arm.drag(np.array((0.2, 0.0, 0.0)), 5.1) == pytest.approx((1.0, 0.0, 0.0))
    assert arm.drag(np.array((0.3, 0.0, 0.0)), 9.0).tolist() == [0.0, 0.0, 0.0]
    assert not arm.moving


# The newest state


def test_only_the_newest_is_handed_over_and_markers_once() -> None:
    fresh = Event()
    newest = Newest(fresh)
    for k in range(100):
        newest.put_answer([bytes([k])], None, lengths=np.full(9, k))
    assert fresh.is_set()
    _, values, messages = newest.take()
    assert values.lengths is not None
    assert values.lengths[0] == 99
    assert values.answered == 100
    assert messages[-1] == bytes([99])
    assert len(messages) <= 10
    assert newest.take()[2] == []


def test_a_node_that_does_not_answer_is_known_by_its_labels() -> None:
    isb = JOINT_CONVENTIONS['isb_yxy']
    facts = Facts.told(isb.coordinates, ('a', 'b'), '/joint_states', {})
    assert facts.convention is isb
    assert facts.joints.names == isb.coordinates
    assert facts.heads == (('a', 0), ('b', 1))
    assert facts.motion is None


def test_a_node_that_answers_is_known_before_its_first_state() -> None:
    parameters = {'joint_convention': 'rep155', 'side': 'left', 'joint_signs': [1.0, -1.0, 1.0]}
    facts = Facts.told((), (), '/arm', parameters)
    assert facts.coordinates == ('y_shoulder', 'p_shoulder', 'r_shoulder')
    assert (facts.side, facts.joints.signs) == ('left', (1.0, -1.0, 1.0))
    assert facts.bands == DELTOID.band_names
    assert facts.heads == (('anterior', 1), ('middle', 3), ('posterior', 7))


def test_of_several_muscles_of_a_node_the_one_with_the_bands_tells_the_heads() -> None:
    parameters = {'muscle': ['example_shared_sphere', 'deltoid', 'absent.yaml']}
    facts = Facts.told(THESIS.coordinates, DELTOID.band_names, '/joint_states', parameters)
    assert facts.heads == (('anterior', 1), ('middle', 3), ('posterior', 7))
    assert Facts.told((), (), '/joint_states', parameters).bands == ()


def test_the_table_has_the_numbers_in_millimetres() -> None:
    facts = Facts.told(*LABELS, '/joint_states', {})
    arms = STATE.moment_vectors @ THESIS.axes((0.9, 0.3, 0.1))
    values = Values(lengths=STATE.lengths, arms=arms, wrap=STATE.wrap)
    text = table(facts, values, 1, {4})
    assert f'{1e3 * STATE.lengths[0]:.1f}' in text
    assert f'{1e3 * arms[8, 1]:.1f}' in text
    assert text.count('interferes') == 1
    assert text.index('middle_2') < text.index('interferes') < text.index('middle_3')
    assert 'None' not in table(facts, Values(), 0, set())
