# SPDX-License-Identifier: Apache-2.0
"""Rotations as (3, 3) matrices: made about an axis, and checked before anything relies on them.

With a shift beside them they are poses, (3, 4).
"""

from __future__ import annotations

from math import cos, isfinite, sin
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError
from ..linked_planes.compilation import compiled
from ..linked_planes.vectors import Rotation, cross, dot
from ..types import Floats

PROPER, NOT_FINITE, NOT_ORTHONORMAL, REFLECTION = range(4)
ORTHONORMAL = 1e-6  # how far R^T R may be from the identity
FAULTS = {
    NOT_FINITE: 'a value is not finite; finite numbers expected',
    NOT_ORTHONORMAL: f'R^T R is not the identity within {ORTHONORMAL:g}; a rotation expected',
    REFLECTION: 'its determinant is -1, a reflection; a proper rotation expected',
}


@compiled
def matrix_rows(matrix: Any) -> Rotation:
    """Return the rows of a (3, 3) matrix."""
    return (
        (matrix[0][0], matrix[0][1], matrix[0][2]),
        (matrix[1][0], matrix[1][1], matrix[1][2]),
        (matrix[2][0], matrix[2][1], matrix[2][2]),
    )


@compiled
def rotation_fault(rotation: Rotation) -> int:
    """Return what keeps a matrix, by its rows, from being a proper rotation, or PROPER."""
    x, y, z = rotation
    size = dot(x, x) + dot(y, y) + dot(z, z)
    if not isfinite(size):  # or the square of a finite number is not
        nothing = (0.0, 0.0, 0.0)
        left = dot(nothing, x) + dot(nothing, y) + dot(nothing, z)  # 0, or NaN
        return NOT_ORTHONORMAL if left == 0.0 else NOT_FINITE
    off = max(abs(dot(x, x) - 1.0), abs(dot(y, y) - 1.0), abs(dot(z, z) - 1.0))
    off = max(off, abs(dot(x, y)), abs(dot(y, z)), abs(dot(z, x)))
    if off > ORTHONORMAL:
        return NOT_ORTHONORMAL
    return REFLECTION if dot(cross(x, y), z) < 0.0 else PROPER


@compiled
def rotation_rows(axis: Any, angle: float) -> Rotation:
    """Return the rows of the right-handed rotation about a unit axis by an angle in rad."""
    x, y, z = axis[0], axis[1], axis[2]
    c, s = cos(angle), sin(angle)
    k = 1.0 - c
    return (
        (c + k * x * x, k * x * y - s * z, k * x * z + s * y),
        (k * x * y + s * z, c + k * y * y, k * y * z - s * x),
        (k * x * z - s * y, k * y * z + s * x, c + k * z * z),
    )


def rotation_about(axis: Floats, angle: float) -> Floats:
    """Return the (3, 3) right-handed rotation about a unit axis (3,) by an angle in rad."""
    return np.array(rotation_rows(axis, angle))


def as_rotation(rotation: npt.ArrayLike) -> Floats:
    """Return a copy of a (3, 3) proper rotation; LinkedPlaneError for anything else."""
    matrix = as_matrix(rotation)
    fault = rotation_fault(matrix_rows(matrix.tolist()))
    if fault != PROPER:
        raise LinkedPlaneError(f'rotation: {FAULTS[fault]}')
    return matrix


def as_matrix(rotation: npt.ArrayLike) -> Floats:
    """Return a copy of a (3, 3) matrix of any numbers; LinkedPlaneError for anything else."""
    matrix = as_floats('rotation', rotation, '(3, 3)')
    if matrix.shape != (3, 3):
        raise LinkedPlaneError(f'rotation: shape {matrix.shape} given, (3, 3) expected')
    return matrix


def as_matrices(rotations: npt.ArrayLike) -> Floats:
    """Return a copy of (m, 3, 3) matrices of any numbers; m may be 0."""
    matrices = as_floats('rotations', rotations, '(m, 3, 3)')
    if matrices.shape == (0,):
        matrices = np.empty((0, 3, 3))
    if matrices.ndim != 3 or matrices.shape[1:] != (3, 3):
        raise LinkedPlaneError(f'rotations: shape {matrices.shape} given, (m, 3, 3) expected')
    return matrices


def as_floats(name: str, values: npt.ArrayLike, expected: str) -> Floats:
    """Return a copy of an array of numbers; LinkedPlaneError, which names it, for others."""
    if isinstance(values, np.ndarray) and values.dtype == np.float64:
        return values.copy()
    try:
        array = np.asarray(values)
        if array.dtype.kind in 'fiu' or array.size == 0:
            return np.array(array, dtype=np.float64, order='C')
    except (TypeError, ValueError):
        pass
    raise LinkedPlaneError(f'{name}: not an array of numbers; real ones, {expected} expected')


def compose_poses(outer: Floats, inner: Floats) -> Floats:
    """Return poses (..., 3, 4): what stands at `inner` in a frame that stands at `outer`."""
    R = outer[..., :3]
    return np.concatenate([R @ inner[..., :3], R @ inner[..., 3:] + outer[..., 3:]], axis=-1)


def invert_poses(poses: Floats) -> Floats:
    """Return the inverse of poses (..., 3, 4)."""
    R = poses[..., :3].swapaxes(-2, -1)
    return np.concatenate([R, -R @ poses[..., 3:]], axis=-1)
