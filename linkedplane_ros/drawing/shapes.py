# SPDX-License-Identifier: Apache-2.0
"""The markers of a muscle, and where they are at each state, before they are messages.

Namespaces: `bands` (a line strip each, id = band), `attachments` (origins 0, insertions 1),
`obstacle_spheres` (id = the first of the bands that share it), `bones` (humeral head 0, shaft 1,
the bony rim of the ground's origins 2; from 3 on, a strut for each bone between the ground and the
last, as the clavicle). As details: `planes` (id = band), `interference_spheres` (id =
sphere), `interferences` (id = band: where it is deepest in one of them).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..solver.interference import depths
from ..solver.states import MuscleState, WrapState
from ..types import Colour, Floats, Point
from .bones import (
    BONE,
    HEAD_RADIUS,
    SHAFT_END,
    SHAFT_RADIUS,
    SHAFT_START,
    shaft_axis,
    strut_points,
)
from .colours import head_colours, sphere_colours
from .planes import plane_patches

# visualization_msgs/Marker's numbers
SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, SPHERE_LIST, TRIANGLE_LIST = 2, 3, 4, 5, 7, 11
ADD, DELETE, DELETE_ALL = 0, 2, 3

MARKER_RATE = 30.0  # Hz, by default
POINTS_ON_ARC = 16

BAND_WIDTH = 0.004  # m
ATTACHMENT_DIAMETER = 0.006  # m
RIM_WIDTH = 0.008  # m
STRUT_WIDTH = 0.012  # m, of bones between the ground and the last
OBSTACLE_ALPHA = 0.12  # opacity of the obstacle spheres
PLANE_WIDTH = 0.05  # m that is drawn of a band's plane
INTERFERENCE_COLOUR = (0.86, 0.08, 0.24)
MARK_DIAMETER = 0.01  # m, of the mark where a band interferes
UP = np.array((0.0, 0.0, 1.0))
CENTRE = np.zeros(3)  # of the humeral head, in the last bone's frame


class RateLimiter:
    """Decides which states get markers: `rate` a second, by the stamps of the input.

    A replay at any speed then shows the same ones. After a jump in time, forwards or back, the next
    state is allowed at once; where stamps stand still, the time of arrival counts instead.

    Parameters
    ----------
    rate
        Hz; 0: all states are allowed.
    """

    def __init__(self, rate: float) -> None:
        """Begin with nothing allowed so far."""
        self._period = 1.0 / rate - 1e-6 if rate else 0.0
        self._stamp = self._arrival = -np.inf

    def allows(self, stamp: float, arrival: float) -> bool:
        """Return whether a state of this stamp, s, which arrived at a time, s, gets markers."""
        moved = stamp != self._stamp
        passed = abs(stamp - self._stamp) if moved else arrival - self._arrival
        if passed < self._period:
            return False
        self._stamp, self._arrival = stamp, arrival
        return True


@dataclass(frozen=True)
class Shape:
    """What of a marker stays the same at all states."""

    namespace: str
    number: int
    """The marker's id in its namespace."""
    kind: int
    """visualization_msgs/Marker's type."""
    scale: Point
    """m, along the marker's axes."""
    colour: Colour
    alpha: float = 1.0
    colours: tuple[Colour, ...] = ()
    """Of each of its points, where they differ."""


class Placement(NamedTuple):
    """Where a marker is at a state; None: upright at the frame's origin, without points."""

    position: Floats | None = None
    """(3,) m, scapula frame."""
    orientation: Floats | None = None
    """(4,) quaternion x, y, z, w."""
    points: Floats | None = None
    """(k, 3) m."""
    action: int = ADD

    @property
    def numbers(self) -> tuple[Floats | None, Floats | None, Floats | None]:
        """Position, orientation and points."""
        return self.position, self.orientation, self.points


class MuscleShapes:
    """The markers of one muscle, before they are messages.

    Parameters
    ----------
    muscle
        What is drawn.
    points
        How many points there are on the arc of a wrapped band.
    details
        Whether planes, interference spheres and interferences are drawn, too.

    Attributes
    ----------
    shapes
        One for each marker, in a fixed order.
    """

    def __init__(self, muscle: BroadMuscle, points: int, details: bool) -> None:
        """Describe the shapes."""
        self._points, self._details = points, details
        self._spheres = sphere_colours(muscle)
        colours = head_colours(muscle)
        self._shaft_centre = shaft_axis(muscle).mean(axis=0)
        self._struts = {
            bone: strut
            for bone in muscle.bones.names[1:-1]
            if len(strut := strut_points(muscle, bone))
        }
        owners = muscle.bones.of_bands('origin', len(muscle.band_names))
        self._rim = [i for i, owner in enumerate(owners) if owner == muscle.bones.ground]
        width, length = 2.0 * SHAFT_RADIUS, SHAFT_END - SHAFT_START
        ball = (ATTACHMENT_DIAMETER,) * 3
        self.shapes: tuple[Shape, ...] = (
            Shape('bones', 0, SPHERE, (2.0 * HEAD_RADIUS,) * 3, BONE),
            Shape('bones', 1, CYLINDER, (width, width, length), BONE),
            Shape('bones', 2, LINE_STRIP, (RIM_WIDTH, 0.0, 0.0), BONE),
            *(
                Shape('bones', 3 + k, LINE_STRIP, (STRUT_WIDTH, 0.0, 0.0), BONE)
                for k in range(len(self._struts))
            ),
            *(
                Shape('attachments', k, SPHERE_LIST, ball, BONE, colours=tuple(colours))
                for k in range(2)
            ),
            *(
                Shape(
                    'obstacle_spheres',
                    i,
                    SPHERE,
                    (2.0 * float(muscle.sphere_radii[i]),) * 3,
                    colour,
                    OBSTACLE_ALPHA,
                )
                for i, colour in self._spheres.items()  # each once: together they would be opaque
            ),
            *(
                Shape('bands', i, LINE_STRIP, (BAND_WIDTH, 0.0, 0.0), colour)
                for i, colour in enumerate(colours)
            ),
        )
        if details:
            self.shapes += self._detail_shapes(muscle, colours)

    def _detail_shapes(self, muscle: BroadMuscle, colours: Sequence[Colour]) -> tuple[Shape, ...]:
        planes = [
            Shape('planes', i, TRIANGLE_LIST, (1.0, 1.0, 1.0), colour, 0.3)
            for i, colour in enumerate(colours)
        ]
        spheres = [
            Shape('interference_spheres', k, SPHERE, (2.0 * radius,) * 3, INTERFERENCE_COLOUR, 0.2)
            for k, radius in enumerate(muscle.interference_radii.tolist())
        ]
        marks = [
            Shape('interferences', i, SPHERE, (MARK_DIAMETER,) * 3, INTERFERENCE_COLOUR)
            for i in range(len(colours) if spheres else 0)
        ]
        return (*planes, *spheres, *marks)

    def placements(self, state: MuscleState) -> list[Placement]:
        """Return where each shape is at a state, in the order of `shapes`.

        A band with an end inside its sphere has no path: its marker is deleted. So is the mark of
        a band that touches no interference sphere.
        """
        origins, side = state.origins, state.solver.to_side
        up = side(UP @ state.rotation.T)
        orientation = quaternion_from_z_axis(up)
        places = [
            Placement() if state.posed is None else Placement(state.to_scapula(CENTRE)),
            Placement(state.to_scapula(self._shaft_centre), orientation),
            Placement(points=origins[self._rim], action=ADD if len(self._rim) > 1 else DELETE),
            *(
                Placement(points=side(state.place_points(strut, (bone,) * len(strut))))
                for bone, strut in self._struts.items()
            ),
            Placement(points=origins),
            Placement(points=state.insertions),
            *(Placement(state.sphere_centres[i]) for i in self._spheres),
            *(
                Placement(points=path, action=DELETE if wrap == WrapState.INSIDE else ADD)
                for path, wrap in zip(state.paths(self._points), state.wrap.tolist(), strict=True)
            ),
        ]
        return [*places, *detail_placements(state)] if self._details else places


def detail_placements(state: MuscleState) -> Iterator[Placement]:
    """Yield where the planes, the interference spheres and the marks in them are."""
    solver = state.solver
    for a, b, c, d in plane_patches(state, PLANE_WIDTH):
        yield Placement(points=np.array((a, b, c, a, c, d)))
    if not len(solver.muscle.interference_radii):
        return
    for centre in state.interference_centres:
        yield Placement(centre)
    depth, deepest = depths(state)
    for i, k in enumerate(depth.argmax(axis=1).tolist()):
        enters = depth[i, k] >= 0.0 and state.wrap[i] != WrapState.INSIDE
        yield Placement(deepest[i, k], action=ADD if enters else DELETE)


def quaternion_from_z_axis(axis: Floats) -> Floats:
    """Return the shortest rotation from +z to a unit axis (3,): a quaternion x, y, z, w (4,)."""
    x, y, z = axis.tolist()
    if z < -1.0 + 1e-9:
        return np.array((1.0, 0.0, 0.0, 0.0))
    size = math.sqrt(2.0 * (1.0 + z))
    return np.array((-y / size, x / size, 0.0, 0.5 * size))
