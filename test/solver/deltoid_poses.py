# SPDX-License-Identifier: Apache-2.0
"""The deltoid at random poses."""

from __future__ import annotations

import numpy as np
import reference
from random_muscles import random_poses
from reference import Array

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver

THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
RANGES = np.radians(((-40, 120), (0, 120), (-60, 60)))  # flexion, abduction, rotation

POSES = random_poses(70, seed=21)
BATCH = LinkedPlaneSolver(BroadMuscle.load('deltoid')).solve_batch(POSES)


def rotations_in_range(count: int, seed: int) -> Array:
    """Return random poses (count, 3, 3) of the range of motion."""
    angles = np.random.default_rng(seed).uniform(*RANGES.T, (count, 3))
    return np.array([THESIS.rotation(each) for each in angles])


def literal_moments(muscle: BroadMuscle, poses: Array, neutral: float) -> list[reference.Moments]:
    """Return the reference's moment vectors at poses, by differences of its lengths."""
    return [reference.moment_vectors(muscle, rotation, neutral) for rotation in poses]
