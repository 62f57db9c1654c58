# SPDX-License-Identifier: Apache-2.0
"""What is made of the motion in a table: other rates, a filter, derivatives."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_tables import JOINTS, read_all
from unhurried import unhurried

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.recordings.filters import differentiate, filter_lowpass, resample
from linkedplane_ros.recordings.tables.table import Table
from linkedplane_ros.types import Floats


def sine(frequency: float, times: Floats) -> Floats:
    """Return a sine (m, 1) of a frequency (Hz)."""
    return np.sin(2.0 * math.pi * frequency * times)[:, None]


def test_at_its_own_rate_a_motion_stays_as_it_is(shared: Path) -> None:
    table = Table.from_file(shared / 'recordings' / 'abduction.mot')
    times, values = read_all(table, JOINTS)
    new, there = resample(times, values, 100.0)
    np.testing.assert_allclose(new, times, rtol=0.0, atol=1e-12)  # s: rounding
    np.testing.assert_allclose(there, values, rtol=0.0, atol=1e-8)  # deg: the file's last decimal


def test_a_line_stays_a_line_at_any_rate() -> None:
    times = np.array([1.0, 1.1, 1.15, 1.4, 2.0])
    values = np.column_stack((3.0 * times, 1.0 - times))
    new, there = resample(times, values, 8.0)
    np.testing.assert_array_equal(new, 1.0 + np.arange(9) / 8.0)
    # 1: some roundings of numbers up to 6
    np.testing.assert_allclose(there, np.column_stack((3.0 * new, 1.0 - new)), atol=1e-14)


@unhurried
@given(
    st.lists(st.floats(1e-4, 10.0), min_size=1, max_size=30),
    st.floats(-1e4, 1e4),
    st.floats(0.01, 1000.0),
)
def test_no_row_is_made_beyond_the_last_or_left_out(
    steps: list[float], begin: float, rate: float
) -> None:
    times = begin + np.concatenate(([0.0], np.cumsum(steps)))
    new, there = resample(times, times[:, None], rate)
    assert new[0] == times[0]
    assert times[-1] - (1.0 + 1e-6) / rate - 1e-9 < new[-1] <= times[-1]  # s
    np.testing.assert_allclose(np.diff(new), 1.0 / rate, rtol=2e-6, atol=1e-11)  # s: 1e4 s + 1e-12
    assert there.shape == (len(new), 1)
    assert there.min() >= times[0]
    assert there.max() <= times[-1]


def test_at_its_own_rate_a_motion_keeps_all_its_rows_wherever_it_begins() -> None:
    for begin in range(0, 300, 7):
        for count in range(2, 120):
            times = np.array([float(f'{(begin + k) / 100.0:.6f}') for k in range(count)])  # s
            new, _ = resample(times, np.zeros((count, 1)), 100.0)
            assert len(new) == count
            assert new[-1] <= times[-1]


def test_a_gap_stays_a_gap() -> None:
    times = np.arange(5.0)
    _, there = resample(times, np.array([[0.0], [1.0], [math.nan], [3.0], [4.0]]), 2.0)
    assert np.isnan(there[:, 0]).tolist() == [k in (3, 4, 5) for k in range(9)]


@pytest.mark.parametrize(
    ('times', 'rate', 'reason'),
    [
        ([], 10.0, '0 rows at 10 Hz; at least 2 rows'),
        ([0.0], 10.0, '1 rows at 10 Hz; at least 2 rows'),
        ([0.0, 1.0], 0.0, 'a rate above 0 expected'),
        ([0.0, 1.0], math.nan, 'a rate above 0 expected'),
        ([0.0, 1.0], math.inf, 'a rate above 0 expected'),
        ([0.0, 0.5, 0.5, 1.0], 10.0, r'times have to increase, but 0\.5 s follows 0\.5 s'),
        ([0.0, 0.5, 0.25], 10.0, r'times have to increase, but 0\.25 s follows 0\.5 s'),
        ([0.0, math.nan, 1.0], 10.0, 'times have to increase, but nan s follows'),
    ],
)
def test_times_that_cannot_be_resampled_are_refused(
    times: list[float], rate: float, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        resample(np.array(times), np.zeros((len(times), 2)), rate)


TIMES = np.arange(1000) / 100.0  # s
MIDDLE = slice(200, 800)  # away from the ends, where the filter has little to go by


def test_slow_motion_passes_the_filter_without_lag() -> None:
    slow = sine(1.0, TIMES)
    # 1: the gain at 1 Hz is 1 / (1 + (1/6)^4) = 0.9992
    np.testing.assert_allclose(filter_lowpass(slow, 100.0, 6.0)[MIDDLE], slow[MIDDLE], atol=0.01)


def test_fast_motion_does_not_pass_the_filter() -> None:
    # 1: the gain at 20 Hz is below 1 / (1 + (20/6)^4) = 0.008
    assert np.abs(filter_lowpass(sine(20.0, TIMES), 100.0, 6.0)[MIDDLE]).max() < 0.008


@pytest.mark.parametrize('frequency', [3.0, 6.0, 9.0, 12.0])
def test_the_filter_is_of_fourth_order_and_leaves_half_at_the_cutoff(frequency: float) -> None:
    def warped(hertz: float) -> float:  # by the bilinear transform
        return math.tan(math.pi * hertz / 100.0)

    gain = 1.0 / (1.0 + (warped(frequency) / warped(6.0)) ** 4)
    left = filter_lowpass(sine(frequency, TIMES), 100.0, 6.0)
    expected = gain * sine(frequency, TIMES)
    np.testing.assert_allclose(left[MIDDLE], expected[MIDDLE], atol=1e-6)  # 1: from the ends


def test_each_column_is_filtered_by_itself() -> None:
    both = np.column_stack((sine(1.0, TIMES), sine(20.0, TIMES)))
    for k, column in enumerate(filter_lowpass(both, 100.0, 6.0).T):
        np.testing.assert_array_equal(column, filter_lowpass(both[:, [k]], 100.0, 6.0)[:, 0])


def test_rest_stays_at_rest_even_in_the_fewest_rows() -> None:
    rest = np.full((10, 2), 0.7)
    np.testing.assert_allclose(filter_lowpass(rest, 100.0, 6.0), rest, atol=1e-12)  # rad: rounding


@pytest.mark.parametrize(
    ('rows', 'cutoff', 'reason'),
    [
        (100, 50.0, 'cutoff 50 Hz; above 0 and below 50 Hz expected'),
        (100, 60.0, 'cutoff 60 Hz; above 0 and below 50 Hz expected'),
        (100, 0.0, 'cutoff 0 Hz; above 0'),
        (100, math.nan, 'cutoff nan Hz; above 0'),
        (9, 6.0, '9 rows to filter; at least 10 expected'),
        (0, 6.0, '0 rows to filter; at least 10 expected'),
    ],
)
def test_what_cannot_be_filtered_is_refused_in_one_line(
    rows: int, cutoff: float, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason) as caught:
        filter_lowpass(np.zeros((rows, 2)), 100.0, cutoff)
    assert '\n' not in str(caught.value)


def test_no_filter_goes_across_a_gap() -> None:
    values = np.zeros((20, 3))
    values[4, 2] = math.nan
    with pytest.raises(ValueError, match='row 5, column 3: a gap; no filter can cross it'):
        filter_lowpass(values, 100.0, 6.0)


def test_without_scipy_the_filter_says_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'scipy.signal', None)
    with pytest.raises(RecordingError, match='a low-pass filter needs SciPy: pip install scipy'):
        filter_lowpass(np.zeros((20, 1)), 100.0, 6.0)


def test_the_derivative_of_a_parabola_is_a_line_even_at_uneven_times() -> None:
    times = np.array([0.0, 0.1, 0.3, 0.35, 0.7, 1.0])
    values = np.column_stack((times**2, 1.0 - 3.0 * times**2))
    slopes = np.column_stack((2.0 * times, -6.0 * times))
    found = differentiate(times, values)
    np.testing.assert_allclose(found[1:-1], slopes[1:-1], atol=1e-13)  # 1/s: rounding
    # of first order at the ends: the slope in the middle of the outermost step
    np.testing.assert_allclose(found[0], 0.5 * (slopes[0] + slopes[1]), atol=1e-13)
    np.testing.assert_allclose(found[-1], 0.5 * (slopes[-1] + slopes[-2]), atol=1e-13)


def test_a_single_row_does_not_move() -> None:
    np.testing.assert_array_equal(differentiate(np.zeros(1), np.ones((1, 3))), np.zeros((1, 3)))
    assert differentiate(np.zeros(0), np.ones((0, 3))).shape == (0, 3)


def test_two_rows_have_the_slope_between_them() -> None:
    found = differentiate(np.array([0.0, 0.5]), np.array([[0.0, 1.0], [1.0, 1.0]]))
    assert found.tolist() == [[2.0, 0.0]] * 2


def test_there_is_no_derivative_where_time_stands_still() -> None:
    times = np.array([0.0, 1.0, 2.0, 2.0, 3.0, 4.0])
    with np.errstate(divide='ignore', invalid='ignore'):
        found = differentiate(times, times[:, None])
    assert np.isfinite(found[:, 0]).tolist() == [True, True, False, False, True, True]
