# SPDX-License-Identifier: Apache-2.0
"""From the swarm's best particle downhill: least squares on the criterion's residuals."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...errors import LinkedPlaneError
from ...types import Floats
from .swarm import INSTALL

Residuals = Callable[[Floats], 'Floats | float']

STEP = 1e-6  # of the unit box: derivatives by differences then have a relative error of some 1e-6
WALL = 1e4  # mm: each residual of a muscle without a path


def polish(
    residuals: Residuals, start: Floats, evaluations: int, pool: ThreadPoolExecutor | None = None
) -> Floats:
    """Return x (p,) in the unit box where the sum of squares is not greater than at the start.

    Parameters
    ----------
    residuals
        Gives the residuals at x, mm; a float where there are none.
    start
        (p,) in the unit box.
    evaluations
        The most steps of SciPy's `least_squares`, each with p evaluations more for derivatives.
    pool
        Threads for the derivatives; the result is the same.

    """
    try:
        from scipy.optimize import least_squares  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise LinkedPlaneError(INSTALL) from None
    inside = np.clip(start, STEP, 1.0 - STEP)
    here = residuals(inside)
    if isinstance(here, float):
        return start
    count = len(here)

    def walled(x: Floats) -> Floats:
        found = residuals(x)
        return np.full(count, WALL) if isinstance(found, float) else found

    def slopes(x: Floats) -> Floats:
        middle = walled(x)
        steps = np.where(x + STEP < 1.0, STEP, -STEP)
        moved = x + np.diag(steps)
        found = map(walled, moved) if pool is None else pool.map(walled, moved)
        return np.array([(each - middle) / h for each, h in zip(found, steps, strict=True)]).T

    answer = least_squares(walled, inside, jac=slopes, bounds=(0.0, 1.0), max_nfev=evaluations)
    before = residuals(start)
    if isinstance(before, float) or answer.fun @ answer.fun < before @ before:
        return np.asarray(answer.x, dtype=np.float64)
    return start
