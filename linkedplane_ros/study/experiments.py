# SPDX-License-Identifier: Apache-2.0
"""The simulated experiments: lengths and moment arms over three motions (thesis ch. 5).

Axes are those of the right scapula: x lateral, y anterior, z superior. Each motion starts with the
arm at the side and turns the humerus about one axis that stays where it is in the scapula. Moment
arms are about that axis, by r = -dL/dq: positive where shortening carries the motion on (a flexor
in flexion, an abductor in abduction and scaption).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import LinkedPlaneError
from ..joints.rotations import rotation_about
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import MuscleStates
from ..types import Floats, Point

STEP = math.radians(10.0)  # from pose to pose (thesis ch. 5)
CUBIC = 3  # the degree of the polynomial through a length curve (thesis ch. 5)
HALF = 0.5  # simulated moment arms, before the thesis compares them with elderly cadavers (ch. 5)


@dataclass(frozen=True)
class AxisMotion:
    """A rotation of the humerus, from the arm at the side, about an axis fixed in the scapula."""

    name: str
    axis: Point
    """Unit vector, scapula frame; the rotation about it is right-handed."""
    last: float
    """The largest angle, rad."""

    def angles(self, step: float = STEP) -> Floats:
        """Return the angles (m,), rad, from 0 to the last one."""
        return np.linspace(0.0, self.last, round(self.last / step) + 1)

    def rotate(self, angle: float) -> AxisMotion:
        """Return the same motion in a plane rotated about the vertical (z) by an angle, rad."""
        x, y, z = (rotation_about(np.array((0.0, 0.0, 1.0)), angle) @ self.axis).tolist()
        return replace(self, axis=(x, y, z))


# Axes and ranges of thesis ch. 5. Scaption is about the axis 30 deg lateral of posterior.
MOTIONS = (
    AxisMotion('flexion', (1.0, 0.0, 0.0), math.radians(80.0)),
    AxisMotion('abduction', (0.0, -1.0, 0.0), math.radians(90.0)),
    AxisMotion('scaption', (0.5, -math.sqrt(0.75), 0.0), math.radians(60.0)),
)


@dataclass(frozen=True, eq=False)
class Experiment:
    """A motion and the muscle at each of its m poses; n bands."""

    motion: AxisMotion
    angles: Floats
    """(m,) rad"""
    states: MuscleStates
    arms: Floats
    """(m, n) exact moment arms about the motion's axis, m, multiplied by `scale`."""
    scale: float
    """The factor of the moment arms: 1, or the thesis's HALF. Lengths are never scaled."""

    @property
    def lengths(self) -> Floats:
        """(m, n) band lengths, m."""
        return self.states.lengths

    @property
    def cubic_arms(self) -> Floats:
        """(m, n) moment arms as the thesis computes them, m, multiplied by `scale`."""
        return self.scale * cubic_arms(self.angles, self.lengths)

    def column(self, head: str) -> int:
        """Return the index of the band that represents a head."""
        muscle = self.states.solver.muscle
        (band,) = (each.represented_by for each in muscle.heads if each.name == head)
        return muscle.band_names.index(band)


def simulate_motion(
    solver: LinkedPlaneSolver,
    motion: AxisMotion,
    angles: Floats | None = None,
    scale: float = 1.0,
) -> Experiment:
    """Solve a motion.

    Parameters
    ----------
    solver
        Of the right shoulder.
    motion
        What is moved.
    angles
        (m,) rad; None: every 10 deg.
    scale
        What the moment arms are multiplied by.

    Raises
    ------
    LinkedPlaneError
        Where a band has no plane at a pose.
    """
    angles = motion.angles() if angles is None else angles
    axis = np.array(motion.axis)
    rotations = [rotation_about(axis, angle) for angle in angles.tolist()]
    states = solver.solve_batch(rotations)
    return Experiment(motion, angles, states, scale * (states.moment_vectors @ axis), scale)


def simulate_motions(
    muscle: BroadMuscle, motions: Sequence[AxisMotion] = MOTIONS, scale: float = 1.0
) -> list[Experiment]:
    """Solve motions every 10 deg: 26 poses for the thesis's three, the arm at the side in each."""
    solver = LinkedPlaneSolver(muscle)
    return [simulate_motion(solver, motion, scale=scale) for motion in motions]


def cubic_arms(angles: Floats, lengths: Floats) -> Floats:
    """Return moment arms as the thesis computes them: a cubic through each length curve, derived.

    r = -dL/dq (thesis ch. 5, eq. 5.1; the thesis gives no sign, this one is ours and OpenSim's).

    Parameters
    ----------
    angles
        (m,) rad, at least 4.
    lengths
        (m, n) m.

    Returns
    -------
    arms
        (m, n) m.

    Raises
    ------
    LinkedPlaneError
        For fewer angles.
    """
    if len(angles) <= CUBIC:
        raise LinkedPlaneError(f'{len(angles)} poses; more than {CUBIC} expected, for a cubic')
    arms = np.empty(lengths.shape)
    for k, column in enumerate(lengths.T):
        cubic = np.polynomial.Polynomial.fit(angles, column, CUBIC)
        arms[:, k] = -cubic.deriv()(angles)
    return arms
