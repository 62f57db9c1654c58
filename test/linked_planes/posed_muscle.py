# SPDX-License-Identifier: Apache-2.0
"""A muscle thrown together, at a pose thrown, as the kernels and as the literal method have it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import reference
from random_muscles import DELTOID, random_muscle_in_frames, random_poses
from reference import Array

from linkedplane_ros import BroadMuscle
from linkedplane_ros.joints.rotations import matrix_rows
from linkedplane_ros.linked_planes.chain import Band, bands_at
from linkedplane_ros.solver.packing import pack_broad_muscle

FRAMES = ('moving', 'ground', 'humerus', 'mixed')
CASES = [
    *((seed, frame) for seed in range(3, 7) for frame in FRAMES),
    *((seed, 'deltoid') for seed in range(3)),
]
THETAS = (-2.9, -1.1, 0.2, 1.4, 2.6)


def posed_bands(muscle: BroadMuscle, rotation: Array) -> list[Band]:
    """Return the bands of a muscle over a ball joint at a rotation (3, 3)."""
    bones = muscle.bones.number_on_ball_joint(muscle.sphere_frames)
    return bands_at(pack_broad_muscle(muscle, bones), matrix_rows(rotation.tolist()))


class Posed:
    """The bands of a muscle of one seed, its spheres in a frame, at a rotation."""

    def __init__(self, seed: int, frame: str) -> None:
        if frame == 'deltoid':
            self.muscle, rotations = DELTOID, random_poses(1, seed)
        else:
            self.muscle, rotations = random_muscle_in_frames(seed, frame)
        self.rotation = rotations[0]
        self.bands = self.pose(self.muscle)

    def pose(self, muscle: BroadMuscle) -> list[Band]:
        """Return the bands of a muscle at this pose."""
        return posed_bands(muscle, self.rotation)

    def count_from(self, turn: float) -> list[Band]:
        """Return the bands with theta counted from a plane that is turned by an angle, rad."""
        u, N = self.bands[0].u, self.muscle.reference_normal
        across = reference.unit(N - (N @ u) * np.array(u))
        turned = np.cos(turn) * across + np.sin(turn) * np.cross(u, across)
        return self.pose(replace(self.muscle, reference_normal=turned))

    def literal(self, theta: Array | float) -> list[reference.BandPath]:
        return reference.chain(self.muscle, self.rotation, theta)
