"""Bones for the eye alone, as pictures and markers show them; m."""

from __future__ import annotations

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats

BONE = (0.89, 0.85, 0.76)  # red, green, blue
HEAD_RADIUS = 0.024  # of the humeral head
SHAFT_RADIUS = 0.012
SHAFT_START, SHAFT_END = 0.01, 0.22  # below the glenohumeral centre


def shaft_axis(muscle: BroadMuscle) -> Floats:
    """Return the upper and lower end (2, 3) of the humeral shaft's axis, humerus frame.

    As in the humerus, it runs beside the centre of its head: where the muscle reaches it.
    """
    aside = muscle.insertions.mean(axis=0) * (1.0, 1.0, 0.0)
    aside *= 1.0 - SHAFT_RADIUS / max(float(np.linalg.norm(aside)), SHAFT_RADIUS)
    return np.array([aside - (0.0, 0.0, depth) for depth in (SHAFT_START, SHAFT_END)])
