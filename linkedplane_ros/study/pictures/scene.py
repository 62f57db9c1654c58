# SPDX-License-Identifier: Apache-2.0
"""Solids, bands and planes seen from one side: parallel projection, far before near, equal scale.

matplotlib's own 3-D axes sort whole objects by depth; here every small piece is sorted, so that a
band that goes around or through a sphere looks so. Scapula frame of the right shoulder, m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ...types import Colour, Floats, Triple

if TYPE_CHECKING:
    from matplotlib.axes import Axes


PIECE = 0.004  # m: the longest piece of a ribbon
HALO = 1.8  # times a ribbon's width: the white that sets off one that crosses another
BEHIND = 0.005  # m: by which a halo lies behind its ribbon
RIM = 0.5  # points: the width of the rim of a sphere or a plane
CLEAR = (0.0, 0.0, 0.0, 0.0)  # no colour
GLOSS = 6  # discs, each smaller and lighter, that make a sphere look round
AMBIENT = 0.62  # of the light: what the shaded side of a rod has
LIGHT = np.array((-0.35, 0.45, 0.82))  # where it comes from: right, up, towards
AXES = {'lateral': (1.0, 0.0, 0.0), 'anterior': (0.0, 1.0, 0.0), 'superior': (0.0, 0.0, 1.0)}
ARROW = {'arrowstyle': '-|>', 'linewidth': 0.7, 'shrinkA': 0.0, 'shrinkB': 0.0, 'color': 'black'}
TRIAD = 0.38  # of half the picture's width: where the axes stand, right of the middle
IN_VIEW = 0.4  # of an axis's length in the picture, below which it is not drawn
SMALL = 6.0  # points: the size of a picture's words


@dataclass(frozen=True)
class Viewpoint:
    """The direction of a view: the picture's right and up, orthogonal unit vectors."""

    name: str
    right: Triple
    up: Triple

    @property
    def axes(self) -> Floats:
        """(3, 3) rows: right, up and towards the viewer."""
        return np.array((self.right, self.up, np.cross(self.right, self.up)))

    def project(self, points: Floats) -> Floats:
        """Return points (..., 3) along right, up and towards the viewer."""
        return points @ self.axes.T


_C, _S = np.cos(np.radians(40.0)).item(), np.sin(np.radians(40.0)).item()
LATERAL = Viewpoint('from lateral', (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FRONTAL = Viewpoint('from the front', (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
POSTERIOR = Viewpoint('from behind', (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
SUPERIOR = Viewpoint('from above', (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
TOP_BACK = Viewpoint('from behind and above', (1.0, 0.0, 0.0), (0.0, _S, _C))


class Scene:
    """A picture from one side; it is filled piece by piece, then drawn once."""

    def __init__(self, view: Viewpoint) -> None:
        """Begin with an empty picture."""
        self.view = view
        self._outlines: list[Floats] = []  # (k, 2) along right and up, m
        self._colours: list[tuple[float, ...]] = []  # red, green, blue, alpha
        self._rims: list[tuple[float, ...]] = []  # the same
        self._depths: list[float] = []  # m towards the viewer

    def add_sphere(
        self,
        centre: Floats,
        radius: float,
        colour: Colour,
        alpha: float = 1.0,
        towards: float = 0.0,
    ) -> None:
        """Add a sphere, as discs halfway before its centre; `towards` as for `add_ribbon`."""
        right, up, near = self.view.project(centre).tolist()
        turn = np.linspace(0.0, 2.0 * np.pi, 73)
        circle = radius * np.column_stack((np.cos(turn), np.sin(turn)))
        depth = near + 0.5 * radius + towards
        middle = np.array((right, up))
        self._add(circle + middle, (*colour, alpha), depth, rim=True)
        for k in range(1, GLOSS):
            aside = 0.4 * k / GLOSS * radius
            shine = (1.0 - k / GLOSS) * circle + middle + np.array((-aside, aside))
            self._add(shine, (1.0, 1.0, 1.0, 0.11 * alpha), depth + 1e-6 * k)

    def add_rod(self, ends: Floats, radius: float, colour: Colour) -> None:
        """Add a cylinder between two ends (2, 3), behind everything."""
        start, end = self.view.project(ends)
        along = (end - start) / np.linalg.norm(end - start)
        first = np.cross(along, np.eye(3)[np.abs(along).argmin()])
        first /= np.linalg.norm(first)
        turn = np.linspace(0.0, 2.0 * np.pi, 49)[:, None]
        ring = np.cos(turn) * first + np.sin(turn) * np.cross(along, first)
        lids = ((-along, start + radius * ring), (along, end + radius * ring))
        # each side reaches a little over the next, or the paper shines through between them
        sides = [
            (a, np.array([place + radius * each for place, each in (
                (start, a), (start, b + 0.2 * (b - a)), (end, b + 0.2 * (b - a)), (end, a))]))
            for a, b in pairwise(ring)
        ]  # fmt: skip
        for normal, corners in (*sides, *lids):
            if normal[2] > 0.0:
                bright = AMBIENT + (1.0 - AMBIENT) * max(float(normal @ LIGHT), 0.0)
                depth = -1.0 + 1e-3 * float(normal[2])
                self._add(corners[:, :2], (*(bright * np.array(colour)).tolist(), 1.0), depth)

    def add_ribbon(
        self, points: Floats, width: float, colour: Colour, towards: float = 0.0
    ) -> None:
        """Add a polyline (k, 3) of a width, m, with white beside it where it passes others.

        `towards` brings it, m, before what lies at the same depth.
        """
        place = self.view.project(refine(points))
        step = place[1:] - place[:-1]
        aside = np.column_stack((-step[:, 1], step[:, 0]))
        aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-12)
        a, b = (place[:-1] - 0.15 * step)[:, :2], (place[1:] + 0.15 * step)[:, :2]
        depths = (0.5 * (place[:-1, 2] + place[1:, 2]) + towards).tolist()
        white = (HALO * width, (1.0, 1.0, 1.0), BEHIND)
        for size, shade, back in (white, (width, colour, 0.0)):
            half = 0.5 * size * aside
            for quad, depth in zip(np.stack((a - half, b - half, b + half, a + half), axis=1),
                                   depths, strict=True):  # fmt: skip
                self._add(quad, (*shade, 1.0), depth - back)

    def add_sheet(self, corners: Floats, colour: Colour, alpha: float) -> None:
        """Add a flat, unlit surface (k, 3)."""
        place = self.view.project(corners)
        self._add(place[:, :2], (*colour, alpha), float(place[:, 2].mean()), rim=True)

    def _add(
        self, outline: Floats, colour: Sequence[float], depth: float, rim: bool = False
    ) -> None:
        red, green, blue, _ = colour
        self._outlines.append(1e3 * outline)
        self._colours.append(tuple(colour))
        self._rims.append((0.6 * red, 0.6 * green, 0.6 * blue, 1.0) if rim else CLEAR)
        self._depths.append(depth)

    def draw(self, axes: Axes) -> Any:
        """Draw everything, far things first, into axes in mm; return what was added."""
        from matplotlib.collections import PolyCollection

        order = np.argsort(self._depths, kind='stable').tolist()
        drawn = PolyCollection(
            [self._outlines[k] for k in order],
            facecolors=[self._colours[k] for k in order],
            edgecolors=[self._rims[k] for k in order],
            linewidths=[RIM if self._rims[k] is not CLEAR else 0.0 for k in order],
        )
        axes.add_collection(drawn)
        axes.set_aspect('equal')
        axes.set_axis_off()
        return drawn


def set_frame(axes: Axes, view: Viewpoint, centre: Triple, size: float) -> None:
    """Set the picture's middle, at a point, and half its height, m; draw axes and a scale.

    The picture's shape is that of its axes.
    """
    right, up, _ = (1e3 * view.project(np.array(centre))).tolist()
    box = axes.get_window_extent()
    half = 1e3 * size
    wide = half * box.width / box.height
    axes.set(xlim=(right - wide, right + wide), ylim=(up - half, up + half))
    left, bottom = right - 0.94 * wide, up - 0.94 * half
    axes.plot((left, left + 50.0), (bottom, bottom), color='black', linewidth=1.2)
    axes.text(left + 25.0, bottom + 0.02 * half, '50 mm', ha='center', va='bottom', size=SMALL)
    root = np.array((right + TRIAD * wide, bottom))
    for names, seen in visible_axes(view):
        tip = root + 0.17 * half * seen
        axes.annotate('', tuple(tip), tuple(root), arrowprops=ARROW)
        level = abs(seen[0]) > abs(seen[1])
        x, y = (tip + 0.03 * half * seen).tolist()
        axes.text(
            x, y, names, size=SMALL,
            ha=('left' if seen[0] > 0.0 else 'right') if level else 'center',
            va='center' if level else ('bottom' if seen[1] > 0.0 else 'top'),
        )  # fmt: skip


def visible_axes(view: Viewpoint) -> list[tuple[str, Floats]]:
    """Return names and directions (2,) of the anatomical axes in view; parallel ones together."""
    visible: list[tuple[str, Floats]] = []
    for name, axis in AXES.items():
        seen = view.project(np.array(axis))[:2]
        size = float(np.hypot(*seen))
        if size < IN_VIEW:
            continue
        for k, (other, there) in enumerate(visible):
            if seen @ there > 0.94 * size * np.hypot(*there):
                visible[k] = f'{other}, {name}', there
                break
        else:
            visible.append((name, seen))
    return visible


def refine(points: Floats, step: float = PIECE) -> Floats:
    """Return a polyline (k, 3) with its points about `step`, m, apart."""
    along = np.concatenate(([0.0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()))
    distances = np.union1d(along, np.linspace(0.0, along[-1], int(along[-1] / step) + 2))
    return np.column_stack([np.interp(distances, along, column) for column in points.T])


def push_apart(points: Floats, fixed: Floats, least: float, rounds: int = 200) -> Floats:
    """Return points (k, 2), pushed apart to a distance of about `least` or more.

    That is from each other, and from the fixed points (j, 2).
    """
    places = points + 1e-6 * np.arange(2 * len(points)).reshape(-1, 2)  # none on another
    for _ in range(rounds):
        between = places[:, None] - np.concatenate((places, fixed))[None, :]
        distance = np.linalg.norm(between, axis=2)
        np.fill_diagonal(distance, np.inf)
        lack = np.maximum(least - distance, 0.0)
        if lack.max() < 0.02 * least:
            break
        push = np.where(lack > 0.0, lack / np.maximum(distance, 1e-9), 0.0)
        places = places + 0.3 * (push[..., None] * between).sum(axis=1)
    return places
