"""What each method does to the muscle as the joint moves, a row a method, a panel a measure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...rivals.breadth import Breadth
from ..experiments import MILLIMETRES
from .figures import WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKERS = (('o', '#0072B2'), ('s', '#009E73'), ('^', '#D55E00'))  # of the sets of motions
APART = 0.22  # rows, between them


def rivals(found: Sequence[Breadth]) -> Figure:
    """Return moves, jumps, spacing and crossed poses of every method and set of motions."""
    from matplotlib.figure import Figure

    methods = list(dict.fromkeys(each.method for each in found))
    motions = list(dict.fromkeys(each.motion for each in found))
    figure = Figure(figsize=(WIDTH, 0.9 + 0.32 * len(methods)))
    move, length, moment, spacing, crossed = figure.subplots(1, 5, sharey=True)
    for each in found:
        place = motions.index(each.motion)
        marker, colour = MARKERS[place % len(MARKERS)]
        row = methods.index(each.method) + APART * (place - (len(motions) - 1) / 2)
        style = {'marker': marker, 'color': colour, 'markersize': 3.2, 'linestyle': 'none'}
        move.plot(MILLIMETRES * each.move, row, **style,
                  label=each.motion if each.method == methods[0] else None)  # fmt: skip
        length.plot(MILLIMETRES * each.length_jump, row, **style)
        moment.plot(MILLIMETRES * each.moment_jump, row, **style)
        spacing.plot(
            [each.spacing_least, each.spacing_most], [row] * 2, color=colour, linewidth=1.0
        )
        spacing.plot([each.spacing_least, each.spacing_most], [row] * 2, **style)
        crossed.plot(100.0 * each.crossed, row, **style)
    for axes, label in (
        (move, 'farthest move of a\nmiddle in 0.5° (mm)'),
        (length, 'largest jump\nof a length (mm)'),
        (moment, 'largest jump of a\nmoment arm (mm)'),
        (spacing, 'spacing of neighbours\nover that at the side'),
        (crossed, 'poses with\ncrossed bands (%)'),
    ):
        axes.set_xlabel(label)
        axes.grid(axis='x', linewidth=0.3, color='0.85')
        axes.tick_params(axis='y', length=0.0)
        axes.set_axisbelow(True)
        for row in range(1, len(methods)):
            axes.axhline(row - 0.5, color='0.9', linewidth=0.5, zorder=0.5)
    move.set_xscale('log')
    move.set_xlim(0.3, 200.0)
    spacing.set_xscale('log')
    spacing.set_xlim(0.08, 10.0)
    for axes in (length, moment):
        axes.set_xscale('symlog', linthresh=1.0)
        axes.set_xlim(-0.4, 250.0)
    for axes, ticks in (
        (move, (1, 10, 100)),
        (length, (0, 1, 10, 100)),
        (moment, (0, 1, 10, 100)),
        (spacing, (0.1, 0.3, 1, 3, 10)),
    ):
        axes.set_xticks(ticks, [f'{tick:g}' for tick in ticks])
        axes.minorticks_off()
    crossed.set_xlim(-4.0, 100.0)
    move.set_yticks(range(len(methods)), methods)
    move.set_ylim(len(methods) - 0.5, -0.5)
    figure.legend(*move.get_legend_handles_labels(), loc='lower center', ncols=3, frameon=False)
    figure.subplots_adjust(0.19, 0.86 / figure.get_figheight(), 0.985, 0.985, wspace=0.12)
    return figure
