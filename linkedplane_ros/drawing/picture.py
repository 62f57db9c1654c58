# SPDX-License-Identifier: Apache-2.0
"""A picture of a muscle model: attachments, spheres and bands at three poses, from two sides."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ModelError
from ..joints.conventions import THESIS_CONVENTION
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.range_check import DEFAULT_RANGE, describe_pose
from ..solver.states import MuscleState, WrapState
from ..types import Floats
from .colours import head_colours, sphere_colours
from .figure_files import import_matplotlib, write_figure
from .units import MILLIMETRES

if TYPE_CHECKING:
    from matplotlib.figure import Figure


VIEWS = {'from the right front': (14.0, 38.0), 'from the right back': (14.0, -52.0)}
"""Elevation and azimuth of the eye, deg; x lateral, y anterior, z superior."""
MARGIN = 5.0  # mm
GREY = '0.45'
RAISED = (math.radians(80.0), math.radians(90.0))  # flexion, abduction, if the model goes so far


def pictured_poses(muscle: BroadMuscle) -> Floats:
    """Return three poses (3, 3), rad, of the range of motion: hanging, flexed and abducted."""
    low, high = np.array(muscle.range_of_motion or DEFAULT_RANGE).T
    wanted = ((0.0, 0.0, 0.0), (RAISED[0], 0.0, 0.0), (0.0, RAISED[1], 0.0))
    return np.clip(wanted, low, high)


def save_picture(muscle: BroadMuscle, file: Path) -> None:
    """Write the picture of a model.

    Parameters
    ----------
    muscle
        What is drawn.
    file
        Where: a .png or .svg.

    Raises
    ------
    ModelError
        For another ending.
    RecordingError
        If the file cannot be written, or matplotlib is not there.
    """
    kind = file.suffix.lower().removeprefix('.')
    if kind not in ('png', 'svg'):
        raise ModelError(f'{file}: a picture ends in .png or .svg')
    write_figure(model_figure(muscle), file, kind)


def model_figure(muscle: BroadMuscle) -> Figure:
    """Return the picture of a model: a column for each pose, a row for each view; mm."""
    import_matplotlib()
    from matplotlib.figure import Figure

    solver = LinkedPlaneSolver(muscle)
    poses = pictured_poses(muscle)
    states = [(each, solver.solve(THESIS_CONVENTION.rotation(each))) for each in poses]
    corners = bounding_corners(muscle, [state for _, state in states])
    figure = Figure(figsize=(11.0, 7.4))
    for row, (side, (elevation, azimuth)) in enumerate(VIEWS.items()):
        for column, (angles, state) in enumerate(states):
            axes: Any = figure.add_subplot(2, 3, 3 * row + column + 1, projection='3d')
            draw_state(axes, state)
            axes.set(xlim=corners[:, 0], ylim=corners[:, 1], zlim=corners[:, 2])
            axes.set_box_aspect(corners[1] - corners[0], zoom=1.06)
            axes.view_init(elev=elevation, azim=azimuth)
            axes.tick_params(labelsize=5, pad=-3)
            axes.locator_params(nbins=4)
            for name, label in zip('xyz', ('lateral', 'anterior', 'superior'), strict=True):
                getattr(axes, f'set_{name}label')(f'{name}, {label} (mm)', size=5, labelpad=-9)
            title = f'{describe_pose(angles)}\n{side}' if row == 0 else side
            axes.set_title(title, size=8, y=0.96)
    add_caption(figure, muscle)
    figure.subplots_adjust(0.02, 0.05, 0.97, 0.93, 0.04, 0.04)
    return figure


def bounding_corners(muscle: BroadMuscle, states: list[MuscleState]) -> Floats:
    """Return two corners (2, 3), mm, that hold the muscle and its spheres at all poses."""
    points = [np.zeros((1, 3))]
    for state in states:
        points += [state.origins, state.insertions, *state.paths(8)]
        for centres, radii in (
            (state.sphere_centres, muscle.sphere_radii),
            (state.interference_centres, muscle.interference_radii),
        ):
            points += [centres - radii[:, np.newaxis], centres + radii[:, np.newaxis]]
    every = MILLIMETRES * np.concatenate(points)
    return np.array((every.min(axis=0) - MARGIN, every.max(axis=0) + MARGIN))


def draw_state(axes: Any, state: MuscleState) -> None:
    """Draw a state, in mm: bands and their ends, obstacle and interference spheres, the humerus."""
    muscle = state.solver.muscle
    colours = head_colours(muscle)
    for first, colour in sphere_colours(muscle).items():
        centre, radius = state.sphere_centres[first], muscle.sphere_radii[first]
        axes.plot_surface(*sphere_grid(centre, radius), color=colour, alpha=0.10, linewidth=0)
    for centre, radius in zip(state.interference_centres, muscle.interference_radii, strict=True):
        axes.plot_wireframe(*sphere_grid(centre, radius)[:, ::2, ::2], color=GREY, linewidth=0.25)
    for path, colour, wrap in zip(state.paths(24), colours, state.wrap.tolist(), strict=True):
        dashed = wrap == WrapState.INSIDE  # no path: an end lies in the sphere
        axes.plot(*MILLIMETRES * path.T, color=colour, linestyle=':' if dashed else '-')
    for ends, mark in ((state.origins, 'o'), (state.insertions, 's')):
        axes.scatter(*MILLIMETRES * ends.T, c=colours, marker=mark, s=10, depthshade=False)
    shaft = state.to_scapula(np.array(((0.0, 0.0, 0.0), (0.0, 0.0, muscle.insertions[:, 2].min()))))
    axes.plot(*MILLIMETRES * shaft.T, color='0.7', linewidth=3.0, zorder=0)


def sphere_grid(centre: Floats, radius: float) -> Floats:
    """Return the grid (3, 11, 19), mm, of a sphere's surface; centre and radius in m."""
    down, around = np.meshgrid(
        np.linspace(0.0, np.pi, 11), np.linspace(0.0, 2.0 * np.pi, 19), indexing='ij'
    )
    unit = np.stack((np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)))
    return np.asarray(MILLIMETRES * (centre[:, np.newaxis, np.newaxis] + radius * unit))


def add_caption(figure: Figure, muscle: BroadMuscle) -> None:
    """Write the muscle's name, and a legend of its heads and lines."""
    from matplotlib.lines import Line2D

    colours = dict(zip(muscle.band_names, head_colours(muscle), strict=True))
    handles = [
        Line2D([], [], color=colours[head.bands[0]], label=head.name) for head in muscle.heads
    ]
    handles.append(Line2D([], [], color='0.7', linewidth=3.0, label='humerus'))
    if muscle.interference_names:
        handles.append(Line2D([], [], color=GREY, linewidth=0.5, label='interference spheres'))
    figure.legend(handles=handles, loc='lower center', ncols=6, frameon=False, fontsize=8)
    figure.text(0.02, 0.97, f'{muscle.name}: {len(muscle.band_names)} bands', size=11, va='top')
    spheres = 'tinted: obstacle spheres; round marks: origins, square: insertions'
    figure.text(0.98, 0.97, spheres, size=8, va='top', ha='right')
