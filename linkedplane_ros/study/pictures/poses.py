# SPDX-License-Identifier: Apache-2.0
"""Pictures of the muscle in the manner of the thesis's Figures E.1 to E.3 and E.6 to E.10.

The thesis draws reconstructed bones, which are not available: here the interference spheres stand
for the scapula and the humeral head, and a cylinder for the humeral shaft.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

from ...drawing.bones import BONE
from ...drawing.colours import band_shades
from ...drawing.units import DEGREES
from ...solver.states import MuscleState
from ...types import Point
from ..attachments import span_attachments
from ..interference import Checks
from ..subject import Subject
from .muscle import (
    add_attachments,
    add_bands,
    add_bones,
    add_entries,
    add_obstacles,
    named_bands,
    number_bands,
    number_bone,
    number_obstacles,
)
from .scene import FRONTAL, LATERAL, POSTERIOR, SUPERIOR, TOP_BACK, Scene, Viewpoint, set_frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 7.2  # inches: of a page's text
TITLE = 0.2  # inches: above a panel
EXTENSION, FLEXION = -40.0, 80.0  # deg: E.10 names no angles
DOWN = (0.0, 0.0, -0.035)  # m: the middle of a picture
# Where bands enter bone: the pose that is deepest in each motion, and neutral
ENTERED = (
    ('arm at the side', 'flexion', 0.0, LATERAL),
    ('flexion 50°', 'flexion', 50.0, POSTERIOR),
    ('abduction 90°', 'abduction', 90.0, POSTERIOR),
    ('scaption 60°', 'scaption', 60.0, POSTERIOR),
)

Add = Callable[[Scene, MuscleState], None]
Number: TypeAlias = 'Callable[[Axes, Scene, MuscleState], None]'


@dataclass(frozen=True)
class Panel:
    """One picture of a page."""

    title: str
    state: MuscleState
    view: Viewpoint
    middle: Point
    size: float
    """Half the picture's height, m."""
    adds: tuple[Add, ...]
    numbers: tuple[Number, ...] = (number_bands,)


def attachments_figure(subject: Subject) -> Figure:
    """E.1: the attachments of the bands within their whole span."""
    span = span_attachments(subject.muscle)
    adds: tuple[Add, ...] = (add_bones, lambda s, state: add_attachments(s, state, span))
    neutral = subject.solve_pose('flexion', 0.0)
    return draw_panels(
        [
            Panel('from lateral', neutral, LATERAL, DOWN, 0.105, adds),
            Panel('from above', neutral, SUPERIOR, (-0.02, 0.0, 0.0), 0.105, adds),
        ],
        columns=2,
        height=2.9,
    )


def obstacles_figure(subject: Subject) -> Figure:
    """E.2: the obstacle spheres of all bands, with the attachments."""
    neutral = subject.solve_pose('flexion', 0.0)
    adds: tuple[Add, ...] = (add_bones, add_obstacles, add_attachments)
    return draw_panels(
        [
            Panel(view.name, neutral, view, DOWN, 0.105, adds, (number_bands, number_obstacles))
            for view in (LATERAL, FRONTAL)
        ],
        columns=2,
        height=2.9,
    )


def poses_figure(subject: Subject) -> Figure:
    """E.3 and E.6 to E.9: the muscle at rest and at the ends of the motions."""
    neutral = subject.solve_pose('flexion', 0.0)
    flexed, raised, abducted = (
        subject.solve_pose(*pose)
        for pose in (('flexion', 80.0), ('scaption', 80.0), ('abduction', 90.0))
    )
    panels = (
        ('E.3  arm at the side, from behind and above', neutral, TOP_BACK, (-0.01, 0.0, -0.035)),
        ('E.6  arm at the side, from lateral', neutral, LATERAL, DOWN),
        ('E.7  flexion 80°, from lateral', flexed, LATERAL, (0.0, 0.03, 0.0)),
        ('E.8  scaption 80°, from lateral', raised, LATERAL, (0.0, 0.02, 0.0)),
        ('E.9  abduction 90°, from the front', abducted, FRONTAL, (0.008, 0.0, 0.0)),
    )
    figure = draw_panels(
        [Panel(*each, 0.105, (add_bones, add_bands, add_attachments)) for each in panels],
        columns=3,
        height=2.55,
    )
    add_key(figure, subject, left=0.7, bottom=0.1)
    return figure


def montage_figure(subject: Subject) -> Figure:
    """E.10: from extension to flexion, from lateral."""
    adds: tuple[Add, ...] = (add_bones, add_bands, add_attachments)
    return draw_panels(
        [
            Panel(
                title,
                subject.solve_pose('flexion', degrees),
                LATERAL,
                (0.0, 0.01, -0.02),
                0.115,
                adds,
            )
            for title, degrees in (
                (f'a)  extension {-EXTENSION:.0f}°', EXTENSION),
                ('b)  neutral', 0.0),
                (f'c)  flexion {FLEXION:.0f}°', FLEXION),
            )
        ],
        columns=3,
        height=2.6,
    )


def entries_figure(readings: Mapping[str, tuple[Subject, Checks]]) -> Figure:
    """Where bands enter bone, a row for each reading: black within bone, white where deepest."""
    panels = []
    for name, (subject, checks) in readings.items():
        for title, motion, degrees, view in ENTERED:
            there = [
                each
                for each in checks.entries
                if each.motion == motion and round(DEGREES * each.angle) == degrees
            ]
            adds = (add_bones, add_bands, add_attachments, partial(add_entries, entries=there))
            state, middle = subject.solve_pose(motion, degrees), (0.012, 0.0, -0.025)
            words = f'{name}\n{title}, {view.name}'
            numbers = (number_bands, number_bone)
            panels.append(Panel(words, state, view, middle, 0.125, adds, numbers))
    return draw_panels(panels, columns=4, height=2.2, title=0.32)


def draw_panels(
    panels: Sequence[Panel], columns: int, height: float, title: float = TITLE
) -> Figure:
    """Return a page of pictures, `columns` in a row, each of a height in inches below its title."""
    from matplotlib.figure import Figure

    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(WIDTH, rows * (height + title)))
    width, step, share = 1.0 / columns, 1.0 / rows, height / (height + title)
    for k, panel in enumerate(panels):
        row, column = divmod(k, columns)
        axes: Any = figure.add_axes((column * width, 1.0 - (row + 1) * step, width, step * share))
        axes.set_title(panel.title, loc='left', size=6.5, pad=3.0, x=0.02)
        set_frame(axes, panel.view, panel.middle, panel.size)
        scene = Scene(panel.view)
        for add in panel.adds:
            add(scene, panel.state)
        scene.draw(axes)
        for number in panel.numbers:
            number(axes, scene, panel.state)
    return figure


def add_key(figure: Figure, subject: Subject, left: float, bottom: float) -> None:
    """Write which number and colour is which band, and what stands for bone."""
    from matplotlib.lines import Line2D

    muscle = subject.muscle
    handles = [
        Line2D([], [], color=colour, linewidth=2.5, label=f'{k}  {band}')
        for k, (band, colour) in enumerate(
            zip(muscle.band_names, band_shades(muscle), strict=True), 1
        )
        if band in named_bands(muscle)
    ]
    bone = Line2D([], [], color=BONE, linewidth=5.0, label='interference spheres, for\n'
                  'bone; humeral shaft (schematic)')  # fmt: skip
    figure.legend(handles=[*handles, bone], loc='lower left', bbox_to_anchor=(left, bottom))
