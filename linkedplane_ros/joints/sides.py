# SPDX-License-Identifier: Apache-2.0
"""The two sides of the body: the left shoulder is the mirror image of the right, x -> -x.

Both frames have x to the body's right, y anterior and z superior. Each function here takes what is
of one side to the other; twice, it changes nothing.
"""

from __future__ import annotations

import numpy as np

from ..errors import LinkedPlaneError
from ..types import Floats

SIDES = ('right', 'left')
AXIS_SIGN = {'right': 1.0, 'left': -1.0}
"""What y and z of the right side's axes and moments are multiplied by, for those of a side."""
_POINTS: Floats = np.array([-1.0, 1.0, 1.0])
_AXES: Floats = -_POINTS


def check_side(side: str) -> None:
    """Refuse what is not a side of the body."""
    if side not in SIDES:
        raise LinkedPlaneError(f"side: {side!r} given, 'right' or 'left' expected")


def mirror_points(points: Floats) -> Floats:
    """Return points, or other true vectors, (..., 3) mirrored: (-x, y, z)."""
    return points * _POINTS


def mirror_axes(axes: Floats) -> Floats:
    """Return axes of rotation, or moments, (..., 3) mirrored: (x, -y, -z)."""
    return axes * _AXES


def mirror_columns(axes: Floats) -> Floats:
    """Return axes of rotation that are the columns of (..., 3, 3), mirrored."""
    return axes * _AXES[:, np.newaxis]


def mirror_poses(poses: Floats) -> Floats:
    """Return poses (..., 3, 4), R and t side by side, mirrored."""
    return poses * np.outer(_POINTS, [*_POINTS, 1.0]) + 0.0  # -0.0 is 0.0


def mirror_screws(screws: Floats) -> Floats:
    """Return screws (w, v), or wrenches (moment, force), (..., 6) mirrored."""
    return screws * np.concatenate((_AXES, _POINTS))


def mirror_rotation(rotation: Floats) -> Floats:
    """Return a (3, 3) rotation mirrored: by the same angle about the mirrored axis, back."""
    return rotation * np.outer(_POINTS, _POINTS) + 0.0  # -0.0 is 0.0
