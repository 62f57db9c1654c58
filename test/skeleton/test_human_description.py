# SPDX-License-Identifier: Apache-2.0
"""The recipe for ROS4HRI's human (doc/how_to/robot_urdf.md) beside MuJoCo.

Links, joints, axes and places are those of urdf/human-tpl.xacro of ros4hri/human_description,
1.0.1, at a height of 1.65 m and the id anna: both arms, and the waist that carries the torso.
"""

from __future__ import annotations

import numpy as np
import pytest
from optional import requires
from random_urdfs import joint, link, robot

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, Skeleton

LINKS = 'body', 'waist', 'torso'
REP103 = np.array(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))  # rows: our axes in it
LOW, HIGH = (-1.1, -0.4, -1.7), (1.9, 3.3, 1.5)


def arm(side: str, reflect: int) -> list[str]:
    names = [f'{side}_{each}shoulder_anna' for each in ('y_', 'p_', '')]
    joints = [f'{side}_{each}_shoulder_anna' for each in 'ypr']
    axes = f'0 0 {-reflect}', f'{reflect} 0 0', f'0 0 {reflect}'
    places = f'0 {reflect * 0.176} 0', '0 0 0', '0 0 0'
    parts = [link(name) for name in names]
    for name, parent, child, axis, place in zip(
        joints, ('torso_anna', *names), names, axes, places, strict=False
    ):
        inside = f'<origin rpy="0 0 0" xyz="{place}"/><axis xyz="{axis}"/>'
        parts.append(joint(name, 'revolute', parent, child, inside))
    return parts


HUMAN = robot(
    *(link(f'{name}_anna') for name in LINKS),
    joint('waist_anna', 'revolute', 'body_anna', 'waist_anna', '<axis xyz="0 1 0"/>'),
    joint('torso_anna', 'fixed', 'waist_anna', 'torso_anna', '<origin xyz="0 0 0.605"/>'),
    *arm('l', 1),
    *arm('r', -1),
)


@requires('mujoco')
@pytest.mark.parametrize(('side', 'y'), [('right', -0.176), ('left', 0.176)])
def test_both_arms_of_the_human_turn_the_humerus_as_in_mujoco(side: str, y: float) -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string(HUMAN)
    data = mujoco.MjData(model)
    s = side[0]
    skeleton = Skeleton.from_urdf(HUMAN).for_bones(
        ['scapula', 'humerus'],
        {'scapula': 'torso_anna', 'humerus': f'{s}_shoulder_anna'},
        origin=((0, y, 0), (0, 0, -np.pi / 2)),
    )
    names = tuple(f'{s}_{each}_shoulder_anna' for each in 'ypr')
    assert skeleton.moving == names
    columns = [skeleton.coordinates.index(name) for name in names]
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'), side)
    rep155 = JOINT_CONVENTIONS['rep155']
    rng = np.random.default_rng(155)
    for _ in range(20):
        q = rng.uniform(-0.2, 0.8, len(skeleton.coordinates))
        q[columns] = rng.uniform(LOW, HIGH)
        for name, value in zip(skeleton.coordinates, q, strict=True):
            data.qpos[model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(model, data)
        torso, humerus = (
            data.body(name).xmat.reshape(3, 3) for name in ('torso_anna', f'{s}_shoulder_anna')
        )
        R, t = skeleton.pose(q)['humerus']
        np.testing.assert_allclose(R, REP103 @ torso.T @ humerus @ REP103.T, rtol=0, atol=1e-12)
        np.testing.assert_allclose(t, 0.0, rtol=0, atol=1e-15)
        answer = solver.answer(skeleton, q, np.zeros(len(q)))
        same = solver.answer(rep155, q[columns], np.zeros(3))
        np.testing.assert_allclose(answer.state.lengths, same.state.lengths, rtol=0, atol=1e-12)
        np.testing.assert_allclose(
            answer.moment_arms[:, columns], same.moment_arms, rtol=0, atol=1e-10
        )
