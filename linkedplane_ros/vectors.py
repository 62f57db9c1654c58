"""Three-vectors as plain tuples: what the solver's formulas are written in, compiled or not."""

from math import sqrt

from .compiled import compiled

Vector = tuple[float, float, float]


@compiled
def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@compiled
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@compiled
def times(k: float, a: Vector) -> Vector:
    """Return k a."""
    return (k * a[0], k * a[1], k * a[2])


@compiled
def mix(j: float, a: Vector, k: float, b: Vector) -> Vector:
    """Return j a + k b."""
    return (j * a[0] + k * b[0], j * a[1] + k * b[1], j * a[2] + k * b[2])


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def norm(a: Vector) -> float:
    """Return the length of a."""
    return sqrt(dot(a, a))


@compiled
def turned(rotation: tuple[Vector, Vector, Vector], a: Vector) -> Vector:
    """Return the rotation (its three rows) applied to a."""
    return (dot(rotation[0], a), dot(rotation[1], a), dot(rotation[2], a))
