# SPDX-License-Identifier: Apache-2.0
"""Values far beyond the limits of joints are found, with the likely cause."""

from __future__ import annotations

import numpy as np
import pytest
from random_urdfs import joint, link, robot

from linkedplane_ros import Skeleton
from linkedplane_ros.skeleton.joint_limits import JointLimits

LIMITED = '<axis xyz="1 0 0"/><limit lower="{}" upper="{}" effort="1" velocity="1"/>'
ARM = robot(
    *map(link, ('scapula', 'a', 'b', 'c', 'humerus', 'finger')),
    joint('slide', 'prismatic', 'scapula', 'a', LIMITED.format(-0.02, 0.02)),
    joint('lift', 'revolute', 'a', 'b', LIMITED.format(-0.2, 1.8)),
    joint('spin', 'continuous', 'b', 'c', '<axis xyz="0 0 1"/>'),
    joint('left_out', 'revolute', 'c', 'humerus', LIMITED.format(0, 0)),
    joint('bend', 'revolute', 'humerus', 'finger', LIMITED.format(1, 2)),
)
LIMITS = JointLimits.from_skeleton(Skeleton.from_urdf(ARM).for_bones(('scapula', 'humerus')))


def test_a_tenth_of_the_range_is_let_pass_and_joints_without_limits_or_bones_are_passed_over() -> (
    None
):
    inside = (-0.0239, 1.99, 900.0, 3.0, 0.0), (0.0239, -0.39, -900.0, -3.0, 9.0)
    outside = (0.0241, 0.0, 0.0, 0.0, 0.0), (0.0, 2.01, 0.0, 0.0, 0.0), (0.0, -0.41, 0, 0, 0)
    values = np.array([*inside, *outside])
    assert LIMITS.find_beyond(values).any(axis=0).tolist() == [True, True, False, False, False]
    assert LIMITS.count_beyond(values) == 3


@pytest.mark.parametrize(
    ('k', 'ends', 'said', 'text'),
    [
        (0, (0.0, 9.0), False, 'slide 0 to 9 m, its limits are -0.02 to 0.02 m; mm?'),
        (0, (0.0, 90.0), False, 'another joint, or another skeleton?'),
        (1, (0.0, 60.0), False, 'limits are -11.46 to 103.1 deg; degrees?'),
        (1, (0.0, 60.0), True, 'another joint, or another skeleton?'),
        (1, (-1.7, 0.1), True, 'lift -97.4 to 5.73 deg, its limits are'),
        (1, (-1.7, 0.1), True, 'deg; the other sign?'),
    ],
)
def test_the_likely_cause_is_named(
    k: int, ends: tuple[float, float], said: bool, text: str
) -> None:
    assert text in LIMITS.describe(k, *ends, said)
