# SPDX-License-Identifier: Apache-2.0
"""From markers to what a scene draws: lines, bodies and sheets, few for each namespace.

Few things with many parts are drawn faster than many things. Lengths in m, colours 0..255.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...drawing.shapes import (
    CYLINDER,
    DELETE,
    DELETE_ALL,
    LINE_LIST,
    LINE_STRIP,
    SPHERE,
    SPHERE_LIST,
    TRIANGLE_LIST,
)
from ...types import Bytes, Floats
from .wire import Marker

Markers = dict[tuple[str, int], Marker]
BANDS = 'bands'


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight pieces."""

    points: Floats
    """(m, 2, 3): the ends of each."""
    colours: Bytes
    """(m, 2, 3)"""
    width: float


@dataclass(frozen=True, eq=False)
class Bodies:
    """Balls, or rods along z, scaled from diameter 1 and height 1."""

    positions: Floats
    """(m, 3)"""
    orientations: Floats
    """(m, 4) w x y z."""
    sizes: Floats
    """(m, 3)"""
    colours: Bytes
    """(m, 3)"""
    opacity: float


@dataclass(frozen=True, eq=False)
class Sheets:
    """Triangles of one colour."""

    points: Floats
    """(3 m, 3)"""
    colour: tuple[int, int, int]
    opacity: float


Drawable = Lines | Bodies | Sheets


def apply_message(markers: Markers, message: Iterable[Marker]) -> None:
    """Add, replace and remove markers as a message says."""
    for marker in message:
        if marker.action == DELETE_ALL:
            markers.clear()
        elif marker.action == DELETE:
            markers.pop((marker.namespace, marker.number), None)
        else:
            markers[marker.namespace, marker.number] = marker


def drawables(
    markers: Markers, band_colours: Mapping[int, npt.ArrayLike] | None = None
) -> dict[str, Drawable]:
    """Return what is drawn of markers.

    Parameters
    ----------
    markers
        By namespace and number.
    band_colours
        Red, green and blue, 0..255, by the number of a band; other bands have their marker's.

    Returns
    -------
    dict
        By name: namespace/kind, or namespace/sheets/colour.

    """
    groups: dict[str, list[Marker]] = {}
    for marker in markers.values():
        groups.setdefault(drawable_name(marker), []).append(marker)
    drawn: dict[str, Drawable] = {}
    for name, group in groups.items():
        kind = name.split('/')[1]
        if kind == 'lines':
            own = band_colours or {} if name.startswith(f'{BANDS}/') else {}
            drawn[name] = merge_lines(group, own)
        elif kind in ('balls', 'rods'):
            bodies = merge_bodies(group)
            if len(bodies.positions):  # a list may have no points
                drawn[name] = bodies
        elif kind == 'sheets':
            drawn[name] = merge_sheets(group)
    return drawn


def drawable_name(marker: Marker) -> str:
    """Return the name of the drawable that a marker is part of; unknown kinds are not drawn."""
    namespace = marker.namespace.replace('/', '_')  # it is a part of a path
    if marker.kind in (LINE_STRIP, LINE_LIST):
        return f'{namespace}/lines'
    if marker.kind in (SPHERE, SPHERE_LIST):
        return f'{namespace}/balls'
    if marker.kind == CYLINDER:
        return f'{namespace}/rods'
    if marker.kind == TRIANGLE_LIST:
        return f'{namespace}/sheets/{"_".join(map(str, rgb(marker.colour)))}'
    return f'{namespace}/unknown'


def rgb(colour: Floats) -> tuple[int, int, int]:
    """Return red, green and blue, 0..255, of a colour in 0..1."""
    red, green, blue = np.rint(255.0 * np.clip(colour[:3], 0.0, 1.0)).astype(int).tolist()
    return red, green, blue


def merge_lines(group: list[Marker], colours: Mapping[int, npt.ArrayLike]) -> Lines:
    """Return line strips and line lists as pieces; `colours`, by number, replace the markers'."""
    ends, paint = [np.empty((0, 2, 3))], [np.empty((0, 2, 3), np.uint8)]
    for marker in group:
        points = posed_points(marker)
        if marker.kind == LINE_LIST:
            pieces = points[: len(points) // 2 * 2].reshape(-1, 2, 3)
        else:
            pieces = np.stack((points[:-1], points[1:]), axis=1)
        colour = np.asarray(colours.get(marker.number, rgb(marker.colour)), np.uint8)
        ends.append(pieces)
        paint.append(np.broadcast_to(colour, pieces.shape))
    return Lines(np.concatenate(ends), np.concatenate(paint), float(group[0].scale[0]))


def merge_bodies(group: list[Marker]) -> Bodies:
    """Return spheres, sphere lists and cylinders as bodies."""
    positions, orientations, sizes, paint = [], [], [], []
    for marker in group:
        is_list = marker.kind == SPHERE_LIST
        places = posed_points(marker) if is_list else marker.position[np.newaxis]
        own = np.tile(rgb(marker.colour), (len(places), 1))
        if is_list and len(marker.colours) == len(places):
            own = np.rint(255.0 * np.clip(marker.colours[:, :3], 0.0, 1.0))
        positions.append(places)
        orientations.append(np.tile(marker.orientation[[3, 0, 1, 2]], (len(places), 1)))
        sizes.append(np.tile(marker.scale, (len(places), 1)))
        paint.append(own)
    return Bodies(
        np.concatenate(positions),
        np.concatenate(orientations),
        np.concatenate(sizes),
        np.concatenate(paint).astype(np.uint8),
        float(group[0].colour[3]),
    )


def merge_sheets(group: list[Marker]) -> Sheets:
    """Return triangle lists of one colour as one sheet."""
    points = [posed_points(marker)[: len(marker.points) // 3 * 3] for marker in group]
    return Sheets(np.concatenate(points), rgb(group[0].colour), float(group[0].colour[3]))


def posed_points(marker: Marker) -> Floats:
    """Return the points (k, 3) of a marker, moved by its pose."""
    x, y, z, w = marker.orientation.tolist()
    if (x, y, z) == (0.0, 0.0, 0.0):
        return marker.points + marker.position
    turn = np.array((x, y, z))
    aside = np.cross(turn, marker.points)
    moved: Floats = marker.points + 2.0 * (w * aside + np.cross(turn, aside)) + marker.position
    return moved
