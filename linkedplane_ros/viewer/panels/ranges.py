# SPDX-License-Identifier: Apache-2.0
"""How far the coordinates of a muscle are moved by sliders, and where they are at rest."""

from __future__ import annotations

import math

import numpy as np

from ...joints.articulation import PRISMATIC
from ...joints.conventions import JointConvention
from ...joints.joint_state import FARTHEST, FULL_CIRCLE
from ...skeleton.skeleton import Skeleton
from ...types import Floats, Intervals
from ..newest import MuscleInfo

MAX_ELEVATION = math.radians(150.0)  # of sliders, if the model gives no range
MAX_TURN = math.radians(120.0)


def coordinate_ranges(info: MuscleInfo) -> Intervals:
    """Return the lowest and the highest value of each coordinate's slider, rad or m."""
    if info.skeleton is not None:
        return skeleton_ranges(info.skeleton)
    if info.obstacle:  # of a skeleton that is not known here
        return ((-math.pi, math.pi),) * len(info.coordinates)
    return slider_ranges(info.convention, info.motion)


def slider_ranges(convention: JointConvention, motion: Intervals | None) -> Intervals:
    """Return the lowest and the highest angle of each coordinate's slider, rad.

    Parameters
    ----------
    convention
        The coordinates'.
    motion
        The model's range of flexion, abduction and rotation; used for their convention only.

    """
    elevates = convention.middle[0] >= 0.0
    if motion is not None and not elevates:
        return motion
    middle = (0.0, MAX_ELEVATION) if elevates else (-MAX_TURN, MAX_TURN)
    return (-MAX_TURN, MAX_TURN), middle, (-MAX_TURN, MAX_TURN)


def skeleton_ranges(skeleton: Skeleton) -> Intervals:
    """Return the limits of a skeleton's joints, rad or m; of those without, half a turn."""
    ranges = []
    for kind, (low, high) in zip(skeleton.kinds, skeleton.limits, strict=True):
        if math.isinf(low) or math.isinf(high):
            low, high = max(low, -math.pi), min(high, math.pi)
        most = FARTHEST if kind == PRISMATIC else FULL_CIRCLE  # what a node takes
        ranges.append((max(low, -most), min(high, most)))
    return tuple(ranges)


def rest_pose(info: MuscleInfo) -> Floats:
    """Return the coordinates (d,) at rest, rad or m: zero, or what is nearest to it in range."""
    low, high = np.array(coordinate_ranges(info)).T
    return np.asarray(np.clip(0.0, low, high))


def rounded_ranges(info: MuscleInfo) -> Floats:
    """Return the ranges (d, 2) in the units that are shown, to a tenth, none wider than it was."""
    sizes = np.array([[unit.size] for unit in info.units])
    exact = np.array(coordinate_ranges(info)) / sizes
    near = 1e-3  # a range of 120 deg in a file is 119.999999 deg
    low, high = np.ceil(10.0 * exact[:, 0] - near), np.floor(10.0 * exact[:, 1] + near)
    rounded = np.column_stack((low, high)) / 10.0
    return np.where((low < high)[:, np.newaxis], rounded, exact) + 0.0
