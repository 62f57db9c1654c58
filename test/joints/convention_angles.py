# SPDX-License-Identifier: Apache-2.0
"""Angles of all conventions, and rotations about an axis."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from reference import Array
from scipy.spatial.transform import Rotation


def rotation_about(axis: Array, angle: float) -> Array:
    """Return the rotation (3, 3) by an angle (rad) about an axis of any length."""
    return Rotation.from_rotvec(angle * np.asarray(axis) / np.linalg.norm(axis)).as_matrix()


def random_angles(count: int, seed: int) -> Array:
    """Return angles (count, 3) with the second one where every convention answers it: 0..90 deg."""
    rng = np.random.default_rng(seed)
    return rng.uniform([-3.1, 0.1, -3.1], [3.1, 1.5, 3.1], (count, 3))


ANGLES = random_angles(200, seed=5)
angle = st.floats(-10.0, 10.0, allow_subnormal=False)
