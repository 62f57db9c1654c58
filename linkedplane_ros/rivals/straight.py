# SPDX-License-Identifier: Apache-2.0
"""Paths without an obstacle (thesis ch. 3): a straight line, and one through via points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ..linked_planes.band import CLEAR, WRAPPED
from ..linked_planes.compilation import compiled
from ..linked_planes.layout import vector
from ..linked_planes.vectors import ZERO, Rotation, Vector, cross, minus, norm, times, turned
from .bands import PathModel
from .path import (
    NO_ARC,
    OBSTACLE,
    Arc,
    BandRow,
    ObstaclePath,
    ends,
    make_kernel,
    straight_path,
    write_arc,
)


@compiled
def straight(row: BandRow, rotation: Rotation) -> ObstaclePath:
    """Return the path of a band that has only P and S."""
    P, S = ends(row, rotation)
    return straight_path(P, S, CLEAR)


@compiled
def via_point(row: BandRow, rotation: Rotation, i: int) -> Vector:
    """Return the i-th via point, scapula frame: those of the scapula come first."""
    point = vector(row, OBSTACLE + 2 + 3 * i)
    return point if i < row[OBSTACLE] else turned(rotation, point)


@compiled
def via_count(row: BandRow) -> int:
    """Return how many via points a band has."""
    return int(row[OBSTACLE] + row[OBSTACLE + 1])


@compiled
def via_points(row: BandRow, rotation: Rotation) -> ObstaclePath:
    """Return the path of a band of P, S, how many points on the scapula and on the humerus, them.

    Only the straight part from the last scapular to the first humeral point turns the joint.
    """
    P, S = ends(row, rotation)
    count = via_count(row)
    length, moment = 0.0, ZERO
    start = P
    for i in range(count + 1):
        end = via_point(row, rotation, i) if i < count else S
        line = minus(end, start)
        D = norm(line)
        length += D
        if i == row[OBSTACLE]:
            moment = times(-1.0 / max(D, 1e-300), cross(end, line))
        start = end
    return ObstaclePath(length, WRAPPED if count else CLEAR, 0, moment, NO_ARC, NO_ARC)


@compiled
def write_points(row: BandRow, rotation: Rotation, path: ObstaclePath, numbers: Any) -> None:
    """Write the via points as arcs without length."""
    numbers[0] = 0
    for i in range(via_count(row)):
        write_arc(Arc(via_point(row, rotation, i), ZERO, ZERO, 0.0, 0.0), numbers, i)


@dataclass(frozen=True)
class Straight(PathModel):
    """A straight line from origin to insertion. Always CLEAR: there is nothing to wrap."""

    kernel = make_kernel(straight)


@dataclass(frozen=True)
class ViaPoints(PathModel):
    """Straight lines through points that are fixed to the bones, and always active.

    WRAPPED if there are any. (Via points that are switched off at some poses, as in thesis ch. 3,
    need a rule for each muscle, and none is published for the deltoid.)
    """

    on_scapula: tuple[Vector, ...] = ()
    """From the origin on; scapula frame."""
    on_humerus: tuple[Vector, ...] = ()
    """After those, up to the insertion; humerus frame."""
    kernel = make_kernel(via_points, write_points)
    arcs_are_points = True

    @property
    def row(self) -> tuple[float, ...]:
        """Attachments, how many points there are on each bone, the points."""
        numbers = super().row
        counts = float(len(self.on_scapula)), float(len(self.on_humerus))
        return (*numbers[:OBSTACLE], *counts, *numbers[OBSTACLE:])

    @property
    def most_arcs(self) -> int:
        """Via points."""
        return len(self.on_scapula) + len(self.on_humerus)

    def _fields(self) -> Iterator[tuple[str, Any]]:
        for name, value in super()._fields():
            if name in ('on_scapula', 'on_humerus'):
                yield from ((f'{name}[{i}]', point) for i, point in enumerate(value))
            else:
                yield name, value
