"""From a muscle state to the markers that RViz and Foxglove show: message types, no node.

Namespaces: `bands` (a line strip each, id = band), `attachments` (origins 0, insertions 1),
`obstacle_spheres` (id = band), `bones` (humeral head 0, shaft 1, the bony rim of the origins 2).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from .colours import head_colours
from .model import BroadMuscle
from .solver import MuscleState, WrapState

Floats = npt.NDArray[np.float64]

BONE = (0.89, 0.85, 0.76)
BAND_WIDTH = 0.004  # m
ATTACHMENT = 0.006  # m, diameter
HEAD_RADIUS = 0.024  # m: the humeral head, for the eye alone
SHAFT_RADIUS = 0.012  # m
SHAFT_START, SHAFT_END = 0.01, 0.22  # m below the glenohumeral centre
UP = np.array((0.0, 0.0, 1.0))


class Pace:
    """Lets markers through so many times a second, by the stamps of the input.

    So a replay at any speed shows the same ones. A jump in time, forwards or back, passes at once;
    where stamps stand still, the time of arrival counts instead.
    """

    def __init__(self, rate: float) -> None:
        """Let through `rate` Hz; 0: all."""
        self._period = 1.0 / rate - 1e-6 if rate else 0.0
        self._stamp = self._arrival = -np.inf

    def due(self, stamp: float, arrival: float) -> bool:
        """Return whether what came at these times, s, is let through."""
        moved = stamp != self._stamp
        passed = abs(stamp - self._stamp) if moved else arrival - self._arrival
        if passed < self._period:
            return False
        self._stamp, self._arrival = stamp, arrival
        return True


class MuscleMarkers:
    """The markers of one muscle: made once, then moved in place from state to state."""

    def __init__(self, muscle: BroadMuscle, frame_id: str, points: int) -> None:
        """Make all markers; `points` on the arc of a wrapped band."""
        self.points = points
        self._muscle = muscle
        self._frame_id = frame_id
        n = len(muscle.band_names)
        colours = head_colours(muscle)
        self._bands = [
            self._marker('bands', i, Marker.LINE_STRIP, colours[i], (BAND_WIDTH, 0.0, 0.0))
            for i in range(n)
        ]
        self._pool = [[Point() for _ in range(points + 2)] for _ in range(n)]
        self._spheres = [
            self._marker(
                'obstacle_spheres',
                i,
                Marker.SPHERE,
                colours[i],
                (2.0 * radius,) * 3,
                alpha=0.12,
            )
            for i, radius in enumerate(muscle.sphere_radii.tolist())
        ]
        self._attachments = [
            self._marker('attachments', k, Marker.SPHERE_LIST, BONE, (ATTACHMENT,) * 3)
            for k in range(2)
        ]
        for marker in self._attachments:
            marker.points = [Point() for _ in range(n)]
            marker.colors = [ColorRGBA(r=r, g=g, b=b, a=1.0) for r, g, b in colours]
        head = self._marker('bones', 0, Marker.SPHERE, BONE, (2.0 * HEAD_RADIUS,) * 3)
        # as the humerus is: the shaft beside the centre of its head, where the muscle reaches it
        aside = muscle.insertions.mean(axis=0) * (1.0, 1.0, 0.0)
        aside *= 1.0 - SHAFT_RADIUS / max(float(np.linalg.norm(aside)), SHAFT_RADIUS)
        self._shaft_centre = aside - (0.0, 0.0, 0.5 * (SHAFT_START + SHAFT_END))
        length = SHAFT_END - SHAFT_START
        shaft = self._marker(
            'bones', 1, Marker.CYLINDER, BONE, (2.0 * SHAFT_RADIUS, 2.0 * SHAFT_RADIUS, length)
        )
        rim = self._marker('bones', 2, Marker.LINE_STRIP, BONE, (0.008, 0.0, 0.0))
        rim.points = [Point() for _ in range(n)]
        self._bones = [head, shaft, rim]
        self._all = self._bones + self._attachments + self._spheres + self._bands

    def _marker(
        self,
        namespace: str,
        number: int,
        kind: int,
        colour: tuple[float, float, float],
        scale: tuple[float, ...],
        alpha: float = 1.0,
    ) -> Marker:
        marker = Marker(ns=namespace, id=number, type=kind, action=Marker.ADD, frame_locked=True)
        marker.header.frame_id = self._frame_id
        marker.pose.orientation.w = 1.0
        marker.color = ColorRGBA(r=colour[0], g=colour[1], b=colour[2], a=alpha)
        marker.scale = Vector3(x=scale[0], y=scale[1], z=scale[2])
        return marker

    def clear(self, stamp: Time) -> MarkerArray:
        """Return the message that removes every marker on the topic."""
        marker = Marker(action=Marker.DELETEALL)
        marker.header.frame_id = self._frame_id
        marker.header.stamp = stamp
        return MarkerArray(markers=[marker])

    def at(self, state: MuscleState, stamp: Time) -> MarkerArray:
        """Return the markers at a state. The next call changes the same messages.

        A band with an end inside its sphere has no path: its marker is deleted.
        """
        for marker in self._all:
            marker.header.stamp = stamp
        for i, path in enumerate(state.paths(self.points)):
            band = self._bands[i]
            band.action = Marker.DELETE if state.wrap[i] == WrapState.INSIDE else Marker.ADD
            band.points = place(self._pool[i][: len(path)], path)
        for marker, centre in zip(self._spheres, state.sphere_centres.tolist(), strict=True):
            put(marker.pose.position, centre)
        origins = state.solver.origins
        place(self._attachments[0].points, origins)
        place(self._attachments[1].points, state.insertions)
        place(self._bones[2].points, origins)
        put(self._bones[1].pose.position, state.moved(self._shaft_centre).tolist())
        self._bones[1].pose.orientation = upright_turned(state.moved(UP))
        return MarkerArray(markers=self._all)


def place(points: list[Point], places: Floats) -> list[Point]:
    """Move points to places (k, 3), m."""
    for point, (x, y, z) in zip(points, places.tolist(), strict=True):
        point.x, point.y, point.z = x, y, z
    return points


def put(point: Point, place: list[float]) -> None:
    """Move one point."""
    point.x, point.y, point.z = place


def upright_turned(axis: Floats) -> Quaternion:
    """Return the shortest turn that takes +z to a unit axis (3,)."""
    x, y, z = axis.tolist()
    if z < -1.0 + 1e-9:
        return Quaternion(x=1.0, y=0.0, z=0.0, w=0.0)
    size = float(np.sqrt(2.0 * (1.0 + z)))
    return Quaternion(x=-y / size, y=x / size, z=0.0, w=0.5 * size)
