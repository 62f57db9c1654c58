"""Moment vectors -dL/domega of all bands, exactly (thesis eq. 5.1; spec section 4).

domega is an infinitesimal rotation of the humerus about the ground axes. What a band's length does
has two parts: its own, at a fixed theta, and the one that every band shares because theta follows
the pose, dtheta/domega = -(d2E/dtheta domega) / (d2E/dtheta2). A prime is d/dtheta.
"""

from math import cos, sin, sqrt
from typing import NamedTuple

from .band import WRAPPED, length_by_plane, wrap
from .compiled import compiled
from .linked_planes import Band, Constants, Plane, plane_at, state_at, vector
from .vectors import Vector, cross, dot, minus, mix, plus, times, turned

ZERO = (0.0, 0.0, 0.0)


class Turn(NamedTuple):
    """How a band's plane turns about its line with the pose at a fixed theta, and its prime."""

    W: Vector  # dpsi/domega
    dW: Vector


class Pull(NamedTuple):
    """What turning the humerus does to one band at a fixed theta, and its prime."""

    g: Vector  # dL/domega, m/rad
    dg: Vector
    dL: float  # dL/dtheta, m/rad


@compiled
def tilt(band: Band, x: Vector) -> Vector:
    """Return d(u.x)/domega for a fixed x across the line: u turns as its end S moves."""
    return times(1.0 / band.D, cross(band.S, x))


@compiled
def sphere_moves(band: Band, HM: Vector, f: Vector) -> Vector:
    """Return d(f.C)/domega for a fixed f: the sphere's frame turns with HM (thesis ch. 5)."""
    moment = cross(band.p, f)
    my, mz = dot(moment, band.y), dot(moment, band.z)
    mx = dot(moment, cross(band.y, band.z))
    push = mix(mz, band.y, -(my + band.skew * mx), band.z)
    return times(1.0 / band.lever, cross(HM, push))


@compiled
def first_turn(band: Band, N: Vector) -> Turn:
    """Return how the first band's plane follows its line against the reference normal N."""
    uN = cross(band.u, N)
    return Turn(times(-dot(N, band.u) / dot(uN, uN), tilt(band, uN)), ZERO)


@compiled
def next_turn(before: Turn, last: Band, n: Vector, J: float, band: Band) -> Turn:
    """Return how a band's plane follows the plane before it, of normal n and dpsi/dtheta J."""
    e = cross(last.u, n)
    nu, eps, mu = dot(n, band.u), dot(e, band.u), dot(last.u, band.u)
    un, ue = cross(band.u, n), cross(band.u, e)
    size2 = max(eps * eps + mu * mu, 1e-300)  # 1 - nu^2
    top = mix(mu, before.W, eps, tilt(last, n))
    top = minus(top, times(nu, tilt(band, un)))
    dtop = mix(mu, before.dW, -J * nu, tilt(last, n))
    dtop = plus(dtop, times(J * eps, tilt(last, e)))
    dtop = minus(dtop, mix(J * eps, tilt(band, un), J * nu, tilt(band, ue)))
    shrink = -2.0 * nu * J * eps / size2
    return Turn(times(1.0 / size2, top), mix(1.0 / size2, dtop, -shrink / size2, top))


@compiled
def pull(band: Band, HM: Vector, n: Vector, plane: Plane, turn: Turn) -> Pull:
    """Return what turning the humerus does to a wrapped band (spec section 4).

    dL = t2.dS + (t1 - t2).dC - (arc d / r) n.dC + d ((t1 - t2).u + arc a / r) n.du + dL/dpsi dpsi
    """
    d, b, J, dJ = plane
    u, e = band.u, cross(band.u, n)
    w = wrap(band.D, band.a, band.tP, band.tS, band.R, d, b)
    Lpsi, Lpsi2 = length_by_plane(w, d, b)
    dd, dr = J * b, -J * d * b / w.r
    df1, df2 = -J * d * w.t1e / w.r, -J * d * w.t2e / w.r  # turn of t1 and t2 in the plane
    darc = df1 - df2

    t2 = mix(w.t2u, u, w.t2e, e)
    dt2 = mix(-w.t2e * df2, u, w.t2u * df2, e)
    dt2 = minus(dt2, times(J * w.t2e, n))
    bend_u, bend_e = w.t1u - w.t2u, w.t1e - w.t2e
    dbend_u, dbend_e = -w.t1e * df1 + w.t2e * df2, w.t1u * df1 - w.t2u * df2
    off = w.arc * d / w.r
    doff = (darc * d + w.arc * dd - off * dr) / w.r
    f = minus(mix(bend_u, u, bend_e, e), times(off, n))  # force on the sphere
    df = mix(dbend_u, u, dbend_e - J * off, e)
    df = minus(df, times(J * bend_e + doff, n))
    h = d * bend_u + off * band.a
    dh = dd * bend_u + d * dbend_u + doff * band.a

    g = plus(cross(band.S, t2), sphere_moves(band, HM, f))
    g = plus(g, mix(h, tilt(band, n), Lpsi, turn.W))
    dg = plus(cross(band.S, dt2), sphere_moves(band, HM, df))
    dg = plus(dg, mix(dh, tilt(band, n), h * J, tilt(band, e)))
    dg = plus(dg, mix(Lpsi2 * J, turn.W, Lpsi, turn.dW))
    return Pull(g, dg, Lpsi * J)


@compiled
def edge_follows(band: Band, HM: Vector, n: Vector, plane: Plane, turn: Turn) -> Vector:
    """Return dtheta/domega where theta keeps a band at the edge of its sphere: d, or b, stays."""
    lever = plane.b
    if abs(plane.d) < (1.0 - 1e-6) * band.R:  # the edge at b = 0
        n, lever = cross(band.u, n), -plane.d
    drift = minus(sphere_moves(band, HM, n), times(band.a, tilt(band, n)))
    return times(-1.0 / (lever * plane.J), plus(drift, times(lever, turn.W)))


@compiled
def muscle_state(
    muscle: Constants,
    rotation: tuple[Vector, Vector, Vector],
    bands: list[Band],
    theta: float,
    held: int,
    lengths: list[float],
    moments: list[float],
    states: list[int],
) -> None:
    """Fill in lengths (n, m), moment vectors (3 n, m, ground axes) and wrap states (n)."""
    HM = turned(rotation, vector(muscle.humeral_point, 0))
    c, s = cos(theta), sin(theta)
    Ett, Etw = 0.0, ZERO  # d2E/dtheta2 and d2E/dtheta domega
    follow = ZERO  # dtheta/domega
    shared = [0.0] * len(bands)
    last, n, turn, J = bands[0], ZERO, Turn(ZERO, ZERO), 1.0
    for i in range(len(bands)):
        band = bands[i]
        if i == 0:
            turn = first_turn(band, vector(muscle.reference_normal, 0))
        else:
            turn = next_turn(turn, last, n, J, band)
        n = mix(c, band.A, s, band.B)
        n = times(1.0 / sqrt(max(dot(n, n), 1e-300)), n)
        plane = plane_at(band, c, s)
        last, J = band, plane.J
        states[i] = state_at(band, plane, i == held)
        if states[i] == WRAPPED:
            w = wrap(band.D, band.a, band.tP, band.tS, band.R, plane.d, plane.b)
            lengths[i] = band.tP + w.r * w.arc + band.tS
            g, dg, shared[i] = pull(band, HM, n, plane, turn)
            Lpsi, Lpsi2 = length_by_plane(w, plane.d, plane.b)
            Ett += Lpsi2 * J * J + Lpsi * plane.dJ
            Etw = plus(Etw, dg)
        else:
            lengths[i] = band.D
            g = cross(band.S, band.u)
        if i == held:
            follow = edge_follows(band, HM, n, plane, turn)
        moments[3 * i], moments[3 * i + 1], moments[3 * i + 2] = g
    if held < 0 and Ett > 0.0:
        follow = times(-1.0 / Ett, Etw)
    for i in range(len(bands)):
        for k in range(3):
            moments[3 * i + k] = -(moments[3 * i + k] + shared[i] * follow[k])
