# SPDX-License-Identifier: Apache-2.0
"""The method, literally and slowly: spec sections 2, 3 and 4 in plain NumPy and SciPy.

Shares no formula with the package: the arc comes from acos and mod 2 pi, planes are a chain of
normalised normals, theta is found by a scan of the whole circle, moment vectors are differences of
whole solutions. Lengths in m, angles in rad. `...` is any number of leading dimensions, which
broadcast: many thetas and many rotations (k, 3, 3) are taken at once.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle

Array = npt.NDArray[np.float64]

WRAPPED, CLEAR, MISSED, INSIDE = 0, 1, 2, 3

SCAN = 360  # thetas on the circle
DIPS = 3  # of the scan are searched further, the deepest first
STENCIL = 1e-3  # rad, for dE/dtheta: (8 E(+1) - 8 E(-1) - E(+2) + E(-2)) / 12 steps


class BandPath(NamedTuple):
    """A band in its plane, each field (...) or (..., 3)."""

    length: Array
    state: Array
    normal: Array
    arc: Array  # valid where wrapped, like what follows
    r: Array
    centre: Array  # of the circle
    Q: Array  # the tangent points
    T: Array


def dot(a: Array, b: Array) -> Array:
    """Return the scalar products (...) of vectors (..., 3)."""
    return np.einsum('...i,...i->...', a, b)


def unit(v: Array) -> Array:
    """Return v (..., 3) at unit length."""
    return v / np.sqrt(dot(v, v))[..., np.newaxis]


def along(k: npt.ArrayLike, v: Array) -> Array:
    """Return k (...) times v (..., 3)."""
    return np.asarray(k)[..., np.newaxis] * v


def band(
    P: Array, S: Array, n_ref: Array, phi: npt.ArrayLike, C: Array, R: npt.ArrayLike
) -> BandPath:
    """Return one band, step by step as in section 2; points (..., 3), phi and R (...)."""
    D = np.sqrt(dot(S - P, S - P))
    u = unit(S - P)
    m = unit(n_ref - along(dot(n_ref, u), u))
    n = along(np.cos(phi), m) + along(np.sin(phi), np.cross(u, m))
    e = np.cross(u, n)
    d, a, b = dot(C - P, n), dot(C - P, u), dot(C - P, e)
    c = C - along(d, n)
    with np.errstate(invalid='ignore', divide='ignore'):
        r = np.sqrt(R * R - d * d)
        cP, cS = np.hypot(a, b), np.hypot(D - a, b)
        alpha = np.mod(np.arctan2(-b, -a) - np.arctan2(-b, D - a), 2.0 * np.pi)
        at_P, at_S = np.arccos(r / cP), np.arccos(r / cS)
        arc = alpha - at_P - at_S
        round_it = np.sqrt(cP * cP - r * r) + r * arc + np.sqrt(cS * cS - r * r)
        turn_Q = np.arctan2(-b, -a) - at_P  # clockwise from the direction of P
        turn_T = np.arctan2(-b, D - a) + at_S
    state = np.select(
        [np.abs(d) >= R, (cP < r) | (cS < r), arc <= 0.0], [MISSED, INSIDE, CLEAR], WRAPPED
    )
    Q, T = (c + along(r * np.cos(t), u) + along(r * np.sin(t), e) for t in (turn_Q, turn_T))
    length = np.where(state == WRAPPED, round_it, D)
    return BandPath(length, state, n, arc, r, c, Q, T)


def sphere_centres(muscle: BroadMuscle, rotation: Array) -> Array:
    """Return the (..., n, 3) sphere centres, ground frame; moving frames are those of section 5."""
    P, centres = muscle.origins, muscle.sphere_centres
    frames = np.array(muscle.sphere_frames)[:, np.newaxis]
    on_humerus = np.einsum('...ij,nj->...ni', rotation, centres)
    standing = np.where(frames == 'humerus', on_humerus, centres)
    if muscle.humeral_point is None:
        return standing
    HM = (rotation @ muscle.humeral_point)[..., np.newaxis, :]
    x = unit(HM - P)
    z = unit(np.cross(x, muscle.ground_point - P))
    y = np.cross(z, x)
    cx, cy, cz = centres.T
    return np.where(frames == 'moving', P + along(cx, x) + along(cy, y) + along(cz, z), standing)


def chain(muscle: BroadMuscle, rotation: Array, theta: npt.ArrayLike) -> list[BandPath]:
    """Return all bands: band 1 from N and theta, each next one from the normal before it."""
    centres = sphere_centres(muscle, rotation)
    normal = muscle.reference_normal
    bands = []
    for i, P in enumerate(muscle.origins):
        S = rotation @ muscle.insertions[i]
        phi = theta if i == 0 else muscle.plane_angles[i]
        found = band(P, S, normal, phi, centres[..., i, :], muscle.sphere_radii[i])
        normal = found.normal
        bands.append(found)
    return bands


def lengths_at(muscle: BroadMuscle, rotation: Array, theta: npt.ArrayLike) -> Array:
    """Return the band lengths (..., n) at theta (...)."""
    return np.stack([found.length for found in chain(muscle, rotation, theta)], axis=-1)


def states_at(muscle: BroadMuscle, rotation: Array, theta: npt.ArrayLike) -> Array:
    """Return the wrap states (..., n) at theta (...)."""
    return np.stack([found.state for found in chain(muscle, rotation, theta)], axis=-1)


def total_at(muscle: BroadMuscle, rotation: Array, theta: npt.ArrayLike) -> Array:
    """Return E(theta) (...)."""
    return lengths_at(muscle, rotation, theta).sum(axis=-1)


def straight_at(muscle: BroadMuscle, rotation: Array, theta: npt.ArrayLike) -> Array:
    """Return whether every band is straight at theta (...)."""
    return np.all(states_at(muscle, rotation, theta) != WRAPPED, axis=-1)


def slope_at(muscle: BroadMuscle, rotation: Array, theta: Array) -> Array:
    """Return dE/dtheta (k,) by differences of the fourth order; rotations (k, 3, 3)."""
    steps = theta[:, np.newaxis] + STENCIL * np.array([-2.0, -1.0, 1.0, 2.0])
    E = total_at(muscle, rotation[:, np.newaxis], steps)
    return E @ np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * STENCIL)


def circle(samples: int) -> Array:
    """Return angles equally spaced over the whole circle."""
    return np.linspace(-np.pi, np.pi, samples, endpoint=False)


def in_circle(angle: npt.ArrayLike) -> Array:
    """Return angles in [-pi, pi)."""
    return np.mod(np.asarray(angle) + np.pi, 2.0 * np.pi) - np.pi


def least_theta(muscle: BroadMuscle, rotations: Array, neutral: float) -> Array:
    """Return the theta (k,) of least E for rotations (k, 3, 3): the best dip of a scan, refined.

    Where every band is straight over a range, the end of that range nearest to `neutral`.
    """
    thetas = circle(SCAN)
    E = total_at(muscle, rotations[:, np.newaxis], thetas)
    dips = (E <= np.roll(E, 1, axis=1)) & (E <= np.roll(E, -1, axis=1))
    deepest = np.argsort(np.where(dips, E, np.inf), axis=1)[:, :DIPS]
    theta = deepest_of(muscle, rotations, thetas[deepest])
    # a minimum shows its place only to the root of the precision; its slope shows it fully
    for reach in (1e-5, 1e-7):
        low, high = (slope_at(muscle, rotations, theta + end) for end in (-reach, reach))
        valley = (low < 0.0) & (high > 0.0)
        theta = theta + reach * (low + high) / np.where(valley, low - high, np.inf)
    straight = straight_at(muscle, rotations[:, np.newaxis], thetas)
    plateau = straight.any(axis=1)
    if plateau.any():
        theta[plateau] = nearest_straight(muscle, rotations[plateau], neutral, straight[plateau])
    return in_circle(theta)


def deepest_of(muscle: BroadMuscle, rotations: Array, theta: Array) -> Array:
    """Return the best (k,) of candidates (k, j), each followed by ever finer scans."""
    step = 2.0 * np.pi / SCAN
    turned = rotations[:, np.newaxis, np.newaxis]
    while step > 1e-9:
        finer = theta[..., np.newaxis] + step * np.linspace(-1.0, 1.0, 25)
        E = total_at(muscle, turned, finer)
        theta = np.take_along_axis(finer, E.argmin(axis=-1)[..., np.newaxis], axis=-1)[..., 0]
        step /= 8.0
    best = total_at(muscle, rotations[:, np.newaxis], theta).argmin(axis=1)
    return theta[np.arange(len(theta)), best]


def nearest_straight(
    muscle: BroadMuscle, rotations: Array, neutral: float, straight: Array
) -> Array:
    """Return the theta (k,) nearest to neutral at which all is straight, by bisection.

    straight (k, SCAN) tells where on the scanned circle it is.
    """
    away = np.where(straight, in_circle(circle(SCAN) - neutral), np.inf)
    good = np.take_along_axis(away, np.abs(away).argmin(axis=1)[:, np.newaxis], axis=1)[:, 0]
    bad = good - np.copysign(np.minimum(np.abs(good), 2.0 * np.pi / SCAN), good)
    for _ in range(40):
        middle = 0.5 * (good + bad)
        fine = straight_at(muscle, rotations, neutral + middle)
        good, bad = np.where(fine, middle, good), np.where(fine, bad, middle)
    good = np.where(straight_at(muscle, rotations, neutral), 0.0, good)
    return neutral + good


def neutral_theta(muscle: BroadMuscle) -> float:
    """Return theta with the arm at the side."""
    return float(least_theta(muscle, np.eye(3)[np.newaxis], 0.0)[0])


class Moments(NamedTuple):
    """Moment vectors by differences, and what is known of their error."""

    vectors: Array  # (n, 3), m
    error: float  # m, the last correction
    smooth: bool  # no band changes its wrap state within the differences


def moment_vectors(
    muscle: BroadMuscle, rotation: Array, neutral: float, step: float = 8e-3
) -> Moments:
    """Return -dL/domega of every band: central differences of the whole solution, extrapolated.

    Three steps, each half the one before, make the error that of the sixth order in the step.
    """
    steps = step * np.array([1.0, 0.5, 0.25])
    turns = np.einsum('h,s,ij->hsij', steps, [1.0, -1.0], np.eye(3)).reshape(-1, 3)
    turned = Rotation.from_rotvec(turns).as_matrix() @ rotation
    theta = least_theta(muscle, turned, neutral)
    around = theta + 2.0 * STENCIL * np.array([[-1.0], [0.0], [1.0]])
    found = chain(muscle, turned, around)
    ends = np.stack([one.length[1] for one in found], axis=-1).reshape(3, 2, 3, -1)
    slopes = (ends[:, 0] - ends[:, 1]) / (2.0 * steps[:, np.newaxis, np.newaxis])
    once = (4.0 * slopes[1:] - slopes[:-1]) / 3.0
    twice = (16.0 * once[1] - once[0]) / 15.0
    states = np.stack([one.state for one in found])
    straight = bool((states[:, 1] != WRAPPED).all())  # theta matters to no length then
    smooth = straight or bool((states == states[:, :1, :1]).all())
    return Moments(-twice.T, float(np.abs(twice - once[1]).max()), smooth)


def mirrored(muscle: BroadMuscle) -> BroadMuscle:
    """Return the left shoulder's muscle in a left frame (x to the body's right), mirrored by hand.

    Points change x. A plane's normal is an axial vector: it changes y and z, and angles about lines
    change their sense. Of a sphere's moving frame x and y mirror, z = x cross (SC - P) is axial.
    """
    point, axial = np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0])
    moving = np.array(muscle.sphere_frames)[:, np.newaxis] == 'moving'
    return replace(
        muscle,
        origins=muscle.origins * point,
        insertions=muscle.insertions * point,
        sphere_centres=muscle.sphere_centres * np.where(moving, [1.0, 1.0, -1.0], point),
        ground_point=muscle.ground_point * point if moving.any() else None,
        humeral_point=muscle.humeral_point * point if moving.any() else None,
        plane_angles=-muscle.plane_angles,
        reference_normal=muscle.reference_normal * axial,
    )


def mirrored_rotation(rotation: Array) -> Array:
    """Return the left shoulder's rotation in its own frame for a right shoulder's (3, 3)."""
    mirror = np.diag([-1.0, 1.0, 1.0])
    return mirror @ rotation @ mirror
