# SPDX-License-Identifier: Apache-2.0
"""Poses of bones, and muscles whose points are spread over bones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from random_muscles import random_muscle_in_frames
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle
from linkedplane_ros.muscle.bones import Bones

Poses = dict[str, tuple[Array, Array]]

NAMES = ('scapula', 'clavicle', 'humerus')


def girdle_poses(count: int, seed: int) -> Poses:
    """Return random poses of clavicle and humerus, shifts included: R (count, 3, 3), t (count, 3).

    The humerus as in the range of motion; the clavicle by up to 15 deg about each axis.
    """
    from random_muscles import random_poses

    rng = np.random.default_rng(seed)
    turns = rng.uniform(-1.0, 1.0, (count, 3)) * np.radians(15.0)
    return {
        'clavicle': (Rotation.from_rotvec(turns).as_matrix(), rng.uniform(-8e-3, 8e-3, (count, 3))),
        'humerus': (random_poses(count, seed), rng.uniform(-4e-3, 4e-3, (count, 3))),
    }


def at_pose(poses: Poses, k: int) -> Poses:
    """Return the k-th of many poses."""
    return {bone: (R[k], t[k]) for bone, (R, t) in poses.items()}


def with_poses(poses: Poses, chosen: Array) -> Poses:
    """Return some of many poses."""
    return {bone: (R[chosen], t[chosen]) for bone, (R, t) in poses.items()}


def moved(pose: tuple[Array, Array], twist: Array) -> tuple[Array, Array]:
    """Return poses (..., 3, 3), (..., 3) after a turn and a slide (..., 6) about the ground."""
    Q = Rotation.from_rotvec(np.array(twist[..., :3]).reshape(-1, 3)).as_matrix()
    Q = Q.reshape(*twist.shape[:-1], 3, 3)
    R, t = pose
    return Q @ R, np.einsum('...ij,...j->...i', Q, t) + twist[..., 3:]


def random_muscle_on_bones(seed: int) -> tuple[BroadMuscle, Poses]:
    """Return a muscle thrown together, all its points on random bones, and a few poses of these.

    Points are written so that the muscle is an ordinary one at rest. The first bone, world, has
    none: wrenches on all others add up to zero.
    """
    rng = np.random.default_rng(seed)
    muscle, rotations = random_muscle_in_frames(seed, ('mixed', 'moving', 'humerus')[seed % 3])
    n = len(muscle.band_names)
    names = ('world', *NAMES)

    def pick(count: int) -> tuple[str, ...]:
        return tuple(names[k] for k in rng.integers(1, 4, count))

    frames = tuple(
        'moving' if frame == 'moving' else each
        for frame, each in zip(muscle.sphere_frames, pick(n), strict=True)
    )
    HM, SC, N = pick(3)
    bones = Bones(names, pick(n), pick(n), SC, HM, N)
    k = len(muscle.interference_names)
    spread = replace(muscle, sphere_frame=frames, bones=bones, interference_bones=pick(k))
    count = len(rotations)
    poses = {
        name: (
            Rotation.from_rotvec(0.4 * rng.uniform(-1.0, 1.0, (count, 3))).as_matrix(),
            rng.uniform(-0.01, 0.01, (count, 3)),
        )
        for name in NAMES[:2]
    }
    poses['humerus'] = (rotations, rng.uniform(-0.01, 0.01, (count, 3)))
    return spread, poses
