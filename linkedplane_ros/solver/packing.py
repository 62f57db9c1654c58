# SPDX-License-Identifier: Apache-2.0
"""A broad muscle as the kernels read it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..linked_planes.compilation import COMPILED
from ..linked_planes.layout import PointBones, pack_muscle
from ..muscle.broad_muscle import BroadMuscle


def pack_broad_muscle(muscle: BroadMuscle, bones: PointBones) -> Any:
    """Return the muscle as the kernels read it: an array compiled, a list, faster, if not."""
    numbers = pack_muscle(
        muscle.reference_normal,
        muscle.ground_point,
        muscle.humeral_point,
        muscle.origins,
        muscle.insertions,
        muscle.sphere_centres,
        muscle.sphere_radii,
        np.cos(muscle.plane_angles),
        np.sin(muscle.plane_angles),
        bones,
    )
    return numbers if COMPILED else numbers.tolist()
