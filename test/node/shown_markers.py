# SPDX-License-Identifier: Apache-2.0
"""The markers of a few poses, and what tests read from them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from rclpy.serialization import deserialize_message, serialize_message
from visualization_msgs.msg import Marker, MarkerArray

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, MuscleState
from linkedplane_ros.node.markers import MuscleMarkers

THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
DELTOID = BroadMuscle.load('deltoid')
STAMP = Time(sec=12, nanosec=345)
POSES = [
    THESIS.rotation(angles)
    for angles in ((0.0, 0.0, 0.0), (0.0, 1.6, 0.0), (1.4, 0.1, 0.3), (-0.5, 0.4, -0.8), (2, 1, 1))
]
Array = np.ndarray


def states_with_markers(
    side: LinkedPlaneSolver, points: int = 16
) -> Iterator[tuple[MuscleState, MarkerArray]]:
    """Return states and their markers, all made by the same MuscleMarkers."""
    markers = MuscleMarkers(DELTOID, 'scapula', points)
    for rotation in POSES:
        state = side.solve(rotation)
        yield state, markers.update(state, STAMP)


def through_middleware(array: MarkerArray) -> MarkerArray:
    """Return a copy of the markers as the middleware gives it to a receiver."""
    return deserialize_message(serialize_message(array), MarkerArray)


def in_namespace(array: MarkerArray, namespace: str) -> list[Marker]:
    """Return the markers of one namespace in order of id."""
    found = sorted((m for m in array.markers if m.ns == namespace), key=lambda marker: marker.id)
    assert [marker.id for marker in found] == list(range(len(found)))
    return found


def point_array(point: Point) -> Array:
    """Return a point of a message as an array (3,)."""
    return np.array((point.x, point.y, point.z))


def points_array(marker: Marker) -> Array:
    """Return a marker's points as an array (n, 3)."""
    return np.array([(p.x, p.y, p.z) for p in marker.points])
