# SPDX-License-Identifier: Apache-2.0
"""The linked planes at a pose: the bands, the chain of their planes, E (thesis ch. 4, App. B).

Left unnormalised, every band's plane normal is a fixed combination A cos(theta) + B sin(theta) of
two vectors that depend only on the pose, so the chain of planes is built once per pose.
"""

from math import cos, sin, sqrt
from typing import NamedTuple

from .band import (
    BESIDE,
    CLEAR,
    EXTENDED,
    MISSED,
    PIERCED,
    WRAPPED,
    length_by_plane,
    obstacle_kind,
    wrap,
    wrap_state,
)
from .compilation import compiled
from .layout import (
    GROUND_POINT,
    HUMERAL_POINT,
    HUMERUS,
    MOVING,
    NORMAL,
    Muscle,
    band_bones,
    band_count,
    band_numbers,
    band_vectors,
    vector,
)
from .vectors import ZERO, Rotation, Vector, blend, cross, dot, minus, mix, norm, times, turned

ROUNDING = 1e-12  # of a radius: how well the numbers of a pose tell where an edge is
CANCELLED = 1e-4  # of |A|^2 + |B|^2: a smaller normal, squared, has lost digits in their sum
VANISHING = 1e-14  # of |A|^2 + |B|^2: a smaller normal, squared, has no direction


class Section(NamedTuple):
    """What a band's length at one pose takes besides theta: only numbers, m."""

    D: float  # |S - P|
    a: float  # the sphere's centre along u, from P
    tP: float  # tangent lengths from P and S to the sphere
    tS: float
    R: float  # the sphere's radius
    rho2: float  # the squared distance of its centre from the line, m^2
    dA: float  # p.A, p.B: the centre's distance from the plane, times |A cos + B sin|
    dB: float
    bA: float  # (p x u).A, (p x u).B: the same for its offset b towards the bulge
    bB: float
    AA: float
    AB: float
    BB: float
    kappa: float  # (A x B).u: how fast the plane turns with theta
    kind: int  # PIERCED, BESIDE, EXTENDED or INSIDE


class Band(NamedTuple):
    """One band at one pose, ground frame, m: all of it that does not depend on theta."""

    S: Vector  # insertion
    u: Vector  # from the origin P to S, unit
    p: Vector  # from P to the sphere's centre
    A: Vector  # plane normal, unnormalised: A cos(theta) + B sin(theta)
    B: Vector
    frame: int  # what the sphere moves with: MOVING or a bone
    x: Vector  # axes of a moving frame, for the sphere's motion
    y: Vector
    z: Vector
    lever: float  # |HM - P|
    skew: float  # (SC - P).x / (SC - P).y in that frame
    section: Section
    origin_bone: int
    insertion_bone: int


@compiled
def moving_frame(P: Vector, HM: Vector, SC: Vector) -> tuple[Vector, Vector, Vector, float, float]:
    """Return the axes x, y, z of a band's moving frame, |HM - P| and the skew (thesis ch. 5).

    x points from P to HM, z stands across the plane with SC. |HM - P| is given as 0 where P, HM and
    SC lie in one line, so that there is no such frame.
    """
    x = minus(HM, P)
    lever = norm(x)
    x = times(1.0 / max(lever, 1e-9), x)
    q = minus(SC, P)
    z = cross(x, q)
    across = norm(z)
    if lever < 1e-9 or across < 1e-9:
        return x, x, x, 0.0, 0.0
    z = times(1.0 / across, z)
    return x, cross(z, x), z, lever, dot(q, x) / across


@compiled
def bands_at(muscle: Muscle, rotation: Rotation) -> list[Band]:
    """Pose the muscle: its bands and the chain of their planes, for a humerus -> scapula rotation.

    A band without a line (it ends where it begins), a plane (the normal before it runs along its
    line) or a moving frame of its sphere (P, HM and SC in one line) ends the list early.
    """
    SC = vector(muscle, GROUND_POINT)
    HM = turned(rotation, vector(muscle, HUMERAL_POINT))
    A = vector(muscle, NORMAL)
    B = ZERO
    bands = []
    for i in range(band_count(muscle)):
        P, S, centre = band_vectors(muscle, i)
        R, cos_phi, sin_phi, frame = band_numbers(muscle, i)
        S = turned(rotation, S)
        line = minus(S, P)
        D = norm(line)
        if D < 1e-9:
            break
        u = times(1.0 / D, line)
        x, y, z, lever, skew = ZERO, ZERO, ZERO, 0.0, 0.0
        if frame == MOVING:
            x, y, z, lever, skew = moving_frame(P, HM, SC)
            if lever == 0.0:
                break
            cx, cy, cz = centre
            p = blend(cx, x, cy, y, cz, z)
        elif frame == HUMERUS:
            p = minus(turned(rotation, centre), P)
        else:
            p = minus(centre, P)
        a = dot(p, u)
        # distances from the line by the cross product: no cancellation
        pu = cross(p, u)
        rho2 = dot(pu, pu)
        kind = obstacle_kind(D, a, rho2, R)
        tP = sqrt(max(rho2 + a * a - R * R, 0.0))
        tS = sqrt(max(rho2 + (D - a) * (D - a) - R * R, 0.0))
        # the plane: the reference normal, then the normal of the band before (App. B)
        if i == 0:
            A = mix(1.0, A, -dot(A, u), u)
            B = cross(u, A)
        else:
            A = blend(cos_phi, A, -cos_phi * dot(A, u), u, sin_phi, cross(u, A))
            B = blend(cos_phi, B, -cos_phi * dot(B, u), u, sin_phi, cross(u, B))
        AA, BB = dot(A, A), dot(B, B)
        size2 = AA + BB
        if size2 < 1e-18:
            break
        if size2 < 0.25:  # long chains shrink
            A, B = times(1.0 / sqrt(size2), A), times(1.0 / sqrt(size2), B)
            AA, BB = AA / size2, BB / size2
        section = Section(
            D, a, tP, tS, R, rho2, dot(p, A), dot(p, B), dot(pu, A), dot(pu, B),
            AA, dot(A, B), BB, dot(cross(A, B), u), kind,
        )  # fmt: skip
        from_bone, to_bone = band_bones(muscle, i)
        band = Band(S, u, p, A, B, frame, x, y, z, lever, skew, section, from_bone, to_bone)
        bands.append(band)
    return bands


@compiled
def plane_at(section: Section, c: float, s: float) -> tuple[float, float, float, float]:
    """Return a band's plane at theta, given its cosine and sine: d, b, J, dJ.

    d is the distance of the sphere's centre from the plane, b that centre's offset towards the
    bulge (m); J = dpsi/dtheta and dJ = d2psi/dtheta2, psi the plane's turn about the band's line.
    """
    _, a, _, _, _, rho2, dA, dB, bA, bB, AA, AB, BB, kappa, _ = section
    d, b = dA * c + dB * s, bA * c + bB * s
    size2 = AA * c * c + 2.0 * AB * c * s + BB * s * s
    if size2 < CANCELLED * (AA + BB) and rho2 > VANISHING * a * a:
        size2 = (d * d + b * b) / rho2  # the centre keeps its distance from the line
    k2 = 1.0 / max(size2, 1e-300)
    k = sqrt(k2)
    J = kappa * k2
    dJ = -2.0 * J * k2 * ((BB - AA) * c * s + AB * (c * c - s * s))
    return k * d, k * b, J, dJ


@compiled
def planes_exist(bands: list[Band], c: float, s: float) -> bool:
    """Return whether every plane's normal has a direction at theta, given its cosine and sine."""
    for i in range(len(bands)):
        _, _, _, _, _, _, _, _, _, _, AA, AB, BB, _, _ = bands[i].section
        if AA * c * c + 2.0 * AB * c * s + BB * s * s < VANISHING * (AA + BB):
            return False
    return True


@compiled
def meets_edge(section: Section, d: float, b: float) -> bool:
    """Return whether a plane is, to rounding, at an edge: where the band begins to wrap."""
    near = ROUNDING * section.R
    if section.kind == BESIDE:
        return abs(abs(d) - section.R) <= near and b > -near
    return section.kind == EXTENDED and abs(b) <= near


@compiled
def state_at(section: Section, d: float, b: float, i: int, held: int) -> int:
    """Return the wrap state of the i-th band.

    `held` is the band that theta keeps just outside its sphere's edge, -1 for none; bands whose
    edge is there as well are kept outside with it.
    """
    if i == held or (held >= 0 and meets_edge(section, d, b)):
        return MISSED if section.kind == BESIDE else CLEAR
    return wrap_state(section.kind, section.R, d, b)


@compiled
def energy(bands: list[Band], theta: float, pierced: bool, held: int) -> tuple[float, float, float]:
    """Return E (m), dE/dtheta and d2E/dtheta2.

    `pierced` leaves out all bands but those that pierce their spheres; `held` is the band at the
    edge of its sphere (-1: none), which counts as straight.
    """
    c, s = cos(theta), sin(theta)
    E, dE, ddE = 0.0, 0.0, 0.0
    for i in range(len(bands)):
        section = bands[i].section
        if pierced and section.kind != PIERCED:
            continue
        d, b, J, dJ = plane_at(section, c, s)
        if not pierced and state_at(section, d, b, i, held) != WRAPPED:
            E += section.D
            continue
        r, arc, t1u, t1e, t2u, t2e = wrap(
            section.D, section.a, section.tP, section.tS, section.R, d, b
        )
        dL, ddL = length_by_plane(d, b, r, arc, t1u, t1e, t2u, t2e)
        E += section.tP + r * arc + section.tS
        dE += dL * J
        ddE += ddL * J * J + dL * dJ
    return E, dE, ddE
