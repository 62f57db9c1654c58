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


class Chain(NamedTuple):
    """A tree of j joints and the bones it moves, as arrays; joint i's child is link i + 1."""

    parents: Integers
    """(j,) the link that a joint hangs from, before its own; 0 is the root."""
    kinds: Integers
    """(j,) STILL, TURNING or SLIDING."""
    places: Floats
    """(j, 3, 4) the joint's frame in its parent link."""
    axes: Floats
    """(j, 3) of length 1, in the joint's frame."""
    sources: Integers
    """(j,) the coordinate that moves a joint, -1 if none does."""
    factors: Floats
    """(j,) what a joint takes of its coordinate,"""
    offsets: Floats
    """(j,) and what it has beside."""
    bones: Integers
    """(1 + k,) the bones' links, the ground's first."""
    frames: Floats
    """(k, 3, 4) the moving bones' frames in their links."""
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
def fill_pose(pose: Any, rotation: Rotation, point: Vector) -> None:
    """Fill in a pose (3, 4)."""
    for i in range(3):
        row = rotation[i]
        pose[i, 0], pose[i, 1], pose[i, 2], pose[i, 3] = row[0], row[1], row[2], point[i]


@compiled
def move_links(chain: Chain, values: Any, links: Any, screws: Any) -> None:
    """Fill in the links' poses (j + 1, 3, 4) and the joints' screws (j, 6), in the root's frame."""
    fill_pose(links[0], ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))
    for i in range(len(chain.parents)):
        parent = links[chain.parents[i]]
        R, o = matrix_rows(parent), column(parent, 3)
        o = plus(o, turned(R, column(chain.places[i], 3)))
        R = product(R, matrix_rows(chain.places[i]))
        source, kind = chain.sources[i], chain.kinds[i]
        q = chain.offsets[i]
        if source >= 0:
            q += chain.factors[i] * values[source]
        axis = chain.axes[i, 0], chain.axes[i, 1], chain.axes[i, 2]
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
def pose_bones(chain: Chain, values: Any, poses: Any, screws: Any) -> None:
    """Fill in poses (m, k, 3, 4) and screws (m, d, k, 6) at values (m, d), in the ground's frame.

    T_k = T_ground^-1 T_link T_frame. The screw of a coordinate is the sum of those of the joints
    that it moves, less the ground's own motion: what the bone does, seen from the ground.
    """
    joints = len(chain.parents)
    links, own = np.empty((joints + 1, 3, 4)), np.empty((joints, 6))
    for m in range(len(values)):
        move_links(chain, values[m], links, own)
        ground = links[chain.bones[0]]
        G, g = transposed(matrix_rows(ground)), column(ground, 3)
        for k in range(len(chain.frames)):
            link = links[chain.bones[k + 1]]
            R, o = matrix_rows(link), column(link, 3)
            o = minus(plus(o, turned(R, column(chain.frames[k], 3))), g)
            R = product(R, matrix_rows(chain.frames[k]))
            fill_pose(poses[m, k], product(G, R), turned(G, o))
            screws[m, :, k, :] = 0.0
            for i in range(joints):
                sign = chain.ways[k, i]
                if sign == 0 or chain.sources[i] < 0:
                    continue
                s = sign * chain.factors[i]
                w = own[i, 0], own[i, 1], own[i, 2]
                v = plus((own[i, 3], own[i, 4], own[i, 5]), cross(w, g))
                w, v = turned(G, w), turned(G, v)
                for c in range(3):
                    screws[m, chain.sources[i], k, c] += s * w[c]
                    screws[m, chain.sources[i], k, 3 + c] += s * v[c]
