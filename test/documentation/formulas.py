# SPDX-License-Identifier: Apache-2.0
"""The formulas of the derivation, as they stand there; the numbers in comments are the page's.

Nothing here is the solver's. `reference.py` has the spec's other way to the same, without
derivatives. Lengths in m, angles in rad, ground axes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from reference import Array

from linkedplane_ros import BroadMuscle, WrapState

cross = np.cross
norm = np.linalg.norm


class Band(NamedTuple):
    """A posed band: what does not depend on theta."""

    S: Array
    D: float
    u: Array
    p: Array
    frame: str
    xyz: Array
    lever: float
    skew: float
    a: float
    rho2: float
    tP: float
    tS: float
    R: float
    kind: str
    A: Array
    B: Array


def humeral_point(muscle: BroadMuscle, rotation: Array) -> Array:
    """Return HM, ground frame; anything where no sphere moves with it."""
    return np.zeros(3) if muscle.humeral_point is None else rotation @ muscle.humeral_point


def moving_frame(P: Array, HM: Array, SC: Array) -> tuple[Array, float, float]:
    """Return the axes x, y, z (rows), lever and skew of a moving frame, (2)."""
    lever = norm(HM - P)
    x, q = (HM - P) / lever, SC - P
    across = norm(cross(x, q))
    z = cross(x, q) / across
    return np.array([x, cross(z, x), z]), lever, q @ x / across


def posed(muscle: BroadMuscle, rotation: Array) -> list[Band]:
    """Return the bands, (1) to (6)."""
    HM = humeral_point(muscle, rotation)
    A = B = np.zeros(3)
    bands = []
    for i, P in enumerate(muscle.origins):
        S = rotation @ muscle.insertions[i]
        D = norm(S - P)  # (1)
        u = (S - P) / D
        frame, c = muscle.sphere_frames[i], muscle.sphere_centres[i]
        xyz, lever, skew = (np.eye(3), 1.0, 0.0)
        C = rotation @ c if frame == 'humerus' else c
        if frame == 'moving':
            xyz, lever, skew = moving_frame(P, HM, muscle.ground_point)
            C = P + xyz.T @ c  # (3)
        p = C - P
        R = muscle.sphere_radii[i]
        a, rho2 = p @ u, norm(cross(p, u)) ** 2  # (4)
        outside = min(rho2 + a**2, rho2 + (D - a) ** 2) - R**2
        tP, tS = (np.sqrt(max(rho2 + along**2 - R**2, 0.0)) for along in (a, D - a))
        kind = 'PIERCED' if rho2 < R**2 and 0.0 < a < D else 'BESIDE'
        kind = 'INSIDE' if outside < 0.0 else kind
        if i == 0:  # (5)
            N = muscle.reference_normal
            A = N - (N @ u) * u
            B = cross(u, A)
        else:  # (6)
            phi = muscle.plane_angles[i]
            A, B = (np.cos(phi) * (X - (X @ u) * u) + np.sin(phi) * cross(u, X) for X in (A, B))
        bands.append(Band(S, D, u, p, frame, xyz, lever, skew, a, rho2, tP, tS, R, kind, A, B))
    return bands


class Plane(NamedTuple):
    """A band's plane at a theta: (7) to (9)."""

    n: Array
    e: Array
    d: float
    b: float
    J: float
    dJ: float


def plane(band: Band, theta: float) -> Plane:
    c, s = np.cos(theta), np.sin(theta)
    A, B, u, p = band.A, band.B, band.u, band.p
    k = (A @ A * c * c + 2.0 * (A @ B) * c * s + B @ B * s * s) ** -0.5  # (7)
    n = k * (A * c + B * s)
    pu = cross(p, u)
    d, b = k * (p @ A * c + p @ B * s), k * (pu @ A * c + pu @ B * s)  # (8)
    J = cross(A, B) @ u * k**2  # (9)
    dJ = -2.0 * J * k**2 * ((B @ B - A @ A) * c * s + A @ B * (c * c - s * s))
    return Plane(n, cross(u, n), d, b, J, dJ)


class Wrap(NamedTuple):
    """A wrapped band in its plane: (10) to (13), (17) and (18)."""

    r: float
    t1: Array  # along u and e
    t2: Array
    arc: float
    L: float
    Lpsi: float
    Lpsi2: float


def wrapped(band: Band, d: float, b: float) -> Wrap:
    a, over, tP, tS = band.a, band.D - band.a, band.tP, band.tS
    r = np.sqrt(band.R**2 - d**2)  # (10)
    t1 = np.array([a * tP - b * r, a * r + b * tP]) / (tP**2 + r**2)  # (11)
    t2 = np.array([over * tS - b * r, -over * r - b * tS]) / (tS**2 + r**2)
    (t1u, t1e), (t2u, t2e) = t1, t2
    arc = np.arctan2(t1e * t2u - t1u * t2e, t1u * t2u + t1e * t2e) % (2.0 * np.pi)  # (12)
    L = tP + r * arc + tS  # (13)
    open_e = t1e - t2e
    bulge = b / r * arc + open_e  # (17)
    bend = (arc * (1.0 - (b / r) ** 2) + b / r * open_e + t1e * t1u - t2e * t2u) / r  # (18)
    return Wrap(r, t1, t2, arc, L, -d * bulge, d**2 * bend - b * bulge)


def state_of(band: Band, d: float, b: float) -> int:
    """Return the wrap state, by the page's table."""
    if band.kind == 'BESIDE' and abs(d) >= band.R:
        return WrapState.MISSED
    if band.kind == 'BESIDE' and b <= 0.0:
        return WrapState.CLEAR
    return WrapState.INSIDE if band.kind == 'INSIDE' else WrapState.WRAPPED


def at_an_edge(band: Band, at: Plane) -> bool:
    """Return whether theta holds a band where it would jump onto its sphere."""
    return band.kind == 'BESIDE' and at.b > 0.0 and abs(abs(at.d) / band.R - 1.0) < 1e-9


def tilt(band: Band, f: Array) -> Array:
    return cross(band.S, f) / band.D  # (24)


def sphere_moves(band: Band, HM: Array, f: Array) -> Array:
    if band.frame != 'moving':
        return cross(band.S - band.D * band.u + band.p, f) * (band.frame == 'humerus')
    x, y, z = band.xyz
    mx, my, mz = (axis @ cross(band.p, f) for axis in (x, y, z))
    return cross(HM, (mz * y - (my + band.skew * mx) * z) / band.lever)  # (25)


def turns(bands: list[Band], planes: list[Plane], N: Array) -> list[tuple[Array, Array]]:
    """Return W and its prime of every band."""
    uN = cross(bands[0].u, N)
    W, dW = -(N @ bands[0].u) / (uN @ uN) * tilt(bands[0], uN), np.zeros(3)  # (26)
    found = [(W, dW)]
    for last, at, band in zip(bands, planes, bands[1:], strict=False):
        n, e, J = at.n, at.e, at.J
        nu, eps, mu = n @ band.u, e @ band.u, last.u @ band.u  # (27)
        size = mu**2 + eps**2
        top = mu * W + eps * tilt(last, n) - nu * tilt(band, cross(band.u, n))
        dtop = mu * dW + J * (eps * tilt(last, e) - nu * tilt(last, n))  # (28)
        dtop -= J * (nu * tilt(band, cross(band.u, e)) + eps * tilt(band, cross(band.u, n)))
        W, dW = top / size, dtop / size + 2.0 * nu * eps * J / size**2 * top
        found.append((W, dW))
    return found


def pulls(band: Band, at: Plane, w: Wrap, W: Array, dW: Array, HM: Array) -> tuple[Array, Array]:
    """Return g and its prime of a wrapped band."""
    (n, e, d, b, J, _), (t1u, t1e), (t2u, t2e) = at, w.t1, w.t2
    open_u, open_e = t1u - t2u, t1e - t2e
    off = w.arc * d / w.r  # (29)
    h = d * open_u + off * band.a
    end = t2u * band.u + t2e * e + h / band.D * n
    push = open_u * band.u + open_e * e - off * n
    g = cross(band.S, end) + sphere_moves(band, HM, push) + w.Lpsi * W  # (30)
    turn_1, turn_2 = -J * d * t1e / w.r, -J * d * t2e / w.r
    dd, dr = J * b, -J * d * b / w.r
    dopen_u, dopen_e = t2e * turn_2 - t1e * turn_1, t1u * turn_1 - t2u * turn_2  # (32)
    doff = ((turn_1 - turn_2) * d + w.arc * dd - off * dr) / w.r
    dh = dd * open_u + d * dopen_u + doff * band.a
    dend = -t2e * turn_2 * band.u + (t2u * turn_2 + h / band.D * J) * e
    dend += (dh / band.D - J * t2e) * n
    dpush = dopen_u * band.u + (dopen_e - J * off) * e - (J * open_e + doff) * n
    dg = cross(band.S, dend) + sphere_moves(band, HM, dpush) + w.Lpsi2 * J * W + w.Lpsi * dW
    return g, dg


def by_the_page(muscle: BroadMuscle, rotation: Array, theta: float) -> tuple[Array, Array, Array]:
    """Return lengths (n,), moment vectors (n, 3) and wrap states (n,), (1) to (34)."""
    bands = posed(muscle, rotation)
    planes = [plane(band, theta) for band in bands]
    HM = humeral_point(muscle, rotation)
    Ett, Etw, follow = 0.0, np.zeros(3), np.zeros(3)
    lengths, slopes, shared, states = [], [], [], []
    edge = None
    for band, at, (W, dW) in zip(
        bands, planes, turns(bands, planes, muscle.reference_normal), strict=True
    ):
        held = at_an_edge(band, at)
        states.append(WrapState.MISSED if held else state_of(band, at.d, at.b))
        if held:  # (34)
            drift = sphere_moves(band, HM, at.n) - band.a * tilt(band, at.n) + at.b * W
            edge = -drift / (at.b * at.J)
        if states[-1] == WrapState.WRAPPED:
            w = wrapped(band, at.d, at.b)
            g, dg = pulls(band, at, w, W, dW, HM)
            Ett += w.Lpsi2 * at.J**2 + w.Lpsi * at.dJ  # (19)
            Etw = Etw + dg
            lengths.append(w.L)
            shared.append(w.Lpsi * at.J)
        else:
            g = cross(band.S, band.u)
            lengths.append(band.D)
            shared.append(0.0)
        slopes.append(g)
    if edge is not None:
        follow = edge
    elif Ett > 0.0:
        follow = -Etw / Ett  # (31)
    return (
        np.array(lengths),
        -(np.array(slopes) + np.outer(shared, follow)),  # (33)
        np.array(states),
    )
