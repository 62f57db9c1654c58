# SPDX-License-Identifier: Apache-2.0
"""The markers from state to state: stable keys, no old points, nothing that is not finite."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st
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

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.node.markers import MuscleMarkers

THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
DELTOID = BroadMuscle.load('deltoid')
RIGHT, LEFT = (LinkedPlaneSolver(DELTOID, side) for side in ('right', 'left'))
STAMP = Time(sec=12, nanosec=345)

# The sphere of the first band is blown up until it holds the band's end where the arm hangs.
WIDE = dataclasses.replace(DELTOID, sphere_radii=np.append(0.1, DELTOID.sphere_radii[1:]))


def numbers(marker: Marker) -> list[float]:
    """Return every number that RViz would refuse the marker for if it were not finite."""
    pose, scale = marker.pose, marker.scale
    turn = pose.orientation
    colours = [marker.color, *marker.colors]
    return [
        *point_array(pose.position), turn.x, turn.y, turn.z, turn.w, scale.x, scale.y, scale.z,
        *points_array(marker).ravel(), *(x for c in colours for x in (c.r, c.g, c.b, c.a)),
    ]  # fmt: skip


@pytest.mark.parametrize('side', [RIGHT, LEFT], ids=['right', 'left'])
def test_no_two_markers_have_one_key_and_the_keys_and_types_never_change(
    side: LinkedPlaneSolver,
) -> None:
    seen = [[(m.ns, m.id, m.type) for m in array.markers] for _, array in states_with_markers(side)]
    assert all(keys == seen[0] for keys in seen)
    assert len({key[:2] for key in seen[0]}) == len(seen[0])


def test_a_band_that_loses_its_sphere_and_wraps_again_shows_no_old_point() -> None:
    markers = MuscleMarkers(DELTOID, 'scapula', 16)
    sizes = []
    for rotation in (POSES[0], POSES[1], POSES[0]):
        array = through_middleware(markers.update(RIGHT.solve(rotation), STAMP))
        sizes.append([len(marker.points) for marker in in_namespace(array, 'bands')])
    assert sizes[0] == sizes[2]
    assert 18 in sizes[0]
    assert 2 in sizes[1]


def test_markers_stay_until_they_are_replaced_and_follow_the_frame() -> None:
    for frame in ('scapula', 'body/right_scapula'):
        markers = MuscleMarkers(DELTOID, frame, 16)
        for k, rotation in enumerate(POSES):
            stamp = Time(sec=100 + k, nanosec=7 * k)
            for marker in markers.update(RIGHT.solve(rotation), stamp).markers:
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
    first = list(markers.update(RIGHT.solve(POSES[0]), STAMP).markers)
    points = [id(point) for point in first[-1].points[:2]]
    second = markers.update(RIGHT.solve(POSES[2]), STAMP).markers
    assert all(one is other for one, other in zip(first, second, strict=True))
    assert [id(point) for point in second[-1].points[:2]] == points


def test_two_sets_of_markers_do_not_share_any() -> None:
    one, other = (
        MuscleMarkers(DELTOID, 'scapula', 16).update(RIGHT.solve(rotation), STAMP)
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
            in_namespace(markers.update(state, STAMP), 'bands'), state.wrap.tolist(), strict=True
        ):
            inside = wrap == WrapState.INSIDE
            assert marker.action == (Marker.DELETE if inside else Marker.ADD)
        actions.append(in_namespace(markers.update(state, STAMP), 'bands')[0].action)
    assert actions[0] == Marker.DELETE
    usual = MuscleMarkers(WIDE, 'scapula', 16)
    usual.update(solver.solve(np.eye(3)), STAMP)
    back = in_namespace(usual.update(RIGHT.solve(np.eye(3)), STAMP), 'bands')[0]
    assert back.action == Marker.ADD
    assert len(back.points) >= 2


@unhurried
@given(st.tuples(*[st.floats(-6.0, 6.0)] * 3), st.sampled_from([RIGHT, LEFT]))
def test_no_marker_holds_a_number_that_is_not_finite(
    angles: tuple[float, float, float], side: LinkedPlaneSolver
) -> None:
    state = side.solve(THESIS.rotation(angles))
    for marker in MARKERS.update(state, STAMP).markers:
        assert np.isfinite(numbers(marker)).all()
        assert marker.scale.x > 0.0


MARKERS = MuscleMarkers(DELTOID, 'scapula', 16)


def test_the_markers_come_out_of_the_middleware_as_they_went_in() -> None:
    for _, array in states_with_markers(RIGHT):
        for one, other in zip(through_middleware(array).markers, array.markers, strict=True):
            assert (one.header, one.ns, one.id, one.type) == (
                other.header,
                other.ns,
                other.id,
                other.type,
            )
            assert (one.pose, one.scale, one.points) == (other.pose, other.scale, other.points)
            # a colour is stored in single precision
            assert numbers(one) == pytest.approx(numbers(other), abs=1e-6)
