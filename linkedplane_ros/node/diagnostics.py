# SPDX-License-Identifier: Apache-2.0
"""The status of a muscle on /diagnostics: its level, counts and times."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from ..errors import describe_value
from ..joints.joint_state import REASONS
from ..solver.moment_bounds import REACH_FACTOR
from ..solver.states import MuscleState, WrapState

TIMED = 2000  # callbacks that the timing figures look back on
STALE_AFTER = 3.0  # s without input, or without one of the joints
POOR_FIT = 5.0  # deg: a skeleton that misses measured poses by more is another's
OUTSIDE_SHARE = 0.1  # of the last second's answers: less is a moment's excursion


@dataclass
class Tally:
    """Counts and times (s) of a muscle's messages so far; an arrival is that of its joints."""

    received: int = 0
    answered: int = 0
    near_singular: int = 0
    without_plane: int = 0
    """Answers near the side, where a rhythm needs the plane of elevation and nothing says it."""
    beyond_limits: int = 0
    """Answers with a joint of the skeleton far beyond its limits."""
    outside: int = 0
    """Answers at poses outside the model's range of motion."""
    beyond: int = 0
    """Answers with a moment arm beyond its bound."""
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
    ages: Mapping[str, float] = field(default_factory=dict)
    """s, of each joint's value."""
    oldest: float = STALE_AFTER
    """s: an older value of a joint is worth a warning."""
    awaited: str = ''
    """What has to come before anything is answered; empty: nothing."""
    unseen: Sequence[str] = ()
    """The joints that have not come so far."""
    lacking: str = ''
    """Why the frames of the bones do not hang together; empty: they do, or joints are read."""
    misfit: tuple[float, float] | None = None
    """deg and mm by which the skeleton misses the newest measured pose."""
    same_name: str = ''
    """A line on other nodes of this node's name."""
    _before: Counter[str] = field(default_factory=Counter)

    def take_misfit(self, turn: float, shift: float) -> None:
        """Keep how far the skeleton's bones are turned (rad) and shifted (m) from measured ones."""
        self.misfit = math.degrees(turn), 1e3 * shift

    def assess(self, now: float) -> tuple[bytes, str]:
        """Return the level and its line: rejected input warns, no input is stale; `now` in s."""
        new = self._count_new()
        if self.awaited:
            return DiagnosticStatus.WARN, f'waiting for {self.awaited}'
        if self.last_arrival is None and self.others:
            return DiagnosticStatus.ERROR, f'no joint state was usable: {self.last_other}'
        if self.last_arrival is None:
            nothing = self.lacking or 'no joint states received yet'
            line = next(iter(self.incompatible_peers), nothing)
            return DiagnosticStatus.STALE, line
        if not self.answered:
            return DiagnosticStatus.ERROR, f'no joint state was usable: {self.last_rejection}'
        age = now - self.last_arrival
        if age > STALE_AFTER:
            return DiagnosticStatus.STALE, f'no joint states for {age:.1f} s'
        if warnings := '; '.join(self._find_warnings(new)):
            return DiagnosticStatus.WARN, warnings
        if near := new['without_plane']:
            line = f'answering; {near} near the singularity, the arm at the side, whose plane of '
            return DiagnosticStatus.OK, f'{line}elevation the rhythm needs: moment arms jump'
        if near := new['near']:
            line = f'answering; {near} near the singularity, where two moment arms are nearly equal'
            return DiagnosticStatus.OK, f'{line}: use the moment vectors'
        return DiagnosticStatus.OK, 'answering'

    def _count_new(self) -> Counter[str]:
        """Return how many there were of each kind since the last time."""
        total = Counter(
            rejected=sum(self.rejected.values()),
            answered=self.answered,
            near=self.near_singular,
            without_plane=self.without_plane,
            beyond_limits=self.beyond_limits,
            outside=self.outside,
            beyond=self.beyond,
        )
        new, self._before = total - self._before, total
        return new

    def _find_warnings(self, new: Counter[str]) -> Iterator[str]:
        """Yield what is odd, the worst first."""
        if new['rejected']:
            yield f'{new["rejected"]} rejected in the last second: {self.last_rejection}'
        if self.same_name:
            yield self.same_name
        if self.incompatible_peers:
            yield self.incompatible_peers[0]
        if self.misfit is not None and self.misfit[0] > POOR_FIT:
            yield (
                f'the skeleton misses the measured poses by {self.misfit[0]:.3g} deg: beyond the '
                'limits of its joints, or other axes'
            )
        old = [name for name, age in self.ages.items() if age > self.oldest]
        if old:
            yield (
                f'answering with joint {describe_value(old[0])} as it was '
                f'{self.ages[old[0]]:.1f} s ago; joint_timeout stops that'
            )
        if new['beyond']:
            yield (
                f'{new["beyond"]} with a moment arm of more than {REACH_FACTOR:g} times the '
                'distance of the insertion: a small error of the pose changes it a lot'
            )
        if new['beyond_limits'] > OUTSIDE_SHARE * new['answered']:
            yield (
                f'{new["beyond_limits"]} of {new["answered"]} with a joint beyond its limits by '
                'more than a tenth of its range: mm, degrees, or the other sign?'
            )
        if new['outside'] > OUTSIDE_SHARE * new['answered']:
            yield (
                f'{new["outside"]} of {new["answered"]} poses outside the range of motion that the '
                'model is for'
            )


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
    values['answers near the singularity'] = str(tally.near_singular + tally.without_plane)
    values['answers beyond limits of joints'] = str(tally.beyond_limits)
    values['poses outside the range of motion'] = str(tally.outside)
    values['answers with a moment arm beyond its bound'] = str(tally.beyond)
    for reason in REASONS:
        values[f'rejected: {reason}'] = str(tally.rejected[reason])
    for kind, times in (('solve', tally.solve_times), ('callback', tally.callback_times)):
        for figure, text in summarise_times(times).items():
            values[f'{kind} time {figure} (ms)'] = text
    age = 'none' if tally.last_arrival is None else f'{now - tally.last_arrival:.3f}'
    values['input age (s)'] = age
    if tally.misfit is not None:
        values['misfit of the skeleton (deg)'] = f'{tally.misfit[0]:.6f}'
        values['misfit of the skeleton (mm)'] = f'{tally.misfit[1]:.3f}'
    if tally.unseen:
        values['joints not seen so far'] = ', '.join(tally.unseen)
    for joint, seconds in tally.ages.items():
        values[f'age of joint {joint} (s)'] = f'{seconds:.3f}'
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
