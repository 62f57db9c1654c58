# SPDX-License-Identifier: Apache-2.0
"""A muscle thrown together, at a pose thrown, as the kernels and as the literal method have it."""

from __future__ import annotations

import reference
from random_muscles import random_muscle_in_frames
from reference import Array

from linkedplane_ros.joints.rotations import matrix_rows
from linkedplane_ros.linked_planes.chain import Band, bands_at
from linkedplane_ros.solver.linked_plane_solver import pack_broad_muscle

FRAMES = ('moving', 'ground', 'humerus', 'mixed')
CASES = [(seed, frame) for seed in range(3, 7) for frame in FRAMES]
THETAS = (-2.9, -1.1, 0.2, 1.4, 2.6)


class Posed:
    """The bands of a muscle of one seed, its spheres in a frame, at a rotation."""

    def __init__(self, seed: int, frame: str) -> None:
        self.muscle, rotations = random_muscle_in_frames(seed, frame)
        self.rotation = rotations[0]
        flat = pack_broad_muscle(self.muscle)
        self.bands: list[Band] = bands_at(flat, matrix_rows(self.rotation.tolist()))

    def literal(self, theta: Array | float) -> list[reference.BandPath]:
        return reference.chain(self.muscle, self.rotation, theta)
