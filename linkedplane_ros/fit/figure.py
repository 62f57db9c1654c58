# SPDX-License-Identifier: Apache-2.0
"""The pictures of a fit: what was measured, the model before and after, and the trade-off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..drawing.colours import head_colour
from ..drawing.figure_files import house_style, write_figure
from ..drawing.units import MILLIMETRES
from ..types import Colour
from .report import FinishedFit, mean_deviation

WIDTH, HEIGHT = 2.6, 2.2  # of a panel, inches


def draw_fit(outcome: FinishedFit, file: Path) -> None:
    """Write the picture as PNG: rows lengths and moment arms, columns motions, colours parts.

    RecordingError if it cannot be written, or matplotlib is not there.
    """
    with house_style():
        from matplotlib.figure import Figure

        kinds = {kind: rows for kind, rows in outcome.deviations(outcome.end).items() if rows}
        before = outcome.deviations(outcome.start)
        motions = list(dict.fromkeys(row[1] for rows in kinds.values() for row in rows))
        colours = _find_colours(outcome)
        figure = Figure((WIDTH * len(motions) + 0.8, HEIGHT * len(kinds) + 0.9))
        panels = figure.subplots(len(kinds), len(motions), squeeze=False, sharey='row')
        for row, kind in zip(panels, kinds, strict=True):
            for axes, motion in zip(row, motions, strict=True):
                for part, (_, colour) in colours.items():
                    of = (part, motion)
                    _draw_curves(axes, outcome, kind, of, (before[kind], kinds[kind]), colour)
                axes.set_visible(axes.has_data())
                axes.axhline(0.0, color='0.8', linewidth=0.6, zorder=0) if kind != 'length' else 0
                axes.set_xlabel(f'{motion} (deg)')
            row[0].set_ylabel(f'{kind} (mm)')
        _add_legend(figure, dict(colours.values()))
        title = f'{outcome.title}; {outcome.data.path.name}, {outcome.data.reading}'
        figure.suptitle(title, fontsize=7.0)
        figure.tight_layout(rect=(0.0, 0.09, 1.0, 1.0))
        write_figure(figure, file, 'png')


def draw_trade_off(outcome: FinishedFit, file: Path) -> None:
    """Write the mean deviations over how deep bands enter the spheres, stage by stage, as PNG.

    RecordingError if it cannot be written, or matplotlib is not there.
    """
    with house_style():
        from matplotlib.figure import Figure

        figure = Figure((4.0, 2.8))
        axes = figure.subplots()
        deepest = [MILLIMETRES * stage.survey.depths.max() for stage in outcome.stages]
        for kind, line in (('moment arm', 'o-'), ('length', 's--')):
            if outcome.deviations(outcome.end)[kind]:
                means = [
                    mean_deviation(outcome.deviations(each.best)[kind]) for each in outcome.stages
                ]
                axes.plot(deepest, means, line, color='0.2', markersize=3.0, label=kind)
                before = mean_deviation(outcome.deviations(outcome.start)[kind])
                depth = MILLIMETRES * outcome.survey_before.depths.max()
                axes.plot([depth], [before], line[0], color='0.2', fillstyle='none', markersize=5.0,
                          label=f'{kind}, {outcome.before.name}')  # fmt: skip
        axes.set_xlabel('deepest entry of a band into bone over the range of motion (mm)')
        axes.set_ylabel('mean deviation (mm)')
        axes.margins(y=0.08)
        axes.set_ylim(bottom=0.0)
        axes.axvline(0.0, color='0.8', linewidth=0.6, zorder=0)
        axes.legend()
        figure.suptitle(f'{outcome.title}; {outcome.data.path.name}, {outcome.data.reading}',
                        fontsize=7.0)  # fmt: skip
        figure.tight_layout()
        write_figure(figure, file, 'png')


def _draw_curves(
    axes: Any,
    outcome: FinishedFit,
    kind: str,
    of: tuple[str, str],
    deviations: Sequence[Sequence[tuple[str, str, float, float]]],
    colour: Colour,
) -> None:
    """Draw a part in a motion: points measured, dashed before, solid after."""
    name = {'length': 'length', 'moment arm': 'arm'}[kind]
    measured = [row for row in outcome.data.measurements if math.isfinite(getattr(row, name))]
    rows = sorted(
        (row.angle, MILLIMETRES * getattr(row, name), before[-1], after[-1])
        for row, before, after in zip(measured, *deviations, strict=True)
        if (row.part, row.motion) == of
    )
    if not rows:
        return
    angles, points, before, after = map(np.array, zip(*rows, strict=True))
    axes.plot(np.degrees(angles), points, 'o', color=colour, markersize=2.5)
    curve = len(angles) > 1 and bool((np.diff(angles) > 0.0).all())
    for off, line, size in ((before, (0, (3.0, 1.5)), 5.0), (after, '-', 9.0)):
        style = {} if curve else {'marker': '_', 'markersize': size}
        axes.plot(np.degrees(angles), points + off, linestyle=line if curve else '', color=colour,
                  linewidth=0.9, **style)  # fmt: skip


def _find_colours(outcome: FinishedFit) -> dict[str, tuple[str, Colour]]:
    """Return of each part that was measured the head that it belongs to, and that one's colour."""
    muscle = outcome.after
    heads = {
        row.part: muscle.find_head(muscle.band_names[row.band]) for row in outcome.data.measurements
    }
    order = list(dict.fromkeys(heads.values()))
    return {part: (head, head_colour(order.index(head))) for part, head in heads.items()}


def _add_legend(figure: Any, colours: Mapping[str, Colour]) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=colour, label=head) for head, colour in colours.items()]
    handles += [
        Line2D([], [], color='0.3', marker='o', markersize=2.5, linestyle='', label='measured'),
        Line2D([], [], color='0.3', linestyle=(0, (3.0, 1.5)), label='before'),
        Line2D([], [], color='0.3', label='after'),
    ]
    figure.legend(handles=handles, loc='lower center', ncols=min(len(handles), 6))
