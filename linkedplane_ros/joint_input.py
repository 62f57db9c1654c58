"""From the joints of a message to the three angles of a convention, or a reason why not.

No message package is needed here: a JointState is read as its names and its sequences of numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

FULL_CIRCLE = 2.0 * math.pi  # rad: a larger angle is taken for degrees


class Rejected(ValueError):
    """A message that is not answered; `reason` is the name it is counted under."""

    def __init__(self, reason: str, text: str) -> None:
        """Keep the reason beside the line that explains it."""
        super().__init__(text)
        self.reason = reason


REASONS = ('sizes', 'no_joint', 'not_finite', 'degrees', 'incomplete', 'no_plane')


@dataclass(frozen=True)
class JointMap:
    """Which joints are the convention's coordinates: angle = sign * position + offset (rad)."""

    names: tuple[str, str, str]
    signs: tuple[float, float, float]
    offsets: tuple[float, float, float]


@dataclass
class JointMemory:
    """The newest accepted value of each of the three joints, as the messages gave it."""

    joints: JointMap
    positions: dict[str, float] = field(default_factory=dict)
    velocities: dict[str, float] = field(default_factory=dict)

    def take(
        self, names: Sequence[str], positions: Sequence[float], velocities: Sequence[float]
    ) -> tuple[Floats, Floats | None, str]:
        """Take one message in; return angles (3,) rad, velocities (3,) rad/s or None, a warning.

        The velocities are None where the message has none, or unusable ones (the warning then says
        which; it is empty otherwise). Raises Rejected and remembers nothing where the message as a
        whole is no good, and where not all three joints have been seen ('incomplete').
        """
        fresh = self._positions(names, positions)
        rates, warning = self._velocities(names, velocities)
        self.positions.update(fresh)
        for name in fresh:  # a velocity is no older than the position it came with
            self.velocities.pop(name, None)
        self.velocities.update(rates)
        unseen = [name for name in self.joints.names if name not in self.positions]
        if unseen:
            raise Rejected('incomplete', f'waiting for joint {unseen[0]!r}, not seen so far')
        angles = np.array([self.positions[name] for name in self.joints.names])
        angles = np.array(self.joints.signs) * angles + np.array(self.joints.offsets)
        if any(name not in self.velocities for name in self.joints.names):
            return angles, None, warning
        speeds = np.array([self.velocities[name] for name in self.joints.names])
        return angles, np.array(self.joints.signs) * speeds, warning

    def _positions(self, names: Sequence[str], positions: Sequence[float]) -> dict[str, float]:
        if len(names) != len(positions):
            raise Rejected(
                'sizes', f'{len(names)} names but {len(positions)} positions; one each expected'
            )
        fresh = {name: q for name, q in zip(names, positions, strict=True)
                 if name in self.joints.names}  # fmt: skip
        if not fresh:
            raise Rejected(
                'no_joint',
                f'none of the joints {", ".join(self.joints.names)} in it, but '
                f'{listed(names)}; set joint_names or joint_convention',
            )
        for name, q in fresh.items():
            if not math.isfinite(q):
                raise Rejected('not_finite', f'joint {name!r} is {q}; a finite angle expected')
            if abs(q) > FULL_CIRCLE:
                raise Rejected(
                    'degrees', f'joint {name!r} is {q:g}: degrees? radians expected (|q| <= 2 pi)'
                )
        return fresh

    def _velocities(
        self, names: Sequence[str], velocities: Sequence[float]
    ) -> tuple[dict[str, float], str]:
        if not len(velocities):
            return {}, ''
        if len(names) != len(velocities):
            return {}, f'velocities left out: {len(velocities)} for {len(names)} names'
        rates = {name: v for name, v in zip(names, velocities, strict=True)
                 if name in self.joints.names}  # fmt: skip
        for name, v in rates.items():
            if not math.isfinite(v):
                return {}, f'velocities left out: that of joint {name!r} is {v}'
        return rates, ''


def listed(names: Sequence[str], most: int = 6) -> str:
    """Return the first few names as text."""
    if not len(names):
        return 'no joint at all'
    more = f' and {len(names) - most} more' if len(names) > most else ''
    return ', '.join(names[:most]) + more
