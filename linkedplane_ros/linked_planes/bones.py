# SPDX-License-Identifier: Apache-2.0
"""Bones that move: a muscle's points placed in the ground frame, and how they move (spec bones.md).

A bone's pose is a rotation R and a shift t: its point x stands at R x + t. Placed, a muscle is
solved as it is with all bones at rest. A small motion of a bone is a twist: a turn dw about the
ground's axes, and a slide dv of what stands at the ground's origin; its point at x moves by
dv + dw x x.
"""

from typing import Any, NamedTuple

from .chain import Band
from .compilation import compiled
from .layout import (
    CENTRE,
    GROUND,
    GROUND_POINT,
    HUMERAL_POINT,
    INSERTION,
    MOVING,
    NORMAL,
    ORIGIN,
    Muscle,
    band_bones,
    band_count,
    band_numbers,
    band_place,
    point_bones,
    vector,
)
from .vectors import ZERO, Rotation, Vector, cross, dot, minus, mix, plus, times, turned

REST: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class BoneMotion(NamedTuple):
    """A turn or a slide of one bone, and what of a placed muscle it may take along."""

    bone: int
    slides: bool
    normal_bone: int
    ground_point_bone: int
    humeral_point_bone: int
    SC: Vector


@compiled
def posed_rows(poses: Any, bone: int) -> tuple[Rotation, Vector]:
    """Return R, by its rows, and t of a bone; poses (k, 3, 4) are (R | t) of those that move."""
    pose = poses[bone - 1]
    R = (
        (pose[0][0], pose[0][1], pose[0][2]),
        (pose[1][0], pose[1][1], pose[1][2]),
        (pose[2][0], pose[2][1], pose[2][2]),
    )
    return R, (pose[0][3], pose[1][3], pose[2][3])


@compiled
def place_vector(muscle: Muscle, k: int, poses: Any, bone: int, shift: float) -> None:
    """Place, in a flat muscle, the vector of a bone that starts at the k-th number.

    `shift` is 1 for a point, and 0 for a direction, which turns only.
    """
    if bone > GROUND:
        R, t = posed_rows(poses, bone)
        x, y, z = mix(1.0, turned(R, vector(muscle, k)), shift, t)
        muscle[k], muscle[k + 1], muscle[k + 2] = x, y, z


@compiled
def place_muscle(muscle: Muscle, poses: Any) -> Muscle:
    """Return a flat muscle with all its points where they stand in the ground frame.

    Spheres in moving frames stay in these.
    """
    placed = muscle.copy()
    normal_bone, SC_bone, HM_bone = point_bones(muscle)
    place_vector(placed, NORMAL, poses, normal_bone, 0.0)
    place_vector(placed, GROUND_POINT, poses, SC_bone, 1.0)
    place_vector(placed, HUMERAL_POINT, poses, HM_bone, 1.0)
    for i in range(band_count(muscle)):
        k = band_place(i)
        from_bone, to_bone = band_bones(muscle, i)
        frame = band_numbers(muscle, i)[3]
        place_vector(placed, k + ORIGIN, poses, from_bone, 1.0)
        place_vector(placed, k + INSERTION, poses, to_bone, 1.0)
        place_vector(placed, k + CENTRE, poses, frame, 1.0)
    return placed


@compiled
def bone_motion(placed: Muscle, bone: int, slides: bool) -> BoneMotion:
    """Return a turn of a bone about the ground's axes, or a slide of it."""
    N_bone, SC_bone, HM_bone = point_bones(placed)
    return BoneMotion(bone, slides, N_bone, SC_bone, HM_bone, vector(placed, GROUND_POINT))


@compiled
def moves(motion: BoneMotion, bone: int, x: Vector, f: Vector) -> Vector:
    """Return d(f.x) for a fixed f and a point x of a bone: x cross f of a turn, f of a slide."""
    if bone != motion.bone:
        return ZERO
    return f if motion.slides else cross(x, f)


@compiled
def origin_point(band: Band) -> Vector:
    """Return a band's origin P."""
    return minus(band.S, times(band.section.D, band.u))


@compiled
def line_moves(motion: BoneMotion, band: Band, f: Vector) -> Vector:
    """Return d(f.(S - P)) for a fixed f."""
    ahead = moves(motion, band.insertion_bone, band.S, f)
    return minus(ahead, moves(motion, band.origin_bone, origin_point(band), f))


@compiled
def centre_moves(motion: BoneMotion, band: Band, HM: Vector, f: Vector) -> Vector:
    """Return d(f.(C - P)) for a fixed f, C the sphere's centre.

    A moving frame turns with its x axis, from P to HM, and about it, with SC.
    """
    P = origin_point(band)
    if band.frame != MOVING:
        ahead = moves(motion, band.frame, plus(P, band.p), f)
        return minus(ahead, moves(motion, band.origin_bone, P, f))
    moment = cross(band.p, f)
    mx, my, mz = dot(moment, band.x), dot(moment, band.y), dot(moment, band.z)
    k = 1.0 / band.lever
    at_HM = mix(k * mz, band.y, -k * (my + band.skew * mx), band.z)
    at_SC = times(mx / dot(minus(motion.SC, P), band.y), band.z)
    ahead = plus(
        moves(motion, motion.humeral_point_bone, HM, at_HM),
        moves(motion, motion.ground_point_bone, motion.SC, at_SC),
    )
    return minus(ahead, moves(motion, band.origin_bone, P, plus(at_HM, at_SC)))


@compiled
def normal_moves(motion: BoneMotion, N: Vector, f: Vector) -> Vector:
    """Return d(f.N) for a fixed f: a direction turns with its bone, and does not slide."""
    if motion.slides:
        return ZERO
    return moves(motion, motion.normal_bone, N, f)
