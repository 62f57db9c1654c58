# SPDX-License-Identifier: Apache-2.0
"""Poses outside the range of motion are counted, in next to no time."""

from __future__ import annotations

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats

AT_ONCE = 256  # poses: checking one alone takes as long as solving it


class OutsideCounter:
    """Counts the poses outside a muscle's range of motion, many at a time.

    Parameters
    ----------
    muscle
        Without a range of motion no pose is outside.

    """

    def __init__(self, muscle: BroadMuscle) -> None:
        self._muscle = muscle
        self._poses = bytearray()
        self._outside = 0

    def add(self, rotation: Floats) -> None:
        """Add a pose (3, 3), right-shoulder form."""
        self._poses += rotation.tobytes()
        if len(self._poses) == AT_ONCE * rotation.nbytes:
            self._check_poses()

    def take_count(self) -> int:
        """Return how many were outside since the last time."""
        if self._poses:
            self._check_poses()
        count, self._outside = self._outside, 0
        return count

    def _check_poses(self) -> None:
        rotations = np.frombuffer(self._poses).reshape(-1, 3, 3)
        self._outside += self._muscle.count_outside_range(rotations)
        self._poses = bytearray()
