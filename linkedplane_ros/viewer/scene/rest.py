# SPDX-License-Identifier: Apache-2.0
"""The arm at rest, solved here: what is seen before its node has answered anything."""

from __future__ import annotations

from contextlib import suppress
from threading import Event, Thread

import numpy as np

from ...drawing.shapes import POINTS_ON_ARC, MuscleShapes, Placement, Shape
from ...errors import LinkedPlaneError
from ...solver.linked_plane_solver import LinkedPlaneSolver
from ...types import Floats
from ..newest import MuscleInfo
from .geometry import Markers, apply_message
from .wire import Marker

UPRIGHT = np.array((0.0, 0.0, 0.0, 1.0))  # quaternion x, y, z, w


class RestArms:
    """Solves muscles at rest, each in a thread of its own: the first one may compile the solver."""

    def __init__(self, fresh: Event) -> None:
        """`fresh` is set whenever one is solved."""
        self._fresh = fresh
        self._asked: dict[str, MuscleInfo] = {}
        self._solved: dict[str, Markers] = {}

    def find_markers(self, prefix: str, info: MuscleInfo) -> Markers:
        """Return the markers of a muscle at rest: none before they are solved, or if none can be.

        Parameters
        ----------
        prefix
            That of the muscle's topics.
        info
            What is known of it; when another one is given, it is solved again.

        """
        if self._asked.get(prefix) is not info:
            self._asked[prefix] = info
            Thread(target=self._solve, args=(prefix, info), daemon=True).start()
        return self._solved.get(prefix, {})

    def _solve(self, prefix: str, info: MuscleInfo) -> None:
        markers: Markers = {}
        if info.model is not None:
            with suppress(LinkedPlaneError):
                markers = rest_markers(LinkedPlaneSolver(info.model, info.side))
        if self._asked[prefix] is info:  # else a newer one is on its way
            self._solved[prefix] = markers
            self._fresh.set()


def rest_markers(solver: LinkedPlaneSolver) -> Markers:
    """Return the markers of a muscle with all of its bones at rest: those its node would send."""
    shapes = MuscleShapes(solver.muscle, POINTS_ON_ARC, details=True)
    places = shapes.placements(solver.solve(np.eye(3)))
    markers: Markers = {}
    apply_message(markers, map(build_marker, shapes.shapes, places))
    return markers


def build_marker(shape: Shape, place: Placement) -> Marker:
    """Return a shape at its place as a marker that is read from a message."""
    position, orientation, points = place.numbers
    return Marker(
        shape.namespace,
        shape.number,
        shape.kind,
        place.action,
        np.zeros(3) if position is None else position,
        UPRIGHT if orientation is None else orientation,
        np.array(shape.scale),
        np.array((*shape.colour, shape.alpha)),
        np.empty((0, 3)) if points is None else points,
        opaque(shape.colours),
    )


def opaque(colours: tuple[tuple[float, float, float], ...]) -> Floats:
    """Return red, green, blue and alpha (k, 4), 0..1, of colours."""
    return np.array([(*colour, 1.0) for colour in colours]).reshape(-1, 4)
