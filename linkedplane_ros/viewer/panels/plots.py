# SPDX-License-Identifier: Apache-2.0
"""Live plots: length and moment arm of each head, over time or against a coordinate."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import viser
from viser import uplot

from ...drawing.colours import head_colour
from ...drawing.units import MILLIMETRES
from ...types import Floats, Interval
from ..names import html_name, short_name
from ..newest import MuscleInfo, Values, match_coordinate
from ..scene.colour_map import css_colour
from .history import CoordinateCurve, Recent, merge_curves, widen_range

SPAN = 20.0  # s, of the time axis
RATE = 60  # rows a second at most
FRESH = 0.25  # s between drawings of a plot while states keep coming
REST = 0.12  # s without a new state, after which it is drawn at once; the scene comes first
SHOWN = {'deg': (-360.0, 360.0, 1.0), 'mm': (-500.0, 500.0, 1.0)}  # of a coordinate's axis
TIME, COORDINATE = 'time', 'coordinate'
HEIGHT = 125  # px
PADDING = (8, 24, 0, 0)  # px, from the top clockwise
UP = ('length, mm', 'moment arm, mm')
RETIRED = 5.0  # s that a plot is hidden before it is removed
ROUND = 20.0  # mm: the ends of a plot are multiples of it
NOTE = 'style="padding:0 0.9em;font-size:0.8em"'
DASH = (6, 4)  # px, of the second muscle's lines


def head_values(info: MuscleInfo, newest: Values) -> tuple[Floats, Floats]:
    """Return the heads' lengths (h,), mm, and moment arms (h, d), mm; NaN before the first."""
    bands = [band for _, band in info.heads]
    n = len(info.bands)
    lengths, arms = newest.lengths, newest.arms
    if lengths is None or len(lengths) != n:
        lengths = np.full(n, np.nan)
    if arms is None or arms.shape != (n, len(info.coordinates)):
        arms = np.full((n, len(info.coordinates)), np.nan)
    return MILLIMETRES * lengths[bands], MILLIMETRES * arms[bands]


class Plots:
    """Two plots of all muscles: the lines of the second are dashed."""

    def __init__(self, gui: viser.GuiApi, muscles: Sequence[tuple[str, MuscleInfo]]) -> None:
        """Add them to the open part of the GUI; `muscles` are names and what is known of each."""
        self._gui = gui
        self._muscles = [info for _, info in muscles]
        first = self._muscles[0]
        d = len(first.coordinates)
        self._width = 1 + d  # a length and an arm about each
        self._chosen = [
            [match_coordinate(info, first, k) for k in range(d)] for info in self._muscles
        ]
        self._begin = 0.0
        self._first = self._last = -np.inf  # when the rows that are not drawn yet came
        self._rows = self._rows_drawn = 0
        self._lines = plot_series(muscles)
        self._place = gui.add_folder(None)
        self._plots: list[Any] = []
        self._retired: list[tuple[float, Any]] = []
        self._reach: list[Interval | None] = [None, None]
        if len(muscles) > 1:
            gui.add_html(
                f'<div {NOTE}>dashed: {", ".join(html_name(name) for name, _ in muscles[1:])}</div>'
            )
        self._axis = gui.add_dropdown('against', (TIME, COORDINATE))
        clear = gui.add_button('clear the plots')
        clear.on_click(self._on_clear)
        self._reset()

    def _add_plots(self, data: Sequence[tuple[Floats, ...]], across: str) -> None:
        """Add the plots with their first data.

        They replace earlier ones: the library loses the range of time when axes or scales change.
        """
        self._retire_plots()
        with self._place:
            self._plots = [
                self._gui.add_uplot(
                    each,
                    (uplot.Series(label='x'), *self._lines),
                    height=HEIGHT,
                    legend=uplot.Legend(show=False),
                    scales=plot_scales(reach),
                    axes=plot_axes(across, up),
                    padding=PADDING,
                )
                for each, reach, up in zip(data, self._reach, UP, strict=True)
            ]

    def _retire_plots(self) -> None:
        """Hide the plots, and remove them later.

        A browser reports an error for one that gets data and is removed in the same frame.
        """
        now = time.monotonic()
        for plot in self._plots:
            plot.visible = False
            self._retired.append((now, plot))
        self._plots = []
        while self._retired and self._retired[0][0] < now - RETIRED:
            self._retired.pop(0)[1].remove()

    def _reset(self) -> None:
        """Forget all rows."""
        widths = [self._width * len(info.heads) for info in self._muscles]
        self._recent = Recent(sum(widths), round(SPAN * RATE))
        self._curves = [
            [CoordinateCurve(width, *SHOWN[unit.name]) for unit in self._muscles[0].units]
            for width in widths
        ]
        self._shown: tuple[str, int] | None = None
        self._retire_plots()

    async def _on_clear(self, _: Any) -> None:
        self._reset()

    def add(self, now: float, newest: Sequence[Values]) -> None:
        """Add the newest state of each muscle, if any has arrived."""
        if not self._lines or not any(values.answered for values in newest):
            return
        self._begin = self._begin or now
        rows = []
        for info, values, curves, chosen in zip(
            self._muscles, newest, self._curves, self._chosen, strict=True
        ):
            lengths, arms = head_values(info, values)
            row = np.column_stack((lengths, choose_columns(arms, chosen))).ravel()
            rows.append(row)  # length and arms of each head
            if values.pose is None or len(values.pose) != len(info.units):
                continue
            sizes = np.array([unit.size for unit in info.units])
            [places] = choose_columns((values.pose / sizes)[np.newaxis], chosen).tolist()
            if np.isfinite(lengths).all():
                for curve, place in zip(curves, places, strict=True):
                    if math.isfinite(place):
                        curve.add(place, row)
        self._recent.add(now - self._begin, np.concatenate(rows))
        if self._rows == self._rows_drawn:
            self._first = now
        self._rows, self._last = self._rows + 1, now

    def draw(self, now: float, coordinate: int) -> bool:
        """Draw the rows if some are new and it is time.

        Parameters
        ----------
        now
            The time of the frame, s.
        coordinate
            The number of the one that the moment arms are about.

        Returns
        -------
        bool
            Whether they were drawn.

        """
        axis = self._axis.value
        known = self._rows == self._rows_drawn and self._shown == (axis, coordinate)
        if known or not self._lines or now < min(self._first + FRESH, self._last + REST):
            return False
        self._rows_drawn = self._rows
        table = self._table(axis, coordinate)
        if len(table) < 2:
            return True
        values = table[:, 1:].reshape(len(table), -1, self._width)
        data = [
            (table[:, 0], *np.ascontiguousarray(values[:, :, k].T)) for k in (0, 1 + coordinate)
        ]
        before = self._reach if self._shown == (axis, coordinate) else [None, None]
        reach = [widen_range(old, each[1:], ROUND) for old, each in zip(before, data, strict=True)]
        if not self._plots or reach != before:
            self._reach, self._shown = reach, (axis, coordinate)
            first = self._muscles[0]
            name, unit = short_name(first.coordinates[coordinate]), first.units[coordinate].name
            self._add_plots(data, 'time, s' if axis == TIME else f'{name}, {unit}')
        else:
            for plot, each in zip(self._plots, data, strict=True):
                plot.data = each
        return True

    def _table(self, axis: str, coordinate: int) -> Floats:
        """Return the rows of the plots: x, then length and arms of each head, mm."""
        if axis == TIME:
            return self._recent.rows_of_last(SPAN)
        return merge_curves([curves[coordinate].known_rows() for curves in self._curves])


def choose_columns(values: Floats, chosen: Sequence[int | None]) -> Floats:
    """Return the chosen columns of values (m, d); NaN in place of None."""
    wide = np.column_stack((values, np.full(len(values), np.nan)))
    return np.asarray(wide[:, [-1 if k is None else k for k in chosen]])


def plot_series(muscles: Sequence[tuple[str, MuscleInfo]]) -> list[Any]:
    """Return the series of a plot, one for each head of each muscle."""
    lines = []
    for k, (name, info) in enumerate(muscles):
        for i, (head, _) in enumerate(info.heads):
            colour = css_colour(head_colour(i))
            line = uplot.Series(label=short_name(f'{head} {name}'.strip()), stroke=colour, width=2)
            if k:
                line['dash'] = DASH
            lines.append(line)
    return lines


def plot_scales(reach: Interval | None) -> dict[str, Any]:
    """Return the scales of a plot; its range is given, as NaN at the start of a line hides it."""
    held = {} if reach is None else {'y': uplot.Scale(range=reach)}
    return {'x': uplot.Scale(time=False), **held}


def plot_axes(across: str, up: str) -> tuple[Any, Any]:
    """Return the axes of a plot with their labels."""
    look = {'labelSize': 16, 'labelFont': '10px sans-serif', 'font': '11px sans-serif'}
    return (
        uplot.Axis(label=across, size=26, **look),
        uplot.Axis(label=up, size=38, **look),
    )
