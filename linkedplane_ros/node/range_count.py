# SPDX-License-Identifier: Apache-2.0
"""What is odd of answers is counted many at a time, in next to no time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..types import Floats

AT_ONCE = 256  # checking one pose alone takes as long as solving it


class OddCounter:
    """Counts poses or values that are odd, many at a time.

    Parameters
    ----------
    count
        Returns how many of many are odd.

    """

    def __init__(self, count: Callable[[Floats], int]) -> None:
        self._count = count
        self._bytes = bytearray()
        self._odd = 0

    def add(self, each: Floats) -> None:
        """Add a pose or values, an array of one shape throughout."""
        self._shape = each.shape
        self._bytes += each.tobytes()
        if len(self._bytes) == AT_ONCE * each.nbytes:
            self._check()

    def take_count(self) -> int:
        """Return how many were odd since the last time."""
        if self._bytes:
            self._check()
        count, self._odd = self._odd, 0
        return count

    def _check(self) -> None:
        self._odd += self._count(np.frombuffer(self._bytes).reshape(-1, *self._shape))
        self._bytes = bytearray()
