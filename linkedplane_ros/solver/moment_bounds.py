# SPDX-License-Identifier: Apache-2.0
"""How long moment arms are at most, as a rule: longer ones are true, but hang on very little."""

from __future__ import annotations

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats

REACH_FACTOR = 3.0
"""Of the insertion's reach. 1: a stretched band pulls at its insertion with its own tension, with a
lever of no more than the reach. 2: where it turns right back it presses on its sphere with twice
its tension, and a sphere that follows the arm passes that on. The forces that hold a plane to its
neighbours are not in this: they grow without bound where theta turns faster than the arm."""


def moment_arm_bounds(muscle: BroadMuscle) -> Floats:
    """Return the bound above which a moment arm, about any axis, is worth a warning.

    No pose of the bundled models' ranges of motion exceeds it. Outside them moment arms do, where
    theta turns much faster than the arm: at the edge of a sphere, or where a plane's normal nearly
    vanishes. They are the true derivatives of lengths that change that fast (`bench/moments.py`
    proves it by differences of lengths), but a small error of the pose changes them a lot.

    Returns
    -------
    Floats
        (n,) m: REACH_FACTOR times the distance of each band's insertion from the joint's centre.

    """
    return REACH_FACTOR * np.asarray(np.linalg.norm(muscle.insertions, axis=1))
