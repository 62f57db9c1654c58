# SPDX-License-Identifier: Apache-2.0
"""Poses, and muscles thrown together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import reference
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle
from linkedplane_ros.joints.conventions import THESIS_CONVENTION

DELTOID = BroadMuscle.load('deltoid')


LEAST = 1e-9  # m: what a total may exceed the least one of a scan by


SAME = 1e-11  # m: the rounding of a length, with room for acos near 1


def random_poses(count: int, seed: int) -> Array:
    """Return rotations: flexion -40..120, abduction 0..120, axial rotation +-60 deg."""
    angles = np.random.default_rng(seed).uniform([-40, 0, -60], [120, 120, 60], (count, 3))
    return THESIS_CONVENTION.rotations_and_axes(np.radians(angles))[0]


def deltoid_with_bands(count: int, curve: BroadMuscle = DELTOID) -> BroadMuscle:
    """Return the deltoid with another number of bands, its arrays interpolated along it."""
    s, old = np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, len(curve.band_names))

    def interpolated(values: Array) -> Array:
        columns = values.reshape(len(old), -1).T
        rows = np.column_stack([np.interp(s, old, column) for column in columns])
        return rows.reshape(count, *values.shape[1:])

    return replace(
        curve,
        band_names=tuple(f'band_{i}' for i in range(count)),
        heads=(),
        origins=interpolated(curve.origins),
        insertions=interpolated(curve.insertions),
        sphere_centres=interpolated(curve.sphere_centres),
        sphere_radii=interpolated(curve.sphere_radii),
        plane_angles=interpolated(curve.plane_angles) * 9.0 / count,
    )


def random_muscle(seed: int) -> tuple[BroadMuscle, Array]:
    """Return a muscle of 1 to 6 bands thrown together, and a few rotations from all there are."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 7))
    origins = rng.uniform(-0.08, 0.08, (n, 3))
    insertions = np.array([0.02, 0.0, -0.1]) + rng.uniform(-0.03, 0.03, (n, 3))
    normal = reference.unit(rng.normal(size=3))
    muscle = replace(
        DELTOID,
        band_names=tuple(f'band_{i}' for i in range(n)),
        heads=(),
        origins=origins,
        insertions=insertions,
        sphere_centres=np.array([0.05, 0.0, 0.0]) + rng.uniform(-0.04, 0.04, (n, 3)),
        sphere_radii=rng.uniform(0.01, 0.04, n),
        plane_angles=rng.uniform(-0.6, 0.6, n),
        reference_normal=normal,
    )
    return muscle, Rotation.random(4, rng).as_matrix()


MIXED = ('ground', 'moving', 'humerus', 'moving', 'humerus', 'ground')


def random_muscle_in_frames(seed: int, frame: str) -> tuple[BroadMuscle, Array]:
    """Return a muscle thrown together, its spheres in a frame or (mixed) in all, and rotations."""
    muscle, rotations = random_muscle(seed)
    if frame == 'moving':
        return muscle, rotations
    n = len(muscle.band_names)
    frames = MIXED[:n] if frame == 'mixed' else (frame,) * n
    moving = np.array(frames) == 'moving'
    near = 0.5 * (muscle.sphere_centres - [0.05, 0.0, 0.0])  # the joint, where bands pass by
    fixed = replace(
        muscle,
        sphere_frame=frames,
        sphere_centres=np.where(moving[:, np.newaxis], muscle.sphere_centres, near),
        sphere_radii=np.where(moving, 1.0, 1.6) * muscle.sphere_radii,
    )
    return fixed, rotations
