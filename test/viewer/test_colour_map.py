# SPDX-License-Identifier: Apache-2.0
"""The colours of moment arms: even steps, a screen's colours, round ends."""

from __future__ import annotations

import numpy as np
import pytest

from linkedplane_ros.viewer.scene import colour_map


def test_equal_steps_of_the_map_look_equally_far_apart() -> None:
    steps = np.linalg.norm(np.diff(colour_map.oklab(np.linspace(-1, 1, 101)), axis=0), axis=1)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)


def test_a_screen_can_show_the_whole_map() -> None:
    shown = colour_map.srgb(colour_map.oklab(np.linspace(-1, 1, 501)))
    assert 0.0 <= shown.min()
    assert shown.max() <= 1.0


def test_zero_is_grey_and_the_signs_can_be_told_apart() -> None:
    low, zero, high = colour_map.map_colours([-60.0, 0.0, 60.0], 60.0).astype(int)
    assert len(set(zero.tolist())) == 1
    assert low[2] - low[0] > 100
    assert high[0] - high[2] > 100


def test_oklab_white_is_white_on_the_screen() -> None:
    # the matrices' published digits are good to 1e-6
    white = colour_map.srgb(np.array((1.0, 0.0, 0.0)))
    np.testing.assert_allclose(white, 1.0, atol=1e-6)


@pytest.mark.parametrize(
    ('value', 'rounded'),
    [(0.0, 1.0), (0.3, 0.5), (1.0, 1.0), (1.01, 2.0), (38.2, 50.0), (51.0, 100.0)],
)
def test_the_end_of_a_map_is_a_round_number(value: float, rounded: float) -> None:
    assert colour_map.round_up(value) == pytest.approx(rounded)


def test_the_legend_says_what_which_unit_and_the_ends() -> None:
    text = colour_map.legend_html('moment arm about flexion', 50.0, 'mm')
    for part in ('moment arm about flexion, mm', '-50', '+50', '>0<', 'linear-gradient'):
        assert part in text
