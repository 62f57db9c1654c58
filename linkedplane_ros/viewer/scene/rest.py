# SPDX-License-Identifier: Apache-2.0
"""The arm at rest, solved here: what is seen before its node has answered anything."""

from __future__ import annotations

from contextlib import suppress
from threading import Event, Thread

import numpy as np

from ...drawing.shapes import MuscleShapes, Placement, Shape
from ...errors import LinkedPlaneError
from ...node.parameters import SPECS
from ...node.settings import Settings, list_muscles
from ...types import Floats
from ..newest import MuscleInfo
from ..panels.ranges import rest_pose
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
        with suppress(LinkedPlaneError):
            markers = rest_markers(info)
        if self._asked[prefix] is info:  # else a newer one is on its way
            self._solved[prefix] = markers
            self._fresh.set()


def rest_markers(info: MuscleInfo) -> Markers:
    """Return the markers of a muscle at rest: those that its node would send.

    LinkedPlaneError if its model, or what moves its bones, cannot be loaded here.
    """
    values = {spec.name: info.parameters.get(spec.name, spec.default) for spec in SPECS}
    settings = Settings.from_values(values, may_fail=list_muscles(values['muscle']))
    markers: Markers = {}
    for solver, moved_by in zip(settings.solvers, settings.articulations.moved_by, strict=False):
        if solver.muscle.name == info.name:
            rest = rest_pose(info)
            state = solver.answer(moved_by, rest, np.zeros_like(rest)).state
            shapes = MuscleShapes(solver.muscle, settings.markers_points, settings.markers_details)
            apply_message(markers, map(build_marker, shapes.shapes, shapes.placements(state)))
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
