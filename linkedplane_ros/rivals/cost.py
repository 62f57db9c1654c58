# SPDX-License-Identifier: Apache-2.0
"""What a configuration costs in each method: time for all bands, lengths and moment vectors."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ..joints.conventions import THESIS_CONVENTION
from ..muscle.broad_muscle import BroadMuscle
from .methods import methods
from .sweeps import angle_limits

FRAMES = 500  # of a batch: few enough for one core
FINITE_ELEMENTS = (
    'finite elements: about 5 to 10 hours a run on a super computer (thesis ch. 3, of Blemker et '
    'al.); tens of minutes to hours for a position of a muscle (ch. 7)'
)


CallName = TypeVar('CallName')


@dataclass(frozen=True)
class Cost:
    """Time for all bands of a muscle at one pose, s; the best of many, as noise only adds."""

    method: str
    one_call: float
    """Of `solve`, from Python."""
    batch: float
    """Of `solve_batch`, a pose, on one core."""


def cost(muscle: BroadMuscle, seconds: float = 0.1) -> list[Cost]:
    """Measure what each method takes on this machine, for `seconds` each."""
    low, high = angle_limits(muscle).T
    angles = np.random.default_rng(1).uniform(low, high, (FRAMES, 3))
    rotations = THESIS_CONVENTION.rotations_and_axes(angles)[0]
    found = methods(muscle)
    calls: dict[tuple[str, str], Callable[[], Any]] = {}
    for method in found:
        calls['one', method.name] = partial(method.solver.solve, rotations[0])
        calls['batch', method.name] = partial(method.solver.solve_batch, rotations)
    times = best_times(calls, seconds, 0.002)
    return [
        Cost(method.name, times['one', method.name], times['batch', method.name] / FRAMES)
        for method in found
    ]


def best_times(
    calls: Mapping[CallName, Callable[[], Any]], seconds: float = 2.0, round_seconds: float = 0.02
) -> dict[CallName, float]:
    """Measure how long calls take, at best: noise only adds.

    Parameters
    ----------
    calls
        By name; they take turns, so that noise meets all alike.
    seconds
        How long to measure, for each call.
    round_seconds
        How long each call is repeated before the next one's turn, about.

    Returns
    -------
    dict
        s a call, by name.

    """
    counts = {}
    for name, call in calls.items():
        call()
        start = time.perf_counter()
        call()
        counts[name] = max(1, int(round_seconds / max(time.perf_counter() - start, 1e-7)))
    found = dict.fromkeys(calls, math.inf)
    end = time.perf_counter() + seconds * len(calls)
    rounds = 0
    while rounds < 2 or time.perf_counter() < end:
        rounds += 1
        for name, call in calls.items():
            start = time.perf_counter()
            for _ in range(counts[name]):
                call()
            found[name] = min(found[name], (time.perf_counter() - start) / counts[name])
    return found
