"""Live plots: length and moment arm of each head, over time or against a coordinate."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import viser
from viser import uplot

from ...drawing.colours import HEAD_COLOURS
from ...types import Floats, Interval
from ..newest import Facts, Values
from .history import Curve, Recent, side_by_side, widened

SPAN = 20.0  # s shown
RATE = 60  # rows a second at most
FRESH = 0.25  # s between drawings of a plot while states come one after the other
REST = 0.12  # s without a new one after which it is drawn at once: the scene goes first
DEGREES = (-180.0, 180.0, 1.0)
TIME, COORDINATE = 'time', 'coordinate'
HEIGHT = 125  # px
PADDING = (8, 24, 0, 0)  # px, from the top clockwise
UP = ('length, mm', 'moment arm, mm')
RETIRED = 5.0  # s that a plot is hidden before it is removed
ROUND = 20.0  # mm, to which the ends of a plot are rounded
MILLIMETRES = 1e3
NOTE = 'style="padding:0 0.9em;font-size:0.8em"'
DASH = (6, 4)  # px, of the second muscle's lines


def numbers(facts: Facts, newest: Values) -> tuple[Floats, Floats]:
    """Return the heads' lengths (h,), mm, and moment arms (h, 3), mm; NaN where none has come."""
    bands = [band for _, band in facts.heads]
    n = len(facts.bands)
    lengths, arms = newest.lengths, newest.arms
    if lengths is None or len(lengths) != n:
        lengths = np.full(n, np.nan)
    if arms is None or len(arms) != n:
        arms = np.full((n, 3), np.nan)
    return MILLIMETRES * lengths[bands], MILLIMETRES * arms[bands]


class Plots:
    """Two plots of all muscles: the lines of the second are dashed."""

    def __init__(self, gui: viser.GuiApi, muscles: Sequence[tuple[str, Facts]]) -> None:
        """Add them to what is open of the GUI; a muscle has a name and facts."""
        self._gui = gui
        self._facts = [facts for _, facts in muscles]
        self._begin = 0.0
        self._first = self._last = -np.inf  # when rows came that are not drawn
        self._rows = self._rows_drawn = 0
        self._lines = lines_of(muscles)
        self._place = gui.add_folder(None)
        self._plots: list[Any] = []
        self._retired: list[tuple[float, Any]] = []
        self._reach: list[Interval | None] = [None, None]
        if len(muscles) > 1:
            gui.add_html(f'<div {NOTE}>dashed: {", ".join(name for name, _ in muscles[1:])}</div>')
        self._axis = gui.add_dropdown('against', (TIME, COORDINATE))
        clear = gui.add_button('clear the plots')
        clear.on_click(self._clear)
        self._begin_anew()

    def _make(self, data: Sequence[tuple[Floats, ...]], across: str) -> None:
        """Add the plots, with the first of their data.

        New ones where there were others: the library loses the range of time when it is given
        other axes or scales.
        """
        self._retire()
        with self._place:
            self._plots = [
                self._gui.add_uplot(
                    each,
                    (uplot.Series(label='x'), *self._lines),
                    height=HEIGHT,
                    legend=uplot.Legend(show=False),
                    scales=scales(reach),
                    axes=axes(across, up),
                    padding=PADDING,
                )
                for each, reach, up in zip(data, self._reach, UP, strict=True)
            ]

    def _retire(self) -> None:
        """Hide the plots, and remove them later.

        A browser complains of one that is given data and removed in the same frame.
        """
        now = time.monotonic()
        for plot in self._plots:
            plot.visible = False
            self._retired.append((now, plot))
        self._plots = []
        while self._retired and self._retired[0][0] < now - RETIRED:
            self._retired.pop(0)[1].remove()

    def _begin_anew(self) -> None:
        """Forget what there was."""
        count = sum(len(facts.heads) for facts in self._facts)
        self._recent = Recent(4 * count, round(SPAN * RATE))
        self._curves = [
            [Curve(4 * len(facts.heads), *DEGREES) for _ in range(3)] for facts in self._facts
        ]
        self._shown: tuple[str, int] | None = None
        self._retire()

    async def _clear(self, _: Any) -> None:
        self._begin_anew()

    def add(self, now: float, newest: Sequence[Values]) -> None:
        """Take in the newest state of each muscle; nothing if none has come yet."""
        if not self._lines or not any(values.answered for values in newest):
            return
        self._begin = self._begin or now
        rows = []
        for facts, values, curves in zip(self._facts, newest, self._curves, strict=True):
            lengths, arms = numbers(facts, values)
            row = np.column_stack((lengths, arms)).ravel()  # length and three arms of each head
            rows.append(row)
            if values.pose is not None and np.isfinite(row).all():
                for curve, angle in zip(curves, np.degrees(values.pose).tolist(), strict=True):
                    curve.add(angle, row)
        self._recent.add(now - self._begin, np.concatenate(rows))
        if self._rows == self._rows_drawn:
            self._first = now
        self._rows, self._last = self._rows + 1, now

    def draw(self, now: float, coordinate: int) -> bool:
        """Draw what there is, if it is new and it is time; return whether that was so.

        The moment arms are those about a coordinate (0, 1, 2).
        """
        axis = self._axis.value
        known = self._rows == self._rows_drawn and self._shown == (axis, coordinate)
        if known or not self._lines or now < min(self._first + FRESH, self._last + REST):
            return False
        self._rows_drawn = self._rows
        table = self._table(axis, coordinate)
        if len(table) < 2:
            return True
        values = table[:, 1:].reshape(len(table), -1, 4)
        data = [
            (table[:, 0], *np.ascontiguousarray(values[:, :, k].T)) for k in (0, 1 + coordinate)
        ]
        before = self._reach if self._shown == (axis, coordinate) else [None, None]
        reach = [widened(old, each[1:], ROUND) for old, each in zip(before, data, strict=True)]
        if not self._plots or reach != before:
            self._reach, self._shown = reach, (axis, coordinate)
            name = self._facts[0].coordinates[coordinate]
            self._make(data, 'time, s' if axis == TIME else f'{name}, deg')
        else:
            for plot, each in zip(self._plots, data, strict=True):
                plot.data = each
        return True

    def _table(self, axis: str, coordinate: int) -> Floats:
        """Return the rows to be drawn: x, then length and three arms of each head, mm."""
        if axis == TIME:
            return self._recent.last(SPAN)
        return side_by_side([curves[coordinate].known() for curves in self._curves])


def lines_of(muscles: Sequence[tuple[str, Facts]]) -> list[Any]:
    """Return the lines of a plot, one for each head of each muscle."""
    lines = []
    for k, (name, facts) in enumerate(muscles):
        for i, (head, _) in enumerate(facts.heads):
            red, green, blue = (round(255 * c) for c in HEAD_COLOURS[i % len(HEAD_COLOURS)])
            line = uplot.Series(
                label=f'{head} {name}'.strip(), stroke=f'rgb({red},{green},{blue})', width=2
            )
            if k:
                line['dash'] = DASH
            lines.append(line)
    return lines


def scales(reach: Interval | None) -> dict[str, Any]:
    """Return the scales of a plot.

    Its range is given, as the library finds none where a line begins with NaN.
    """
    held = {} if reach is None else {'y': uplot.Scale(range=reach)}
    return {'x': uplot.Scale(time=False), **held}


def axes(across: str, up: str) -> tuple[Any, Any]:
    """Return the axes of a plot with their labels."""
    look = {'labelSize': 16, 'labelFont': '10px sans-serif', 'font': '11px sans-serif'}
    return (
        uplot.Axis(label=across, size=26, **look),
        uplot.Axis(label=up, size=38, **look),
    )
