# SPDX-License-Identifier: Apache-2.0
"""Three-vectors as plain tuples: what the solver's formulas are written in, compiled or not."""

from math import sqrt

from .compilation import compiled

Vector = tuple[float, float, float]
Rotation = tuple[Vector, Vector, Vector]  # the rows of its matrix

ZERO = (0.0, 0.0, 0.0)


@compiled
def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    ax, ay, az = a
    bx, by, bz = b
    return ax + bx, ay + by, az + bz


@compiled
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    ax, ay, az = a
    bx, by, bz = b
    return ax - bx, ay - by, az - bz


@compiled
def times(k: float, a: Vector) -> Vector:
    """Return k a."""
    ax, ay, az = a
    return k * ax, k * ay, k * az


@compiled
def mix(j: float, a: Vector, k: float, b: Vector) -> Vector:
    """Return j a + k b."""
    ax, ay, az = a
    bx, by, bz = b
    return j * ax + k * bx, j * ay + k * by, j * az + k * bz


@compiled
def blend(j: float, a: Vector, k: float, b: Vector, m: float, c: Vector) -> Vector:
    """Return j a + k b + m c."""
    ax, ay, az = a
    bx, by, bz = b
    cx, cy, cz = c
    return j * ax + k * bx + m * cx, j * ay + k * by + m * cy, j * az + k * bz + m * cz


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product of a and b."""
    ax, ay, az = a
    bx, by, bz = b
    return ax * bx + ay * by + az * bz


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product a x b."""
    ax, ay, az = a
    bx, by, bz = b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@compiled
def norm(a: Vector) -> float:
    """Return the length of a."""
    ax, ay, az = a
    return sqrt(ax * ax + ay * ay + az * az)


@compiled
def turned(rotation: Rotation, a: Vector) -> Vector:
    """Return the rotation (its three rows) applied to a."""
    x, y, z = rotation
    return dot(x, a), dot(y, a), dot(z, a)
