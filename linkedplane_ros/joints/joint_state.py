# SPDX-License-Identifier: Apache-2.0
"""From the joints of a message to the values of coordinates, or a reason why not.

No message package is needed here: a JointState is read as its names and its sequences of numbers.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

from ..errors import LinkedPlaneError, describe_value
from ..types import JointValues
from .articulation import CONTINUOUS, PRISMATIC, REVOLUTE

FULL_CIRCLE = 2.0 * math.pi  # rad: a larger angle is taken for degrees, a larger offset refused
MOST_TURNED = 1e6  # rad of a continuous joint: beyond, 1e-10 rad are lost
FARTHEST = 100.0  # m of a prismatic joint: a larger value is taken for mm, a larger offset refused
FASTEST = 1e9  # rad/s: beyond, no velocity of a joint; answers to it would lose their last digits
REASONS = (
    'sizes',
    'no_joint',
    'duplicate',
    'not_finite',
    'degrees',
    'too_large',
    'incomplete',
    'waiting',
    'stale',
    'no_plane',
    'answer_not_finite',
    'apart',
    'loop',
    'not_unit',
    'far',
    'no_angles',
)
LONG_AGO = -math.inf  # s
OF_ANGLES = 'a full turn at most expected, |offset| <= 2 pi rad'
MOST_OFFSETS = {
    REVOLUTE: OF_ANGLES,
    CONTINUOUS: OF_ANGLES,
    PRISMATIC: f'{FARTHEST:g} m at most expected of a prismatic joint',
}
LARGEST = {REVOLUTE: FULL_CIRCLE, CONTINUOUS: MOST_TURNED, PRISMATIC: FARTHEST}


class Stamp(Protocol):
    """A time as messages have it."""

    sec: int
    nanosec: int


Seen = tuple[Stamp | None, float]
"""When a joint's value was measured, by its message's stamp, and when it came, s."""


class Rejected(LinkedPlaneError):
    """A message that is not answered.

    Parameters
    ----------
    reason
        The name it is counted under, one of REASONS.
    text
        The line that explains it.

    """

    def __init__(self, reason: str, text: str) -> None:
        """Keep the reason beside the line that explains it."""
        super().__init__(text)
        self.reason = reason


class OtherJoints(Rejected):
    """A message of other joints alone, as a hand's or another arm's on the same topic."""

    def __init__(self, wanted: Sequence[str], names: Sequence[str]) -> None:
        """Keep the names that came instead of the wanted ones."""
        super().__init__('no_joint', explain_missing(wanted, names))
        self.names = summarize_names(names)


@dataclass(frozen=True)
class JointMap:
    """Which joints are d coordinates: angle = sign * position + offset.

    Raises
    ------
    LinkedPlaneError
        Unless there are d different joints, finite signs, and offsets of a full turn at most (of
        prismatic joints: of 100 m).

    """

    names: tuple[str, ...]
    """The joints, in the order of the coordinates."""
    signs: JointValues
    offsets: JointValues
    """rad, a full turn at most; of prismatic joints m."""
    kinds: tuple[str, ...] = ()
    """REVOLUTE, CONTINUOUS or PRISMATIC; empty: all revolute."""
    idle: frozenset[str] = frozenset()
    """The joints that move nothing that matters: they are not read, their coordinates stay 0."""

    def __post_init__(self) -> None:
        """Check the joints."""
        d = len(self.names)
        if len(set(self.names)) < d:
            raise LinkedPlaneError(f'joints {", ".join(self.names)}: {d} different joints expected')
        if not len(self.signs) == len(self.offsets) == d == len(self.kinds or self.names):
            counts = f'{len(self.signs)} signs and {len(self.offsets)} offsets'
            raise LinkedPlaneError(f'joints {", ".join(self.names)}: {counts} given, {d} expected')
        if not all(map(math.isfinite, (*self.signs, *self.offsets))):
            raise LinkedPlaneError(
                f'signs {describe_value(self.signs)}, offsets {describe_value(self.offsets)}: '
                'finite numbers expected'
            )
        kinds = self.kinds or (REVOLUTE,) * d
        for offset, kind in zip(self.offsets, kinds, strict=True):
            if abs(offset) > (FARTHEST if kind == PRISMATIC else FULL_CIRCLE):
                raise LinkedPlaneError(
                    f'offsets {describe_value(self.offsets)}: {MOST_OFFSETS[kind]}'
                )

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """The joints that are read."""
        return tuple(name for name in self.names if name not in self.idle)

    @cached_property
    def sliding(self) -> frozenset[str]:
        """The prismatic joints, whose positions are m."""
        kinds = zip(self.names, self.kinds, strict=True) if self.kinds else ()
        return frozenset(name for name, kind in kinds if kind == PRISMATIC)

    @cached_property
    def turning(self) -> tuple[str, ...]:
        """The joints that are read and turn by less than a circle."""
        return tuple(name for name in self.needed if name not in self.most)

    @cached_property
    def most(self) -> dict[str, float]:
        """The largest position of each joint that is not revolute, rad or m."""
        kinds = zip(self.names, self.kinds, strict=True) if self.kinds else ()
        return {name: LARGEST[kind] for name, kind in kinds if kind != REVOLUTE}

    @staticmethod
    def from_facts(facts: Mapping[str, str]) -> JointMap:
        """Return the mapping that an output's metadata has; KeyError or ValueError for none."""
        names = json.loads(facts['joints'])
        signs = map(float, facts['joint_signs'].split())
        offsets = map(float, facts['joint_offsets_rad'].split())
        kinds = facts.get('joint_kinds', '').split()
        idle = json.loads(facts.get('joints_not_read', '[]'))
        return JointMap(tuple(names), tuple(signs), tuple(offsets), tuple(kinds), frozenset(idle))

    @property
    def facts(self) -> dict[str, str]:
        """How angles follow from the recorded positions, for an output's metadata."""
        facts = {
            'joints': json.dumps(self.names),
            'joint_signs': ' '.join(f'{sign:g}' for sign in self.signs),
            'joint_offsets_rad': ' '.join(repr(offset) for offset in self.offsets),
        }
        if self.kinds:
            facts['joint_kinds'] = ' '.join(self.kinds)
            facts['joints_not_read'] = json.dumps(sorted(self.idle))
        return facts


@dataclass
class JointMemory:
    """The newest accepted value of each joint that is needed, as the messages gave it."""

    joints: JointMap
    positions: dict[str, float] = field(default_factory=dict)
    """rad or m, by the joint's name."""
    velocities: dict[str, float] = field(default_factory=dict)
    """rad/s or m/s, by the joint's name."""
    timeout: float = 0.0
    """How much older than a message the other joints may be, s; 0: any time."""
    _seen: dict[str, Seen] = field(default_factory=dict)
    _names: list[str] | None = None
    _places: list[tuple[str, int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Lay out the work on a message."""
        joints = self.joints
        self._rows = list(zip(joints.names, joints.signs, joints.offsets, strict=True))
        self._count = len(joints.needed)

    def take_message(
        self,
        names: Sequence[str],
        positions: Sequence[float],
        velocities: Sequence[float],
        stamp: Stamp | None = None,
        arrival: float = 0.0,
    ) -> tuple[JointValues, JointValues | None, str]:
        """Take one message in, and return the joints as they are then.

        Parameters
        ----------
        names
            (k) any joints, in any order; each of ours at most once.
        positions
            (k) rad or m
        velocities
            (k) rad/s or m/s, or none at all.
        stamp
            Of the message; None or 0: it has none.
        arrival
            When it came, s; on any clock, the same for all messages.

        Returns
        -------
        angles : JointValues
            (d) the coordinates, rad or m.
        velocities : JointValues or None
            (d) rad/s or m/s; None where one is not known for the newest position.
        warning : str
            Why the message's velocities were left out; empty where they were not.

        Raises
        ------
        Rejected
            Where the message cannot be used, which then changes nothing; and where not all the
            joints have been seen so far ('incomplete'), or not within the timeout ('stale').

        """
        if len(names) != len(positions):
            raise Rejected(
                'sizes', f'{len(names)} names but {len(positions)} positions; one each expected'
            )
        places = self._find_places(names)
        fresh = {name: positions[i] for name, i in places}
        wrong = [name for name, q in fresh.items() if not abs(q) <= FULL_CIRCLE]  # also NaN
        if wrong:
            self._check_values(wrong, fresh)
        rates, warning = _usable_velocities(len(names), velocities, places)
        self.positions.update(fresh)
        seen = dict.fromkeys(fresh, (stamp, arrival))
        self._seen = seen if len(seen) == self._count else self._seen | seen
        if len(rates) < len(fresh):  # a velocity is no older than the position it came with
            for name in fresh:
                self.velocities.pop(name, None)
        self.velocities.update(rates)
        known, speeds = self.positions, self.velocities
        if len(known) < self._count:
            unseen = self.find_unseen()[0]
            raise Rejected('incomplete', f'waiting for joint {unseen!r}, not seen so far')
        if self.timeout and len(fresh) < self._count:
            self._check_ages(stamp, arrival)
        if self.joints.idle:
            angles = [s * known[n] + x if n in known else 0.0 for n, s, x in self._rows]
        else:
            angles = [s * known[n] + x for n, s, x in self._rows]
        if len(speeds) < self._count:
            return tuple(angles), None, warning
        return tuple(angles), tuple([s * speeds.get(n, 0.0) for n, s, _ in self._rows]), warning

    def find_unseen(self) -> list[str]:
        """Return the joints that are needed and have not come so far."""
        return [name for name in self.joints.needed if name not in self.positions]

    def _check_values(self, doubtful: Sequence[str], values: Mapping[str, float]) -> None:
        """Reject values that are not finite, or too large for their kinds of joints."""
        for name in doubtful:
            q, most = values[name], self.joints.most.get(name)
            if not math.isfinite(q):
                raise Rejected('not_finite', f'joint {name!r} is {q}; a finite angle expected')
            if most is None:
                text = f'joint {name!r} is {q:g}: degrees? radians expected (|q| <= 2 pi)'
                raise Rejected('degrees', text)
            if abs(q) > most:
                raise Rejected('too_large', f'joint {name!r} is {q:g}; at most {most:g} expected')

    def _check_ages(self, stamp: Stamp | None, arrival: float) -> None:
        """Reject a message unless all joints are of its time, by their stamps and arrivals.

        A joint from after the message is one from before time went back: it is never used again.
        """
        now = read_seconds(stamp)
        for name in self.joints.needed:
            seen_stamp, seen_arrival = self._seen[name]
            then, by_arrival = read_seconds(seen_stamp), arrival - seen_arrival
            by_stamp = now - then if now and then else 0.0
            if min(by_stamp, by_arrival) < -self.timeout:
                self._seen[name] = None, LONG_AGO
                by_arrival = math.inf
            age = max(by_stamp, by_arrival)
            if age > self.timeout:
                since = 'since time went back' if age == math.inf else f'for {age:.3g} s'
                raise Rejected(
                    'stale',
                    f'joint {name!r} has not come {since}; '
                    f'{self.timeout:g} s at most expected (joint_timeout)',
                )

    def find_ages(self, now: float) -> dict[str, float]:
        """Return how long ago each joint seen so far came, s; `now` on the clock of arrivals."""
        return {
            name: now - self._seen[name][1] for name in self.joints.needed if name in self._seen
        }

    def _find_places(self, names: Sequence[str]) -> list[tuple[str, int]]:
        """Return the joints' places among the names."""
        if names != self._names:
            last = {name: i for i, name in enumerate(names)}
            places = [(name, last[name]) for name in self.joints.needed if name in last]
            if len(last) < len(names):
                _check_counts([name for name, _ in places], names)
            if not places:
                wanted = self.joints.needed
                if len(names):
                    raise OtherJoints(wanted, names)
                raise Rejected('no_joint', explain_missing(wanted, names))
            self._names, self._places = list(names), places
        return self._places


def read_seconds(stamp: Stamp | None) -> float:
    """Return a stamp in s; 0 for none."""
    return 0.0 if stamp is None else stamp.sec + 1e-9 * stamp.nanosec


def _check_counts(ours: Sequence[str], names: Sequence[str]) -> None:
    counts = Counter(names)
    for name in ours:
        if counts[name] > 1:
            raise Rejected(
                'duplicate', f'joint {name!r} is in it {counts[name]} times; once expected'
            )


def _usable_velocities(
    count: int, velocities: Sequence[float], places: list[tuple[str, int]]
) -> tuple[dict[str, float], str]:
    """Return the joints' velocities, none where they cannot be used, and then why."""
    if not len(velocities):
        return {}, ''
    if count != len(velocities):
        return {}, f'velocities left out: {len(velocities)} for {count} names'
    rates = {name: velocities[i] for name, i in places}
    wrong = [name for name, v in rates.items() if not abs(v) <= FASTEST]  # also NaN
    if wrong:
        return {}, f'velocities left out: that of joint {wrong[0]!r} is {rates[wrong[0]]}'
    return rates, ''


def summarize_names(names: Sequence[str], most: int = 6) -> str:
    """Return the first few names as text, safe to log whatever they are."""
    if not len(names):
        return 'no joint at all'
    more = f' and {len(names) - most} more' if len(names) > most else ''
    return ', '.join(map(describe_value, names[:most])) + more


def explain_missing(wanted: Sequence[str], names: Sequence[str]) -> str:
    """Return why a message without any of the wanted joints is of no use."""
    return (
        f'none of the joints {", ".join(wanted)} in it, but {summarize_names(names)}; '
        'set joint_names or joint_convention'
    )
