# SPDX-License-Identifier: Apache-2.0
"""Flexion as a GIF: the bands and their planes, which fan out and rotate with theta."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...drawing.colours import band_shades
from ...drawing.figure_files import house_style
from ...drawing.units import DEGREES, MILLIMETRES
from ..experiments import Experiment, simulate_motion
from ..subject import Subject
from .muscle import add_attachments, add_bands, add_bones, add_planes, number_bands
from .scene import LATERAL, SUPERIOR, Scene, set_frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STEP = np.radians(5.0).item()  # from frame to frame
SIZE, DPI = (8.0, 3.4), 100  # inches, pixels an inch
DURATION = 100  # ms a frame
COLOURS = 96
STYLES = ('-', '--', ':', '-.')  # of the heads' curves, in turn


def write_animation(subject: Subject, path: Path, step: float = STEP) -> None:
    """Write flexion, there and back, as an endless GIF with a frame every `step`, rad."""
    from PIL import Image

    motion = subject.experiments[0].motion
    one = simulate_motion(subject.solver, motion, motion.angles(step), subject.scale)
    with house_style():
        there = [
            Image.fromarray(render_frame(subject, one, pose)) for pose in range(len(one.angles))
        ]
    palette = there[0].quantize(COLOURS)
    first, *others = [
        each.quantize(palette=palette, dither=Image.Dither.NONE)
        for each in (*there, *there[-2:0:-1])
    ]
    first.save(
        path, format='GIF', save_all=True, append_images=others, duration=DURATION, loop=0,
        optimize=True,
    )  # fmt: skip


def render_frame(subject: Subject, one: Experiment, pose: int) -> npt.NDArray[np.uint8]:
    """Return a frame's pixels (rows, columns, 3): from lateral, from above, moment arms."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, dpi=DPI)
    canvas: Any = FigureCanvasAgg(figure)
    state = one.states[pose]
    views = (
        (LATERAL, (0.0, 0.0, 0.39, 1.0), (0.0, 0.03, -0.02)),
        (SUPERIOR, (0.39, 0.0, 0.33, 1.0), (-0.018, 0.02, 0.0)),
    )
    for view, place, middle in views:
        axes = figure.add_axes(place)
        set_frame(axes, view, middle, 0.11)
        scene = Scene(view)
        for add in (add_bones, add_planes, add_bands, add_attachments):
            add(scene, state)
        scene.draw(axes)
        number_bands(axes, scene, state)
        axes.text(0.03, 0.98, view.name, transform=axes.transAxes, va='top', size=7.0)
    angles = f'flexion {DEGREES * one.angles[pose]:.0f}°, theta {DEGREES * state.theta:.0f}°'
    figure.axes[0].text(0.03, 0.93, angles, transform=figure.axes[0].transAxes, va='top', size=8.0)
    _chart(figure.add_axes((0.785, 0.15, 0.2, 0.68)), subject, one, pose)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()


def _chart(axes: Axes, subject: Subject, one: Experiment, pose: int) -> None:
    """Draw the heads' moment arms over the angle, and mark the pose."""
    angles, arms = DEGREES * one.angles, MILLIMETRES * one.arms
    for place, head in enumerate(subject.muscle.heads):
        k = one.column(head.name)
        colour = band_shades(subject.muscle)[k]
        axes.plot(angles, arms[:, k], STYLES[place % len(STYLES)], color=colour, label=head.name)
        axes.plot(angles[pose], arms[pose, k], 'o', color=colour, markersize=4.0, clip_on=False)
    axes.axhline(0.0, color='0.6', linewidth=0.5, zorder=0.5)
    axes.axvline(angles[pose], color='0.6', linewidth=0.5, zorder=0.5)
    scaled = '' if subject.scale == 1.0 else f'{subject.scale:g} x '
    axes.set(xlim=(0.0, angles[-1]), xlabel='flexion (deg)', ylabel=f'{scaled}moment arm (mm)')
    axes.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), borderaxespad=0.3)
