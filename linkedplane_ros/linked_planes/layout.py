# SPDX-License-Identifier: Apache-2.0
"""The flat layout: a muscle as one sequence of numbers, in m and rad, as the kernels read it.

First the reference normal N and the points SC and HM, with the bone of each, then BAND_SIZE
numbers for each band: its origin P, its insertion S, its sphere's centre, the sphere's radius, the
cosine and the sine of phi, what the sphere moves with, and the bones of P and S. A point stands in
the frame of its bone. Bones are numbered: GROUND, then those that move.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..types import Floats
from .compilation import compiled
from .vectors import Vector

Muscle = list[float] | Floats
"""A list where nothing is compiled: its numbers are read faster one by one."""

# where numbers start in a muscle, and in a band
NORMAL, GROUND_POINT, HUMERAL_POINT, NORMAL_BONE, FIRST_BAND = 0, 3, 6, 9, 12
ORIGIN, INSERTION, CENTRE, RADIUS, COS_PHI, SIN_PHI, FRAME = 0, 3, 6, 9, 10, 11, 12
ORIGIN_BONE, BAND_SIZE = 13, 15

MOVING, GROUND, HUMERUS = -1, 0, 1  # its band's moving frame; the two bones of a ball joint


class PointBones(NamedTuple):
    """The number of the bone that each point of a muscle of n bands belongs to."""

    normal: int
    ground_point: int
    humeral_point: int
    origins: Sequence[int]
    """(n)"""
    insertions: Sequence[int]
    """(n)"""
    spheres: Sequence[int]
    """(n) MOVING for those in a moving frame."""


def pack_muscle(
    normal: npt.ArrayLike,
    ground_point: npt.ArrayLike | None,
    humeral_point: npt.ArrayLike | None,
    origins: Floats,
    insertions: Floats,
    sphere_centres: Floats,
    sphere_radii: Floats,
    cos_phi: Floats,
    sin_phi: Floats,
    bones: PointBones,
) -> Floats:
    """Pack a muscle of n bands into its flat sequence.

    Parameters
    ----------
    normal, ground_point, humeral_point
        (3,) N, SC and HM, m; None for points that no sphere needs.
    origins, insertions, sphere_centres
        (n, 3) m, each in the frame of its bone, or in its moving frame.
    sphere_radii, cos_phi, sin_phi
        (n,) m and 1.
    bones
        What the points belong to.

    """
    n = len(origins)
    muscle = np.zeros(muscle_size(n))
    points = (NORMAL, normal), (GROUND_POINT, ground_point), (HUMERAL_POINT, humeral_point)
    for place, point in points:
        if point is not None:
            muscle[place : place + 3] = point
    muscle[NORMAL_BONE:FIRST_BAND] = bones.normal, bones.ground_point, bones.humeral_point
    bands = muscle[FIRST_BAND:].reshape(n, BAND_SIZE)
    for place, vectors in (ORIGIN, origins), (INSERTION, insertions), (CENTRE, sphere_centres):
        bands[:, place : place + 3] = vectors
    bands[:, RADIUS], bands[:, COS_PHI], bands[:, SIN_PHI] = sphere_radii, cos_phi, sin_phi
    bands[:, FRAME] = bones.spheres
    bands[:, ORIGIN_BONE], bands[:, ORIGIN_BONE + 1] = bones.origins, bones.insertions
    return muscle


def muscle_size(bands: int) -> int:
    """Return how many numbers a muscle of so many bands has."""
    return FIRST_BAND + BAND_SIZE * bands


@compiled
def band_count(muscle: Muscle) -> int:
    """Return the number of bands of a muscle."""
    return (len(muscle) - FIRST_BAND) // BAND_SIZE


@compiled
def vector(numbers: Muscle, k: int) -> Vector:
    """Return the vector that starts at the k-th number."""
    return numbers[k], numbers[k + 1], numbers[k + 2]


@compiled
def band_place(i: int) -> int:
    """Return where the numbers of the i-th band start."""
    return FIRST_BAND + BAND_SIZE * i


@compiled
def band_vectors(muscle: Muscle, i: int) -> tuple[Vector, Vector, Vector]:
    """Return a band's origin, its insertion and its sphere's centre."""
    k = band_place(i)
    return (
        vector(muscle, k + ORIGIN),
        vector(muscle, k + INSERTION),
        vector(muscle, k + CENTRE),
    )


@compiled
def band_numbers(muscle: Muscle, i: int) -> tuple[float, float, float, int]:
    """Return its sphere's radius, cos(phi), sin(phi), and MOVING or the sphere's bone."""
    k = band_place(i)
    return muscle[k + RADIUS], muscle[k + COS_PHI], muscle[k + SIN_PHI], int(muscle[k + FRAME])


@compiled
def band_bones(muscle: Muscle, i: int) -> tuple[int, int]:
    """Return the bones of a band's origin and of its insertion."""
    k = band_place(i) + ORIGIN_BONE
    return int(muscle[k]), int(muscle[k + 1])


@compiled
def point_bones(muscle: Muscle) -> tuple[int, int, int]:
    """Return the bones of N, SC and HM."""
    k = NORMAL_BONE
    return int(muscle[k]), int(muscle[k + 1]), int(muscle[k + 2])
