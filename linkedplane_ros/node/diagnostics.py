"""What the node tells of itself on /diagnostics, once a second."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from ..joints.joint_state import REASONS
from ..solver.linked_plane_solver import MuscleState, WrapState

TIMED = 2000  # callbacks that the timing figures look back on
STALE_AFTER = 3.0  # s without input


@dataclass
class Tally:
    """Counts and times of a muscle's messages so far."""

    received: int = 0
    answered: int = 0
    near_singular: int = 0
    rejected: Counter[str] = field(default_factory=Counter)
    last_line: str = ''
    misfits: list[str] = field(default_factory=list)
    solve_times: deque[float] = field(default_factory=lambda: deque(maxlen=TIMED))
    callback_times: deque[float] = field(default_factory=lambda: deque(maxlen=TIMED))
    last_arrival: float | None = None
    last_state: MuscleState | None = None
    rejected_before: int = 0
    near_singular_before: int = 0

    def level(self, now: float) -> tuple[bytes, str]:
        """Return the level and its line: rejected input warns, no input is stale."""
        rejected = sum(self.rejected.values())
        fresh, self.rejected_before = rejected - self.rejected_before, rejected
        near = self.near_singular - self.near_singular_before
        self.near_singular_before = self.near_singular
        if self.last_arrival is None:
            return DiagnosticStatus.STALE, next(iter(self.misfits), 'no joint states received yet')
        if not self.answered:
            return DiagnosticStatus.ERROR, f'no joint state was usable: {self.last_line}'
        age = now - self.last_arrival
        if age > STALE_AFTER:
            return DiagnosticStatus.STALE, f'no joint states for {age:.1f} s'
        if fresh:
            return DiagnosticStatus.WARN, f'{fresh} rejected in the last second: {self.last_line}'
        if self.misfits:
            return DiagnosticStatus.WARN, self.misfits[0]
        if near:
            return (
                DiagnosticStatus.OK,
                f'answering; {near} near the singularity: two moment arms '
                'say nearly the same, use the moment vectors',
            )
        return DiagnosticStatus.OK, 'answering'


def milliseconds(times: deque[float]) -> dict[str, str]:
    """Return mean, 99th percentile and worst of times (s) as text in ms."""
    if not times:
        return dict.fromkeys(('mean', 'p99', 'worst'), 'none')
    values = np.sort(np.fromiter(times, np.float64, len(times)))
    place = 0.99 * (len(values) - 1)
    below = values[int(place)]
    p99 = below + (place - int(place)) * (values[math.ceil(place)] - below)
    figures = {'mean': values.mean(), 'p99': p99, 'worst': values[-1]}
    return {name: f'{1e3 * value:.3f}' for name, value in figures.items()}


def status(
    tally: Tally, name: str, hardware_id: str, now: float, facts: Mapping[str, str]
) -> DiagnosticStatus:
    """Return a muscle's status. `now`, on the clock of the tally's times, in s."""
    level, line = tally.level(now)
    values = dict(facts)
    values['messages received'] = str(tally.received)
    values['messages answered'] = str(tally.answered)
    values['peers that do not fit'] = str(len(tally.misfits))
    values['answers near the singularity'] = str(tally.near_singular)
    for reason in REASONS:
        values[f'rejected: {reason}'] = str(tally.rejected[reason])
    for kind, times in (('solve', tally.solve_times), ('callback', tally.callback_times)):
        for figure, text in milliseconds(times).items():
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
