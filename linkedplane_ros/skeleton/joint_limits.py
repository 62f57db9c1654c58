# SPDX-License-Identifier: Apache-2.0
"""Values far outside the limits of a skeleton's joints: of another unit or sign, most likely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..joints.articulation import PRISMATIC
from ..types import Bools, Floats
from .skeleton import Skeleton

MARGIN = 0.1  # of a joint's range: so far outside may be a subject, farther is doubted


@dataclass(frozen=True, eq=False)
class JointLimits:
    """The limits of the joints that move bones, as far as they have any.

    Joints that are limited to one value are taken for joints whose URDF leaves its limits out.
    """

    coordinates: tuple[str, ...]
    sliding: tuple[bool, ...]
    """Whether a coordinate is m, else it is rad."""
    lower: Floats
    upper: Floats
    """(d,) rad or m; infinite where a joint has none, or moves no bone."""

    @classmethod
    def from_skeleton(cls, skeleton: Skeleton) -> JointLimits:
        """Return those of a skeleton for a muscle's bones."""
        lower, upper = np.array(skeleton.limits).reshape(-1, 2).T
        moving = set(skeleton.moving)
        limited = [name in moving for name in skeleton.coordinates] & (lower < upper)
        return cls(
            skeleton.coordinates,
            tuple(kind == PRISMATIC for kind in skeleton.kinds),
            np.where(limited, lower, -np.inf),
            np.where(limited, upper, np.inf),
        )

    def find_beyond(self, values: Floats) -> Bools:
        """Return which values (m, d) are outside by more than a tenth of the joint's range."""
        margin = MARGIN * (self.upper - self.lower)
        return np.asarray((values < self.lower - margin) | (values > self.upper + margin))

    def count_beyond(self, values: Floats) -> int:
        """Return how many of m have a value beyond."""
        return int(np.sum(self.find_beyond(values).any(axis=1)))

    def describe(self, k: int, low: float, high: float, unit_said: bool) -> str:
        """Return in words what joint k has met, low to high (rad or m), its limits and the cause.

        Parameters
        ----------
        k
            Which coordinate.
        low, high
            The values that were met, rad or m.
        unit_said
            Whether the recording or the user says that angles are what they are taken for.
        """
        to_unit, unit = (1.0, 'm') if self.sliding[k] else (np.degrees(1.0), 'deg')
        ends = to_unit * np.array((low, high, self.lower[k], self.upper[k]))
        met, limits = (f'{a:.4g} to {b:.4g} {unit}' for a, b in ends.reshape(2, 2).tolist())
        smaller, cause = (1e-3, 'mm?') if self.sliding[k] else (np.radians(1.0), 'degrees?')
        causes = []
        if self._holds(k, -high, -low):
            causes.append('the other sign?')
        if self._holds(k, smaller * low, smaller * high) and (self.sliding[k] or not unit_said):
            causes.append(cause)
        likely = ' '.join(causes or ['another joint, or another skeleton?'])
        return f'{self.coordinates[k]} {met}, its limits are {limits}; {likely}'

    def _holds(self, k: int, low: float, high: float) -> bool:
        """Return whether joint k may have such values."""
        beyond = self.find_beyond(np.outer((low, high), np.ones(len(self.coordinates))))
        return not beyond[:, k].any()
