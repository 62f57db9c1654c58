# SPDX-License-Identifier: Apache-2.0
"""Wrenches and a skeleton's screws together are the moment arms about its joints, by differences.

Steps of 1e-4 and 2e-4 rad with Richardson's extrapolation: 1e-10 m of the fourth power of a step
and of rounding; poses near a kink are not among them.
"""

from __future__ import annotations

import numpy as np
import pytest

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, Skeleton
from linkedplane_ros.types import Floats

# a rhythm in a URDF: the clavicle follows the elevation, the scapula stays
COUPLED = """<robot name="coupled">
<link name="scapula"/><link name="clavicle"/><link name="humerus"/>
<joint name="elevation" type="revolute"><parent link="scapula"/><child link="humerus"/>
<origin xyz="0.001 0.002 0"/><axis xyz="0 -1 0"/><limit lower="0" upper="2"/></joint>
<joint name="follows" type="revolute"><parent link="scapula"/><child link="clavicle"/>
<origin xyz="-0.02 0 0.03" rpy="0.1 0.2 0.3"/><axis xyz="1 2 3"/><limit lower="-1" upper="1"/>
<mimic joint="elevation" multiplier="0.2" offset="-0.1"/></joint></robot>"""


@pytest.fixture(scope='module')
def solver() -> LinkedPlaneSolver:
    return LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))


def moment_arms(solver: LinkedPlaneSolver, skeleton: Skeleton, q: Floats) -> Floats:
    state = solver.solve_bones(skeleton.pose(q))
    return np.einsum('nkc,dkc->nd', state.wrenches, skeleton.screws(q))


def by_differences(solver: LinkedPlaneSolver, skeleton: Skeleton, q: Floats) -> Floats:
    def slope(i: int, step: float) -> Floats:
        ahead, behind = (
            solver.solve_bones(skeleton.pose(q + sign * step * np.eye(len(q))[i])).lengths
            for sign in (1.0, -1.0)
        )
        return (ahead - behind) / (2.0 * step)

    return -np.array([(4.0 * slope(i, 1e-4) - slope(i, 2e-4)) / 3.0 for i in range(len(q))]).T


@pytest.mark.parametrize('seed', range(12))
def test_moment_arms_about_the_girdle_s_joints(solver: LinkedPlaneSolver, seed: int) -> None:
    girdle = Skeleton.load('shoulder_girdle')
    assert girdle == girdle.for_bones(solver.bones)  # it is made for this muscle
    rng = np.random.default_rng(seed)
    q = np.concatenate([rng.uniform(-0.3, 0.3, 6), rng.uniform([-0.5, 0.2, -0.5], [1.0, 1.5, 0.5])])
    arms = moment_arms(solver, girdle, q)
    assert not arms[:, :3].any()  # the sternoclavicular joint moves nothing against the scapula
    assert np.abs(arms[:2, 3:6]).max() > 1e-3  # m: bands 1 and 2 arise from the clavicle
    np.testing.assert_allclose(arms, by_differences(solver, girdle, q), rtol=0, atol=1e-9)


def test_a_coordinate_that_others_follow_has_the_moment_arm_of_all(
    solver: LinkedPlaneSolver,
) -> None:
    skeleton = Skeleton.from_urdf(COUPLED).for_bones(solver.bones, rest={'elevation': 0.5})
    alone = Skeleton.from_urdf(COUPLED.replace('"0.2"', '"0"')).for_bones(solver.bones)
    q = np.array([0.8])
    arms = moment_arms(solver, skeleton, q)
    np.testing.assert_allclose(arms, by_differences(solver, skeleton, q), rtol=0, atol=1e-9)
    assert np.abs(arms[:2] - moment_arms(solver, alone, q)[:2]).max() > 1e-3  # m


def test_at_rest_the_girdle_is_the_muscle_of_one_joint(solver: LinkedPlaneSolver) -> None:
    girdle = Skeleton.load('shoulder_girdle')
    one = LinkedPlaneSolver(BroadMuscle.load('deltoid')).solve(np.eye(3))
    state = solver.solve_bones(girdle.pose(np.zeros(9)))
    np.testing.assert_allclose(state.lengths, one.lengths, rtol=0, atol=1e-12)  # m
