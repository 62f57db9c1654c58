# SPDX-License-Identifier: Apache-2.0
"""What Python calls of the compiled solver for a muscle over several bones."""

from __future__ import annotations

from math import isfinite
from typing import Any

from ..joints.rotations import NOT_FINITE, PROPER, rotation_fault
from ..linked_planes.bones import REST, bone_motion, place_muscle, posed_rows
from ..linked_planes.chain import bands_at
from ..linked_planes.compilation import entry
from ..linked_planes.layout import Muscle, band_count
from ..linked_planes.least_length import solve_theta
from ..linked_planes.moment_vectors import muscle_state
from ..skeleton.kinematics import pose_bones
from .kernels import FARTHEST, NO_PLANE, SOLVED, TOO_FAR, Outcome, mark_wrapped


@entry
def solve_bone_poses(
    muscle: Muscle,
    neutral: float,
    poses: Any,
    start: int,
    stop: int,
    thetas: Any,
    lengths: Any,
    wrenches: Any,
    states: Any,
    one_sided: Any,
) -> Outcome:
    """Fill in the states of the poses (m, k, 3, 4) of k bones that move, from start to stop.

    Wrenches are (m, 2 k, 3 n): for each bone the moments, m, then the forces on it. The last number
    of an outcome is the bone whose rotation is at fault, or the band that has no plane.
    """
    for j in range(start, stop):
        bones = len(poses[j])
        for bone in range(1, bones + 1):
            rotation, (x, y, z) = posed_rows(poses[j], bone)
            fault = rotation_fault(rotation)
            if fault == PROPER and not (isfinite(x) and isfinite(y) and isfinite(z)):
                fault = NOT_FINITE
            elif fault == PROPER and not max(abs(x), abs(y), abs(z)) < FARTHEST:
                fault = TOO_FAR
            if fault != PROPER:
                return j, fault, bone
        placed = place_muscle(muscle, poses[j])
        bands = bands_at(placed, REST)
        if len(bands) < band_count(muscle):
            return j, NO_PLANE, len(bands)
        theta, held = solve_theta(bands, neutral)
        thetas[j] = theta
        corner = False
        for k in range(2 * bones):
            motion = bone_motion(placed, k // 2 + 1, k % 2 == 1)
            filled = lengths[j], wrenches[j][k], states[j]
            corner |= muscle_state(placed, REST, bands, theta, held, *filled, motion)
        mark_wrapped(corner, states[j], one_sided[j])
    return stop, SOLVED, 0


@entry
def answer_bone_poses(
    muscle: Muscle,
    neutral: float,
    poses: Any,
    screws: Any,
    speeds: Any,
    mirror: float,
    theta: Any,
    lengths: Any,
    filled: Any,
    states: Any,
    one_sided: Any,
    wrenches: Any,
    arms: Any,
    lengthening: Any,
) -> Outcome:
    """Fill in all that the node answers to one pose (1, k, 3, 4) and its screws (1, d, k, 6).

    The first arrays are those of `solve_bone_poses` at one pose; wrenches (n, k, 6) are of the side
    whose AXIS_SIGN is mirror, arms (n, d) and lengthening (n,) the same on both.
    """
    done = solve_bone_poses(muscle, neutral, poses, 0, 1, theta, lengths, filled, states, one_sided)
    for i in range(len(lengthening)):
        lengthening[i] = 0.0
        for j in range(len(speeds)):
            arms[i, j] = 0.0
        for k in range(len(poses[0])):
            for c in range(6):
                pull = filled[0, 2 * k + c // 3, 3 * i + c % 3]
                # across the mirror: moments about y and z, forces along x
                wrenches[i, k, c] = pull * mirror if 1 <= c <= 3 else pull
                for j in range(len(speeds)):
                    arms[i, j] += pull * screws[0, j, k, c]
        for j in range(len(speeds)):
            lengthening[i] -= arms[i, j] * speeds[j]
    return done


@entry
def answer_chain(
    muscle: Muscle,
    neutral: float,
    joints: Any,
    numbers: Any,
    bones: Any,
    frames: Any,
    ways: Any,
    values: Any,
    speeds: Any,
    mirror: float,
    own_mirror: float,
    poses: Any,
    screws: Any,
    theta: Any,
    lengths: Any,
    filled: Any,
    states: Any,
    one_sided: Any,
    wrenches: Any,
    arms: Any,
    lengthening: Any,
) -> Outcome:
    """Fill in all that the node answers to the values (1, d) of a skeleton's coordinates.

    `joints` to `ways` are the chain's, own_mirror is AXIS_SIGN of the side that the skeleton is of;
    poses and screws are filled in, too, in right-shoulder form.
    """
    pose_bones(joints, numbers, bones, frames, ways, values, poses, screws)
    if own_mirror < 0.0:
        for k in range(len(poses[0])):
            for i in range(3):
                for j in range(4):
                    if (i == 0) != (j == 0):
                        poses[0, k, i, j] = 0.0 - poses[0, k, i, j]  # no -0.0
            for j in range(len(speeds)):
                for c in range(1, 4):
                    screws[0, j, k, c] = -screws[0, j, k, c]
    return answer_bone_poses(
        muscle,
        neutral,
        poses,
        screws,
        speeds,
        mirror,
        theta,
        lengths,
        filled,
        states,
        one_sided,
        wrenches,
        arms,
        lengthening,
    )
