# SPDX-License-Identifier: Apache-2.0
"""From a muscle state to the marker messages that RViz and Foxglove show.

Their shapes are those of `drawing.shapes`, their colours those of `drawing.colours`.
"""

from __future__ import annotations

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from ..drawing.shapes import MuscleShapes, Placement, Shape
from ..muscle.broad_muscle import BroadMuscle
from ..solver.states import MuscleState
from ..types import Colour


class MuscleMarkers:
    """The markers of one muscle: built once, then moved from state to state.

    Parameters
    ----------
    muscle
        What is drawn.
    frame_id
        The frame of the markers.
    points
        Points on the arc of a wrapped band.
    details
        Whether planes, interference spheres, and where bands enter them are drawn, too.

    """

    def __init__(
        self, muscle: BroadMuscle, frame_id: str, points: int, details: bool = True
    ) -> None:
        self._frame_id = frame_id
        self._shapes = MuscleShapes(muscle, points, details)
        self._markers = [self._build_marker(shape) for shape in self._shapes.shapes]
        self._pools: list[list[Point]] = [[] for _ in self._markers]

    def _build_marker(self, shape: Shape) -> Marker:
        marker = Marker(
            ns=shape.namespace,
            id=shape.number,
            type=shape.kind,
            frame_locked=True,
            color=rgba(shape.colour, shape.alpha),
            colors=[rgba(colour, 1.0) for colour in shape.colours],
        )
        marker.header.frame_id = self._frame_id
        marker.scale = Vector3(**dict(zip('xyz', shape.scale, strict=True)))
        return marker

    def clear(self, stamp: Time) -> MarkerArray:
        """Return the message that removes every marker on the topic."""
        marker = Marker(action=Marker.DELETEALL)
        marker.header.frame_id = self._frame_id
        marker.header.stamp = stamp
        return MarkerArray(markers=[marker])

    def update(self, state: MuscleState, stamp: Time) -> MarkerArray:
        """Return the markers at a state. The next call changes the same messages."""
        places = self._shapes.placements(state)
        for marker, pool, place in zip(self._markers, self._pools, places, strict=True):
            marker.header.stamp = stamp
            move_marker(marker, pool, place)
        return MarkerArray(markers=self._markers)


def rgba(colour: Colour, alpha: float) -> ColorRGBA:
    """Return a colour, 0 to 1, as a message."""
    return ColorRGBA(r=colour[0], g=colour[1], b=colour[2], a=alpha)


def move_marker(marker: Marker, pool: list[Point], place: Placement) -> None:
    """Move a marker to a place; its points are taken from the pool, which grows if needed."""
    marker.action = place.action
    if place.position is not None:
        x, y, z = place.position.tolist()
        marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = x, y, z
    if place.orientation is not None:
        x, y, z, w = place.orientation.tolist()
        marker.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
    if place.points is not None:
        places = place.points.tolist()
        pool += [Point() for _ in range(len(places) - len(pool))]
        marker.points = pool[: len(places)]
        for point, (x, y, z) in zip(marker.points, places, strict=True):
            point.x, point.y, point.z = x, y, z
