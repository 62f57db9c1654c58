# SPDX-License-Identifier: Apache-2.0
"""The viewer's plots: the last seconds, curves over an angle, round limits."""

from __future__ import annotations

import numpy as np

from linkedplane_ros.viewer.panels.history import CoordinateCurve, Recent, merge_curves, widen_range


def test_the_last_seconds_are_kept_in_order() -> None:
    recent = Recent(1, 5)
    for k in range(8):
        recent.add(0.5 * k, [10.0 * k])
    np.testing.assert_array_equal(recent.rows_of_last(10.0)[:, 1], [30, 40, 50, 60, 70])
    np.testing.assert_array_equal(recent.rows_of_last(1.0)[:, 0], [2.5, 3.0, 3.5])
    assert Recent(1, 5).rows_of_last(1.0).shape == (0, 2)


def test_a_curve_has_one_value_a_degree_whichever_way_it_was_gone() -> None:
    curve = CoordinateCurve(1, -180.0, 180.0, 1.0)
    there = np.arange(0.0, 60.0, 0.1)
    for angle in [*there, *there[::-1], 400.0]:
        curve.add(angle, [2.0 * angle])
    known = curve.known_rows()
    assert len(known) == 61
    assert (np.diff(known[:, 0]) > 0.0).all()
    np.testing.assert_allclose(known[:, 1], 2.0 * known[:, 0])


def test_curves_side_by_side_share_their_places_and_keep_their_ends() -> None:
    one = np.array(((0.0, 1.0), (2.0, 3.0), (4.0, 5.0)))
    other = np.array(((1.0, -1.0), (3.0, -3.0)))
    table = merge_curves([one, other, np.empty((0, 2))])
    np.testing.assert_array_equal(table[:, :2].T, [[0, 1, 2, 3, 4], [1, 2, 3, 4, 5]])
    np.testing.assert_array_equal(table[:, 2], [np.nan, -1, -2, -3, np.nan])
    assert np.isnan(table[:, 3]).all()
    np.testing.assert_array_equal(merge_curves([one]), one)


def test_a_plot_reaches_round_numbers_and_never_less_far_than_before() -> None:
    assert widen_range(None, [np.nan, 88.2, 151.0], 10.0) == (80.0, 160.0)
    assert widen_range((80.0, 160.0), [120.0, 189.5], 10.0) == (80.0, 200.0)  # with room
    assert widen_range((80.0, 160.0), [np.nan], 10.0) == (80.0, 160.0)
    assert widen_range(None, [np.nan], 10.0) is None
