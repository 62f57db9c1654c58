# SPDX-License-Identifier: Apache-2.0
"""The parts of a report: tables and charts that can be read."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from optional import requires

from linkedplane_ros import BroadMuscle
from linkedplane_ros.drawing.figure_files import house_style
from linkedplane_ros.study.chapters.parts import TablePart, column_heading
from linkedplane_ros.study.interference import PRINTED, check_experiments
from linkedplane_ros.study.pictures import charts
from linkedplane_ros.study.subject import Subject


def test_a_table_shows_units_and_hides_no_digits_from_machines() -> None:
    table = TablePart('t', 'T', ('band', 'length_mm', 'at_deg'), [('a|b', 1.23456789, 30),
                                                              ('c', None, -0)])  # fmt: skip
    assert table.csv() == 'band,length_mm,at_deg\na|b,1.234568,30\nc,,0\n'
    assert table.markdown().splitlines() == [
        '| band | length (mm) | at (deg) |',
        '| --- | ---: | ---: |',
        '| a\\|b | 1.2 | 30 |',
        '| c | | 0 |',
    ]
    assert column_heading('mean_size_mm') == 'mean size (mm)'


def test_a_tiny_negative_number_is_shown_without_its_sign() -> None:
    assert '| 0.0 |' in TablePart('t', 'T', ('x_mm',), [(-0.01,)]).markdown()


@requires('matplotlib')
@pytest.mark.parametrize(
    'chart', [charts.lengths_figure, charts.moment_arms_figure, charts.fidelity_figure]
)
def test_no_word_of_a_chart_runs_off_the_page(chart: Callable[[Subject], Any]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with house_style():
        figure = chart(Subject.load('deltoid', scale=0.5))
        FigureCanvasAgg(figure).draw()
        page = figure.bbox
        labels = [axes.yaxis.label for axes in figure.axes if axes.get_ylabel()]
        for words in (*figure.legends, *labels):
            box = words.get_window_extent()
            assert page.x0 <= box.x0 < box.x1 <= page.x1, words
            assert page.y0 <= box.y0 < box.y1 <= page.y1, words


@requires('matplotlib')
def test_a_chart_of_depths_says_where_and_how_deep() -> None:
    subject = Subject.load('deltoid')
    with house_style():
        (axes,) = charts.depths_figure({PRINTED: check_experiments(subject.experiments)}).axes
    words = [text.get_text() for text in axes.texts]
    assert words.count('20') == 2  # mm, flexion 50 and 60
    assert words.count('<1') == 4
    assert '4,5,6' in words
    assert BroadMuscle.load('deltoid').band_names[0] in axes.get_yticklabels()[0].get_text()
