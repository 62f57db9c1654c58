# SPDX-License-Identifier: Apache-2.0
"""Bones as pictures and markers show them, schematic; m."""

from __future__ import annotations

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Colour, Floats

BONE: Colour = (0.89, 0.85, 0.76)
HEAD_RADIUS = 0.024  # of the humeral head
SHAFT_RADIUS = 0.012
SHAFT_START, SHAFT_END = 0.01, 0.22  # below the glenohumeral centre


def shaft_axis(muscle: BroadMuscle) -> Floats:
    """Return the upper and lower end (2, 3), m, of the humeral shaft's axis, humerus frame.

    As in a humerus, it runs beside the centre of the head: through the muscle's insertions.
    """
    aside = muscle.insertions.mean(axis=0) * (1.0, 1.0, 0.0)
    aside *= 1.0 - SHAFT_RADIUS / max(float(np.linalg.norm(aside)), SHAFT_RADIUS)
    return np.array([aside - (0.0, 0.0, depth) for depth in (SHAFT_START, SHAFT_END)])


def strut_points(muscle: BroadMuscle, bone: str) -> Floats:
    """Return the points (p, 3), m, that a model has on a bone, along it; frame of the bone.

    They are its origins, insertions, landmarks, and SC and HM where these are on it: of a clavicle,
    a line from the sternum to the shoulder.
    """
    bones, n = muscle.bones, len(muscle.band_names)
    points = [each.at for each in muscle.landmarks if each.bone == bone]
    for places, owners in (
        (muscle.origins, bones.of_bands('origin', n)),
        (muscle.insertions, bones.of_bands('insertion', n)),
        ([muscle.ground_point], [bones.ground_point]),
        ([muscle.humeral_point], [bones.humeral_point]),
    ):
        points += [each for each, owner in zip(places, owners, strict=True) if owner == bone]
    if len(points) < 2:
        return np.empty((0, 3))
    array = np.unique(np.array(points, dtype=np.float64), axis=0)
    apart = np.linalg.norm(array[:, np.newaxis] - array, axis=2)
    start, end = np.unravel_index(apart.argmax(), apart.shape)
    along = array @ (array[end] - array[start])
    return np.asarray(array[np.argsort(along, kind='stable')])
