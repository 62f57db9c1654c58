# SPDX-License-Identifier: Apache-2.0
"""The angle theta that makes the muscle shortest, found for each pose by itself (thesis App. D)."""

from math import atan, atan2, cos, inf, pi, sin

from .band import INSIDE, PIERCED, WRAPPED
from .chain import Band, Section, energy, meets_edge, plane_at, planes_exist, state_at
from .compilation import compiled
from .whole_circle import (
    EVEN,
    descend,
    edges,
    search_circle,
    slackest,
    unevenness,
    wrapped_angle,
)

EVEN_STEPS = 12  # samples of a circle for pierced bands that turn evenly


@compiled
def others_straight(bands: list[Band], theta: float, held: int) -> bool:
    """Return whether every band that does not pierce its sphere is straight at theta.

    And all have a plane there.
    """
    c, s = cos(theta), sin(theta)
    for i in range(len(bands)):
        section = bands[i].section
        if section.kind != PIERCED and section.kind != INSIDE:
            d, b, _, _ = plane_at(section, c, s)
            if state_at(section, d, b, i, held) == WRAPPED:
                return False
            if held < 0 and meets_edge(section, d, b):
                return False
    return planes_exist(bands, c, s)


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
    if not turn_evenly(bands):
        return search_circle(bands, neutral)
    if cosine == 0.0 and sine == 0.0:
        return settle(bands, neutral)
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
