# SPDX-License-Identifier: Apache-2.0
"""A packed muscle has every point with its own bone, and places each with that bone's pose."""

import numpy as np
from scipy.spatial.transform import Rotation

from linkedplane_ros.linked_planes.bones import place_muscle
from linkedplane_ros.linked_planes.layout import (
    GROUND_POINT,
    HUMERAL_POINT,
    MOVING,
    NORMAL,
    PointBones,
    band_bones,
    band_count,
    band_numbers,
    band_vectors,
    pack_muscle,
    point_bones,
    vector,
)

RNG = np.random.default_rng(18)
POINTS = RNG.normal(size=(3, 3))  # N, SC, HM
ENDS = RNG.normal(size=(3, 2, 3))  # origins, insertions, centres
BONES = PointBones(1, 2, 3, (3, 0), (2, 1), (3, MOVING))
MUSCLE = pack_muscle(*POINTS, *ENDS, np.ones(2), np.ones(2), np.zeros(2), BONES)


def test_every_point_keeps_its_bone() -> None:
    assert band_count(MUSCLE) == 2
    assert point_bones(MUSCLE) == (1, 2, 3)
    assert [band_bones(MUSCLE, i) for i in range(2)] == [(3, 2), (0, 1)]
    assert [band_numbers(MUSCLE, i)[3] for i in range(2)] == [3, MOVING]


def test_every_point_is_placed_with_its_bone() -> None:
    R, t = Rotation.random(3, RNG).as_matrix(), RNG.normal(size=(3, 3))
    placed = place_muscle(MUSCLE, np.concatenate((R, t[..., np.newaxis]), axis=2))

    def by_hand(point: np.ndarray, bone: int, shift: float = 1.0) -> np.ndarray:
        return point if bone < 1 else R[bone - 1] @ point + shift * t[bone - 1]

    places = (NORMAL, GROUND_POINT, HUMERAL_POINT)
    for place, point, bone, shift in zip(places, POINTS, (1, 2, 3), (0.0, 1.0, 1.0), strict=True):
        np.testing.assert_allclose(vector(placed, place), by_hand(point, bone, shift), atol=1e-14)
    for i in range(2):
        bones = BONES.origins[i], BONES.insertions[i], BONES.spheres[i]
        for found, point, bone in zip(band_vectors(placed, i), ENDS[:, i], bones, strict=True):
            np.testing.assert_allclose(found, by_hand(point, bone), atol=1e-14)
