# SPDX-License-Identifier: Apache-2.0
"""The flat layout: a muscle as one sequence of numbers, in m and rad, as the kernels read it.

First the reference normal N and the points SC and HM, then BAND_SIZE numbers for each band: its
origin P, its insertion S (humerus frame), its sphere's centre, the sphere's radius, the cosine and
the sine of phi, and what the sphere moves with.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..types import Floats
from .compilation import compiled
from .vectors import Vector

Muscle = list[float] | Floats
"""A list where nothing is compiled: its numbers are read faster one by one."""

# where numbers start in a muscle, and in a band
NORMAL, GROUND_POINT, HUMERAL_POINT, FIRST_BAND = 0, 3, 6, 9
ORIGIN, INSERTION, CENTRE, RADIUS, COS_PHI, SIN_PHI, FRAME, BAND_SIZE = 0, 3, 6, 9, 10, 11, 12, 13

MOVING, GROUND, HUMERUS = range(3)  # its band's moving frame, the ground, the humerus
FRAME_CODES = {'moving': MOVING, 'ground': GROUND, 'humerus': HUMERUS}


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
    sphere_frames: Sequence[str],
) -> Floats:
    """Pack a muscle of n bands into its flat sequence.

    Parameters
    ----------
    normal, ground_point, humeral_point
        (3,) N, SC and HM, m; None for points that no sphere needs.
    origins, insertions, sphere_centres
        (n, 3) m, each in its own frame.
    sphere_radii, cos_phi, sin_phi
        (n,) m and 1.
    sphere_frames
        n keys of FRAME_CODES.

    """
    n = len(origins)
    muscle = np.zeros(muscle_size(n))
    points = (NORMAL, normal), (GROUND_POINT, ground_point), (HUMERAL_POINT, humeral_point)
    for place, point in points:
        if point is not None:
            muscle[place : place + 3] = point
    bands = muscle[FIRST_BAND:].reshape(n, BAND_SIZE)
    for place, vectors in (ORIGIN, origins), (INSERTION, insertions), (CENTRE, sphere_centres):
        bands[:, place : place + 3] = vectors
    bands[:, RADIUS], bands[:, COS_PHI], bands[:, SIN_PHI] = sphere_radii, cos_phi, sin_phi
    bands[:, FRAME] = [FRAME_CODES[frame] for frame in sphere_frames]
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
    """Return its sphere's radius, cos(phi), sin(phi), and MOVING, GROUND or HUMERUS."""
    k = band_place(i)
    return muscle[k + RADIUS], muscle[k + COS_PHI], muscle[k + SIN_PHI], int(muscle[k + FRAME])
