# SPDX-License-Identifier: Apache-2.0
"""The chain's kernels: from the values of its coordinates to the bones' poses and screws.

A pose is (3, 4): a rotation and, in the last column, a point. A screw (w, v) is the motion at unit
speed: w turns, v is the velocity of the point of the body that is at the frame's origin.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..joints.rotations import matrix_rows, rotation_rows
from ..linked_planes.compilation import compiled, entry
from ..linked_planes.vectors import Rotation, Vector, cross, dot, minus, plus, times, turned
from ..types import Floats

Integers = npt.NDArray[np.int64]

STILL, TURNING, SLIDING = range(3)


PARENT, KIND, SOURCE = range(3)  # of a joint's integers
AXIS, FACTOR, OFFSET, NUMBERS = (
    12,
    15,
    16,
    17,
)  # where they start in its numbers; its place is first


class Chain(NamedTuple):
    """A tree of j joints and the bones it moves, as the kernel takes it."""

    joints: Integers
    """(j, 3) of joint i, which moves link i + 1: the link that it hangs from, an earlier one or the
    root, 0; STILL, TURNING or SLIDING; the coordinate that moves it, -1 if none does."""
    numbers: Floats
    """(j, NUMBERS) its frame in its parent link, as (3, 4); its unit axis; factor and offset of its
    value, of the coordinate's."""
    bones: Integers
    """(1 + k,) the bones' links, the ground's first."""
    frames: Floats
    """(1 + k, 3, 4) the bones' frames in their links."""
    ways: Integers
    """(k, j) 1 for a joint between root and bone, -1 between root and ground, 0 if both or none."""


@compiled
def column(matrix: Any, j: int) -> Vector:
    """Return a column of a matrix of three rows."""
    return matrix[0][j], matrix[1][j], matrix[2][j]


@compiled
def product(a: Rotation, b: Rotation) -> Rotation:
    """Return the product of two matrices, by rows."""
    (b11, b12, b13), (b21, b22, b23), (b31, b32, b33) = b
    x, y, z = (b11, b21, b31), (b12, b22, b32), (b13, b23, b33)
    p, q, r = a
    return (
        (dot(p, x), dot(p, y), dot(p, z)),
        (dot(q, x), dot(q, y), dot(q, z)),
        (dot(r, x), dot(r, y), dot(r, z)),
    )


@compiled
def transposed(a: Rotation) -> Rotation:
    """Return the transpose of a matrix, by rows."""
    (a11, a12, a13), (a21, a22, a23), (a31, a32, a33) = a
    return (a11, a21, a31), (a12, a22, a32), (a13, a23, a33)


@compiled
def beyond(link: Any, frame: Any) -> tuple[Rotation, Vector]:
    """Return the pose of a frame of a link, both (3, 4)."""
    R = matrix_rows(link)
    return product(R, matrix_rows(frame)), plus(column(link, 3), turned(R, column(frame, 3)))


@compiled
def fill_pose(pose: Any, rotation: Rotation, point: Vector) -> None:
    """Fill in a pose (3, 4)."""
    for i in range(3):
        row = rotation[i]
        pose[i, 0], pose[i, 1], pose[i, 2], pose[i, 3] = row[0], row[1], row[2], point[i]


@compiled
def move_links(joints: Any, numbers: Any, values: Any, links: Any, screws: Any) -> None:
    """Fill in the links' poses (j + 1, 3, 4) and the joints' screws (j, 6), in the root's frame."""
    fill_pose(links[0], ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))
    for i in range(len(joints)):
        parent, kind, source = joints[i, PARENT], joints[i, KIND], joints[i, SOURCE]
        n = numbers[i]
        R, o = matrix_rows(links[parent]), column(links[parent], 3)
        o = plus(o, turned(R, (n[3], n[7], n[11])))
        R = product(R, ((n[0], n[1], n[2]), (n[4], n[5], n[6]), (n[8], n[9], n[10])))
        q = n[OFFSET]
        if source >= 0:
            q += n[FACTOR] * values[source]
        axis = n[AXIS], n[AXIS + 1], n[AXIS + 2]
        w, v = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if kind == TURNING:
            w = turned(R, axis)
            v = cross(o, w)
            R = product(R, rotation_rows(axis, q))
        elif kind == SLIDING:
            v = turned(R, axis)
            o = plus(o, times(q, v))
        fill_pose(links[i + 1], R, o)
        for c in range(3):
            screws[i, c], screws[i, 3 + c] = w[c], v[c]


@entry
def pose_bones(
    joints: Integers,
    numbers: Floats,
    bones: Integers,
    frames: Floats,
    ways: Integers,
    values: Floats,
    poses: Floats,
    screws: Floats,
) -> None:
    """Fill in poses (m, k, 3, 4) and screws (m, d, k, 6) at values (m, d).

    All are in the ground's frame; `joints` to `ways` are the chain's.

    A bone's T is T_link T_frame, seen from the ground T_ground^-1 T. The screw of a coordinate is
    the sum of those of the joints that it moves, less the ground's own motion: what the bone does,
    seen from the ground.
    """
    links, own = np.empty((len(joints) + 1, 3, 4)), np.empty((len(joints), 6))
    for m in range(len(values)):
        move_links(joints, numbers, values[m], links, own)
        G, g = beyond(links[bones[0]], frames[0])
        G = transposed(G)
        for k in range(len(bones) - 1):
            R, o = beyond(links[bones[k + 1]], frames[k + 1])
            fill_pose(poses[m, k], product(G, R), turned(G, minus(o, g)))
            screws[m, :, k, :] = 0.0
            for i in range(len(joints)):
                source, sign = joints[i, SOURCE], ways[k, i]
                if sign == 0 or source < 0:
                    continue
                s = sign * numbers[i, FACTOR]
                w = own[i, 0], own[i, 1], own[i, 2]
                v = plus((own[i, 3], own[i, 4], own[i, 5]), cross(w, g))
                w, v = turned(G, w), turned(G, v)
                for c in range(3):
                    screws[m, source, k, c] += s * w[c]
                    screws[m, source, k, 3 + c] += s * v[c]
