"""Figures of a processed recording: lengths, moment arms and wrap states, a column for each head.

One figure over time, one against each coordinate. They are laid out in inches, for a printed page;
what colour tells is told again by lightness, by line style or by height. matplotlib is loaded when
a figure is made; no window is opened and no global setting changed.
"""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import RecordingError
from ..types import Bools, Colour, Floats
from .colours import HEAD_COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# The only conversions: everything before a figure is in m, rad and s
MILLIMETRES = 1e3  # in a metre
DEGREES = 180.0 / math.pi  # in a radian

MOST = 4000  # points drawn of a line
DENSE = 2000  # frames beyond which lines are thin
CROWDED = 5 * MOST  # frames beyond which a line against a coordinate would fill what it encloses
CELLS = 2000  # places told apart along a strip of wrap states
STILL = 1e-3  # s or deg: what moves less is shown in the middle of 1 s or 1 deg
DATE = 1e6  # s: times from here on are dates, shown from the first on

GREY = np.array((0.299, 0.587, 0.114))  # of red, green and blue (ITU-R BT.601)
DARKEST, ALONE, LIGHTEST = 0.12, 0.4, 0.68  # greys of a head's first, only and last band
DASHES: tuple[Any, ...] = ((0, (1.2, 0.9)), (0, (5.0, 1.3)), '-')  # of the last bands of a head
STATES = {'wrapped': 0.80, 'clear': 0.58, 'missed': 0.33, 'inside': 0.0}  # greys, as WrapState
CAPTION = (
    "Moment arm positive: shortening turns the joint in the coordinate's positive direction. "
    'Wrap states: the higher and darker, the farther from wrapped; one before the other where '
    'several were met. A gap: no answer.'
)
STYLE: dict[Any, Any] = {
    'font.size': 7.0,
    'text.parse_math': False,  # a $ in a name is a $
    'axes.linewidth': 0.6,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.xmargin': 0.02,
    'axes.formatter.useoffset': False,
    'legend.frameon': False,
    'legend.borderpad': 0.0,
    'legend.labelspacing': 0.25,
    'svg.fonttype': 'none',  # text stays text
    'svg.hashsalt': 'linkedplane_ros',  # the same figure is the same file
}

# The page, in inches
LEFT, RIGHT, GAP = 0.72, 0.15, 0.15
WIDTH, LEAST = 2.05, 3.6  # of a panel; of all panels of a row at least
HEIGHT, LANE = 1.25, 0.27  # of a panel; of a band's strip of wrap states
LINE, HEAD, FOOT = 0.135, 0.2, 0.68  # of a line of text; beside text above and below the panels


@dataclass(frozen=True, eq=False)
class Processed:
    """A recording and the muscle's answers: m frames, n bands. What has no answer is NaN."""

    title: str
    heads: Mapping[str, tuple[str, ...]]
    """Each head's bands, in order."""
    bands: tuple[str, ...]
    """(n)"""
    coordinates: tuple[str, ...]
    """(3)"""
    times: Floats
    """(m,) s"""
    angles: Floats
    """(m, 3) rad"""
    lengths: Floats
    """(m, n) m"""
    arms: Floats
    """(m, n, 3) m, positive: shortening turns the joint in the coordinate's positive direction."""
    wrap: npt.NDArray[np.uint8]
    """(m, n) WrapState of each band."""


def figures(processed: Processed) -> dict[str, Figure]:
    """Return the figures `over_time` and, for each coordinate, `against_<coordinate>`.

    Rows are lengths (mm), moment arms about each coordinate (mm) and wrap states; columns heads.
    RecordingError if there is no frame, or no matplotlib.
    """
    matplotlib = library()
    if not len(processed.times):
        raise RecordingError(f'{processed.title}: no frames to plot')
    times, label = processed.times, 'time (s)'
    if abs(times[0]) > DATE:
        times, label = times - times[0], f'time since {times[0]:.3f} s (s)'
    with matplotlib.rc_context(STYLE):
        made = {'over_time': _figure(processed, times, label, crowded=False)}
        for name, angles in zip(processed.coordinates, DEGREES * processed.angles.T, strict=True):
            crowded = len(times) > CROWDED
            made[f'against_{name}'] = _figure(processed, angles, f'{name} (deg)', crowded)
    return made


def library() -> Any:
    """Return matplotlib; RecordingError if it is not there."""
    try:
        import matplotlib
    except ImportError:
        raise RecordingError(
            "a picture needs the matplotlib library: pip install 'linkedplane_ros[tools]'"
        ) from None
    return matplotlib


def save(processed: Processed, out: Path, kind: str) -> list[Path]:
    """Write each figure to <out>_<its name>.<kind>, 'png' (150 dpi) or 'svg'; return the files.

    A file appears when it is complete. RecordingError if it cannot be written.
    """
    files = []
    for name, figure in figures(processed).items():
        file = out.with_name(f'{out.name}_{name}.{kind}')
        with library().rc_context(STYLE):
            write(figure, file, kind)
        files.append(file)
    return files


def write(figure: Figure, file: Path, kind: str) -> None:
    """Write a figure, 'png' or 'svg'; a file appears when it is complete. Raises RecordingError."""
    part = file.with_name(f'.{file.name}.{os.getpid()}.part')
    try:
        undated = {'Date': None} if kind == 'svg' else None
        figure.savefig(part, format=kind, dpi=150, metadata=undated)
        os.replace(part, file)
    except OSError as error:
        raise RecordingError(f'{file}: not written: {error.strerror or error}') from None
    finally:
        with suppress(OSError):  # where there is nothing to remove
            part.unlink()


def thinned(x: Floats, y: Floats, most: int) -> tuple[Floats, Floats]:
    """Return at most `most` (at least 5) of the points x, y (m,), in their order.

    Of each of up to most // 5 runs of frames there remain the least and greatest y, the least and
    greatest x (over time: the ends of the run) and, if it has a gap, a NaN.
    """
    m = len(x)
    if m <= most:
        return x, y
    run = -(-m // (most // 5))
    filled = np.pad(np.stack((x, y)), ((0, 0), (0, -m % run)), mode='edge').reshape(2, -1, run)
    gap = np.isnan(filled).any(axis=0)
    places = np.concatenate(
        [gap.argmax(axis=1)]
        + [np.where(gap, np.inf, values).argmin(axis=1) for values in filled]
        + [np.where(gap, -np.inf, values).argmax(axis=1) for values in filled]
    )
    kept = np.unique(np.minimum(places + run * np.tile(np.arange(filled.shape[1]), 5), m - 1))
    return x[kept], y[kept]


def covered(x: Floats, here: Bools) -> list[tuple[float, float]]:
    """Return the (start, width) of all x (m,) over which `here` (m,) holds, at any frame.

    A frame lasts until the next one. CELLS places are told apart: there are never many stretches.
    """
    begin, end = x[here], np.append(x[1:], np.nan)[here]
    if not len(begin):
        return []
    low, high = np.fmin(begin, end), np.fmax(begin, end)
    start = low.min()
    cell = max((high.max() - start) / CELLS, 1e-9)
    first, last = (np.minimum((ends - start) / cell, CELLS - 1).astype(int) for ends in (low, high))
    entered, left = (np.bincount(cells, minlength=CELLS + 1) for cells in (first, last + 1))
    edges = np.flatnonzero(np.diff(np.cumsum(entered - left) > 0, prepend=False))
    return [(start + cell * a, cell * (b - a)) for a, b in edges.reshape(-1, 2).tolist()]


def shades(colour: Colour, count: int) -> list[Colour]:
    """Return `count` shades of a colour, dark to light, with evenly spaced greys."""
    own = float(GREY @ colour)
    greys = np.linspace(DARKEST, LIGHTEST, count).tolist() if count > 1 else [ALONE]
    red, green, blue = (np.interp(greys, (0.0, own, 1.0), (0.0, c, 1.0)).tolist() for c in colour)
    return list(zip(red, green, blue, strict=True))


def _figure(processed: Processed, x: Floats, label: str, crowded: bool) -> Figure:
    """Return the figure over x (m,): lines, or points alone if they would be too crowded."""
    figure, panels = _page(processed, label)
    finite = x[np.isfinite(x)]
    if len(finite) and np.ptp(finite) < STILL:
        panels[0, 0].set_xlim(finite[0] - 0.5, finite[0] + 0.5)
    quantities = (processed.lengths, *np.moveaxis(processed.arms, 2, 0))
    for column, (head, names) in enumerate(processed.heads.items()):
        colours = shades(HEAD_COLOURS[column % len(HEAD_COLOURS)], len(names))
        for lane, (name, colour) in enumerate(zip(names, colours, strict=True)):
            band = processed.bands.index(name)
            # dark, broken lines lie on light, whole ones
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


def _page(processed: Processed, label: str) -> tuple[Figure, npt.NDArray[Any]]:
    """Return a figure with its text, and its empty panels (5, number of heads)."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch
    from matplotlib.ticker import MaxNLocator

    columns, most = len(processed.heads), max(map(len, processed.heads.values()))
    gaps = GAP * (columns - 1)
    width = LEFT + max(WIDTH * columns + gaps, LEAST) + RIGHT
    title, caption = _lines(processed.title, width, 8.0), _lines(CAPTION, width, 6.0)
    heights = [HEIGHT] * 4 + [LANE * max(most, 2)]
    head, foot = HEAD + LINE * (len(title) + 1 + most), FOOT + LINE * len(caption)
    height = head + sum(heights) + 4 * GAP + foot
    figure = Figure(figsize=(width, height))
    grid = {
        'left': LEFT / width,
        'right': 1.0 - RIGHT / width,
        'top': 1.0 - head / height,
        'bottom': foot / height,
        'hspace': 5 * GAP / sum(heights),
        'wspace': columns * GAP / (width - LEFT - RIGHT - gaps),
        'height_ratios': heights,
    }
    panels = figure.subplots(5, columns, sharex=True, sharey='row', squeeze=False, gridspec_kw=grid)
    for axes in panels.flat:
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.yaxis.set_major_locator(MaxNLocator(5))
    for axes in panels[1:4].flat:
        axes.axhline(0.0, color='0.6', linewidth=0.5, zorder=0.5)
    for axes in panels[-1]:
        axes.set(xlabel=label, yticks=[], ylim=(max(most, 2), 0.0))
    arms = (f'moment arm (mm)\nabout {name}' for name in processed.coordinates)
    for axes, quantity in zip(panels[:, 0], ('length (mm)', *arms, 'wrap state'), strict=True):
        axes.set_ylabel(quantity)
    figure.align_ylabels(panels[:, 0])
    figure.text(LEFT / width, 1.0 - 0.08 / height, '\n'.join(title), size=8.0, va='top')
    figure.text(LEFT / width, 0.06 / height, '\n'.join(caption), size=6.0, va='bottom')
    figure.legend(
        handles=[Patch(color=str(grey), label=state) for state, grey in STATES.items()],
        loc='lower left',
        bbox_to_anchor=(LEFT / width, (0.1 + LINE * len(caption)) / height),
        borderaxespad=0.0,
        ncols=len(STATES),
    )
    return figure, panels


def _lines(text: str, inches: float, points: float) -> list[str]:
    """Return a text in lines that fit a page of this width."""
    return textwrap.wrap(text, int((inches - LEFT - RIGHT) * 72.0 / (0.56 * points)))


def _line(axes: Axes, x: Floats, y: Floats, style: dict[str, Any]) -> None:
    """Draw x, y (m,) as a line; a frame between two gaps is a dot."""
    x, y = thinned(x, y, MOST)
    gap = np.concatenate(([True], np.isnan(x) | np.isnan(y), [True]))
    alone = np.flatnonzero(gap[:-2] & ~gap[1:-1] & gap[2:]).tolist()
    width = 1.0 if len(x) <= DENSE else 0.6
    axes.plot(x, y, linewidth=width, marker='.', markevery=alone, **style)


def _points(axes: Axes, x: Floats, y: Floats, style: dict[str, Any]) -> None:
    """Draw x, y (m,) as points: frames at even distances, and the extremes."""
    step = -(-len(x) // (MOST // 2))
    pairs = zip((x[::step], y[::step]), thinned(x, y, MOST // 2), strict=True)
    axes.plot(*map(np.concatenate, pairs), linestyle='', marker='.', markersize=1.0, **style)


def _strip(
    axes: Axes, x: Floats, wrap: npt.NDArray[np.uint8], known: Bools, lane: int, name: str
) -> None:
    """Draw the wrap states (m,) of one band, the lower ones before the higher ones."""
    axes.text(0.01, lane + 0.06, name, size=5.5, va='top', transform=axes.get_yaxis_transform())
    for state, grey in reversed([*enumerate(STATES.values())]):
        spans, high = covered(x, known & (wrap == state)), 0.14 * (state + 1)
        axes.broken_barh(spans, (lane + 0.97 - high, high), color=str(grey), linewidth=0.6)
