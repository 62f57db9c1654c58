# SPDX-License-Identifier: Apache-2.0
"""The figures: they show what was given, in mm and deg, and can be read in print."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from optional import requires
from plotted import ONE_HEAD, ROWS, SWEEP, panels, repeated, sweep

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, WrapState
from linkedplane_ros.drawing.colours import HEAD_COLOURS, shades
from linkedplane_ros.drawing.plot import STATE_GREYS, figures
from linkedplane_ros.drawing.processed import ProcessedRecording
from linkedplane_ros.drawing.thinning import covered_intervals
from linkedplane_ros.errors import RecordingError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

pytestmark = requires('matplotlib')

EXACT = 1e-9  # mm, deg, s: drawn are the given numbers, but for the rounding of their units
VISIBLE = 0.2  # of the way from black to white: greys side by side in one panel
DELTOID = BroadMuscle.load('deltoid')
ISB = JOINT_CONVENTIONS['isb_yxy']
Array = np.ndarray


@pytest.fixture(scope='module')
def sweep_figures() -> dict[str, Figure]:
    """Return the figures of the sweep."""
    return figures(SWEEP)


def band_line(axes: Any, band: str) -> tuple[Array, Array]:
    """Return the x and y of a band's line."""
    (line,) = (line for line in axes.lines if line.get_label() == band)
    return line.get_xdata(), line.get_ydata()


def state_bars(axes: Any, lane: int, state: int) -> list[tuple[float, float]]:
    """Return the (start, end) of the bars of a state in the strip of a head's band."""
    kind = axes.collections[len(STATE_GREYS) * lane + len(STATE_GREYS) - 1 - state]
    assert kind.get_facecolor()[0, :3] == pytest.approx([list(STATE_GREYS.values())[state]] * 3)
    return [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in kind.get_paths()]


def grey(colour: Any) -> float:
    """Return the lightness of a colour in a greyscale print, 0..1."""
    from matplotlib.colors import to_rgb

    red, green, blue = to_rgb(colour)
    return 0.299 * red + 0.587 * green + 0.114 * blue


def ticks_within(axes: Any) -> list[Text]:
    """Return the labels of the ticks of x that are drawn."""
    low, high = axes.get_xlim()
    return [text for text in axes.get_xticklabels() if low <= text.get_position()[0] <= high]


def texts(figure: Figure) -> list[str]:
    """Return every text in a figure, each in one line."""
    from matplotlib.text import Text

    return [' '.join(text.get_text().split()) for text in figure.findobj(Text)]


def test_there_is_a_figure_over_time_and_one_against_each_coordinate(
    sweep_figures: dict[str, Figure],
) -> None:
    assert list(sweep_figures) == ['over_time', *(f'against_{name}' for name in ISB.coordinates)]


def test_each_head_has_a_column_named_by_its_legend(sweep_figures: dict[str, Figure]) -> None:
    for figure in sweep_figures.values():
        assert panels(figure).shape == (ROWS, len(DELTOID.heads))
        for axes, head in zip(panels(figure)[0], DELTOID.heads, strict=True):
            legend = axes.get_legend()
            assert legend.get_title().get_text() == f'{head.name} head'
            assert tuple(text.get_text() for text in legend.get_texts()) == head.bands


def test_the_axes_are_named_with_their_units(sweep_figures: dict[str, Figure]) -> None:
    arms = [f'moment arm (mm)\nabout {name}' for name in ISB.coordinates]
    across = ['time (s)', *(f'{name} (deg)' for name in ISB.coordinates)]
    for figure, x in zip(sweep_figures.values(), across, strict=True):
        rows = [axes.get_ylabel() for axes in panels(figure)[:, 0]]
        assert rows == ['length (mm)', *arms, 'wrap state']
        assert [axes.get_xlabel() for axes in panels(figure)[-1]] == [x] * len(DELTOID.heads)


def test_the_lines_are_the_given_numbers_in_mm_over_s_and_deg(
    sweep_figures: dict[str, Figure],
) -> None:
    across = [SWEEP.times, *np.degrees(SWEEP.angles).T]
    down = [SWEEP.lengths, *np.moveaxis(SWEEP.arms, 2, 0)]
    for figure, x in zip(sweep_figures.values(), across, strict=True):
        for column, head in enumerate(DELTOID.heads):
            for axes, quantity in zip(panels(figure)[:-1, column], down, strict=True):
                for band in head.bands:
                    given = 1000 * quantity[:, DELTOID.band_names.index(band)]
                    assert band_line(axes, band)[0] == pytest.approx(x, abs=EXACT)
                    assert band_line(axes, band)[1] == pytest.approx(given, abs=EXACT)


def test_rows_share_their_scale_and_all_panels_share_x(sweep_figures: dict[str, Figure]) -> None:
    for figure in sweep_figures.values():
        assert len({axes.get_xlim() for axes in panels(figure).flat}) == 1
        assert all(len({axes.get_ylim() for axes in row}) == 1 for row in panels(figure))


def test_the_title_and_the_sign_of_a_moment_arm_stand_in_each_figure_once(
    sweep_figures: dict[str, Figure],
) -> None:
    sign = "shortening turns the joint in the coordinate's positive direction"
    for figure in sweep_figures.values():
        assert texts(figure).count(SWEEP.title) == 1
        assert sum(sign in text for text in texts(figure)) == 1


def test_the_bands_of_a_head_differ_in_grey_and_in_line_style(
    sweep_figures: dict[str, Figure],
) -> None:
    for figure in sweep_figures.values():
        for axes, head in zip(panels(figure)[1], DELTOID.heads, strict=True):
            lines = [line for line in axes.lines if line.get_label() in head.bands]
            greys = sorted(grey(line.get_color()) for line in lines)
            assert np.diff(greys).min() > VISIBLE
            assert greys[-1] < 1 - VISIBLE  # paper
            assert len({str(line._dash_pattern) for line in lines}) == len(head.bands)


@pytest.mark.parametrize('count', [2, 3, 9])
def test_the_shades_of_every_colour_have_evenly_spaced_greys(count: int) -> None:
    for colour in HEAD_COLOURS:
        steps = np.diff([grey(shade) for shade in shades(colour, count)])
        assert steps == pytest.approx(steps[0])
        assert steps[0] > 0.5 / count


def test_a_band_alone_is_dark_enough_for_paper_whatever_its_colour() -> None:
    assert all(grey(shades(colour, 1)[0]) < 0.5 for colour in HEAD_COLOURS)


def test_the_wrap_states_have_a_legend_and_differ_in_grey(sweep_figures: dict[str, Figure]) -> None:
    assert list(STATE_GREYS) == [state.name.lower() for state in WrapState]
    assert -np.diff([*STATE_GREYS.values()]).max() > VISIBLE
    for figure in sweep_figures.values():
        (legend,) = figure.legends
        assert [text.get_text() for text in legend.get_texts()] == list(STATE_GREYS)
        shown = [grey(patch.get_facecolor()) for patch in legend.get_patches()]
        assert shown == pytest.approx(list(STATE_GREYS.values()))


def test_each_band_has_a_named_strip_of_its_wrap_states_over_time(
    sweep_figures: dict[str, Figure],
) -> None:
    cell = SWEEP.times[-1] / 1000
    middles = SWEEP.times[:-1] + 0.01  # between a frame and the next
    for axes, head in zip(panels(sweep_figures['over_time'])[-1], DELTOID.heads, strict=True):
        assert tuple(text.get_text() for text in axes.texts) == head.bands
        for lane, band in enumerate(head.bands):
            wrap = SWEEP.wrap[:-1, DELTOID.band_names.index(band)]
            for state in WrapState:
                spans = state_bars(axes, lane, state)
                shown = [any(a - cell <= t <= b + cell for a, b in spans) for t in middles]
                assert np.array_equal(shown, wrap == state)


def test_where_a_coordinate_returns_in_another_state_both_are_shown() -> None:
    there_and_back = sweep(np.append(np.linspace(0.2, 1.0, 30), np.linspace(1.0, 0.2, 30)))
    wrap = np.full_like(there_and_back.wrap, WrapState.WRAPPED)
    wrap[40:] = WrapState.CLEAR
    figure = figures(dataclasses.replace(there_and_back, wrap=wrap))['against_elevation']
    low, high, turned = np.degrees((0.2, 1.0, there_and_back.angles[40, 1]))
    axes = panels(figure)[-1, 0]
    assert state_bars(axes, 0, WrapState.WRAPPED) == [pytest.approx((low, high), abs=0.1)]
    assert state_bars(axes, 0, WrapState.CLEAR) == [pytest.approx((low, turned), abs=0.1)]


def test_a_state_of_one_frame_and_a_gap_show_in_the_strip() -> None:
    x = np.arange(10.0)
    here = np.array([0, 0, 1, 0, 0, 1, 1, 1, 0, 0], dtype=bool)
    assert covered_intervals(x, here) == [
        pytest.approx((2, 1), abs=0.01),
        pytest.approx((5, 3), abs=0.01),
    ]
    assert covered_intervals(x, np.zeros(10, dtype=bool)) == []


def test_a_frame_without_answer_breaks_the_line() -> None:
    lengths = ONE_HEAD.lengths.copy()
    lengths[20:30] = lengths[31:40] = np.nan
    figure = figures(dataclasses.replace(ONE_HEAD, lengths=lengths))['over_time']
    axes = panels(figure)[0, 0]
    gaps = np.flatnonzero(np.isnan(band_line(axes, 'middle_1')[1]))
    assert gaps.tolist() == [*range(20, 30), *range(31, 40)]
    assert axes.lines[0].get_markevery() == [30]  # a dot, where no line can be


def test_a_recording_without_any_answer_is_an_empty_figure() -> None:
    nothing = {name: np.full_like(getattr(ONE_HEAD, name), np.nan) for name in ('lengths', 'arms')}
    for figure in figures(dataclasses.replace(ONE_HEAD, **nothing)).values():
        assert state_bars(panels(figure)[-1, 0], 0, WrapState.WRAPPED) == []


def test_one_frame_alone_is_a_dot() -> None:
    alone = repeated(ONE_HEAD, 1)
    for figure in figures(alone).values():
        axes = panels(figure)[0, 0]
        assert band_line(axes, 'middle_1')[1] == pytest.approx(
            1000 * alone.lengths[:, 3], abs=EXACT
        )
        assert axes.lines[0].get_markevery() == [0]
        assert np.ptp(axes.get_xlim()) == pytest.approx(1)


def test_a_recording_of_no_frames_is_named() -> None:
    with pytest.raises(RecordingError, match=r'^sweep\.csv: .*: no frames to plot$'):
        figures(repeated(ONE_HEAD, 0))


def test_dates_are_shown_from_the_first_frame_on() -> None:
    dated = dataclasses.replace(ONE_HEAD, times=ONE_HEAD.times + 1.7e9)
    axes = panels(figures(dated)['over_time'])
    assert axes[-1, 0].get_xlabel() == 'time since 1700000000.000 s (s)'
    rounding = 1e-6  # s, of a date in a float
    assert band_line(axes[0, 0], 'middle_1')[0] == pytest.approx(ONE_HEAD.times, abs=rounding)


@pytest.mark.parametrize('processed', [SWEEP, ONE_HEAD], ids=['three heads', 'one head'])
def test_no_text_is_cropped_or_lies_on_another(processed: ProcessedRecording) -> None:
    titled = dataclasses.replace(processed, title='a_long_name_of_a_file ' * 8)
    for figure in figures(titled).values():
        width, height = figure.get_size_inches()
        box = figure.get_tightbbox()
        assert 0 <= box.x0 < box.x1 <= width
        assert 0 <= box.y0 < box.y1 <= height
        legends = [*figure.legends, *(axes.get_legend() for axes in panels(figure)[0])]
        labels = [axes.yaxis.label for axes in panels(figure)[:, 0]]
        labels += [axes.xaxis.label for axes in panels(figure)[-1]]
        ticks = [text for axes in panels(figure)[-1] for text in ticks_within(axes)]
        shown = [*figure.texts, *legends, *labels, *ticks, *panels(figure)[-1, 0].texts]
        boxes = [artist.get_window_extent() for artist in shown]
        for i, one in enumerate(boxes):
            assert not any(one.overlaps(other) for other in boxes[:i]), shown[i]


def test_names_are_shown_as_they_are() -> None:
    odd = dataclasses.replace(ONE_HEAD, title='cost_$1_$2.csv')
    figure = figures(odd)['over_time']
    (title,) = (text for text in figure.texts if text.get_text() == odd.title)
    assert not title.get_parse_math()
