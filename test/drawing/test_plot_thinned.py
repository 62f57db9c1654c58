# SPDX-License-Identifier: Apache-2.0
"""Long series are drawn with few points that keep their extremes and gaps."""

from __future__ import annotations

import numpy as np
import pytest
from optional import requires
from plotted import ONE_HEAD, panels, repeated

from linkedplane_ros.drawing.plot import CROWDED, MOST, figures
from linkedplane_ros.drawing.thinning import thin_points

pytestmark = requires('matplotlib')

EXACT = 1e-9  # mm, deg, s: drawn are the given numbers, but for the rounding of their units


def test_a_short_series_is_not_thinned() -> None:
    x, y = np.arange(100.0), np.sin(np.arange(100.0))
    assert all(a is b for a, b in zip(thin_points(x, y, 100), (x, y), strict=True))


@pytest.mark.parametrize(('frames', 'most'), [(1001, 1000), (1003, 50), (100_003, 4000), (17, 5)])
def test_extremes_survive_thinning(frames: int, most: int) -> None:
    random = np.random.default_rng(frames)
    x, y = np.cumsum(random.random(frames)), random.normal(size=frames)
    peak, trough, turn = random.choice(frames, 3, replace=False)
    y[peak], y[trough], x[turn] = 99.0, -99.0, 2 * x[-1]
    few, values = thin_points(x, y, most)
    assert len(few) == len(values) <= most
    assert {x[peak], x[trough], x[turn], x[0]} <= set(few)
    assert (values.max(), values.min()) == (99.0, -99.0)
    places = np.flatnonzero(np.isin(y, values))
    assert np.array_equal(x[places], few)  # in their order
    assert np.array_equal(y[places], values)


def test_every_run_keeps_its_own_extremes() -> None:
    y = np.random.default_rng(1).normal(size=10_000)
    _, few = thin_points(np.arange(10_000.0), y, 500)
    for run in y.reshape(100, 100):
        assert {run.min(), run.max(), run[0], run[-1]} <= set(few)


def test_a_gap_survives_thinning_beside_the_extremes() -> None:
    y = np.arange(1000.0)
    y[500] = np.nan
    y[503] = 5000.0
    _, few = thin_points(np.arange(1000.0), y, 100)
    assert np.isnan(few).sum() == 1
    assert np.nanmax(few) == 5000.0


def test_a_long_recording_is_drawn_with_few_points_and_its_peaks() -> None:
    long = repeated(ONE_HEAD, CROWDED + 1)
    long.lengths[12_345] = 0.5
    for name, figure in figures(long).items():
        axes = panels(figure)[0, 0]
        for line in (line for line in axes.lines if line.get_label() in long.bands):
            assert len(line.get_xdata()) <= MOST
            assert line.get_ydata().max() == pytest.approx(500, abs=EXACT)
            # a line through a few frames of a cloud would show what was never there
            assert (line.get_linestyle() == 'None') == name.startswith('against')
