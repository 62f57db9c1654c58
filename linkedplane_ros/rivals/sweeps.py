# SPDX-License-Identifier: Apache-2.0
"""Motions to measure a muscle over: sweeps of poses, so close together that nothing is missed."""

from __future__ import annotations

import numpy as np

from ..joints.conventions import THESIS_CONVENTION
from ..joints.rotations import rotation_about
from ..muscle.broad_muscle import BroadMuscle
from ..solver.range_check import DEFAULT_RANGE
from ..types import Floats

STEP = np.radians(0.5)  # at most, of the humerus between neighbouring poses
RANDOM_SWEEPS = 12
SCAPTION = np.array((0.5, -(0.75**0.5), 0.0))  # the axis, thesis ch. 5


def step_count(angle: float, step: float) -> int:
    """Return in how many steps to take an angle; angles in files are rounded."""
    return int(np.ceil(angle / step - 1e-4))


def straight_sweep(start: Floats, end: Floats, step: float) -> Floats:
    """Return the poses (m, 3, 3) of a sweep on which the three angles (3,), rad, change evenly.

    The angles' changes add up to no more than a step, so the humerus turns by no more.
    """
    count = step_count(float(np.abs(end - start).sum()), step) + 1
    angles = start + np.linspace(0.0, 1.0, max(count, 2))[:, np.newaxis] * (end - start)
    return THESIS_CONVENTION.rotations_and_axes(angles)[0]


def angle_limits(muscle: BroadMuscle) -> Floats:
    """Return the lowest and highest flexion, abduction and rotation (3, 2), rad."""
    return np.array(muscle.range_of_motion or DEFAULT_RANGE)


def thesis_motions(step: float = STEP) -> list[Floats]:
    """Return the case study's (ch. 5): flexion to 80, abduction to 90, scaption to 60 deg."""
    still = np.zeros(3)
    flexion, abduction = (np.radians(end) for end in ((80.0, 0.0, 0.0), (0.0, 90.0, 0.0)))
    angles = np.linspace(0.0, np.radians(60.0), step_count(np.radians(60.0), step) + 1)
    return [
        straight_sweep(still, flexion, step),
        straight_sweep(still, abduction, step),
        np.array([rotation_about(SCAPTION, angle) for angle in angles]),
    ]


def single_axes(muscle: BroadMuscle, step: float = STEP) -> list[Floats]:
    """Return each coordinate over its range of motion, the other two 0."""
    sweeps = []
    for axis, (low, high) in zip(np.eye(3), angle_limits(muscle), strict=True):
        sweeps.append(straight_sweep(low * axis, high * axis, step))
    return sweeps


def random_sweeps(
    muscle: BroadMuscle, count: int = RANDOM_SWEEPS, seed: int = 0, step: float = STEP
) -> list[Floats]:
    """Return straight sweeps, in the angles, between random poses of the range of motion."""
    low, high = angle_limits(muscle).T
    ends = np.random.default_rng(seed).uniform(low, high, (count, 2, 3))
    return [straight_sweep(start, end, step) for start, end in ends]


def turns_between(rotations: Floats) -> Floats:
    """Return the turns (m - 1, 3), rad, scapula axes, between neighbours, less than pi/2 apart."""
    D = rotations[1:] @ rotations[:-1].swapaxes(1, 2)
    v = 0.5 * np.stack(
        (D[:, 2, 1] - D[:, 1, 2], D[:, 0, 2] - D[:, 2, 0], D[:, 1, 0] - D[:, 0, 1]), axis=1
    )
    sine = np.linalg.norm(v, axis=1, keepdims=True)
    angle = np.arcsin(np.minimum(sine, 1.0))
    return np.asarray(v * np.where(sine > 1e-9, angle / np.maximum(sine, 1e-9), 1.0))


def poses_between(start: Floats, end: Floats, parts: int) -> Floats:
    """Return the poses (parts + 1, 3, 3) of the shortest turn between two near ones."""
    turn = turns_between(np.array((start, end)))[0]
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return np.repeat(start[np.newaxis], parts + 1, axis=0)
    axis = turn / angle
    return np.array([rotation_about(axis, angle * k / parts) @ start for k in range(parts + 1)])
