# SPDX-License-Identifier: Apache-2.0
"""Signals brought to another rate, filtered, and differentiated in time."""

from __future__ import annotations

import numpy as np

from ..errors import RecordingError
from ..libraries import advise_install
from ..types import Floats

PADDING = 9  # rows by which the filter prolongs a motion at each end, 3 for each coefficient


def resample(times: Floats, values: Floats, rate: float) -> tuple[Floats, Floats]:
    """Interpolate values linearly at a constant rate, from the first time to the last at most.

    Parameters
    ----------
    times
        (m,) s, increasing.
    values
        (m, k).
    rate
        Hz.

    Returns
    -------
    times, values
        (n,) s and (n, k).

    Raises
    ------
    RecordingError
        For fewer than 2 rows, times that do not increase, or no rate.
    """
    if len(times) < 2 or not 0.0 < rate < np.inf:
        raise RecordingError(
            f'{len(times)} rows at {rate:g} Hz; at least 2 rows and a rate above 0 expected'
        )
    increases = np.diff(times) > 0.0  # also False beside NaN
    if not increases.all():
        k = int(np.argmin(increases))
        raise RecordingError(f'times have to increase, but {times[k + 1]} s follows {times[k]} s')
    steps = int((times[-1] - times[0]) * rate + 1e-6)  # rounding may leave the last one short
    instants = np.minimum(times[0] + np.arange(steps + 1) / rate, times[-1])
    there = np.empty((len(instants), values.shape[1]))
    for k, column in enumerate(values.T):
        there[:, k] = np.interp(instants, times, column)
    return instants, there


def filter_lowpass(values: Floats, rate: float, cutoff: float) -> Floats:
    """Filter values without lag: Butterworth of second order, once forwards and once backwards.

    Together that is of fourth order, with half the amplitude left at the cutoff.

    Parameters
    ----------
    values
        (m, k), finite: anything else would spread over its column.
    rate
        Hz, at which they were sampled.
    cutoff
        Hz, between 0 and rate / 2.

    Returns
    -------
    values
        (m, k).

    Raises
    ------
    RecordingError
        For another cutoff, fewer than 10 rows, values that are not finite, or without SciPy.
    """
    if not 0.0 < cutoff < 0.5 * rate:
        raise RecordingError(f'cutoff {cutoff:g} Hz; above 0 and below {0.5 * rate:g} Hz expected')
    if len(values) <= PADDING:
        raise RecordingError(f'{len(values)} rows to filter; at least {PADDING + 1} expected')
    gaps = np.argwhere(~np.isfinite(values))
    if len(gaps):
        row, column = gaps[0] + 1
        raise RecordingError(f'row {row}, column {column}: a gap; no filter can cross it')
    try:
        from scipy.signal import butter, sosfiltfilt  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise RecordingError(f'a low-pass filter needs SciPy: {advise_install("scipy")}') from None
    sections = butter(2, cutoff, fs=rate, output='sos')
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=PADDING), dtype=float)


def differentiate(times: Floats, values: Floats) -> Floats:
    """Return the derivative (m, k), per s, of values (m, k) at times (m,), s; zero for one row.

    Of second order, but of first at both ends; not finite, with NumPy's warning, where a time is
    repeated.
    """
    if len(times) < 2:
        return np.zeros(values.shape)
    return np.asarray(np.gradient(values, times, axis=0), dtype=float)
