# SPDX-License-Identifier: Apache-2.0
"""What each method does to the muscle as the joint moves, a row a method, a panel a measure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ...drawing.units import MILLIMETRES
from ...rivals.breadth import Breadth
from .poses import WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKERS = (('o', '#0072B2'), ('s', '#009E73'), ('^', '#D55E00'))  # of the sets of motions
APART = 0.22  # rows, between them
JUMP = 'symlog', (-0.4, 250.0), (0, 1, 10, 100)
# label, scale, limits and ticks of each panel
PANELS: Sequence[tuple[str, str | None, tuple[float, float], tuple[float, ...]]] = (
    ('farthest move of a\nmiddle in 0.5° (mm)', 'log', (0.3, 200.0), (1, 10, 100)),
    ('largest jump\nof a length (mm)', *JUMP),
    ('largest jump of a\nmoment arm (mm)', *JUMP),
    ('spacing of neighbours\nover that at the side', 'log', (0.08, 10.0), (0.1, 0.3, 1, 3, 10)),
    ('poses with\ncrossed bands (%)', None, (-4.0, 100.0), ()),
)


def rivals_figure(breadths: Sequence[Breadth]) -> Figure:
    """Return moves, jumps, spacing and crossed poses of every method and set of motions."""
    from matplotlib.figure import Figure

    methods = list(dict.fromkeys(each.method for each in breadths))
    figure = Figure(figsize=(WIDTH, 0.9 + 0.32 * len(methods)))
    panels = figure.subplots(1, len(PANELS), sharey=True)
    _draw_breadths(panels, breadths, methods)
    for axes, (label, scale, limits, ticks) in zip(panels, PANELS, strict=True):
        axes.set_xlabel(label)
        axes.grid(axis='x', linewidth=0.3, color='0.85')
        axes.tick_params(axis='y', length=0.0)
        axes.set_axisbelow(True)
        for row in range(1, len(methods)):
            axes.axhline(row - 0.5, color='0.9', linewidth=0.5, zorder=0.5)
        if scale is not None:
            axes.set_xscale(scale, **({'linthresh': 1.0} if scale == 'symlog' else {}))
            axes.set_xticks(ticks, [f'{tick:g}' for tick in ticks])
            axes.minorticks_off()
        axes.set_xlim(limits)
    panels[0].set_yticks(range(len(methods)), methods)
    panels[0].set_ylim(len(methods) - 0.5, -0.5)
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc='lower center', ncols=3, frameon=False
    )
    figure.subplots_adjust(0.19, 0.86 / figure.get_figheight(), 0.985, 0.985, wspace=0.12)
    return figure


def _draw_breadths(
    panels: Sequence[Any], breadths: Sequence[Breadth], methods: Sequence[str]
) -> None:
    """Draw the marks of all panels, a row for each method."""
    move, length, moment, spacing, crossed = panels
    motions = list(dict.fromkeys(each.motion for each in breadths))
    for each in breadths:
        number = motions.index(each.motion)
        marker, colour = MARKERS[number % len(MARKERS)]
        row = methods.index(each.method) + APART * (number - (len(motions) - 1) / 2)
        style = {'marker': marker, 'color': colour, 'markersize': 3.2, 'linestyle': 'none'}
        move.plot(MILLIMETRES * each.move, row, **style,
                  label=each.motion if each.method == methods[0] else None)  # fmt: skip
        length.plot(MILLIMETRES * each.length_jump, row, **style)
        moment.plot(MILLIMETRES * each.moment_jump, row, **style)
        ends = [each.spacing_least, each.spacing_most]
        spacing.plot(ends, [row] * 2, color=colour, linewidth=1.0)
        spacing.plot(ends, [row] * 2, **style)
        crossed.plot(100.0 * each.crossed, row, **style)
