# SPDX-License-Identifier: Apache-2.0
"""Where a muscle's ground bone stands in the view, which holds the root of its skeleton."""

from __future__ import annotations

import numpy as np

from ...joints.rotations import compose_poses, invert_poses
from ...node.articulated_frames import TF_INPUT
from ...types import Floats
from ..newest import MuscleInfo
from ..panels.ranges import rest_pose

STILL: Floats = np.eye(3, 4)


def pose_in_view(info: MuscleInfo, angles: Floats | None) -> Floats:
    """Return where the frame of the muscle's ground bone stands in the view.

    Parameters
    ----------
    info
        The muscle's. Without a skeleton that moves its ground, it holds still.
    angles
        (d,) its coordinates, rad or m; None: at rest.

    Returns
    -------
    Floats
        (3, 4) R and t, m, side by side: at rest the identity.

    """
    root = root_in_view(info)
    if root is None or info.skeleton is None or angles is None:
        return STILL
    if len(angles) != len(info.coordinates):  # of a node that was there before
        return STILL
    return compose_poses(root, info.skeleton.pose_ground(angles, info.side))


def root_in_view(info: MuscleInfo) -> Floats | None:
    """Return where the root of a muscle's skeleton stands in the view, (3, 4) as `pose_in_view`.

    None where joint states move no joint between it and the ground: the ground holds still.
    """
    skeleton = info.skeleton
    if skeleton is None or info.parameters.get('input') == TF_INPUT:
        return None
    if skeleton.links[0] == skeleton.tree.root:
        return None
    return invert_poses(skeleton.pose_ground(rest_pose(info), info.side))
