# SPDX-License-Identifier: Apache-2.0
"""What is no model, and what is no pose, is refused in one line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from random_bands import Model, random_model, random_models

from linkedplane_ros import LinkedPlaneError
from linkedplane_ros.rivals import (
    Bands,
    CappedCylinder,
    Cylinder,
    DoubleCylinder,
    Sphere,
    Straight,
    ViaPoints,
)

STILL = np.eye(3)


@pytest.mark.parametrize(
    ('kind', 'changed', 'said'),
    [
        (Straight, {'origin': (0.0, 0.0)}, r'origin: \(0.0, 0.0\) given, 3 finite numbers in m'),
        (Straight, {'insertion': (0.0, 0.0, np.inf)}, r'insertion: .* given, 3 finite numbers'),
        (Straight, {'origin': np.zeros(2)}, r'origin: \[0.0, 0.0\] given, 3 finite numbers in m'),
        (Straight, {'origin': 'abc'}, "origin: 'abc' given, 3 finite numbers in m expected"),
        (Straight, {'origin': None}, 'origin: None given, 3 finite numbers in m expected'),
        (ViaPoints, {'on_humerus': ((0.0, np.nan, 0.0),)}, r'on_humerus\[0\]: .* given'),
        (Sphere, {'radius': 0.0}, r'radius: 0.0 given, a finite length > 0 in m expected'),
        (Sphere, {'radius': '1'}, "radius: '1' given, a finite length > 0 in m expected"),
        (Sphere, {'bone': ['ulna']}, r"bone: \['ulna'\] given, 'scapula' or 'humerus' expected"),
        (Sphere, {'bone': 'ulna'}, "bone: 'ulna' given, 'scapula' or 'humerus' expected"),
        (Cylinder, {'axis': (0.0, 0.0, 0.0)}, r'axis: .* given, 3 finite numbers, not all 0'),
        (DoubleCylinder, {'second_radius': np.nan}, 'second_radius: nan given'),
        (CappedCylinder, {'turn': 'over'}, "turn: 'over' given, one of right-handed, left-handed"),
    ],
)
def test_a_model_that_is_none_is_refused(kind: Model, changed: dict, said: str) -> None:
    with pytest.raises(LinkedPlaneError, match=said):
        replace(random_model(kind, np.random.default_rng(0)), **changed)


def test_bands_are_of_one_kind_and_poses_are_rotations() -> None:
    straight = random_models(Straight, 2)
    with pytest.raises(ValueError, match='models: 0 given, 1 or more of one kind expected'):
        Bands([])
    with pytest.raises(ValueError, match='models: 3 given, 1 or more of one kind expected'):
        Bands([*straight, *random_models(Sphere, 1)])
    with pytest.raises(ValueError, match=r'rotation: shape \(3,\) given, \(3, 3\) expected'):
        straight[0].solve((1, 2, 3))
    with pytest.raises(ValueError, match=r'rotation: R\^T R is not the identity'):
        straight[0].solve(2.0 * STILL)
    with pytest.raises(ValueError, match=r'rotations\[1\]: its determinant is -1'):
        Bands(straight).solve_batch([STILL, -STILL])
    with pytest.raises(ValueError, match='points: 1 given, at least 2 expected'):
        straight[0].solve(STILL).path(1)
    assert len(Bands(straight).solve_batch([])) == 0
