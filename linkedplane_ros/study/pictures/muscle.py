# SPDX-License-Identifier: Apache-2.0
"""The muscle as a scene: bones, attachments, bands, their obstacle spheres and planes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...drawing.bones import BONE, SHAFT_RADIUS, shaft_axis
from ...drawing.colours import band_shades
from ...drawing.planes import plane_patches
from ...muscle.broad_muscle import BroadMuscle
from ...solver.states import MuscleState
from ...types import Colour, Floats
from ..attachments import Attachments
from ..interference import SphereEntry
from .scene import SMALL, Scene, push_apart, refine

if TYPE_CHECKING:
    from matplotlib.axes import Axes


BAND = 0.0032  # m: the width of a band in a picture
ATTACHMENT = 0.0028  # m: the radius of an attachment
SITE = 0.0021  # m: ... of one of the whole span
OBSTACLE = 0.16  # of an obstacle sphere's opacity
VEIL = 0.6  # the opacity of bone: bands are seen to go through it
ABOVE, BELOW = 0.024, 0.004  # m: how far a plane is drawn beyond its band, on either side
ASIDE = 0.008  # m: how far a band's number stands from its origin, and from the next number
PAPER = {'boxstyle': 'round,pad=0.08', 'color': 'white', 'alpha': 0.6, 'linewidth': 0.0}
MOST_NAMED = 12  # bands in a legend
INSIDE: Colour = (0.0, 0.0, 0.0)  # what is in bone


def named_bands(muscle: BroadMuscle) -> set[str]:
    """Return the bands that a legend names: all, or of many those that represent heads."""
    if len(muscle.band_names) > MOST_NAMED:
        return {head.represented_by for head in muscle.heads}
    return set(muscle.band_names)


def add_bones(scene: Scene, state: MuscleState, alpha: float = VEIL) -> None:
    """Add the interference spheres, for the bone that they stand for, and a humeral shaft."""
    muscle = state.solver.muscle
    spheres = zip(muscle.interference_centres, muscle.interference_radii.tolist(), strict=True)
    for centre, radius in spheres:
        scene.add_sphere(centre, radius, BONE, alpha)
    scene.add_rod(state.to_scapula(shaft_axis(muscle)), SHAFT_RADIUS, BONE)


def add_attachments(scene: Scene, state: MuscleState, span: Attachments | None = None) -> None:
    """Add the ends of the bands, in their colours, and the whole span, in that of bone."""
    muscle = state.solver.muscle
    if span is not None:
        for point in (*span.origins, *state.to_scapula(span.insertions)):
            scene.add_sphere(point, SITE, BONE)
    for ends in (muscle.origins, state.insertions):
        for point, colour in zip(ends, band_shades(muscle), strict=True):
            scene.add_sphere(point, ATTACHMENT, colour)


def add_bands(scene: Scene, state: MuscleState) -> None:
    """Add the bands' paths."""
    for path, colour in zip(state.paths(17), band_shades(state.solver.muscle), strict=True):
        scene.add_ribbon(path, BAND, colour)


def add_obstacles(scene: Scene, state: MuscleState) -> None:
    """Add the bands' obstacle spheres."""
    muscle = state.solver.muscle
    spheres = zip(
        state.sphere_centres, muscle.sphere_radii.tolist(), band_shades(muscle), strict=True
    )
    for centre, radius, colour in spheres:
        scene.add_sphere(centre, radius, colour, OBSTACLE)


def add_planes(scene: Scene, state: MuscleState, alpha: float = 0.12) -> None:
    """Add each band's plane: as much of it as lies about the band."""
    muscle = state.solver.muscle
    drawn = zip(plane_patches(state, 1.0), state.paths(17), band_shades(muscle), strict=True)
    for (P, S, _, aside), path, colour in drawn:
        e = aside - P
        above = (float(((path - P) @ e).max()) + ABOVE) * e
        corners = np.array((P - BELOW * e, P + above, S + above, S - BELOW * e))
        scene.add_sheet(corners, colour, alpha)


def add_entries(scene: Scene, state: MuscleState, entries: list[SphereEntry]) -> None:
    """Add the parts of bands that lie in bone, before everything, and their deepest points."""
    muscle = state.solver.muscle
    for path in state.paths(65):
        points = refine(path, step=0.0005)
        inside = np.zeros(len(points), dtype=bool)
        for centre, radius in zip(
            muscle.interference_centres, muscle.interference_radii, strict=True
        ):
            inside |= np.linalg.norm(points - centre, axis=1) <= radius
        edges = np.flatnonzero(np.diff(inside, prepend=False, append=False))
        for start, stop in edges.reshape(-1, 2).tolist():
            if stop - start > 1:
                scene.add_ribbon(points[start:stop], 1.15 * BAND, INSIDE, towards=1.0)
    for entry in entries:
        scene.add_sphere(np.array(entry.point), 0.0024, (1.0, 1.0, 1.0), towards=2.0)


def number_bands(axes: Axes, scene: Scene, state: MuscleState) -> None:
    """Write each band's number beside its origin, away from the others' middle."""
    origins = scene.view.project(state.solver.muscle.origins)[:, :2]
    away = origins - origins.mean(axis=0)
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-6)
    places = push_apart(origins + ASIDE * away, origins, ASIDE)
    _number(axes, state.solver.muscle, places, origins)


def number_obstacles(axes: Axes, scene: Scene, state: MuscleState) -> None:
    """Write each band's number at the lowest point of its obstacle sphere's rim."""
    muscle = state.solver.muscle
    rims = scene.view.project(state.sphere_centres)[:, :2].copy()
    rims[:, 1] -= muscle.sphere_radii
    places = push_apart(rims - np.array((0.0, ASIDE)), rims, 0.8 * ASIDE)
    _number(axes, muscle, places, rims)


def number_bone(axes: Axes, scene: Scene, state: MuscleState) -> None:
    """Write the number of each interference sphere, S4, at its rim away from the others."""
    muscle = state.solver.muscle
    centres = scene.view.project(muscle.interference_centres)[:, :2]
    away = centres - centres.mean(axis=0) - (0.0, 1e-3)
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-6)
    places = 1e3 * (centres + (muscle.interference_radii[:, np.newaxis] - 0.5 * ASIDE) * away)
    for name, (x, y) in zip(muscle.interference_names, places.tolist(), strict=True):
        axes.text(x, y, f'S{name.rpartition("_")[2]}', size=SMALL, style='italic', ha='center',
                  va='center', color='0.2')  # fmt: skip


def _number(axes: Axes, muscle: BroadMuscle, places: Floats, things: Floats) -> None:
    """Write the bands' numbers at places (n, 2), m in the picture; a line leads to the thing."""
    drawn = zip(places, things, band_shades(muscle), strict=True)
    for k, (place, thing, colour) in enumerate(drawn, 1):
        if muscle.band_names[k - 1] not in named_bands(muscle):
            continue
        red, green, blue = (0.75 * np.array(colour)).tolist()
        x, y = (1e3 * place).tolist()
        if np.linalg.norm(place - thing) > 1.25 * ASIDE:
            axes.plot(*(1e3 * np.array((place, thing))).T, color=(red, green, blue), linewidth=0.4)
        axes.text(x, y, str(k), size=SMALL, weight='bold', color=(red, green, blue), ha='center',
                  va='center', bbox=PAPER)  # fmt: skip
