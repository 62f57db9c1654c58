# SPDX-License-Identifier: Apache-2.0
"""Vectors as tuples, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkedplane_ros.linked_planes import vectors

ROUNDING = 1e-15  # of a sum of three products of numbers near 1


@pytest.mark.parametrize('case', range(20))
def test_vectors_are_those_of_numpy(case: int) -> None:
    a, b, c = np.random.default_rng(case).normal(size=(3, 3))
    j, k, m = np.random.default_rng(case + 100).normal(size=3)
    R = Rotation.random(random_state=case).as_matrix()
    for found, expected in (
        (vectors.plus(a, b), a + b),
        (vectors.minus(a, b), a - b),
        (vectors.times(k, a), k * a),
        (vectors.mix(j, a, k, b), j * a + k * b),
        (vectors.blend(j, a, k, b, m, c), j * a + k * b + m * c),
        (vectors.dot(a, b), np.dot(a, b)),
        (vectors.cross(a, b), np.cross(a, b)),
        (vectors.norm(a), np.linalg.norm(a)),
        (vectors.turned(R, a), R @ a),
    ):
        np.testing.assert_allclose(found, expected, rtol=ROUNDING * 10, atol=ROUNDING * 10)
    np.testing.assert_array_equal(vectors.ZERO, np.zeros(3))
