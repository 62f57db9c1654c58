# SPDX-License-Identifier: Apache-2.0
"""A subject's rest from the motion itself: the first second in which the arm hangs still.

Seconds are counted from the first pose, and again from each pose that moves: that is further than
`STILL` from the one that the count began with, raised to `HANGING` or more, earlier than the pose
before it or more than `LONGEST_GAP` later. The rest is the mean of the poses in the first whole
second. An arm that hangs straight down has no plane of elevation; noise would give it any, and a
regression would turn the scapula by it. There the plane is that of the scapula, at which the
published regression gives an average subject the rest that it was made from.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..joints.rotations import as_rotation
from ..types import Floats
from .girdle import Rest

STILL = 0.05  # rad in a second: the speed below which a bone is still, 2.9 deg/s
HANGING = np.pi / 6  # rad, 30 deg: the elevation of the humerus below which the arm hangs
STRAIGHT_DOWN = np.radians(5.0)  # the elevation below which the plane is not relied on
SCAPULAR_PLANE = np.radians(30.0)
SECOND = 10**9  # ns
LONGEST_GAP = SECOND // 4  # between two poses of the second
NOT_STILL = (
    f'the arm has not hung still for a second (turned by less than {STILL:g} rad, raised by less '
    f'than {np.degrees(HANGING):.0f} deg)'
)
BONES = 'humerus', 'scapula', 'clavicle'


@dataclass
class StillSecond:
    """Finds the first second in which the arm hangs still, pose by pose."""

    rest: Rest | None = None
    """What was found; None: nothing so far."""
    start: int = 0
    """The stamp with which that second, or else the count, began, ns."""
    _first: Mapping[str, Floats] = field(default_factory=dict)
    _sums: dict[str, Floats] = field(default_factory=dict)
    _last: int = 0

    def add(self, stamp: int, bones: Mapping[str, Floats]) -> Rest | None:
        """Take in a pose; after the first still second they change nothing.

        Parameters
        ----------
        stamp
            ns.
        bones
            (3, 3) of `humerus` and, where they are known, `scapula` and `clavicle`, against the
            thorax, right shoulder, the model's axes. All of them have to be still.

        Returns
        -------
        Rest or None
            The rest, of the bones that are known (the others are an average subject's); None: no
            still second so far.

        Raises
        ------
        LinkedPlaneError
            For anything but proper rotations.
        """
        if self.rest is not None:
            return self.rest
        turns = {bone: as_rotation(bones[bone]) for bone in BONES if bone in bones}
        if not self._goes_on(stamp, turns):
            self.start, self._first, self._sums = stamp, {}, {}
            if turns['humerus'][2, 2] <= np.cos(HANGING):
                return None
            self._first = turns
        self._last = stamp
        self._sums = {bone: R + self._sums.get(bone, 0.0) for bone, R in turns.items()}
        if stamp - self.start >= SECOND:
            means = {bone: _nearest_rotation(total) for bone, total in self._sums.items()}
            self.rest = _measure_rest(means)
        return self.rest

    def _goes_on(self, stamp: int, turns: Mapping[str, Floats]) -> bool:
        """Return whether a pose is still the one that the count began with."""
        return (
            turns.keys() == self._first.keys()
            and 0 <= stamp - self._last <= LONGEST_GAP
            and turns['humerus'][2, 2] > np.cos(HANGING)
            and all(_angle_between(R, self._first[bone]) < STILL for bone, R in turns.items())
        )


def find_rest(poses: Iterable[tuple[int, Mapping[str, Floats]]]) -> StillSecond:
    """Return the first still second of poses, (stamp, bones) as `StillSecond.add` takes them.

    No pose after it is read; without one, its `rest` is None.
    """
    still = StillSecond()
    for stamp, bones in poses:
        if still.add(stamp, bones) is not None:
            break
    return still


def _measure_rest(means: Mapping[str, Floats]) -> Rest:
    rest = Rest.measured(means.get('scapula'), means.get('clavicle'), means['humerus'])
    if rest.humerus is not None and rest.humerus[1] < STRAIGHT_DOWN:
        return replace(rest, humerus=(SCAPULAR_PLANE, rest.humerus[1]))
    return rest


def _angle_between(a: Floats, b: Floats) -> float:
    """Return the angle, rad, of the turn from one rotation to the other."""
    # |A - B|^2 = 8 sin^2(angle / 2), which keeps its digits near 0, as the trace does not
    return float(2.0 * np.arcsin(min(1.0, float(np.linalg.norm(a - b)) / np.sqrt(8.0))))


def _nearest_rotation(matrix: Floats) -> Floats:
    """Return the rotation nearest to a sum of rotations that are near each other: their mean."""
    U, _, V = np.linalg.svd(matrix)
    return np.asarray(U @ V)
