# SPDX-License-Identifier: Apache-2.0
"""One elastic band in its own plane round its own obstacle sphere (thesis ch. 4, App. B and C).

Within its plane a band is described by the line from its origin P to its insertion S and by the
circle in which the plane cuts the sphere: D = |S - P|; (a, b) the circle's centre, from P, along
the line's direction u and along the side e = u x n to which the band bulges; r the circle's radius;
d the distance of the sphere's centre from the plane. A turn of the plane about the line by a small
angle psi changes d by b psi and b by -d psi; everything else about the line and the sphere stays.
"""

from math import atan2, pi, sqrt

from .compilation import compiled

WRAPPED, CLEAR, MISSED, INSIDE = 0, 1, 2, 3

PIERCED = 4  # the line runs through the sphere: the band wraps it in every plane
BESIDE = 5  # the line passes the sphere: the band wraps it only in planes that bulge over it
EXTENDED = 6  # the line's extension meets the sphere: every plane cuts it, those with b > 0 wrap it


@compiled
def obstacle_kind(D: float, a: float, rho2: float, R: float) -> int:
    """Return how a band's line and its sphere meet: PIERCED, BESIDE, EXTENDED or INSIDE.

    D, a in m; rho2 the squared distance (m^2) of the sphere's centre from the line; R in m.
    """
    if a * a + rho2 < R * R or (D - a) * (D - a) + rho2 < R * R:
        return INSIDE
    if 0.0 < a < D:
        return PIERCED if rho2 < R * R else BESIDE
    return BESIDE if rho2 > R * R else EXTENDED


@compiled
def wrap_state(kind: int, R: float, d: float, b: float) -> int:
    """Return WRAPPED, CLEAR, MISSED or INSIDE for a band in a plane at distance d (m).

    The same as the sign of the arc (App. C), without an angle: a band that does not pierce its
    sphere has a positive arc just where the circle's centre lies on the side of the bulge, b > 0.
    """
    if kind == PIERCED:
        return WRAPPED
    if kind == INSIDE:
        return INSIDE
    if kind == BESIDE and abs(d) >= R:
        return MISSED
    return WRAPPED if b > 0.0 else CLEAR


@compiled
def wrap(
    D: float, a: float, tP: float, tS: float, R: float, d: float, b: float
) -> tuple[float, float, float, float, float, float]:
    """Wrap a band round its circle (App. C): return r (m), arc (rad), t1u, t1e, t2u, t2e.

    t1 is the unit tangent from P to the transition point Q, t2 that from the transition point T to
    S, each along (u, e). tP and tS, the lengths of these two straight parts, are those of the
    tangents from P and S to the sphere and do not depend on the plane. The arc, in (0, 2 pi), is
    the turn from t1 to t2.
    """
    r = sqrt(max(R * R - d * d, 1e-30))
    near_P = 1.0 / (tP * tP + r * r)  # 1 / |cP|^2
    near_S = 1.0 / (tS * tS + r * r)
    t1u = (a * tP - b * r) * near_P
    t1e = (a * r + b * tP) * near_P
    t2u = ((D - a) * tS - b * r) * near_S
    t2e = -((D - a) * r + b * tS) * near_S
    arc = atan2(t1e * t2u - t1u * t2e, t1u * t2u + t1e * t2e)
    if arc < 0.0:  # with b <= 0 no more than rounding, where the line just pierces the sphere
        arc = arc + 2.0 * pi if b > 0.0 else 0.0
    return r, arc, t1u, t1e, t2u, t2e


@compiled
def length_by_plane(
    d: float, b: float, r: float, arc: float, t1u: float, t1e: float, t2u: float, t2e: float
) -> tuple[float, float]:
    """Return dL/dpsi (m/rad) and d2L/dpsi2 (m/rad^2) of a wrapped band for a turn of its plane.

    dL = (t1 - t2).dc + arc dr, with dc = -d psi e and r dr = -d dd (spec section 4).
    """
    k = 1.0 / r
    bk = b * k
    open_e = t1e - t2e
    bulge = bk * arc + open_e
    bend = k * (arc * (1.0 - bk * bk) + bk * open_e + t1e * t1u - t2e * t2u)
    return -d * bulge, d * d * bend - b * bulge
