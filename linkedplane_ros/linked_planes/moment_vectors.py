# SPDX-License-Identifier: Apache-2.0
"""Moment vectors -dL/domega of all bands, exactly (thesis eq. 5.1; spec section 4).

domega is an infinitesimal rotation of the humerus about the ground axes. What a band's length does
has two parts: its own, at a fixed theta, and the one that every band shares because theta follows
the pose, dtheta/domega = -(d2E/dtheta domega) / (d2E/dtheta2). A prime is d/dtheta.

`motion` says what moves. None is the ball joint: the humerus turns, with the insertions and HM; all
else stands. Otherwise it is one bone of a placed muscle that turns or slides (bones.py), and
domega is that turn or slide.
"""

from math import cos, sin

from .band import EXTENDED, WRAPPED, length_by_plane, wrap
from .bones import BoneMotion, centre_moves, line_moves, normal_moves
from .chain import Band, Section, meets_edge, plane_at, state_at
from .compilation import compiled
from .layout import GROUND, HUMERAL_POINT, HUMERUS, NORMAL, Muscle, vector
from .vectors import (
    ZERO,
    Rotation,
    Vector,
    blend,
    cross,
    dot,
    minus,
    mix,
    norm,
    plus,
    times,
    turned,
)

RIM = 1e-6  # of a radius: how near to a touched rim the edge's place is lost to rounding
STEADY = 1e-6  # rad: how far theta may be from the floor of its valley
FLAT = 1e-12  # m/rad: slopes that are rounding
SAME = 1e-6  # relative: derivatives that differ by less are the same


@compiled
def ends_move(band: Band, motion: BoneMotion | None, f: Vector) -> Vector:
    """Return d(f.(S - P))/domega for a fixed f: S turns with the humerus."""
    if motion is None:
        return cross(band.S, f)
    return line_moves(motion, band, f)


@compiled
def tilt(band: Band, motion: BoneMotion | None, x: Vector) -> Vector:
    """Return d(u.x)/domega for a fixed x across the line: u turns as its ends move."""
    return times(1.0 / band.section.D, ends_move(band, motion, x))


@compiled
def sphere_moves(band: Band, HM: Vector, motion: BoneMotion | None, f: Vector) -> Vector:
    """Return d(f.(C - P))/domega for a fixed f: the sphere's frame turns with HM (thesis ch. 5).

    A sphere on the humerus turns with it, one on the ground stands still.
    """
    if motion is not None:
        return centre_moves(motion, band, HM, f)
    if band.frame == GROUND:
        return ZERO
    if band.frame == HUMERUS:
        return cross(plus(minus(band.S, times(band.section.D, band.u)), band.p), f)
    moment = cross(band.p, f)
    mx, my, mz = dot(moment, band.x), dot(moment, band.y), dot(moment, band.z)
    k = 1.0 / band.lever
    return cross(HM, mix(k * mz, band.y, -k * (my + band.skew * mx), band.z))


@compiled
def first_turn(band: Band, motion: BoneMotion | None, N: Vector) -> Vector:
    """Return dpsi/domega of the first band's plane, which follows the reference normal N."""
    uN = cross(band.u, N)
    W = times(-dot(N, band.u) / dot(uN, uN), tilt(band, motion, uN))
    if motion is None:
        return W
    return plus(W, times(1.0 / dot(uN, uN), normal_moves(motion, N, uN)))


@compiled
def next_turn(
    W: Vector, dW: Vector, J: float, n: Vector, last: Band, band: Band, motion: BoneMotion | None
) -> tuple[Vector, Vector]:
    """Return dpsi/domega of a band's plane, at a fixed theta, and its prime.

    It follows the plane before it, that of the band `last`: of normal n and turns W, dW and J.
    """
    e = cross(last.u, n)
    nu, eps, mu = dot(n, band.u), dot(e, band.u), dot(last.u, band.u)
    k = 1.0 / max(eps * eps + mu * mu, 1e-300)  # 1 / (1 - nu^2)
    eps_D, last_nu_D, nu_D = eps / last.section.D, nu / last.section.D, nu / band.section.D
    # mu W + eps tilt(last, n) - nu tilt(band, u x n), and its prime
    top = mix(mu, W, eps_D, ends_move(last, motion, n))
    top = minus(top, times(nu_D, ends_move(band, motion, cross(band.u, n))))
    dlast = ends_move(last, motion, mix(eps_D, e, -last_nu_D, n))
    dband = cross(band.u, mix(nu_D, e, eps / band.section.D, n))
    dband = ends_move(band, motion, dband)
    dtop = blend(mu, dW, J, dlast, -J, dband)
    return times(k, top), mix(k, dtop, 2.0 * nu * eps * J * k * k, top)


@compiled
def pull(
    band: Band, HM: Vector, n: Vector, plane: tuple[float, float, float, float], W: Vector,
    dW: Vector, motion: BoneMotion | None,
) -> tuple[float, float, float, Vector, Vector]:  # fmt: skip
    """Return a wrapped band's L (m), dL/dpsi, d2L/dpsi2 and, at fixed theta, dL/domega, its prime.

    dL = t2.dS + (t1 - t2).dC - (arc d / r) n.dC + d ((t1 - t2).u + arc a / r) n.du + dL/dpsi dpsi
    (spec section 4, with dc = dC - dd n - d dn and dd = dC.n + (C - P).dn)
    """
    d, b, J, _ = plane
    section, u, e = band.section, band.u, cross(band.u, n)
    r, arc, t1u, t1e, t2u, t2e = wrap(section.D, section.a, section.tP, section.tS, section.R, d, b)
    Lpsi, Lpsi2 = length_by_plane(d, b, r, arc, t1u, t1e, t2u, t2e)
    k = 1.0 / r
    dd, dr = J * b, -J * d * b * k
    turn_1, turn_2 = -J * d * t1e * k, -J * d * t2e * k  # of t1 and t2 in the plane
    open_u, open_e = t1u - t2u, t1e - t2e
    dopen_u, dopen_e = t2e * turn_2 - t1e * turn_1, t1u * turn_1 - t2u * turn_2
    off = arc * d * k
    doff = ((turn_1 - turn_2) * d + arc * dd - off * dr) * k
    h = d * open_u + off * section.a
    dh = dd * open_u + d * dopen_u + doff * section.a

    # what pulls at the insertion, the turn of the line included, and what pushes the sphere
    h_D, dh_D = h / section.D, dh / section.D
    end = blend(t2u, u, t2e, e, h_D, n)
    dend = blend(-t2e * turn_2, u, t2u * turn_2 + h_D * J, e, dh_D - J * t2e, n)
    push = blend(open_u, u, open_e, e, -off, n)
    dpush = blend(dopen_u, u, dopen_e - J * off, e, -J * open_e - doff, n)
    g = blend(1.0, ends_move(band, motion, end), 1.0, sphere_moves(band, HM, motion, push), Lpsi, W)
    dg = plus(ends_move(band, motion, dend), sphere_moves(band, HM, motion, dpush))
    dg = blend(1.0, dg, Lpsi2 * J, W, Lpsi, dW)
    return section.tP + r * arc + section.tS, Lpsi, Lpsi2, g, dg


@compiled
def touches_rim(section: Section, d: float, b: float) -> bool:
    """Return whether a band at its edge touches the sphere's rim: both kinds of edge meet there."""
    return abs(b) <= RIM * section.R and abs(d) >= (1.0 - RIM * RIM) * section.R


@compiled
def stands_at_edge(band: Band, plane: tuple[float, float, float, float], i: int, held: int) -> bool:
    """Return whether theta keeps the i-th band at its edge: `held`, or another at the same edge."""
    return i == held or meets_edge(band.section, plane[0], plane[1])


@compiled
def edge_follows(
    band: Band, HM: Vector, n: Vector, plane: tuple[float, float, float, float], W: Vector,
    motion: BoneMotion | None,
) -> Vector:  # fmt: skip
    """Return dtheta/domega where theta keeps a band at the edge of its sphere: d, or b, stays.

    Where the line touches the sphere's rim the place where d stays turns infinitely fast; that
    where b stays is the edge of the lines that run into the sphere.
    """
    d, b, J, _ = plane
    if band.section.kind == EXTENDED or touches_rim(band.section, d, b):  # e for n, -d for b
        n, b = cross(band.u, n), -d
    tilted = times(band.section.a, tilt(band, motion, n))
    drift = minus(sphere_moves(band, HM, motion, n), tilted)
    return times(-1.0 / (b * J), plus(drift, times(b, W)))


@compiled
def differs(a: Vector, b: Vector) -> bool:
    """Return whether two vectors differ by more than rounding."""
    return norm(minus(a, b)) > SAME * (norm(a) + norm(b))


@compiled
def muscle_state(
    muscle: Muscle,
    rotation: Rotation,
    bands: list[Band],
    theta: float,
    held: int,
    lengths: list[float],
    moments: list[float],
    states: list[int],
    motion: BoneMotion | None,
) -> bool:
    """Fill in lengths (n, m), moment vectors (3 n, m, ground axes) and wrap states (n).

    For a slide of a bone: forces (3 n) in place of moment vectors.

    Return whether theta's derivative is one-sided, and so those of the wrapped bands: at a corner
    of two edges, where a valley ends at an edge, where a line touches its sphere's rim, and beside
    a theta at which a plane vanishes: there the plane that turns fastest with theta stays.
    """
    HM = turned(rotation, vector(muscle, HUMERAL_POINT))
    c, s = cos(theta), sin(theta)
    Ett, Etw = 0.0, ZERO  # d2E/dtheta2 and d2E/dtheta domega
    follow = ZERO  # dtheta/domega
    fastest, stays = 1.0, ZERO  # of the planes that turn faster than theta; dtheta to stop it
    one_sided = False
    shared = [0.0] * len(bands)  # dL/dtheta
    turning = -1  # the last band whose plane's turn matters
    planes = [plane_at(band.section, c, s) for band in bands]
    for i in range(len(bands)):
        d, b, _, _ = planes[i]
        states[i] = state_at(bands[i].section, d, b, i, held)
        if states[i] == WRAPPED or (held >= 0 and stands_at_edge(bands[i], planes[i], i, held)):
            turning = i
    last, n, J, W, dW = bands[0], ZERO, 1.0, ZERO, ZERO
    first = True
    for i in range(len(bands)):
        band = bands[i]
        if i <= turning:
            if i == 0:
                W = first_turn(band, motion, vector(muscle, NORMAL))
            else:
                W, dW = next_turn(W, dW, J, n, last, band, motion)
            n = mix(c, band.A, s, band.B)
            n = times(1.0 / norm(n), n)
            last, J = band, planes[i][2]
        if states[i] == WRAPPED:
            lengths[i], Lpsi, Lpsi2, g, dg = pull(band, HM, n, planes[i], W, dW, motion)
            shared[i] = Lpsi * J
            Ett += Lpsi2 * J * J + Lpsi * planes[i][3]
            Etw = plus(Etw, dg)
            if abs(J) > fastest:
                fastest, stays = abs(J), times(-1.0 / J, W)
        else:
            lengths[i] = band.section.D
            g = ends_move(band, motion, band.u)
        if held >= 0 and stands_at_edge(band, planes[i], i, held):
            turn = edge_follows(band, HM, n, planes[i], W, motion)
            one_sided = one_sided or touches_rim(band.section, planes[i][0], planes[i][1])
            one_sided = one_sided or (not first and differs(turn, follow))
            if first or i == held:
                follow = turn
            first = False
        moments[3 * i], moments[3 * i + 1], moments[3 * i + 2] = g
    slope, most = 0.0, 0.0  # dE/dtheta, and its largest part
    for each in shared:
        slope += each
        most = max(most, abs(each))
    if held >= 0:
        one_sided = most > FLAT and (one_sided or abs(slope) <= SAME * most)
    elif Ett > 0.0 and abs(slope) <= STEADY * Ett:
        follow = times(-1.0 / Ett, Etw)
    elif most > FLAT:  # where a plane all but vanishes
        one_sided, follow = True, stays
    for i in range(len(bands)):
        for k in range(3):
            moments[3 * i + k] = -(moments[3 * i + k] + shared[i] * follow[k])
    return one_sided
