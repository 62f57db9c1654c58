# SPDX-License-Identifier: Apache-2.0
"""What was measured of a muscle: lengths and moment arms, and at which poses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..joints.conventions import JointConvention
from ..joints.rotations import rotation_about
from ..types import Floats

# Turns from the arm at the side about an axis that stays in the scapula (thesis ch. 5): x lateral,
# y anterior, z superior, right-handed; scaption about the axis 30 deg lateral of posterior.
MOTIONS: Mapping[str, tuple[float, float, float]] = {
    'flexion': (1.0, 0.0, 0.0),
    'abduction': (0.0, -1.0, 0.0),
    'scaption': (0.5, -math.sqrt(0.75), 0.0),
    'rotation': (0.0, 0.0, 1.0),
}


@dataclass(frozen=True)
class Measurement:
    """What was measured of a band at a pose: a length, a moment arm, or both."""

    part: str
    """The head or band, as the table names it."""
    band: int
    """The number of the model's band that it is compared with: of a head, the representing one."""
    motion: str
    """The motion, or the coordinate that the moment arm is about."""
    angles: tuple[float, ...]
    """rad, the angle of the motion, or the convention's three angles."""
    length: float
    """m; NaN: not measured."""
    arm: float
    """m, positive where shortening continues the motion; NaN: not measured."""
    weight: float = 1.0
    """Of the squared deviations."""
    convention: JointConvention | None = None
    """What three angles mean; None for the angle of a motion."""

    @property
    def angle(self) -> float:
        """rad, the angle of the motion or of the coordinate."""
        if self.convention is None:
            return self.angles[0]
        return self.angles[self.convention.coordinates.index(self.motion)]

    def pose(self) -> tuple[Floats, Floats]:
        """Return the pose.

        Returns
        -------
        rotation : Floats
            (3, 3) humerus -> scapula.
        axis : Floats
            (3,) what the moment arm is about, in the scapula frame.

        """
        if self.convention is None:
            axis = np.array(MOTIONS[self.motion])
            return rotation_about(axis, self.angles[0]), axis
        rotation, axes = self.convention.rotation_and_axes(self.angles)
        return rotation, axes[:, self.convention.coordinates.index(self.motion)]


@dataclass(frozen=True)
class Data:
    """A table of measurements, and how it was read."""

    path: Path
    measurements: tuple[Measurement, ...]
    angle_scale: float
    """What the angles of motions were multiplied by."""
    step: float | None
    """rad, of which curves are taken at multiples; None: at the table's own angles."""

    @property
    def reading(self) -> str:
        """How the table was read, for reports."""
        convention = self.measurements[0].convention
        if convention is not None:
            return f'angles in {convention.name}'
        angles = 'angles as they stand'
        if self.angle_scale != 1.0:
            angles = f'angles times {self.angle_scale:g}'
        return angles + (f', every {math.degrees(self.step):g} deg' if self.step else '')
