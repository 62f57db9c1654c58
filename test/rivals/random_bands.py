# SPDX-License-Identifier: Apache-2.0
"""Random path models of the size of a shoulder, and what tests ask of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros.rivals import (
    Bands,
    CappedCylinder,
    Cylinder,
    DoubleCylinder,
    PathModel,
    Sphere,
    Straight,
    ViaPoints,
)

Model = type[PathModel]
MODELS: tuple[Model, ...] = (
    Straight, ViaPoints, Sphere, Cylinder, DoubleCylinder, CappedCylinder,
)  # fmt: skip
BONES = ('scapula', 'humerus')
POINTS = ('origin', 'insertion', 'centre', 'second_centre')
AXES = ('axis', 'second_axis')


def random_model(kind: Model, rng: np.random.Generator) -> PathModel:
    """Return a random model of a kind; m."""

    def point(spread: float) -> tuple[float, ...]:
        return tuple((spread * rng.normal(size=3)).tolist())

    def obstacle() -> dict:
        return {'radius': float(rng.uniform(0.01, 0.04)), 'bone': BONES[rng.integers(2)]}

    P, S, C, w = point(0.06), point(0.08), point(0.02), point(1.0)
    if kind is Straight:
        return Straight(P, S)
    if kind is ViaPoints:
        counts = rng.integers(0, 3, 2)
        first, second = (tuple(point(0.05) for _ in range(count)) for count in counts)
        return ViaPoints(P, S, first, second)
    if kind is Sphere:
        return Sphere(P, S, C, **obstacle())
    if kind is Cylinder:
        return Cylinder(P, S, C, w, **obstacle())
    if kind is CappedCylinder:
        turn = ('right-handed', 'left-handed', 'shorter')[rng.integers(3)]
        return CappedCylinder(P, S, C, w, turn=turn, **obstacle())
    second = {f'second_{name}': value for name, value in obstacle().items()}
    second.update(second_centre=point(0.03), second_axis=point(1.0))
    return DoubleCylinder(P, S, C, w, **obstacle(), **second)


def random_models(kind: Model, count: int, seed: int = 0) -> list[PathModel]:
    """Return random models of a kind."""
    rng = np.random.default_rng(seed)
    return [random_model(kind, rng) for _ in range(count)]


def random_rotations(count: int, seed: int = 1) -> Array:
    """Return random rotations (count, 3, 3), any at all."""
    return Rotation.random(count, np.random.default_rng(seed)).as_matrix()


def turned_model(model: PathModel, Q: Array) -> PathModel:
    """Return a model with both bones turned about the joint's centre."""

    def turn(value: tuple[float, ...]) -> tuple[float, ...]:
        return tuple((Q @ np.array(value)).tolist())

    changed = {
        field.name: turn(getattr(model, field.name))
        for field in fields(model)
        if field.name in POINTS + AXES
    }
    if isinstance(model, ViaPoints):
        for name in ('on_scapula', 'on_humerus'):
            changed[name] = tuple(turn(point) for point in getattr(model, name))
    return replace(model, **changed)


def length_slopes(bands: Bands, R: Array, h: float) -> Array:
    """Return dL/domega (n, 3) by solving anew at turns of h and h / 2 (rad); error of h^4."""
    steps = h * np.array((-1.0, -0.5, 0.5, 1.0))
    turns = Rotation.from_rotvec(np.einsum('h,ij->hij', steps, np.eye(3)).reshape(-1, 3))
    L = bands.solve_batch(turns.as_matrix() @ R).lengths.reshape(4, 3, -1)
    return ((8.0 * (L[2] - L[1]) - (L[3] - L[0])) / (6.0 * h)).T


Outside = Callable[[Array], Array]  # moves points (..., 3) that are in obstacles onto their surface


def keep_out_of_sphere(C: Array, R: Array) -> Outside:
    """Return what keeps points (k, j, 3) out of k spheres."""

    def outside(x: Array) -> Array:
        v = x - C[:, np.newaxis]
        size = np.linalg.norm(v, axis=-1, keepdims=True)
        return np.where(size < R[:, np.newaxis, np.newaxis],
                        C[:, np.newaxis] + v / size * R[:, np.newaxis, np.newaxis], x)  # fmt: skip

    return outside


def keep_out_of_cylinder(C: Array, w: Array, R: Array) -> Outside:
    """Return what keeps points (k, j, 3) out of k endless cylinders of unit axes w."""

    def outside(x: Array) -> Array:
        v = x - C[:, np.newaxis]
        along = np.einsum('kji,ki->kj', v, w)[..., np.newaxis] * w[:, np.newaxis]
        size = np.linalg.norm(v - along, axis=-1, keepdims=True)
        onto = (
            C[:, np.newaxis]
            + along
            + (v - along) / np.maximum(size, 1e-30) * R[:, np.newaxis, np.newaxis]
        )
        return np.where(size < R[:, np.newaxis, np.newaxis], onto, x)

    return outside


def keep_out_of_capped_cylinder(C: Array, w: Array, R: Array) -> Outside:
    """Return what keeps points (k, j, 3) out of k cylinders capped at C; axes to the caps."""
    sphere, cylinder = keep_out_of_sphere(C, R), keep_out_of_cylinder(C, w, R)

    def outside(x: Array) -> Array:
        above = np.einsum('kji,ki->kj', x - C[:, np.newaxis], w) > 0.0
        return np.where(above[..., np.newaxis], sphere(x), cylinder(x))

    return outside


def taut_lengths(knots: Array, outside: Outside, reach: Array, parts: int) -> Array:
    """Return the lengths (k,) of strings pulled taut from polylines (k, j, 3) through their knots.

    The strings are `parts` equal parts; each inner point in turn goes where its neighbours pull it,
    no farther than `reach` (k), so that it jumps no obstacle, then out of it. Two numbers of parts
    give the length without most of the parts' own error, which falls with their square.
    """
    lengths = []
    for n in (parts, 2 * parts):
        at = np.linspace(0.0, knots.shape[1] - 1.0, n + 1)
        k = np.minimum(at.astype(int), knots.shape[1] - 2)
        part = (at - k)[:, np.newaxis]
        x = outside((1.0 - part) * knots[:, k] + part * knots[:, k + 1])
        x[:, [0, -1]] = knots[:, [0, -1]]
        for sweep in range(8 * n):
            # over-relaxed once the string lies about where it will stay
            over = 1.0 if sweep < 2 * n else 2.0 / (1.0 + np.sin(np.pi / n))
            for odd in (1, 2):
                inner = x[:, odd:-1:2]
                pulled = 0.5 * (x[:, odd - 1 : -2 : 2] + x[:, odd + 1 :: 2])
                step = over * (pulled - inner)
                size = np.linalg.norm(step, axis=2, keepdims=True)
                step *= np.minimum(1.0, reach[:, np.newaxis, np.newaxis] / np.maximum(size, 1e-30))
                x[:, odd:-1:2] = outside(inner + step)
        lengths.append(np.linalg.norm(np.diff(x, axis=1), axis=2).sum(axis=1))
    return (4.0 * lengths[1] - lengths[0]) / 3.0


def spiral_polylines(P: Array, S: Array, C: Array, w: Array, R: Array) -> Array:
    """Return polylines (k, 33, 3) from P to S, right-handed about the axes w, well off them."""
    part = np.linspace(0.0, 1.0, 33)[:, np.newaxis, np.newaxis]
    p, s = P - C, S - C
    pz, sz = ((x * w).sum(axis=1, keepdims=True) for x in (p, s))
    p, s = p - pz * w, s - sz * w
    rP, rS = (np.linalg.norm(x, axis=1, keepdims=True) for x in (p, s))
    x = p / rP
    y = np.cross(w, x)
    turn = np.arctan2((s * y).sum(axis=1), (s * x).sum(axis=1))[:, np.newaxis] % (2.0 * np.pi)
    wide = np.maximum((1.0 - part) * rP + part * rS, 1.3 * R[:, np.newaxis])
    around = np.cos(part * turn) * x + np.sin(part * turn) * y
    points = C + ((1.0 - part) * pz + part * sz) * w + wide * around
    points[0], points[-1] = P, S
    return points.swapaxes(0, 1)
