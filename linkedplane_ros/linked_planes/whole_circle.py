# SPDX-License-Identifier: Apache-2.0
"""The theta of least length on the whole circle: every stretch is searched or ruled out."""

from math import acos, atan2, ceil, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple

from .band import BESIDE, EXTENDED, PIERCED, WRAPPED, length_by_plane, wrap
from .chain import (
    ROUNDING,
    VANISHING,
    Band,
    Section,
    energy,
    meets_edge,
    plane_at,
    planes_exist,
    state_at,
)
from .compilation import compiled

LAST_STEP = 1e-7  # rad: a Newton step this small leaves an error of about its square
LAST_GAIN = 1e-13  # m: and what it gains, where planes turn fast with theta
EVEN = 2.0  # a plane's fastest turn with theta over its slowest, up to which it turns evenly
EDGE = 1e-9  # rad: how near to a jump E is computed
BEATEN = 5e-10  # m: by how much another theta may be shorter than the answer
SMALL_TURN = 0.1  # rad: of a plane, within which a length bends by about as much as at the ends
CIRCLE_STEPS = 360  # samples of a circle


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
        if abs(step) < LAST_STEP and ddE * step * step < LAST_GAIN:
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
def unevenness(section: Section) -> float:
    """Return how much faster a band's plane turns with theta at its fastest than at its slowest."""
    mean = 0.5 * (section.AA + section.BB)
    swing = hypot(0.5 * (section.AA - section.BB), section.AB)
    return (mean + swing) / max(mean - swing, 1e-12)


@compiled
def least(bands: list[Band], theta: float, held: int, best: tuple[float, float, int], neutral: float
          ) -> tuple[float, float, int]:  # fmt: skip
    """Return the better of two candidates (E, theta, held): the shorter, then nearest neutral.

    A theta at which a plane vanishes is none, nor one at an edge at which no band is held.
    """
    c, s = cos(theta), sin(theta)
    if not planes_exist(bands, c, s):
        return best
    for i in range(len(bands) if held < 0 else 0):
        d, b, _, _ = plane_at(bands[i].section, c, s)
        if meets_edge(bands[i].section, d, b):
            return best
    E = energy(bands, theta, False, held)[0]
    nearer = abs(wrapped_angle(theta - neutral)) < abs(wrapped_angle(best[1] - neutral))
    if E < best[0] or (E == best[0] and nearer):
        return E, theta, held
    return best


@compiled
def edges(band: Section) -> list[float]:
    """Return the thetas at which a band starts or ceases to touch the sphere that it passes."""
    found: list[float] = []
    if band.kind == EXTENDED:  # the band jumps over its sphere at b = 0
        theta = atan2(-band.bA, band.bB)
        found.append(wrapped_angle(theta))
        found.append(wrapped_angle(theta + pi))
    if band.kind != BESIDE:
        return found
    # |d| = R: a quadratic form in (cos, sin), solved by the double angle
    R2 = band.R * band.R
    m11 = band.dA * band.dA - R2 * band.AA
    m12 = band.dA * band.dB - R2 * band.AB
    m22 = band.dB * band.dB - R2 * band.BB
    swing = hypot(0.5 * (m11 - m22), m12)
    if abs(m11 + m22) <= 2.0 * (1.0 + ROUNDING) * swing:
        middle = atan2(m12, 0.5 * (m11 - m22))
        touch = -0.5 * (m11 + m22) / max(swing, 1e-300)  # 1: the line touches the sphere's rim
        half = acos(min(max(touch, -1.0), 1.0))
        for double in (middle - half, middle + half):
            for theta in (0.5 * double, 0.5 * double + pi):
                if band.bA * cos(theta) + band.bB * sin(theta) > 0.0 or abs(touch) >= 1.0:
                    found.append(wrapped_angle(theta))
    return found


class Sample(NamedTuple):
    """The muscle at one theta: E (m), dE, and what bounds E beside it."""

    theta: float
    E: float  # infinite where a plane vanishes
    dE: float
    bend: float  # the sum of |d2L/dtheta2| over the bands, m
    turn: float  # how fast the fastest plane turns with theta


@compiled
def sample(bands: list[Band], theta: float) -> Sample:
    """Return the muscle at one theta."""
    c, s = cos(theta), sin(theta)
    E, dE, bend, turn = 0.0, 0.0, 0.0, 1.0
    for i in range(len(bands)):
        section = bands[i].section
        d, b, J, dJ = plane_at(section, c, s)
        turn = max(turn, abs(J))
        if state_at(section, d, b, i, -1) != WRAPPED:
            E += section.D
            continue
        r, arc, t1u, t1e, t2u, t2e = wrap(
            section.D, section.a, section.tP, section.tS, section.R, d, b
        )
        dL, ddL = length_by_plane(d, b, r, arc, t1u, t1e, t2u, t2e)
        E += section.tP + r * arc + section.tS
        dE += dL * J
        bend += abs(ddL * J * J + dL * dJ)
    return Sample(theta, E if planes_exist(bands, c, s) else inf, dE, bend, turn)


@compiled
def breaks_of(bands: list[Band]) -> list[float]:
    """Return the thetas about which a plane turns fastest, or has none: no stretch has one within.

    About an edge there, what is nearer than EDGE to it may be long.
    """
    found: list[float] = []
    for i in range(len(bands)):
        section = bands[i].section
        if unevenness(section) > EVEN:
            half = 0.5 * (section.AA - section.BB)
            mean, swing = 0.5 * (section.AA + section.BB), hypot(half, section.AB)
            fastest = 0.5 * (atan2(section.AB, half) + pi)
            short = 2.0 * VANISHING * mean - (mean - swing)  # of a normal without a direction
            aside = 1.001 * sqrt(short / (2.0 * swing)) if short > 0.0 else 0.0
            for theta in (fastest, fastest + pi):
                found.append(wrapped_angle(theta - aside))
                if aside > 0.0:
                    found.append(wrapped_angle(theta + aside))
        for theta in edges(section):
            turn = abs(plane_at(section, cos(theta), sin(theta))[2])
            if turn > EVEN:
                found.append(wrapped_angle(theta - EDGE / turn))
                found.append(wrapped_angle(theta + EDGE / turn))
    return found


@compiled
def descend_from(bands: list[Band], theta: float, reach: float) -> float:
    """Return the floor of the valley that theta lies in, or a theta `reach` further down."""
    downhill = 1.0 if energy(bands, theta, False, -1)[1] < 0.0 else -1.0
    near, step = theta, LAST_STEP
    while step < reach:
        far = theta + downhill * step
        if energy(bands, far, False, -1)[1] * downhill >= 0.0:
            low, high = min(near, far), max(near, far)
            return descend(bands, low, 0.5 * (low + high), high, False)
        near, step = far, 2.0 * step
    return near


@compiled
def rule_out(
    bands: list[Band],
    samples: list[Sample],
    best: tuple[float, float, int],
    neutral: float,
) -> tuple[float, float, int]:
    """Return a candidate that no theta beats by more than BEATEN: the best one, or a better.

    A length bends by no more than `bend` within a stretch in which no plane turns much, so it falls
    below the chord by no more than bend w^2 / 8. A stretch that could be shorter is halved.
    """
    breaks = breaks_of(bands)
    stack = [(samples[k], samples[k + 1]) for k in range(len(samples) - 1)]
    while len(stack) > 0:
        low, high = stack.pop()
        width = high.theta - low.theta
        turn = max(low.turn, high.turn)
        if width * turn <= 3.0 * EDGE:
            continue
        middle = 0.5 * (low.theta + high.theta)
        if not low.theta < middle < high.theta:  # a plane that turns by 3 EDGE between two numbers
            continue
        whole = True
        for theta in breaks:
            for each in (theta, theta + 2.0 * pi):
                if low.theta < each < high.theta:
                    middle, whole = each, False
        sag = 0.5 * max(low.bend, high.bend) * width * width
        if whole and width * turn < SMALL_TURN and min(low.E, high.E) - sag >= best[0] - BEATEN:
            continue
        between = sample(bands, middle)
        if whole and between.E == inf:
            continue
        if between.E < best[0] - BEATEN:
            best = least(bands, middle, -1, best, neutral)
            theta = descend_from(bands, middle, SMALL_TURN / turn)
            best = least(bands, theta, -1, best, neutral)
        stack.append((low, between))
        stack.append((between, high))
    return best


@compiled
def search_circle(bands: list[Band], neutral: float) -> tuple[float, int]:
    """Return the theta of least length on the whole circle, and the band at its sphere's edge.

    Between the edges E is smooth: each stretch is searched for the places where dE/dtheta rises
    through zero; the edges themselves are candidates, as E jumps there. The stretches are short
    where E bends sharply: at an edge, and about the shortest plane of a band that turns fast.
    """
    nodes = [neutral]
    best = least(bands, neutral, -1, (inf, neutral, -1), neutral)
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
    samples = [sample(bands, theta) for theta in nodes]
    for k in range(len(nodes) - 1):
        low, high = nodes[k], nodes[k + 1]
        if high - low <= 3.0 * EDGE:
            continue
        if samples[k].dE < 0.0 <= samples[k + 1].dE:
            theta = descend(bands, low, 0.5 * (low + high), high, False)
            best = least(bands, theta, -1, best, neutral)
    best = rule_out(bands, samples, best, neutral)
    return wrapped_angle(best[1]), best[2]
