# SPDX-License-Identifier: Apache-2.0
"""The arm at rest: its markers are those that the node would send, and scales reach it."""

from __future__ import annotations

from collections.abc import Mapping
from threading import Event
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from unhurried import PATIENCE

from linkedplane_ros import (
    JOINT_CONVENTIONS,
    RHYTHMS,
    BroadMuscle,
    LinkedPlaneSolver,
    MuscleState,
    Skeleton,
)
from linkedplane_ros.node.markers import MuscleMarkers
from linkedplane_ros.skeleton.followed_girdle import FollowedGirdle
from linkedplane_ros.viewer.newest import MuscleInfo
from linkedplane_ros.viewer.scene.geometry import Markers, apply_message
from linkedplane_ros.viewer.scene.rest import RestArms, rest_markers
from linkedplane_ros.viewer.scene.wire import read_markers

THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
STILL = np.zeros(3)


def markers_of_node(state: MuscleState) -> Markers:
    message = MuscleMarkers(state.solver.muscle, 'scapula', 16).update(state, Time())
    markers: Markers = {}
    apply_message(markers, read_markers(serialize_message(message)))
    return markers


def info_of(muscle: str = 'deltoid', **parameters: Any) -> MuscleInfo:
    given = {'muscle': muscle, **parameters}
    return MuscleInfo.from_parameters((), (), '/joint_states', given, muscle)


def solved(info: MuscleInfo) -> Markers:
    """Return what is drawn of a muscle at rest, once it is solved."""
    fresh = Event()
    arms = RestArms(fresh)
    arms.find_markers('/deltoid', info)
    assert fresh.wait(PATIENCE)
    return arms.find_markers('/deltoid', info)


def assert_equal(some: Mapping[Any, Any], others: Mapping[Any, Any]) -> None:
    assert some.keys() == others.keys()
    for key, marker in some.items():
        other = others[key]
        assert (marker.kind, marker.action) == (other.kind, other.action)
        for name in ('position', 'orientation', 'scale', 'points'):
            np.testing.assert_array_equal(getattr(marker, name), getattr(other, name), str(key))
        for name in ('colour', 'colours'):  # in single precision in a message
            np.testing.assert_allclose(getattr(marker, name), getattr(other, name), atol=1e-7)


@pytest.mark.parametrize('side', ['right', 'left'])
@pytest.mark.parametrize('name', ['deltoid', 'deltoid_ackland2008', 'deltoid_girdle'])
def test_the_markers_at_rest_are_those_that_the_node_would_send(name: str, side: str) -> None:
    solver = LinkedPlaneSolver(BroadMuscle.load(name), side)
    markers = rest_markers(info_of(name, side=side))
    assert_equal(markers, markers_of_node(solver.answer(THESIS, STILL, STILL).state))


@pytest.mark.parametrize(
    ('parameters', 'moved_by'),
    [
        ({'skeleton': 'shoulder_girdle'}, Skeleton.load('shoulder_girdle')),
        ({'rhythm': 'mobl'}, FollowedGirdle(THESIS, RHYTHMS['mobl'])),
    ],
    ids=['skeleton', 'rhythm'],
)
def test_at_rest_what_moves_the_bones_is_that_of_the_node(
    parameters: dict[str, str], moved_by: Any
) -> None:
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
    if isinstance(moved_by, Skeleton):
        moved_by = moved_by.for_bones(solver.bones)
    still = np.zeros(len(moved_by.coordinates))
    markers = rest_markers(info_of('deltoid_girdle', **parameters))
    assert_equal(markers, markers_of_node(solver.answer(moved_by, still, still).state))


@pytest.mark.parametrize('scale', ['1.2', '1,1.1,0.9'])
def test_the_arm_at_rest_has_the_size_and_the_side_of_its_node(scale: str) -> None:
    muscle = BroadMuscle.load('deltoid').scaled(scale)
    wanted = markers_of_node(LinkedPlaneSolver(muscle, 'left').solve(np.eye(3)))
    assert_equal(solved(info_of(muscle='deltoid', scale=scale, side='left')), wanted)


@pytest.mark.parametrize(
    'parameters', [{'muscle': '/nowhere/a.yaml'}, {'muscle': 'deltoid', 'scale': '/nowhere/b.yaml'}]
)
def test_a_model_that_only_its_node_can_load_is_not_drawn_at_rest(
    parameters: dict[str, str],
) -> None:
    info = info_of(**parameters)
    assert solved(info) == {}


def test_the_newest_parameters_are_those_of_the_arm_at_rest() -> None:
    fresh = Event()
    arms = RestArms(fresh)
    first, second = info_of(muscle='deltoid'), info_of(muscle='deltoid', scale='2')
    for _ in range(5):
        arms.find_markers('/deltoid', first)
        arms.find_markers('/deltoid', second)
    muscle = BroadMuscle.load('deltoid').scaled(2.0)
    large = markers_of_node(LinkedPlaneSolver(muscle).solve(np.eye(3)))
    while not (shown := arms.find_markers('/deltoid', second)):
        assert fresh.wait(PATIENCE)
    assert_equal(shown, large)
