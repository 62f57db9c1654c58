# SPDX-License-Identifier: Apache-2.0
"""Figures of a processed recording: lengths, moment arms and wrap states, a column for each head.

One figure over time, one against each coordinate. They are laid out in inches, for a printed page;
what colour shows is shown again by lightness, by line style or by height.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import RecordingError
from ..types import Bools, Bytes, Floats
from .colours import head_colour, shades
from .figure_files import house_style, write_figure
from .processed import ProcessedRecording
from .thinning import covered_intervals, thin_points
from .units import DEGREES, MILLIMETRES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST = 4000  # points drawn of a line
DENSE = 2000  # frames beyond which lines are thin
CROWDED = 5 * MOST  # frames beyond which a line against a coordinate would fill what it encloses
STILL = 1e-3  # s or deg: what moves less is shown in the middle of 1 s or 1 deg
DATE = 1e6  # s: times from here on are dates, shown from the first on

DASHES: tuple[Any, ...] = ((0, (1.2, 0.9)), (0, (5.0, 1.3)), '-')  # of the last bands of a head
STATE_GREYS = {'wrapped': 0.80, 'clear': 0.58, 'missed': 0.33, 'inside': 0.0}  # greys, as WrapState
CAPTION = (
    "Moment arm positive: shortening turns the joint in the coordinate's positive direction. "
    'Wrap states: the higher and darker, the farther from wrapped; one before the other where '
    'several were met. A gap: no answer.'
)
# The page, in inches
LEFT, RIGHT, GAP = 0.72, 0.15, 0.15
WIDTH, LEAST = 2.05, 3.6  # of a panel; of all panels of a row at least
HEIGHT, LANE = 1.25, 0.27  # of a panel; of a band's strip of wrap states
LINE, HEAD, FOOT = 0.135, 0.2, 0.68  # of a line of text; beside text above and below the panels


def figures(processed: ProcessedRecording) -> dict[str, Figure]:
    """Return the figures `over_time` and, for each coordinate, `against_<coordinate>`.

    Rows are lengths (mm), moment arms about each coordinate (mm) and wrap states; columns heads.

    Raises
    ------
    RecordingError
        If there is no frame, or no matplotlib.
    """
    if not len(processed.times):
        raise RecordingError(f'{processed.title}: no frames to plot')
    times, label = processed.times, 'time (s)'
    if abs(times[0]) > DATE:
        times, label = times - times[0], f'time since {times[0]:.3f} s (s)'
    with house_style():
        made = {'over_time': _figure(processed, times, label, crowded=False)}
        for name, angles in zip(processed.coordinates, DEGREES * processed.angles.T, strict=True):
            crowded = len(times) > CROWDED
            made[f'against_{name}'] = _figure(processed, angles, f'{name} (deg)', crowded)
    return made


def save_figures(processed: ProcessedRecording, out: Path, kind: str) -> list[Path]:
    """Write the figures of a processed recording; each file appears when it is complete.

    Parameters
    ----------
    processed
        What is drawn.
    out
        The beginning of the files' paths: <out>_<the figure's name>.<kind>.
    kind
        'png' (150 dpi) or 'svg'.

    Returns
    -------
    files
        What was written.

    Raises
    ------
    RecordingError
        If there is no frame, a file cannot be written, or matplotlib is not there.
    """
    files = []
    for name, figure in figures(processed).items():
        file = out.with_name(f'{out.name}_{name}.{kind}')
        with house_style():
            write_figure(figure, file, kind)
        files.append(file)
    return files


def _figure(processed: ProcessedRecording, x: Floats, label: str, crowded: bool) -> Figure:
    """Return the figure over x (m,): lines, or only points where lines would be too crowded."""
    figure, panels = _page(processed, label)
    finite = x[np.isfinite(x)]
    if len(finite) and np.ptp(finite) < STILL:
        panels[0, 0].set_xlim(finite[0] - 0.5, finite[0] + 0.5)
    quantities = (processed.lengths, *np.moveaxis(processed.arms, 2, 0))
    for column, (head, names) in enumerate(processed.heads.items()):
        colours = shades(head_colour(column), len(names))
        for lane, (name, colour) in enumerate(zip(names, colours, strict=True)):
            band = processed.bands.index(name)
            # dark, dashed lines lie on light, solid ones
            style = {'label': name, 'color': colour, 'zorder': 2.5 - 0.001 * lane}
            dashes = DASHES[(lane - len(names)) % len(DASHES)]
            for axes, quantity in zip(panels[:-1, column], quantities, strict=True):
                y = MILLIMETRES * quantity[:, band]
                if crowded:
                    _points(axes, x, y, style)
                else:
                    _line(axes, x, y, {**style, 'linestyle': dashes})
            known = ~np.isnan(x + y)
            _strip(panels[-1, column], x, processed.wrap[:, band], known, lane, name)
        panels[0, column].legend(
            title=f'{head} head',
            title_fontproperties={'weight': 'bold'},
            alignment='left',
            loc='lower left',
            bbox_to_anchor=(0.0, 1.0),
            borderaxespad=0.3,
            handlelength=3.2,
            markerscale=5.0 if crowded else 0.0,
        )
    return figure


def _page(processed: ProcessedRecording, label: str) -> tuple[Figure, npt.NDArray[Any]]:
    """Return a figure with its text, and its empty panels (2 + d, number of heads)."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    columns, most = len(processed.heads), max(map(len, processed.heads.values()))
    gaps = GAP * (columns - 1)
    width = LEFT + max(WIDTH * columns + gaps, LEAST) + RIGHT
    title, caption = _lines(processed.title, width, 8.0), _lines(CAPTION, width, 6.0)
    heights = [HEIGHT] * (1 + len(processed.coordinates)) + [LANE * max(most, 2)]
    head, foot = HEAD + LINE * (len(title) + 1 + most), FOOT + LINE * len(caption)
    height = head + sum(heights) + (len(heights) - 1) * GAP + foot
    figure = Figure(figsize=(width, height))
    grid = {
        'left': LEFT / width,
        'right': 1.0 - RIGHT / width,
        'top': 1.0 - head / height,
        'bottom': foot / height,
        'hspace': len(heights) * GAP / sum(heights),
        'wspace': columns * GAP / (width - LEFT - RIGHT - gaps),
        'height_ratios': heights,
    }
    panels = figure.subplots(
        len(heights), columns, sharex=True, sharey='row', squeeze=False, gridspec_kw=grid
    )
    for axes in panels.flat:
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.yaxis.set_major_locator(MaxNLocator(5))
    for axes in panels[1:-1].flat:
        axes.axhline(0.0, color='0.6', linewidth=0.5, zorder=0.5)
    for axes in panels[-1]:
        axes.set(xlabel=label, yticks=[], ylim=(max(most, 2), 0.0))
    arms = (f'moment arm (mm)\nabout {name}' for name in processed.coordinates)
    for axes, quantity in zip(panels[:, 0], ('length (mm)', *arms, 'wrap state'), strict=True):
        axes.set_ylabel(quantity)
    figure.align_ylabels(panels[:, 0])
    _write_text(figure, title, caption)
    return figure, panels


def _write_text(figure: Figure, title: list[str], caption: list[str]) -> None:
    """Write the title above the panels; the wrap states' greys and the caption below them."""
    from matplotlib.patches import Patch

    width, height = figure.get_size_inches().tolist()
    figure.text(LEFT / width, 1.0 - 0.08 / height, '\n'.join(title), size=8.0, va='top')
    figure.text(LEFT / width, 0.06 / height, '\n'.join(caption), size=6.0, va='bottom')
    figure.legend(
        handles=[Patch(color=str(grey), label=state) for state, grey in STATE_GREYS.items()],
        loc='lower left',
        bbox_to_anchor=(LEFT / width, (0.1 + LINE * len(caption)) / height),
        borderaxespad=0.0,
        ncols=len(STATE_GREYS),
    )


def _lines(text: str, inches: float, points: float) -> list[str]:
    """Return a text in lines that fit a page of this width, at a size in points."""
    return textwrap.wrap(text, int((inches - LEFT - RIGHT) * 72.0 / (0.56 * points)))


def _line(axes: Axes, x: Floats, y: Floats, style: dict[str, Any]) -> None:
    """Draw x, y (m,) as a line; a frame between two gaps is a dot."""
    x, y = thin_points(x, y, MOST)
    gap = np.concatenate(([True], np.isnan(x) | np.isnan(y), [True]))
    isolated = np.flatnonzero(gap[:-2] & ~gap[1:-1] & gap[2:]).tolist()
    width = 1.0 if len(x) <= DENSE else 0.6
    axes.plot(x, y, linewidth=width, marker='.', markevery=isolated, **style)


def _points(axes: Axes, x: Floats, y: Floats, style: dict[str, Any]) -> None:
    """Draw x, y (m,) as points: frames at even distances, and the extremes."""
    step = -(-len(x) // (MOST // 2))
    pairs = zip((x[::step], y[::step]), thin_points(x, y, MOST // 2), strict=True)
    axes.plot(*map(np.concatenate, pairs), linestyle='', marker='.', markersize=1.0, **style)


def _strip(axes: Axes, x: Floats, wrap: Bytes, known: Bools, lane: int, name: str) -> None:
    """Draw the wrap states (m,) of one band, the lower ones before the higher ones."""
    axes.text(0.01, lane + 0.06, name, size=5.5, va='top', transform=axes.get_yaxis_transform())
    for state, grey in reversed([*enumerate(STATE_GREYS.values())]):
        spans, high = covered_intervals(x, known & (wrap == state)), 0.14 * (state + 1)
        axes.broken_barh(spans, (lane + 0.97 - high, high), color=str(grey), linewidth=0.6)
