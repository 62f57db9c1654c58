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

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.markers import MuscleMarkers
from linkedplane_ros.viewer.newest import MuscleInfo
from linkedplane_ros.viewer.scene.geometry import Markers, apply_message
from linkedplane_ros.viewer.scene.rest import RestArms, rest_markers
from linkedplane_ros.viewer.scene.wire import read_markers

COORDINATES = ('flexion', 'abduction', 'rotation')


def markers_of_node(solver: LinkedPlaneSolver) -> Markers:
    message = MuscleMarkers(solver.muscle, 'scapula', 16).update(solver.solve(np.eye(3)), Time())
    markers: Markers = {}
    apply_message(markers, read_markers(serialize_message(message)))
    return markers


def info_of(**parameters: Any) -> MuscleInfo:
    return MuscleInfo.from_parameters(COORDINATES, (), '/joint_states', parameters)


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
    assert_equal(rest_markers(solver), markers_of_node(solver))


@pytest.mark.parametrize('scale', ['1.2', '1,1.1,0.9'])
def test_the_arm_at_rest_has_the_size_and_the_side_of_its_node(scale: str) -> None:
    muscle = BroadMuscle.load('deltoid').scaled(scale)
    wanted = rest_markers(LinkedPlaneSolver(muscle, 'left'))
    assert_equal(solved(info_of(muscle='deltoid', scale=scale, side='left')), wanted)


@pytest.mark.parametrize(
    'parameters', [{'muscle': '/nowhere/a.yaml'}, {'muscle': 'deltoid', 'scale': '/nowhere/b.yaml'}]
)
def test_a_model_that_only_its_node_can_load_is_not_drawn_at_rest(
    parameters: dict[str, str],
) -> None:
    info = info_of(**parameters)
    assert info.model is None
    assert solved(info) == {}


def test_the_newest_parameters_are_those_of_the_arm_at_rest() -> None:
    fresh = Event()
    arms = RestArms(fresh)
    first, second = info_of(muscle='deltoid'), info_of(muscle='deltoid', scale='2')
    for _ in range(5):
        arms.find_markers('/deltoid', first)
        arms.find_markers('/deltoid', second)
    large = rest_markers(LinkedPlaneSolver(BroadMuscle.load('deltoid').scaled(2.0)))
    while not (shown := arms.find_markers('/deltoid', second)):
        assert fresh.wait(PATIENCE)
    assert_equal(shown, large)
