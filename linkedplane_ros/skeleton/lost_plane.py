# SPDX-License-Identifier: Apache-2.0
"""Where a rhythm goes by a plane of elevation that the coordinates do not say.

An arm at the side has no plane of elevation, nor has one that is raised to 180 deg. Coordinates
that are plane and elevation themselves say it there, too; others give only the pose, and the plane
turns by any angle with the smallest movement.
"""

from __future__ import annotations

import numpy as np

from ..joints.conventions import JointConvention
from ..types import Floats
from .followed_girdle import FollowedGirdle
from .girdle import HUMERUS
from .rhythm import Rhythm
from .still_second import STRAIGHT_DOWN


def loses_plane(convention: JointConvention, rhythm: Rhythm) -> bool:
    """Return whether a rhythm goes by the plane, and a convention's coordinates do not say it."""
    return rhythm.needs_plane and FollowedGirdle(convention, rhythm).slopes is None


def caution_of(convention: JointConvention, rhythm: Rhythm) -> tuple[str, ...]:
    """Return a line on where moment arms jump; none if they do nowhere."""
    if not loses_plane(convention, rhythm):
        return ()
    return (
        f'rhythm {rhythm} goes by the plane of elevation, which {convention.name} does not say of '
        f'an arm at the side: lengths and moment arms jump there; {HUMERUS.name} is smooth',
    )


def count_without_plane(girdle: FollowedGirdle, angles: Floats) -> int:
    """Return at how many angles (m, 3), rad, the plane is lost: within 5 deg of the pole."""
    if not loses_plane(girdle.convention, girdle.rhythm):
        return 0
    rotations, _ = girdle.convention.rotations_and_axes(angles)
    sines = np.hypot(rotations[:, 0, 2], rotations[:, 1, 2])
    return int(np.sum(sines < np.sin(STRAIGHT_DOWN)))
