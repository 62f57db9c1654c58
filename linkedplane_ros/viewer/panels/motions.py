"""Where the arm goes when a button or a slider moves it: angles and their speeds over time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...joints.conventions import JointConvention, turn
from ...types import Floats, Intervals

UNHURRIED = 1.2  # rad/s: the mean speed of a glide
SHORTEST = 0.5  # s
PERIOD = 8.0  # s there and back, of a sweep
GAP = 0.25  # s: what comes later after a message is a new movement
ELEVATED = math.radians(150.0)  # how far sliders elevate an arm whose model does not say
ALL_ROUND = math.radians(120.0)  # how far they turn it

# The case study (thesis ch. 5): the ends of its motions, axis and angle in the right scapula
CASE_STUDY: Mapping[str, tuple[tuple[float, float, float], float]] = {
    'neutral': ((1.0, 0.0, 0.0), 0.0),
    'flexion 80': ((1.0, 0.0, 0.0), math.radians(80.0)),
    'abduction 90': ((0.0, -1.0, 0.0), math.radians(90.0)),
    'scaption 60': ((0.5, -math.sqrt(0.75), 0.0), math.radians(60.0)),
}


def poses(convention: JointConvention) -> dict[str, Floats]:
    """Return the case study's end poses as a convention's angles (3,), rad, by their names.

    A pose that has no angles in it (see `JointConvention.angles`) is left out.
    """
    found = {}
    for name, (axis, angle) in CASE_STUDY.items():
        try:
            found[name] = convention.angles(turn(np.array(axis), angle)) + 0.0
        except ValueError:
            continue
    return found


def ranges(convention: JointConvention, motion: Intervals | None) -> Intervals:
    """Return the lowest and highest angle of each coordinate's slider, rad.

    `motion`: the model's range of flexion, abduction and rotation, for their convention.
    """
    elevates = convention.middle[0] >= 0.0
    if motion is not None and not elevates:
        return motion
    middle = (0.0, ELEVATED) if elevates else (-ALL_ROUND, ALL_ROUND)
    return (-ALL_ROUND, ALL_ROUND), middle, (-ALL_ROUND, ALL_ROUND)


@dataclass(frozen=True, eq=False)
class Glide:
    """From one pose to another, with the smoothness of a reach (Flash and Hogan 1985)."""

    start: Floats
    """(3,) rad."""
    end: Floats
    begun: float
    """s"""

    @property
    def seconds(self) -> float:
        """How long it takes, s."""
        return max(float(np.abs(self.end - self.start).max()) / UNHURRIED, SHORTEST)

    def at(self, now: float) -> tuple[Floats, Floats]:
        """Return angles, rad, and speeds, rad/s, (3,) each."""
        x = min(max((now - self.begun) / self.seconds, 0.0), 1.0)
        way = self.end - self.start
        speed = 30.0 * x * x * (1.0 - x) ** 2 / self.seconds
        return self.start + x**3 * (10.0 - 15.0 * x + 6.0 * x * x) * way, speed * way

    def over(self, now: float) -> bool:
        """Return whether the end is reached."""
        return now >= self.begun + self.seconds


@dataclass(frozen=True, eq=False)
class Sweep:
    """One coordinate from its lowest to its highest angle and back, again and again."""

    base: Floats
    """(3,) rad; the swept coordinate's is not used."""
    coordinate: int
    low: float
    high: float
    begun: float

    def at(self, now: float) -> tuple[Floats, Floats]:
        """Return angles, rad, and speeds, rad/s, (3,) each; at first the coordinate is lowest."""
        pace = 2.0 * math.pi / PERIOD
        angle = pace * (now - self.begun)
        half = 0.5 * (self.high - self.low)
        angles, speeds = self.base.copy(), np.zeros(3)
        angles[self.coordinate] = self.low + half * (1.0 - math.cos(angle))
        speeds[self.coordinate] = half * pace * math.sin(angle)
        return angles, speeds


class Arm:
    """The arm that sliders and buttons move: where it is, and how fast."""

    def __init__(self) -> None:
        """Let it hang."""
        self.angles: Floats = np.zeros(3)
        self._moved = -math.inf
        self._motions: list[Glide | Sweep] = []

    @property
    def moving(self) -> bool:
        """Whether it moves by itself."""
        return bool(self._motions)

    def drag(self, angles: Floats, now: float) -> Floats:
        """Put it somewhere by hand; return the speeds (3,), rad/s, from the place before.

        They are zero at the beginning of a movement: it is not known when that began.
        """
        self._motions = []
        since = now - self._moved
        speeds = (angles - self.angles) / since if 1e-3 < since < GAP else np.zeros(3)
        self.angles, self._moved = angles, now
        return speeds

    def stop(self) -> None:
        """Stay."""
        self._motions = []

    def glide(self, end: Floats, now: float) -> None:
        """Set out for a pose."""
        self._motions = [Glide(self.angles, end, now)]

    def sweep(self, coordinate: int, low: float, high: float, now: float) -> None:
        """Set out for the lowest angle of a coordinate, then sweep it until something else."""
        start = self.angles.copy()
        start[coordinate] = low
        there = Glide(self.angles, start, now)
        self._motions = [there, Sweep(start, coordinate, low, high, now + there.seconds)]

    def at(self, now: float) -> Floats:
        """Move on by itself; return the speeds (3,), rad/s, zero once it rests."""
        if not self._motions:
            return np.zeros(3)
        motion = self._motions[0]
        if isinstance(motion, Glide) and motion.over(now):
            self._motions.pop(0)
            self.angles = motion.end
            return self.at(now)
        self.angles, speeds = motion.at(now)
        self._moved = now
        return speeds
