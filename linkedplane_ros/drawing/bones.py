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
