# SPDX-License-Identifier: Apache-2.0
"""The status of a muscle on /diagnostics: its level, counts and times."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from ..joints.joint_state import REASONS
from ..solver.states import MuscleState, WrapState

TIMED = 2000  # callbacks that the timing figures look back on
STALE_AFTER = 3.0  # s without input


@dataclass
class Tally:
    """Counts and times (s) of a muscle's messages so far; an arrival is that of its joints."""

    received: int = 0
    answered: int = 0
    near_singular: int = 0
    rejected: Counter[str] = field(default_factory=Counter)
    last_rejection: str = ''
    others: int = 0
    """Messages of other joints alone; they are nobody's fault as long as ours come, too."""
    last_other: str = ''
    incompatible_peers: list[str] = field(default_factory=list)
    solve_times: deque[float] = field(default_factory=lambda: deque(maxlen=TIMED))
    callback_times: deque[float] = field(default_factory=lambda: deque(maxlen=TIMED))
    last_arrival: float | None = None
    last_state: MuscleState | None = None
    rejected_before: int = 0
    near_singular_before: int = 0

    def assess(self, now: float) -> tuple[bytes, str]:
        """Return the level and its line: rejected input warns, no input is stale; `now` in s."""
        rejected = sum(self.rejected.values())
        fresh, self.rejected_before = rejected - self.rejected_before, rejected
        near = self.near_singular - self.near_singular_before
        self.near_singular_before = self.near_singular
        if self.last_arrival is None and self.others:
            return DiagnosticStatus.ERROR, f'no joint state was usable: {self.last_other}'
        if self.last_arrival is None:
            line = next(iter(self.incompatible_peers), 'no joint states received yet')
            return DiagnosticStatus.STALE, line
        if not self.answered:
            return DiagnosticStatus.ERROR, f'no joint state was usable: {self.last_rejection}'
        age = now - self.last_arrival
        if age > STALE_AFTER:
            return DiagnosticStatus.STALE, f'no joint states for {age:.1f} s'
        if fresh:
            line = f'{fresh} rejected in the last second: {self.last_rejection}'
            return DiagnosticStatus.WARN, line
        if self.incompatible_peers:
            return DiagnosticStatus.WARN, self.incompatible_peers[0]
        if near:
            line = f'answering; {near} near the singularity, where two moment arms are nearly equal'
            return DiagnosticStatus.OK, f'{line}: use the moment vectors'
        return DiagnosticStatus.OK, 'answering'


def summarise_times(times: deque[float]) -> dict[str, str]:
    """Return mean, 99th percentile and worst of times (s) as text in ms."""
    if not times:
        return dict.fromkeys(('mean', 'p99', 'worst'), 'none')
    values = np.sort(np.fromiter(times, np.float64, len(times)))
    place = 0.99 * (len(values) - 1)
    below = values[int(place)]
    p99 = below + (place - int(place)) * (values[math.ceil(place)] - below)
    figures = {'mean': values.mean(), 'p99': p99, 'worst': values[-1]}
    return {name: f'{1e3 * value:.3f}' for name, value in figures.items()}


def build_status(
    tally: Tally, name: str, hardware_id: str, now: float, facts: Mapping[str, str]
) -> DiagnosticStatus:
    """Return the status of a muscle.

    Parameters
    ----------
    tally
        Its counts and times.
    name, hardware_id
        The status's.
    now
        On the clock of the tally's times, s.
    facts
        Further values, shown first.

    """
    level, line = tally.assess(now)
    values = dict(facts)
    values['messages received'] = str(tally.received)
    values['messages answered'] = str(tally.answered)
    values['messages of other joints'] = str(tally.others)
    values['peers that do not fit'] = str(len(tally.incompatible_peers))
    values['answers near the singularity'] = str(tally.near_singular)
    for reason in REASONS:
        values[f'rejected: {reason}'] = str(tally.rejected[reason])
    for kind, times in (('solve', tally.solve_times), ('callback', tally.callback_times)):
        for figure, text in summarise_times(times).items():
            values[f'{kind} time {figure} (ms)'] = text
    age = 'none' if tally.last_arrival is None else f'{now - tally.last_arrival:.3f}'
    values['input age (s)'] = age
    if tally.last_state is not None:
        values['theta (rad)'] = f'{tally.last_state.theta:.6f}'
        for wrap in WrapState:
            count = int((tally.last_state.wrap == wrap).sum())
            values[f'bands {wrap.name.lower()}'] = str(count)
    return DiagnosticStatus(
        level=level,
        name=name,
        message=line,
        hardware_id=hardware_id,
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
