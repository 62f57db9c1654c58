# SPDX-License-Identifier: Apache-2.0
"""Lengths and moment arms over the angle (E.4, E.5), depths of interference, other models' arms.

What colour shows is shown again by line style, marker or lightness. mm and deg.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...drawing.colours import band_shades
from ...drawing.plot import DASHES
from ...drawing.units import DEGREES, MILLIMETRES
from ...types import Floats
from ..experiments import MOTIONS, Experiment
from ..fidelity import AS_IS, TWO_THIRDS, AngleReading, integrate_arms
from ..interference import Checks
from ..literature import (
    HEADS,
    RHYTHM,
    AngleCurve,
    measured_arms,
    published_curves,
    published_models,
)
from ..subject import Subject
from .muscle import named_bands
from .poses import WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Marks = Mapping[str, tuple[Callable[[Experiment], Floats], str]]
"""Markers: what of an experiment they show, (m, n) m, and how the legend calls it."""

ROW = 1.55  # inches: the height of a row of panels
MEASURED: Mapping[AngleReading, Any] = {
    AS_IS: '-',
    TWO_THIRDS: (0, (4.0, 1.2)),
}  # line styles of the measurement's readings
GREY = '0.45'
# of the published models: colour (Okabe and Ito's), line style and marker
MODELS: Sequence[tuple[str, Any, str]] = (
    ('#0072B2', '-', 's'),
    ('#0072B2', ':', 's'),
    ('#56B4E9', '-', '^'),
    ('#56B4E9', ':', '^'),
    ('#009E73', '-', 'D'),
    ('#CC79A7', '-', 'v'),
    ('#8C6D1F', '-', 'x'),
)
OURS = '#D55E00'
MARK: dict[str, Any] = {
    'markersize': 3.0, 'color': 'black', 'markerfacecolor': 'none', 'markeredgewidth': 0.6,
}  # fmt: skip
FOOT = 1.0  # inches below the panels: the axis's name and the legend
GRID = '0.93'  # the grey of the lines between cells
DEEP = 21.0  # mm: what is black


def lengths_figure(subject: Subject) -> Figure:
    """E.4: lengths of all bands over the angle, a row for each head, a column for each motion."""
    marks = {'o': (lambda one: one.lengths, 'every 10 deg, band that represents the head')}
    return _over_angle(subject, 'length (mm)', marks, 'Ackland 2008, integrated', integrate_arms)


def moment_arms_figure(subject: Subject) -> Figure:
    """E.5: moment arms of all bands over the angle; exact, and the thesis's from cubics."""
    marks = {
        'o': (lambda one: one.arms, 'exact, every 10 deg, band that represents the head'),
        'x': (lambda one: one.cubic_arms, 'the same from a cubic through its lengths (thesis)'),
    }
    label = 'moment arm (mm)' if subject.scale == 1.0 else f'{subject.scale:g} x moment arm (mm)'
    figure = _over_angle(subject, label, marks, 'Ackland 2008', lambda curve, start: curve)
    for axes in figure.axes:
        axes.axhline(0.0, color='0.6', linewidth=0.5, zorder=0.5)
    return figure


def _over_angle(
    subject: Subject,
    label: str,
    marks: Marks,
    measurement: str,
    convert: Callable[[AngleCurve, float], AngleCurve],
) -> Figure:
    """Draw the first of the marked quantities as lines, all of them as marks, and what is measured.

    `convert` turns measured moment arms, and the model's first value, into the curve that is drawn.
    """
    figure, panels = _page([head.name for head in subject.muscle.heads], label)
    (quantity, _), *_ = marks.values()
    for row, head in enumerate(subject.muscle.heads):
        for axes, one, tabled in zip(panels[row], subject.curves, subject.experiments, strict=True):
            _bands(axes, subject, head.bands, one.angles, quantity(one))
            k = tabled.column(head.name)
            for marker, (values, _) in marks.items():
                axes.plot(DEGREES * tabled.angles, MILLIMETRES * values(tabled)[:, k],
                          linestyle='', marker=marker, clip_on=False, **MARK)  # fmt: skip
            curve = measured_arms().get((head.name, one.motion.name))
            if subject.is_comparable and curve is not None:
                for reading in MEASURED:
                    there = convert(reading.apply(curve), float(quantity(one)[0, k]))
                    _measured(axes, there, reading, one.motion.last)
    _legend(figure, subject, {marker: text for marker, (_, text) in marks.items()}, measurement)
    return figure


def fidelity_figure(subject: Subject) -> Figure:
    """Measured moment arms beside ours and those of published models, heads by motions."""
    figure, panels = _page(HEADS, 'moment arm (mm)', foot=0.78)
    for row, head in enumerate(HEADS):
        for column, one in enumerate(subject.curves):
            axes, motion = panels[row, column], one.motion.name
            axes.axhline(0.0, color='0.6', linewidth=0.5, zorder=0.5)
            for name, (colour, style, marker) in zip(published_models(), MODELS, strict=True):
                curve = published_curves()[name][head, motion]
                face = 'white' if name.endswith(RHYTHM) else colour
                axes.plot(DEGREES * curve.angles, MILLIMETRES * curve.values, color=colour,
                          linestyle=style, linewidth=0.8, marker=marker, markersize=2.8,
                          markerfacecolor=face, markeredgewidth=0.7, label=name)  # fmt: skip
            arms = one.arms[:, one.column(head)]
            label = 'this model' if subject.scale == 1.0 else f'this model x {subject.scale:g}'
            axes.plot(DEGREES * one.angles, MILLIMETRES * arms, color=OURS, linewidth=2.0,
                      label=label)  # fmt: skip
            if (head, motion) in measured_arms():
                for reading in MEASURED:
                    _measured(
                        axes, reading.apply(measured_arms()[head, motion]), reading, one.motion.last
                    )
    _below(figure, panels[0, 0].get_legend_handles_labels()[0], left=0.06, columns=5, foot=0.78)
    return figure


def depths_figure(readings: Mapping[str, Checks]) -> Figure:
    """How deep each band enters bone at each pose, a chart for each reading; mm and spheres."""
    from matplotlib.figure import Figure

    first = next(iter(readings.values()))
    bands = first.experiments[0].states.solver.muscle.band_names
    figure = Figure(figsize=(WIDTH, len(readings) * (0.62 + 0.21 * len(bands)) + 0.1))
    charts = figure.subplots(len(readings), 1, squeeze=False)[:, 0]
    for axes, (name, checks) in zip(charts, readings.items(), strict=True):
        left, ticks = 0.0, []
        for one, deep in zip(checks.experiments, checks.depths, strict=True):
            _cells(axes, left, MILLIMETRES * deep, checks.spheres)
            places = left + 0.5 + np.arange(len(one.angles))
            angles = (DEGREES * one.angles).tolist()
            ticks += [(place, f'{angle:.0f}') for place, angle in zip(places, angles, strict=True)]
            axes.text(left, -0.25, f'{one.motion.name} (deg)', va='bottom', size=6.5)
            left += len(angles) + 0.5
        axes.set(
            xlim=(0.0, left - 0.5), ylim=(len(bands), 0.0), yticks=np.arange(len(bands)) + 0.5,
            yticklabels=[f'{k}  {band}' for k, band in enumerate(bands, 1)],
            xticks=[place for place, _ in ticks], xticklabels=[text for _, text in ticks],
        )  # fmt: skip
        axes.tick_params(length=0.0, labelsize=6.0)
        axes.spines[:].set_visible(False)
        axes.set_title(name, loc='left', size=7.0, weight='bold', pad=13.0)
    figure.subplots_adjust(0.105, 0.05, 0.995, 0.93, hspace=0.32)
    return figure


def _cells(axes: Axes, left: float, deep: Floats, spheres: Sequence[str]) -> None:
    """Draw a motion's cells: of depths (m, n, k), mm, the deepest, and the spheres' numbers."""
    m, n, _ = deep.shape
    deepest = deep.max(axis=2)
    shades = np.where(deepest >= 0.0, np.clip(0.88 - 0.75 * deepest / DEEP, 0.1, 0.88), 1.0)
    axes.imshow(shades.T, extent=(left, left + m, n, 0.0), cmap='gray', vmin=0.0, vmax=1.0,
                aspect='auto', interpolation='nearest')  # fmt: skip
    axes.vlines(left + np.arange(m + 1), 0.0, n, color=GRID, linewidth=0.5)
    axes.hlines(np.arange(n + 1), left, left + m, color=GRID, linewidth=0.5)
    numbers = [name.rpartition('_')[2] for name in spheres]
    for pose, band in np.argwhere(deepest >= 0.0).tolist():
        depth = float(deepest[pose, band])
        entered = [each for each, mm in zip(numbers, deep[pose, band], strict=True) if mm >= 0.0]
        ink, x = 'white' if shades[pose, band] < 0.45 else 'black', left + pose + 0.5
        style: dict[str, Any] = {'ha': 'center', 'va': 'center', 'color': ink}
        axes.text(x, band + 0.34, f'{depth:.0f}' if depth >= 0.5 else '<1', size=6.0, **style)
        axes.text(x, band + 0.76, ','.join(entered), size=4.0, **style)


def _page(heads: Sequence[str], label: str, foot: float = FOOT) -> tuple[Figure, npt.NDArray[Any]]:
    """Return a figure with a row for each head and a column for each motion."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 0.25 + ROW * len(heads) + foot))
    panels = figure.subplots(len(heads), len(MOTIONS), sharex='col', sharey='row', squeeze=False)
    for column, motion in enumerate(MOTIONS):
        panels[0, column].set_title(motion.name, size=7.5)
        panels[-1, column].set_xlabel('angle (deg)')
        panels[-1, column].set_xlim(0.0, DEGREES * motion.last + 1.0)
        panels[-1, column].set_xticks(np.arange(0.0, DEGREES * motion.last + 1.0, 20.0))
    for row, head in enumerate(heads):
        panels[row, 0].set_ylabel(f'{head} head\n{label}')
    height = figure.get_figheight()
    figure.subplots_adjust(
        0.085, foot / height, 0.99, 1.0 - 0.25 / height, hspace=0.12, wspace=0.06
    )
    return figure, panels


def _bands(
    axes: Axes, subject: Subject, bands: Sequence[str], angles: Floats, values: Floats
) -> None:
    """Draw some bands' values (m, n), m."""
    muscle = subject.muscle
    for lane, band in enumerate(bands):
        k = muscle.band_names.index(band)
        axes.plot(
            DEGREES * angles, MILLIMETRES * values[:, k], color=band_shades(muscle)[k],
            linestyle=DASHES[(lane - len(bands)) % len(DASHES)], linewidth=1.0, label=band,
        )  # fmt: skip


def _measured(axes: Axes, curve: AngleCurve, reading: AngleReading, last: float) -> None:
    """Draw a measured curve, as far as the motion goes, to its last angle, rad."""
    within = curve.angles <= last
    axes.plot(
        DEGREES * curve.angles[within], MILLIMETRES * curve.values[within], color=GREY,
        linestyle=MEASURED[reading], linewidth=2.2, zorder=1.5,
        label=f'measured, {reading.name}',
    )  # fmt: skip


def _legend(figure: Figure, subject: Subject, notes: Mapping[str, str], measurement: str) -> None:
    """Write below the panels what the lines are: bands by heads, then marks and measurements."""
    from matplotlib.lines import Line2D

    heads, named = subject.muscle.heads, named_bands(subject.muscle)
    lines = [line for axes in figure.axes[:: len(MOTIONS)] for line in axes.get_lines()]
    bands = [line for line in lines if line.get_label() in named]
    others: list[Any] = [
        Line2D([], [], linestyle='', marker=marker, label=text, **MARK)
        for marker, text in notes.items()
    ]
    if subject.is_comparable:
        others += [
            Line2D([], [], color=GREY, linestyle=style, linewidth=2.2,
                   label=f'{measurement}; {reading.name}')
            for reading, style in MEASURED.items()
        ]  # fmt: skip
    _below(figure, bands, left=0.02, columns=len(heads))
    _below(figure, others, left=0.55, columns=1)


def _below(
    figure: Figure, handles: Sequence[Any], left: float, columns: int, foot: float = FOOT
) -> None:
    """Write a legend below the panels."""
    figure.legend(
        handles=handles, loc='upper left', ncols=columns, handlelength=3.0, columnspacing=1.0,
        bbox_to_anchor=(left, (foot - 0.42) / figure.get_figheight()), borderaxespad=0.0,
    )  # fmt: skip
