# SPDX-License-Identifier: Apache-2.0
"""A band's path at a solved pose, exactly: two straight parts and an arc between them, compiled."""

from math import cos, inf, pi, sin, sqrt
from typing import Any, NamedTuple

from .band import WRAPPED, wrap
from .chain import Band, plane_at
from .compilation import compiled
from .vectors import Vector, cross, dot, minus, mix, norm, plus, times


class BandPath(NamedTuple):
    """A band's path in its plane: x along u and y along e from its origin P; m, ground frame."""

    P: Vector
    u: Vector
    e: Vector
    n: Vector
    D: float
    wrapped: bool
    a: float  # the circle's centre and radius, the arc's angle
    b: float
    r: float
    arc: float
    tP: float  # the straight parts' lengths and directions
    tS: float
    t1u: float
    t1e: float
    t2u: float
    t2e: float


@compiled
def band_path(band: Band, c: float, s: float, state: int) -> BandPath:
    """Return a band's path at theta, given its cosine and sine, and in its wrap state."""
    section, u = band.section, band.u
    D, tP, tS = section.D, section.tP, section.tS
    P = minus(band.S, times(D, u))
    if state != WRAPPED:
        return BandPath(P, u, u, u, D, False, 0.0, 0.0, 0.0, 0.0, tP, tS, 1.0, 0.0, 1.0, 0.0)
    n = mix(c, band.A, s, band.B)
    n = times(1.0 / norm(n), n)
    d, b, _, _ = plane_at(section, c, s)
    r, arc, t1u, t1e, t2u, t2e = wrap(D, section.a, tP, tS, section.R, d, b)
    return BandPath(P, u, cross(u, n), n, D, True, section.a, b, r, arc, tP, tS, t1u, t1e, t2u, t2e)


@compiled
def off_part(x: float, y: float, size: float) -> float:
    """Return the squared distance of (x, y) from the straight part from (0, 0) to (size, 0)."""
    x -= min(max(x, 0.0), size)
    return x * x + y * y


@compiled
def distance(path: BandPath, X: Vector) -> float:
    """Return the distance (m) of a point X (ground frame) from a path."""
    w = minus(X, path.P)
    x = dot(w, path.u)
    if not path.wrapped:
        across = cross(w, path.u)
        return sqrt(off_part(x, 0.0, path.D) + dot(across, across))
    y = dot(w, path.e)
    t1u, t1e, t2u, t2e = path.t1u, path.t1e, path.t2u, path.t2e
    # from P along t1 to Q; from S back along t2 to T
    near = off_part(x * t1u + y * t1e, y * t1u - x * t1e, path.tP)
    over = path.D - x
    near = min(near, off_part(over * t2u - y * t2e, over * t2e + y * t2u, path.tS))
    # the arc, where X is seen from its centre beyond Q and before T
    x, y = x - path.a, y - path.b
    beyond_Q, before_T = x * t1u + y * t1e >= 0.0, x * t2u + y * t2e <= 0.0
    if (beyond_Q and before_T) or (path.arc >= pi and (beyond_Q or before_T)):
        off = sqrt(x * x + y * y) - path.r
        near = min(near, off * off)
    aside = dot(w, path.n)
    return sqrt(near + aside * aside)


@compiled
def depth_in_spheres(path: BandPath, spheres: Any) -> float:
    """Return how deep (m) a path enters the sphere (centre, radius) that it enters deepest.

    Negative: by how much it keeps off all of them; minus infinity without spheres.
    """
    most = -inf
    for k in range(len(spheres)):
        centre = (spheres[k, 0], spheres[k, 1], spheres[k, 2])
        most = max(most, spheres[k, 3] - distance(path, centre))
    return most


@compiled
def halfway(path: BandPath) -> tuple[Vector, Vector]:
    """Return the point halfway along a path (m, ground frame) and the path's direction there."""
    if not path.wrapped:
        return plus(path.P, times(0.5 * path.D, path.u)), path.u
    bent = path.r * path.arc
    half = 0.5 * (path.tP + bent + path.tS)
    t1u, t1e, t2u, t2e = path.t1u, path.t1e, path.t2u, path.t2e
    if half <= path.tP:
        x, y, tu, te = half * t1u, half * t1e, t1u, t1e
    elif half >= path.tP + bent:
        x, y, tu, te = path.D - half * t2u, -half * t2e, t2u, t2e
    else:
        turn = (half - path.tP) / path.r
        c, s = cos(turn), sin(turn)
        tu, te = t1u * c + t1e * s, t1e * c - t1u * s
        x, y = path.a - path.r * te, path.b + path.r * tu
    return plus(path.P, mix(x, path.u, y, path.e)), mix(tu, path.u, te, path.e)
