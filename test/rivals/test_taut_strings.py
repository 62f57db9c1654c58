# SPDX-License-Identifier: Apache-2.0
"""The rivals' lengths against strings that are pulled taut round the obstacles, point by point."""

from __future__ import annotations

import numpy as np
from random_bands import (
    keep_out_of_capped_cylinder,
    keep_out_of_cylinder,
    keep_out_of_sphere,
    random_models,
    spiral_polylines,
    taut_lengths,
)
from reference import Array

from linkedplane_ros import WrapState
from linkedplane_ros.rivals import (
    Bands,
    CappedCylinder,
    Cylinder,
    DoubleCylinder,
    PathModel,
    Sphere,
)

STILL = np.eye(3)


def unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def field(models: list[PathModel], name: str) -> Array:
    return np.array([getattr(model, name) for model in models])


def wrapped(models: list[PathModel], count: int) -> tuple[list[PathModel], Array, Array]:
    """Return the first wrapped ones, with the bones together; their lengths and contacts."""
    state = Bands(models).solve(STILL)
    chosen = np.flatnonzero(state.wrap == WrapState.WRAPPED)[:count]
    assert len(chosen) == count
    return [models[i] for i in chosen], state.lengths[chosen], state.contacts[chosen]


def thick(models: list[PathModel], least: float = 0.02) -> list[PathModel]:
    """Return those of a good radius: on thin ones the parts of a string are too coarse."""
    return [model for model in models if model.radius >= least]


def test_no_string_round_a_sphere_is_shorter() -> None:
    models, lengths, _ = wrapped(thick(random_models(Sphere, 600)), 40)
    P, S, C, R = (field(models, name) for name in ('origin', 'insertion', 'centre', 'radius'))
    string = taut_lengths(np.stack((P, S), axis=1), keep_out_of_sphere(C, R), 0.4 * R, 32)
    # m: the string's parts are up to 3 mm long on a radius of 20 mm or more
    np.testing.assert_allclose(string, lengths, rtol=0, atol=1e-5)


def test_no_string_that_turns_right_handed_about_a_cylinder_is_shorter() -> None:
    models, lengths, _ = wrapped(thick(random_models(Cylinder, 300)), 40)
    P, S, C, R = (field(models, name) for name in ('origin', 'insertion', 'centre', 'radius'))
    w = unit(field(models, 'axis'))
    string = taut_lengths(
        spiral_polylines(P, S, C, w, R), keep_out_of_cylinder(C, w, R), 0.4 * R, 32
    )
    # m: as above, but long helices have longer parts
    np.testing.assert_allclose(string, lengths, rtol=0, atol=5e-5)


def capped(count: int) -> list[PathModel]:
    """Return bands of the shorter way past a shaft along -z, from above, half of them reversed."""
    rng = np.random.default_rng(4)
    models: list[PathModel] = []
    for i in range(count):
        high = rng.normal((0, 0, 0.02), (0.04, 0.04, 0.01))
        low = rng.normal((0, 0, -0.05), (0.05, 0.05, 0.02))
        P, S = (tuple(end.tolist()) for end in ((high, low) if i % 2 else (low, high)))
        R = float(rng.uniform(0.02, 0.04))
        models.append(CappedCylinder(P, S, (0, 0, 0), (0, 0, 1), R, 'scapula', 'shorter'))
    return models


def test_no_string_on_any_side_of_a_capped_cylinder_is_shorter() -> None:
    """From the right, from the left and from over the cap: what they find is what there is."""
    models, lengths, contacts = wrapped(capped(400), 60)
    assert (np.bincount(contacts)[1:] >= 8).all()
    P, S, C, R = (field(models, name) for name in ('origin', 'insertion', 'centre', 'radius'))
    w = field(models, 'axis').astype(float)
    outside = keep_out_of_capped_cylinder(C, w, R)
    over = np.stack((P, C + 2.0 * R[:, np.newaxis] * w, S), axis=1)
    strings = [
        taut_lengths(start, outside, 0.4 * R, 24)
        for start in (spiral_polylines(P, S, C, w, R), spiral_polylines(P, S, C, -w, R), over)
    ]
    # m: as for a sphere, with longer parts
    np.testing.assert_allclose(np.min(strings, axis=0), lengths, rtol=0, atol=2e-5)


def in_a_row(count: int) -> list[PathModel]:
    """Return bands past two cylinders that are one after the other, each on either side."""
    rng = np.random.default_rng(2)

    def near(*point: float, spread: float) -> tuple[float, ...]:
        return tuple((np.array(point) + spread * rng.normal(size=3)).tolist())

    def cylinder(x: float) -> tuple:
        centre, axis = near(x, 0, 0, spread=0.01), near(0, rng.choice((-1, 1)), 0, spread=0.3)
        return centre, axis, float(rng.uniform(0.015, 0.03)), 'scapula'

    return [
        DoubleCylinder(near(-0.1, 0, 0, spread=0.015), near(0.19, 0, 0, spread=0.015),
                       *cylinder(0.0), *cylinder(0.09))
        for _ in range(count)
    ]  # fmt: skip


def test_no_string_on_the_sides_of_two_cylinders_is_shorter() -> None:
    models, lengths, contacts = wrapped(in_a_row(60), 50)
    assert (np.bincount(contacts)[1:] >= 4).all()
    P, S = field(models, 'origin'), field(models, 'insertion')
    knots, keep = [P], []
    for prefix in ('', 'second_'):
        C, R = field(models, prefix + 'centre'), field(models, prefix + 'radius')
        w = unit(field(models, prefix + 'axis'))
        keep.append(keep_out_of_cylinder(C, w, R))
        knots.append(C + 1.3 * R[:, np.newaxis] * unit(np.cross(S - P, w)))
    string = taut_lengths(
        np.stack((*knots, S), axis=1), lambda x: keep[1](keep[0](x)), np.full(len(P), 0.006), 32
    )
    # m: a string of 0.3 m has parts of 5 mm
    np.testing.assert_allclose(string, lengths, rtol=0, atol=5e-5)
