# SPDX-License-Identifier: Apache-2.0
"""The motions of an arm that buttons and sliders move: angles and speeds over time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...errors import LinkedPlaneError
from ...joints.conventions import JointConvention
from ...joints.rotations import rotation_about
from ...types import Floats

MEAN_SPEED = 1.2  # rad/s, of a glide
SHORTEST = 0.5  # s, of a glide
PERIOD = 8.0  # s, of a sweep there and back
GAP = 0.25  # s without a drag, after which the next one is a new movement

# The case study (thesis ch. 5): the end poses of its motions, axis and angle, right scapula
CASE_STUDY: Mapping[str, tuple[tuple[float, float, float], float]] = {
    'neutral': ((1.0, 0.0, 0.0), 0.0),
    'flexion 80': ((1.0, 0.0, 0.0), math.radians(80.0)),
    'abduction 90': ((0.0, -1.0, 0.0), math.radians(90.0)),
    'scaption 60': ((0.5, -math.sqrt(0.75), 0.0), math.radians(60.0)),
}


def end_poses(convention: JointConvention) -> dict[str, Floats]:
    """Return the case study's end poses as a convention's angles (3,), rad, by their names.

    A pose that has no angles in the convention (see `JointConvention.angles`) is left out.
    """
    poses = {}
    for name, (axis, angle) in CASE_STUDY.items():
        try:
            poses[name] = convention.angles(rotation_about(np.array(axis), angle)) + 0.0
        except LinkedPlaneError:
            continue
    return poses


@dataclass(frozen=True, eq=False)
class Glide:
    """From one pose to another, with the smoothness of a reach (Flash and Hogan 1985)."""

    start: Floats
    """(d,) rad or m."""
    end: Floats
    begun: float
    """s"""

    @property
    def seconds(self) -> float:
        """How long it takes, s."""
        return max(float(np.abs(self.end - self.start).max()) / MEAN_SPEED, SHORTEST)

    def pose_at(self, now: float) -> tuple[Floats, Floats]:
        """Return angles, rad or m, and speeds, rad/s or m/s, (d,) each."""
        x = min(max((now - self.begun) / self.seconds, 0.0), 1.0)
        path = self.end - self.start
        speed = 30.0 * x * x * (1.0 - x) ** 2 / self.seconds
        return self.start + x**3 * (10.0 - 15.0 * x + 6.0 * x * x) * path, speed * path

    def is_over(self, now: float) -> bool:
        """Return whether the end is reached."""
        return now >= self.begun + self.seconds


@dataclass(frozen=True, eq=False)
class Sweep:
    """One coordinate from its lowest to its highest value and back, repeated."""

    base: Floats
    """(d,) rad or m; the swept coordinate's is not used."""
    coordinate: int
    low: float
    high: float
    begun: float

    def pose_at(self, now: float) -> tuple[Floats, Floats]:
        """Return coordinates and speeds (d,), rad or m, and s; at first the swept one is lowest."""
        pace = 2.0 * math.pi / PERIOD
        angle = pace * (now - self.begun)
        half = 0.5 * (self.high - self.low)
        angles, speeds = self.base.copy(), np.zeros_like(self.base)
        angles[self.coordinate] = self.low + half * (1.0 - math.cos(angle))
        speeds[self.coordinate] = half * pace * math.sin(angle)
        return angles, speeds


class Arm:
    """The arm that sliders and buttons move: its angles and its motion."""

    def __init__(self, rest: Floats) -> None:
        """Start with the coordinates (d,) at rest."""
        self.angles = rest
        self._moved = -math.inf
        self._motions: list[Glide | Sweep] = []

    @property
    def is_moving(self) -> bool:
        """Whether a motion is under way."""
        return bool(self._motions)

    def drag(self, angles: Floats, now: float) -> Floats:
        """Move the arm by hand; return its speeds (d,), rad/s or m/s, since the drag before.

        They are zero at the beginning of a movement, as its start is not known.
        """
        self._motions = []
        since = now - self._moved
        speeds = (angles - self.angles) / since if 1e-3 < since < GAP else np.zeros_like(angles)
        self.angles, self._moved = angles, now
        return speeds

    def stop(self) -> None:
        """End any motion."""
        self._motions = []

    def glide(self, end: Floats, now: float) -> None:
        """Begin a motion to a pose."""
        self._motions = [Glide(self.angles, end, now)]

    def sweep(self, coordinate: int, low: float, high: float, now: float) -> None:
        """Begin a motion to the lowest angle of a coordinate, then sweep it from there."""
        start = self.angles.copy()
        start[coordinate] = low
        there = Glide(self.angles, start, now)
        self._motions = [there, Sweep(start, coordinate, low, high, now + there.seconds)]

    def advance(self, now: float) -> Floats:
        """Continue the motion; return the speeds (d,), rad/s or m/s, zero at rest."""
        if not self._motions:
            return np.zeros_like(self.angles)
        motion = self._motions[0]
        if isinstance(motion, Glide) and motion.is_over(now):
            self._motions.pop(0)
            self.angles = motion.end
            return self.advance(now)
        self.angles, speeds = motion.pose_at(now)
        self._moved = now
        return speeds
