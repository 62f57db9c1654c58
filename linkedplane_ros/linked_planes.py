"""The linked planes and the angle theta that makes the muscle shortest (thesis ch. 4, App. B, D).

Left unnormalised, every band's plane normal is a fixed combination A cos(theta) + B sin(theta) of
two vectors that depend on the pose alone, so the chain of planes is built once per pose.
"""

from math import acos, atan2, ceil, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple

from .band import (
    BESIDE,
    CLEAR,
    MISSED,
    PIERCED,
    WRAPPED,
    length_by_plane,
    obstacle_kind,
    wrap,
    wrap_state,
)
from .compiled import compiled
from .vectors import Vector, cross, dot, minus, mix, norm, plus, times, turned

SAME_ANGLE = 1e-13  # rad: theta is found to this
SCAN_STEP = 0.5  # rad: between samples of dE/dtheta where bands pull apart
CIRCLE_STEPS = 96  # samples of a whole circle, where there is nothing better


class Constants(NamedTuple):
    """A muscle as the kernels read it: flat sequences, x y z of each band in turn, in m and rad."""

    origins: list[float]  # ground frame
    insertions: list[float]  # humerus frame
    centres: list[float]  # each in its band's moving frame
    radii: list[float]
    plane_angles: list[float]
    reference_normal: list[float]  # N, ground frame
    ground_point: list[float]  # SC, ground frame
    humeral_point: list[float]  # HM, humerus frame


class Band(NamedTuple):
    """One band at one pose: all of it that does not depend on theta. Ground frame, m."""

    S: Vector  # insertion
    u: Vector  # from the origin P to S, unit
    D: float  # |S - P|
    p: Vector  # from P to the sphere's centre
    a: float  # p along u
    R: float  # the sphere's radius
    tP: float  # tangent lengths from P and S to the sphere
    tS: float
    kind: int  # PIERCED, BESIDE or INSIDE
    y: Vector  # axes of the sphere's moving frame, for its motion
    z: Vector
    lever: float  # |HM - P|
    skew: float  # (SC - P).x / (SC - P).y in that frame
    A: Vector  # plane normal, unnormalised: A cos(theta) + B sin(theta)
    B: Vector
    dA: float  # p.A, p.B: the sphere's distance from the plane, times |A cos + B sin|
    dB: float
    bA: float  # (p x u).A, (p x u).B: the same for b
    bB: float
    AA: float
    AB: float
    BB: float
    kappa: float  # (A x B).u: how fast the plane turns with theta


class Plane(NamedTuple):
    """A band's plane at one theta."""

    d: float  # distance of the sphere's centre, m
    b: float  # that centre's offset towards the bulge, m
    J: float  # dpsi/dtheta, psi the plane's turn about the band's line
    dJ: float  # d2psi/dtheta2


@compiled
def vector(flat: list[float], i: int) -> Vector:
    """Return the i-th vector of a flat sequence."""
    return (flat[3 * i], flat[3 * i + 1], flat[3 * i + 2])


@compiled
def bands_at(muscle: Constants, rotation: tuple[Vector, Vector, Vector]) -> list[Band]:
    """Pose the muscle: its bands and the chain of their planes, for a humerus -> scapula rotation.

    A band whose plane is undefined (its predecessor's normal runs along its line) or whose sphere's
    frame is (P, HM and SC in one line) ends the list before its time.
    """
    SC = vector(muscle.ground_point, 0)
    HM = turned(rotation, vector(muscle.humeral_point, 0))
    A = vector(muscle.reference_normal, 0)
    B = (0.0, 0.0, 0.0)
    bands = []
    for i in range(len(muscle.radii)):
        P = vector(muscle.origins, i)
        S = turned(rotation, vector(muscle.insertions, i))
        R = muscle.radii[i]
        D = norm(minus(S, P))
        u = times(1.0 / D, minus(S, P))
        # the sphere's moving frame (thesis ch. 5): x from P to HM, z across the plane with SC
        lever = norm(minus(HM, P))
        if lever < 1e-9:
            break
        x = times(1.0 / lever, minus(HM, P))
        q = minus(SC, P)
        across = norm(cross(x, q))
        if across < 1e-9:
            break
        z = times(1.0 / across, cross(x, q))
        y = cross(z, x)
        cx, cy, cz = vector(muscle.centres, i)
        p = plus(times(cx, x), mix(cy, y, cz, z))
        a = dot(p, u)
        # distances from the line by the cross product: no cancellation
        pu = cross(p, u)
        kind = obstacle_kind(D, a, dot(pu, pu), R)
        tP = sqrt(max(dot(p, p) - R * R, 0.0))
        from_S = mix(1.0, p, -D, u)
        tS = sqrt(max(dot(from_S, from_S) - R * R, 0.0))
        # the plane: the reference normal, then the normal of the band before (App. B)
        A = mix(1.0, A, -dot(A, u), u)
        B = mix(1.0, B, -dot(B, u), u)
        if i == 0:
            B = cross(u, A)
        else:
            c, s = cos(muscle.plane_angles[i]), sin(muscle.plane_angles[i])
            A = mix(c, A, s, cross(u, A))
            B = mix(c, B, s, cross(u, B))
        size = sqrt(dot(A, A) + dot(B, B))
        if size < 1e-9:
            break
        A, B = times(1.0 / size, A), times(1.0 / size, B)
        bands.append(
            Band(
                S, u, D, p, a, R, tP, tS, kind,
                y, z, lever, dot(q, x) / across,
                A, B, dot(p, A), dot(p, B), dot(pu, A), dot(pu, B),
                dot(A, A), dot(A, B), dot(B, B), dot(cross(A, B), u),
            )
        )  # fmt: skip
    return bands


@compiled
def plane_at(band: Band, c: float, s: float) -> Plane:
    """Return the band's plane at theta, given its cosine and sine."""
    size2 = band.AA * c * c + 2.0 * band.AB * c * s + band.BB * s * s
    growth = 2.0 * ((band.BB - band.AA) * c * s + band.AB * (c * c - s * s))
    size2 = max(size2, 1e-300)
    size = sqrt(size2)
    J = band.kappa / size2
    return Plane(
        (band.dA * c + band.dB * s) / size,
        (band.bA * c + band.bB * s) / size,
        J,
        -J * growth / size2,
    )


@compiled
def state_at(band: Band, plane: Plane, straight: bool) -> int:
    """Return the wrap state of a band; `straight` holds it just outside its sphere's edge."""
    if straight:
        return MISSED if abs(plane.d) > (1.0 - 1e-6) * band.R else CLEAR
    return wrap_state(band.kind, band.R, plane.d, plane.b)


@compiled
def energy(bands: list[Band], theta: float, held: int) -> tuple[float, float, float, int]:
    """Return E (m), dE/dtheta, d2E/dtheta2 and the number of wrapped bands that may be straight.

    `held` is the band at the edge of its sphere (-1: none), which counts as straight.
    """
    c, s = cos(theta), sin(theta)
    E, dE, ddE, extra = 0.0, 0.0, 0.0, 0
    for i in range(len(bands)):
        band = bands[i]
        plane = plane_at(band, c, s)
        if state_at(band, plane, i == held) != WRAPPED:
            E += band.D
            continue
        w = wrap(band.D, band.a, band.tP, band.tS, band.R, plane.d, plane.b)
        dL, ddL = length_by_plane(w, plane.d, plane.b)
        E += band.tP + w.r * w.arc + band.tS
        dE += dL * plane.J
        ddE += ddL * plane.J * plane.J + dL * plane.dJ
        extra += band.kind == BESIDE
    return E, dE, ddE, extra


@compiled
def wrapped_angle(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    turns = ceil((angle - pi) / (2.0 * pi))
    return angle - 2.0 * pi * turns


@compiled
def descend(bands: list[Band], low: float, start: float, high: float) -> float:
    """Return the theta of least length between low, where E falls, and high, where it rises."""
    theta = start
    for _ in range(100):
        _, dE, ddE, _ = energy(bands, theta, -1)
        if dE > 0.0:
            high = theta
        else:
            low = theta
        step = -dE / ddE if ddE > 0.0 else inf
        if not low <= theta + step <= high:
            step = 0.5 * (low + high) - theta
        theta += step
        if abs(step) <= SAME_ANGLE * 1e2:  # the next Newton step would be below SAME_ANGLE
            break
    return theta


@compiled
def valley(bands: list[Band], low: float, guess: float, high: float) -> float:
    """Return the theta of least length between low and high, sampled where they are far apart."""
    steps = max(1, int(ceil((high - low) / SCAN_STEP)))
    best, theta = inf, guess
    left, falling = low, True
    for k in range(1, steps + 1):
        right = low + (high - low) * k / steps
        was_falling = falling
        falling = k < steps and energy(bands, right, -1)[1] < 0.0
        if was_falling and not falling:
            start = guess if left < guess < right else 0.5 * (left + right)
            bottom = descend(bands, left, start, right)
            E = energy(bands, bottom, -1)[0] if steps > 1 else 0.0
            if E < best:
                best, theta = E, bottom
        left = right
    return theta


@compiled
def slackest(band: Band) -> float:
    """Return the theta at which a pierced band is shortest: its plane through the centre."""
    c, s = band.dB, -band.dA
    if band.bA * c + band.bB * s > 0.0:
        c, s = -c, -s
    return atan2(s, c)


@compiled
def least(bands: list[Band], theta: float, held: int, best: tuple[float, float, int], neutral: float
          ) -> tuple[float, float, int]:  # fmt: skip
    """Return the better of two candidates (E, theta, held): the shorter, then nearest neutral."""
    E = energy(bands, theta, held)[0]
    nearer = abs(wrapped_angle(theta - neutral)) < abs(wrapped_angle(best[1] - neutral))
    if E < best[0] or (E == best[0] and nearer):
        return E, theta, held
    return best


@compiled
def edges(band: Band) -> list[float]:
    """Return the thetas at which a band starts or ceases to touch the sphere that it passes."""
    found = []
    if band.kind != BESIDE:
        return found
    # |d| = R: a quadratic form in (cos, sin), solved by the double angle
    R2 = band.R * band.R
    m11 = band.dA * band.dA - R2 * band.AA
    m12 = band.dA * band.dB - R2 * band.AB
    m22 = band.dB * band.dB - R2 * band.BB
    swing = hypot(0.5 * (m11 - m22), m12)
    if abs(m11 + m22) < 2.0 * swing:
        middle = atan2(m12, 0.5 * (m11 - m22))
        half = acos(-0.5 * (m11 + m22) / swing)
        for double in (middle - half, middle + half):
            for theta in (0.5 * double, 0.5 * double + pi):
                if band.bA * cos(theta) + band.bB * sin(theta) > 0.0:
                    found.append(wrapped_angle(theta))
    else:  # the line's extension runs through the sphere: the band jumps over it at b = 0
        theta = atan2(-band.bA, band.bB)
        found.append(wrapped_angle(theta))
        found.append(wrapped_angle(theta + pi))
    return found


@compiled
def search_circle(bands: list[Band], neutral: float) -> tuple[float, int]:
    """Return the theta of least length on the whole circle, and the band at its sphere's edge.

    Between the edges E is smooth: each stretch is searched for the places where dE/dtheta rises
    through zero; the edges themselves are candidates, for there E jumps.
    """
    nodes = [neutral]
    best = (energy(bands, neutral, -1)[0], neutral, -1)
    for i in range(len(bands)):
        if bands[i].kind == PIERCED:
            nodes.append(slackest(bands[i]))
        for theta in edges(bands[i]):
            nodes.append(theta)
            best = least(bands, theta, i, best, neutral)
    for k in range(CIRCLE_STEPS):
        nodes.append(-pi + 2.0 * pi * k / CIRCLE_STEPS)
    nodes.sort()
    nodes.append(nodes[0] + 2.0 * pi)
    inset = 1e-9
    for k in range(len(nodes) - 1):
        low, high = nodes[k] + inset, nodes[k + 1] - inset
        if low >= high:
            continue
        if energy(bands, low, -1)[1] < 0.0 <= energy(bands, high, -1)[1]:
            theta = descend(bands, low, 0.5 * (low + high), high)
            best = least(bands, theta, -1, best, neutral)
    return wrapped_angle(best[1]), best[2]


@compiled
def settle(bands: list[Band], neutral: float) -> tuple[float, int]:
    """Return a theta near neutral at which every band of an all-straight muscle is straight."""
    if energy(bands, neutral, -1)[3] == 0:
        return neutral, -1
    nearest, held = inf, -1
    for i in range(len(bands)):
        for theta in edges(bands[i]):
            away = abs(wrapped_angle(theta - neutral))
            if away < abs(nearest) and energy(bands, theta, i)[3] == 0:
                nearest, held = wrapped_angle(theta - neutral), i
    if held < 0:
        return search_circle(bands, neutral)
    return wrapped_angle(neutral + nearest), held


@compiled
def solve_theta(bands: list[Band], neutral: float) -> tuple[float, int]:
    """Return the theta (rad, in (-pi, pi]) that makes the muscle shortest (App. D), and `held`.

    A function of the pose alone. Each pierced band alone is shortest with its plane through its
    sphere's centre and lengthens steadily up to the opposite plane, so where those angles lie
    within half a circle the minimum lies between them; bands that pass their spheres are straight
    there, or the whole circle is searched. Where no band is pierced the muscle may be straight over
    a range of theta: the one nearest `neutral` is taken.
    """
    first, weight, lean, low, high = inf, 0.0, 0.0, 0.0, 0.0
    for i in range(len(bands)):
        band = bands[i]
        if band.kind != PIERCED:
            continue
        theta = slackest(band)
        if first == inf:
            first = theta
        away = wrapped_angle(theta - first)
        low, high = min(low, away), max(high, away)
        plane = plane_at(band, cos(theta), sin(theta))
        w = wrap(band.D, band.a, band.tP, band.tS, band.R, plane.d, plane.b)
        stiffness = length_by_plane(w, plane.d, plane.b)[1] * plane.J * plane.J
        weight += stiffness
        lean += stiffness * away
    if first == inf:
        return settle(bands, neutral)
    if weight <= 0.0 or high - low >= pi:
        return search_circle(bands, neutral)
    theta = valley(bands, first + low, first + lean / weight, first + high)
    if energy(bands, theta, -1)[3] > 0:
        return search_circle(bands, neutral)
    return wrapped_angle(theta), -1
