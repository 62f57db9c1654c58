# SPDX-License-Identifier: Apache-2.0
"""A rhythm that needs a plane which the coordinates do not say: where it jumps, it is said."""

from __future__ import annotations

import numpy as np
import pytest

from linkedplane_ros import JOINT_CONVENTIONS, RHYTHMS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.skeleton.followed_girdle import FollowedGirdle
from linkedplane_ros.skeleton.lost_plane import caution_of, count_without_plane

SOLVER = LinkedPlaneSolver(BroadMuscle.load('deltoid'))


@pytest.mark.parametrize('name', JOINT_CONVENTIONS)
@pytest.mark.parametrize('rhythm', RHYTHMS.values(), ids=str)
def test_a_caution_is_given_where_lengths_jump_at_the_side(name: str, rhythm: object) -> None:
    convention = JOINT_CONVENTIONS[name]
    girdle = FollowedGirdle(convention, rhythm)  # type: ignore[arg-type]
    thesis = name == 'flexion_abduction_rotation'
    near = [(x, 0.0, 0.0) if thesis else (0.3, x, 0.0) for x in (1e-4, -1e-4)]
    ahead, behind = (SOLVER.answer(girdle, q, np.zeros(3)).state.lengths for q in near)
    jumps = np.abs(ahead - behind).max() > 1e-3  # m
    cautions = caution_of(convention, girdle.rhythm)
    assert len(cautions) == jumps
    assert all('isb_yxy is smooth' in line and name in line for line in cautions)
    assert count_without_plane(girdle, np.array([*near, (0.3, 1.0, 0.0)])) == 2 * jumps


def test_the_arm_at_the_side_is_one_raised_by_less_than_5_deg() -> None:
    girdle = FollowedGirdle(
        JOINT_CONVENTIONS['flexion_abduction_rotation'], RHYTHMS['de_groot_brand_2001']
    )
    angles = np.radians(
        [(4.9, 0, 80), (5.1, 0, 0), (0, -4.9, 0), (0, 5.1, 0), (3, 3, 0), (4, 4, 0)]
    )
    assert [count_without_plane(girdle, each[np.newaxis]) for each in angles] == [1, 0, 1, 0, 1, 0]
