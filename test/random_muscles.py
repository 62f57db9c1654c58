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


def wild_muscle(seed: int, poses: int) -> tuple[BroadMuscle, Array]:
    """Return a muscle whose planes turn anything but evenly with theta, and rotations.

    Its lines run across each other: for some theta a plane's normal nearly runs along the next
    line. Where they are at right angles to the bit, as in one of eight, it does so exactly.
    """
    muscle, _ = random_muscle_in_frames(seed, ('moving', 'ground', 'humerus', 'mixed')[seed % 4])
    rng = np.random.default_rng((seed, 1))
    n = len(muscle.band_names)
    rotations = Rotation.random(poses, rng).as_matrix()
    wild = replace(
        muscle,
        origins=muscle.origins * rng.uniform(0.5, 2.0, (n, 1)),
        insertions=rng.uniform(-0.1, 0.1, (n, 3)),
        plane_angles=rng.uniform(-np.pi, np.pi, n),
    )
    if seed % 8 >= 2:
        return wild, rotations
    axes = np.eye(3)[np.arange(n) % 3]
    lines = 0.1 * axes
    origins = rng.uniform(-0.05, 0.05, (n, 3)).round(2)
    fixed = replace(
        wild,
        sphere_frame='ground',
        origins=origins,
        insertions=origins + lines,
        sphere_centres=origins + 0.5 * lines + rng.uniform(-0.03, 0.03, (n, 3)),
        plane_angles=np.where(rng.random(n) < 0.5, 0.0, wild.plane_angles),
        reference_normal=np.array([0.0, 0.0, 1.0]),
    )
    angles = rng.normal(size=(poses, 3)) * 10.0 ** rng.uniform(-17.0, -1.0, (poses, 1))
    return fixed, Rotation.from_rotvec(angles).as_matrix()


def absurd_muscle(seed: int, poses: int) -> tuple[BroadMuscle, Array]:
    """Return a muscle of any size up to 10 m, whose planes' normals shrink to rounding, and poses.

    Each line is nearly at right angles to the one before, so that its plane nearly loses the
    direction that it would take over; and spheres are up to a thousand times as large as needed.
    """
    rng = np.random.default_rng((seed, 2))
    n = int(rng.integers(2, 6))
    size = 10.0 ** rng.uniform(-4.0, 0.9)
    lines = np.eye(3)[np.arange(n) % 3]
    lines = lines + 10.0 ** rng.uniform(-9.0, -1.0, (n, 1)) * rng.normal(size=(n, 3))
    lines *= size * 10.0 ** rng.uniform(-4.0, 0.0, (n, 1))
    long = np.linalg.norm(lines, axis=1)[:, np.newaxis]
    origins = rng.uniform(-1.0, 1.0, (n, 3)) * size
    across = rng.normal(size=(n, 3)) * long * 10.0 ** rng.uniform(-4.0, 0.0, (n, 1))
    centres = origins + lines * rng.uniform(-0.2, 1.2, (n, 1)) + across
    radii = np.linalg.norm(across, axis=1) * 10.0 ** rng.uniform(-1.0, 3.0, n)
    muscle = replace(
        DELTOID,
        band_names=tuple(f'band_{i}' for i in range(n)),
        heads=(),
        sphere_frame='ground',
        origins=origins,
        insertions=origins + lines,
        sphere_centres=centres,
        sphere_radii=np.clip(radii, 1e-6, 9.9),
        plane_angles=np.where(rng.random(n) < 0.5, 0.0, rng.uniform(-np.pi, np.pi, n)),
        reference_normal=rng.normal(size=3),
    )
    turns = rng.normal(size=(poses, 3)) * 10.0 ** rng.uniform(-17.0, -1.0, (poses, 1))
    return muscle, Rotation.from_rotvec(turns).as_matrix()


def length_bounds(muscle: BroadMuscle, rotations: Array) -> tuple[Array, Array]:
    """Return the straight lines' lengths (m, n), and the tangents' with a whole turn round."""
    ends = np.einsum('mij,nj->mni', rotations, muscle.insertions)
    centres = reference.sphere_centres(muscle, rotations)
    lines = np.linalg.norm(ends - muscle.origins, axis=2)
    tangents = [
        np.sqrt(np.maximum(((centres - each) ** 2).sum(axis=2) - muscle.sphere_radii**2, 0.0))
        for each in (muscle.origins, ends)
    ]
    longest = tangents[0] + tangents[1] + 2.0 * np.pi * muscle.sphere_radii
    return lines, np.maximum(lines, longest)
