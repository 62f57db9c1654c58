# SPDX-License-Identifier: Apache-2.0
"""Wrenches and a skeleton's screws together are the moment arms about its joints, by differences.

Steps of 1e-4 and 2e-4 rad with Richardson's extrapolation: 1e-10 m of the fourth power of a step
and of rounding; poses near a kink are not among them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from linkedplane_ros import BroadMuscle, LinkedPlaneError, LinkedPlaneSolver, Skeleton
from linkedplane_ros.types import Floats

# a rhythm in a URDF: the clavicle follows the elevation, the scapula stays
COUPLED = """<robot name="coupled">
<link name="scapula"/><link name="clavicle"/><link name="humerus"/>
<joint name="elevation" type="revolute"><parent link="scapula"/><child link="humerus"/>
<origin xyz="0.001 0.002 0"/><axis xyz="0 -1 0"/><limit lower="0" upper="2"/></joint>
<joint name="follows" type="revolute"><parent link="scapula"/><child link="clavicle"/>
<origin xyz="-0.02 0 0.03" rpy="0.1 0.2 0.3"/><axis xyz="1 2 3"/><limit lower="-1" upper="1"/>
<mimic joint="elevation" multiplier="0.2" offset="-0.1"/></joint></robot>"""

# three hinges askew, that move both bones, and are no mirror image of themselves
ASKEW = """<robot name="askew">
<link name="scapula"/><link name="clavicle"/><link name="lifted"/><link name="humerus"/>
<joint name="shrug" type="continuous"><parent link="scapula"/><child link="clavicle"/>
<origin xyz="0.002 0.001 0.003" rpy="0.1 -0.2 0.3"/><axis xyz="0.2 -1 0.1"/></joint>
<joint name="lift" type="continuous"><parent link="scapula"/><child link="lifted"/>
<origin xyz="0.001 0.002 0" rpy="0.1 0.2 -0.3"/><axis xyz="0.1 -1 0.3"/></joint>
<joint name="turn" type="continuous"><parent link="lifted"/><child link="humerus"/>
<origin xyz="-0.001 0 0.002"/><axis xyz="0.3 0.1 1"/></joint></robot>"""


@pytest.fixture(scope='module')
def solver() -> LinkedPlaneSolver:
    return LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))


def moment_arms(solver: LinkedPlaneSolver, skeleton: Skeleton, q: Floats) -> Floats:
    """Return them by the recipe of doc/explanation/skeletons.md."""
    state = solver.solve_bones(skeleton.pose(q, solver.side))
    return np.einsum('nkc,dkc->nd', state.wrenches, skeleton.screws(q, solver.side))


def by_differences(solver: LinkedPlaneSolver, skeleton: Skeleton, q: Floats) -> Floats:
    def slope(i: int, step: float) -> Floats:
        ahead, behind = (
            solver.solve_bones(
                skeleton.pose(q + sign * step * np.eye(len(q))[i], solver.side)
            ).lengths
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


@pytest.mark.parametrize('side', ['right', 'left'])
@pytest.mark.parametrize('stated', ['', 'right', 'left'])
@pytest.mark.parametrize('muscle', ['deltoid', 'deltoid_girdle'])
def test_the_recipe_is_the_answer_on_either_side(muscle: str, stated: str, side: str) -> None:
    solver = LinkedPlaneSolver(BroadMuscle.load(muscle), side)
    element = f'<linkedplane_ros side="{stated}"/></robot>' if stated else '</robot>'
    skeleton = Skeleton.from_urdf(ASKEW.replace('</robot>', element)).for_bones(solver.bones)
    assert skeleton.side == stated
    q = np.array([0.4, 1.1, 0.3])
    answer = solver.answer(skeleton, q, np.zeros(3))
    arms = moment_arms(solver, skeleton, q)
    np.testing.assert_allclose(arms, answer.moment_arms, rtol=0, atol=1e-15)
    np.testing.assert_allclose(arms, by_differences(solver, skeleton, q), rtol=0, atol=1e-9)
    # the lengths are those of the right muscle, at the poses of the URDF or their mirror image
    mirror = np.diag([-1.0, 1.0, 1.0]) if (stated or side) == 'left' else np.eye(3)
    poses = {bone: (mirror @ R @ mirror, mirror @ t) for bone, (R, t) in skeleton.pose(q).items()}
    right = LinkedPlaneSolver(BroadMuscle.load(muscle)).solve_bones(poses)
    np.testing.assert_allclose(answer.state.lengths, right.lengths, rtol=0, atol=1e-15)
    # the batch forms are of the same side, to the bit
    for bone, (R, t) in skeleton.pose_batch([q], side).items():
        assert (R[0] == skeleton.pose(q, side)[bone][0]).all()
        assert (t[0] == skeleton.pose(q, side)[bone][1]).all()
    assert (skeleton.screws_batch([q], side)[0] == skeleton.screws(q, side)).all()


@pytest.mark.parametrize('way', ['pose', 'screws', 'pose_batch', 'screws_batch', 'pose_ground'])
@pytest.mark.parametrize('side', ['l', 'LEFT', None])
def test_another_side_is_refused(way: str, side: Any) -> None:
    q = np.zeros((1, 9) if 'batch' in way else 9)
    with pytest.raises(LinkedPlaneError, match=f"side: {side!r} given, 'right' or 'left' expected"):
        getattr(Skeleton.load('shoulder_girdle'), way)(q, side)


def test_at_rest_the_girdle_is_the_muscle_of_one_joint(solver: LinkedPlaneSolver) -> None:
    girdle = Skeleton.load('shoulder_girdle')
    one = LinkedPlaneSolver(BroadMuscle.load('deltoid')).solve(np.eye(3))
    state = solver.solve_bones(girdle.pose(np.zeros(9)))
    np.testing.assert_allclose(state.lengths, one.lengths, rtol=0, atol=1e-12)  # m
