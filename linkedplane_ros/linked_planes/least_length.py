# SPDX-License-Identifier: Apache-2.0
"""The angle theta that makes the muscle shortest, found for each pose by itself (thesis App. D)."""

from math import acos, atan, atan2, ceil, cos, hypot, inf, pi, sin, sqrt

from .band import BESIDE, PIERCED, WRAPPED, wrap_state
from .chain import Band, Section, energy, plane_at
from .compilation import compiled

LAST_STEP = 1e-7  # rad: a Newton step this small leaves an error of about its square
EVEN = 2.0  # a plane's fastest turn with theta over its slowest, up to which it turns evenly
EDGE = 1e-9  # rad: how near to a jump E is computed
EVEN_STEPS, CIRCLE_STEPS = 12, 360  # samples of a circle: pierced bands that turn evenly; others


@compiled
def others_straight(bands: list[Band], theta: float, held: int) -> bool:
    """Return whether every band that does not pierce its sphere is straight at theta."""
    c, s = cos(theta), sin(theta)
    for i in range(len(bands)):
        section = bands[i].section
        if section.kind == BESIDE and i != held:
            d, b, _, _ = plane_at(section, c, s)
            if wrap_state(BESIDE, section.R, d, b) == WRAPPED:
                return False
    return True


@compiled
def wrapped_angle(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    turns = ceil((angle - pi) / (2.0 * pi))
    return angle - 2.0 * pi * turns


@compiled
def descend(bands: list[Band], low: float, start: float, high: float, pierced: bool) -> float:
    """Return the theta of least length between low, where E falls, and high, where it rises."""
    theta = start
    for _ in range(100):
        _, dE, ddE = energy(bands, theta, pierced, -1)
        if dE > 0.0:
            high = theta
        else:
            low = theta
        step = -dE / ddE if ddE > 0.0 else inf
        if not low <= theta + step <= high:
            step = 0.5 * (low + high) - theta
        theta += step
        if abs(step) < LAST_STEP:
            break
    return theta


@compiled
def slackest(section: Section) -> tuple[float, float]:
    """Return (cos, sin) of the theta at which a pierced band is shortest: d = 0, b < 0."""
    c, s = section.dB, -section.dA
    size = sqrt(c * c + s * s)
    if size == 0.0:
        return 1.0, 0.0
    k = 1.0 / size if section.bA * c + section.bB * s <= 0.0 else -1.0 / size
    return k * c, k * s


@compiled
def stiffness(section: Section, c: float, s: float) -> float:
    """Return about d2L/dtheta2 of a pierced band at its shortest, given theta's cosine and sine.

    There d2L/dpsi2 = -b (b arc / r + t1e - t2e) with r = R; for a short arc it is about t1e - t2e.
    """
    _, b, J, _ = plane_at(section, c, s)
    R, over = section.R, section.D - section.a
    t1e = (section.a * R + b * section.tP) / (section.a * section.a + b * b)
    t2e = -(over * R + b * section.tS) / (over * over + b * b)
    return -b * (1.0 + b / R) * (t1e - t2e) * J * J


@compiled
def least(bands: list[Band], theta: float, held: int, best: tuple[float, float, int], neutral: float
          ) -> tuple[float, float, int]:  # fmt: skip
    """Return the better of two candidates (E, theta, held): the shorter, then nearest neutral."""
    E = energy(bands, theta, False, held)[0]
    nearer = abs(wrapped_angle(theta - neutral)) < abs(wrapped_angle(best[1] - neutral))
    if E < best[0] or (E == best[0] and nearer):
        return E, theta, held
    return best


@compiled
def edges(band: Section) -> list[float]:
    """Return the thetas at which a band starts or ceases to touch the sphere that it passes."""
    found: list[float] = []
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
    through zero; the edges themselves are candidates, as E jumps there. The stretches are short
    where E bends sharply: at an edge, and about the shortest plane of a band that turns fast.
    """
    nodes = [neutral]
    best = (energy(bands, neutral, False, -1)[0], neutral, -1)
    for i in range(len(bands)):
        section = bands[i].section
        if section.kind == PIERCED:
            c, s = slackest(section)
            shortest = atan2(s, c)
            nodes.append(shortest)
            away = 0.2 / unevenness(section)
            while away < 2.0 * pi / CIRCLE_STEPS:
                nodes.append(wrapped_angle(shortest - away))
                nodes.append(wrapped_angle(shortest + away))
                away *= 2.0
        for theta in edges(section):
            away = EDGE
            while away < 2.0 * pi / CIRCLE_STEPS:
                nodes.append(wrapped_angle(theta - away))
                nodes.append(wrapped_angle(theta + away))
                away *= 4.0
            best = least(bands, theta, i, best, neutral)
    for k in range(CIRCLE_STEPS):
        nodes.append(-pi + 2.0 * pi * k / CIRCLE_STEPS)
    nodes.sort()
    nodes.append(nodes[0] + 2.0 * pi)
    for k in range(len(nodes) - 1):
        low, high = nodes[k], nodes[k + 1]
        if high - low <= 3.0 * EDGE:
            continue
        if energy(bands, low, False, -1)[1] < 0.0 <= energy(bands, high, False, -1)[1]:
            theta = descend(bands, low, 0.5 * (low + high), high, False)
            best = least(bands, theta, -1, best, neutral)
    return wrapped_angle(best[1]), best[2]


@compiled
def settle(bands: list[Band], neutral: float) -> tuple[float, int]:
    """Return the theta nearest neutral at which every band of an all-straight muscle is straight.

    The second answer is the band that this theta puts at the edge of its sphere, or -1.
    """
    if others_straight(bands, neutral, -1):
        return neutral, -1
    nearest, held = inf, -1
    for i in range(len(bands)):
        for theta in edges(bands[i].section):
            away = wrapped_angle(theta - neutral)
            if abs(away) < abs(nearest) and others_straight(bands, theta, i):
                nearest, held = away, i
    if held < 0:
        return search_circle(bands, neutral)
    return wrapped_angle(neutral + nearest), held


@compiled
def unevenness(section: Section) -> float:
    """Return how much faster a band's plane turns with theta at its fastest than at its slowest."""
    mean = 0.5 * (section.AA + section.BB)
    swing = hypot(0.5 * (section.AA - section.BB), section.AB)
    return (mean + swing) / max(mean - swing, 1e-12)


@compiled
def turn_evenly(bands: list[Band]) -> bool:
    """Return whether the planes of all pierced bands turn about evenly with theta."""
    for i in range(len(bands)):
        if bands[i].section.kind == PIERCED and unevenness(bands[i].section) > EVEN:
            return False
    return True


@compiled
def near_side(bands: list[Band], theta: float) -> bool:
    """Return whether every pierced band's plane is within 90 deg of its shortest: b < 0."""
    c, s = cos(theta), sin(theta)
    for i in range(len(bands)):
        section = bands[i].section
        if section.kind == PIERCED and section.bA * c + section.bB * s >= 0.0:
            return False
    return True


@compiled
def search_pierced(bands: list[Band], steps: int) -> float:
    """Return the theta on the whole circle at which pierced, evenly turning bands are shortest."""
    best, theta = inf, 0.0
    left = -pi
    falling = energy(bands, left, True, -1)[1] < 0.0
    for k in range(1, steps + 1):
        right = -pi + 2.0 * pi * k / steps
        was_falling, falling = falling, energy(bands, right, True, -1)[1] < 0.0
        if was_falling and not falling:
            floor = descend(bands, left, 0.5 * (left + right), right, True)
            E = energy(bands, floor, True, -1)[0]
            if E < best:
                best, theta = E, floor
        left = right
    return theta


@compiled
def solve_theta(bands: list[Band], neutral: float) -> tuple[float, int]:
    """Return the theta (rad, in (-pi, pi]) that makes the muscle shortest (App. D).

    The second answer is the band that this theta keeps at the edge of its sphere, or -1.

    It depends only on the pose. Where the pierced bands are together at their shortest and all
    other bands are straight, nothing is shorter; if others are not, the whole circle is searched.
    Where no band is pierced the muscle may be straight over a range of theta: the one nearest
    `neutral` is taken.
    """
    # the guess: where springs as stiff as the pierced bands at their shortest would balance
    cosine, sine = 0.0, 0.0
    for i in range(len(bands)):
        section = bands[i].section
        if section.kind == PIERCED:
            c, s = slackest(section)
            weight = stiffness(section, c, s)
            cosine += weight * c
            sine += weight * s
    if cosine == 0.0 and sine == 0.0:
        return settle(bands, neutral)
    if not turn_evenly(bands):
        return search_circle(bands, neutral)
    guess = atan2(sine, cosine)
    low, high, together = 0.0, 0.0, True  # tangents of the pierced bands' own thetas from there
    for i in range(len(bands)):
        section = bands[i].section
        if section.kind == PIERCED:
            c, s = slackest(section)
            beside, ahead = s * cosine - c * sine, c * cosine + s * sine
            together = together and ahead > 0.0
            if together:
                low, high = min(low, beside / ahead), max(high, beside / ahead)
    # a pierced band is convex in its plane's turn up to 90 deg from its shortest, and longer beyond
    # than on the near side; with planes that turn evenly all scans of the sum found one valley
    low, high = guess + atan(low), guess + atan(high)
    if together and near_side(bands, low) and near_side(bands, high):
        theta = descend(bands, low, guess, high, True)
    else:
        theta = search_pierced(bands, EVEN_STEPS)
    if not others_straight(bands, theta, -1):
        return search_circle(bands, neutral)
    return wrapped_angle(theta), -1
