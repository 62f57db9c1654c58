# SPDX-License-Identifier: Apache-2.0
"""No absurd number leaves as OK: not finite, far arms, poses outside, old joints."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from parameter_changes import as_sent
from ros_harness import Peer, running
from rosgraph_msgs.msg import Clock
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
NAMES = ('flexion', 'abduction', 'rotation')
POSE = (0.3, 0.8, 0.2)  # rad, in the range of motion of all models
SECOND = 10**9  # ns


class Catcher:
    """Stands at the end of an output and keeps nothing but the count."""

    def __init__(self) -> None:
        self.count = 0

    def get_subscription_count(self) -> int:
        return 1

    def publish(self, message: Any) -> None:
        self.count += 1


def feed(node: MuscleStatePublisher, *angles: float, names: Any = NAMES, stamp: int = 0) -> None:
    """Let the node answer one message; the stamp in ns."""
    message = JointState(name=names, position=angles)
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, SECOND)
    node._answer(message)


def report(node: MuscleStatePublisher) -> tuple[bytes, str, dict[str, str]]:
    """Return level, line and values of the node's status, as it is once a second."""
    [muscle] = node._muscles
    status = muscle.build_status(node._memory.find_ages(node._read_clock()))
    return status.level, status.message, {item.key: item.value for item in status.values}


@pytest.mark.parametrize('field', ['lengths', 'moment_vectors', 'moment_arms', 'lengthening'])
@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf])
def test_an_answer_that_is_not_finite_is_rejected_and_counted(
    lone_node: MuscleStatePublisher, monkeypatch: pytest.MonkeyPatch, field: str, value: float
) -> None:
    solve = LinkedPlaneSolver.answer

    def spoil(self: LinkedPlaneSolver, *given: Any) -> Any:
        answer = solve(self, *given)
        owner = answer if hasattr(answer, field) else answer.state
        spoilt = getattr(owner, field).copy()
        spoilt.flat[-1] = value
        if owner is answer:
            return dataclasses.replace(answer, **{field: spoilt})
        return dataclasses.replace(
            answer, state=dataclasses.replace(answer.state, **{field: spoilt})
        )

    [muscle] = lone_node._muscles
    catchers = {name: Catcher() for name in muscle.topics}
    real, muscle.topics = muscle.topics, catchers
    monkeypatch.setattr(LinkedPlaneSolver, 'answer', spoil)
    message = JointState(name=NAMES, position=POSE, velocity=(0.1, 0.2, 0.3))
    lone_node._answer(message)
    assert {name: catcher.count for name, catcher in catchers.items()} == dict.fromkeys(catchers, 0)
    level, line, values = report(lone_node)
    assert level == ERROR
    assert '17.1887, 45.8366, 11.4592 deg is not finite' in line
    assert values['rejected: answer_not_finite'] == '1'
    assert values['messages answered'] == '0'
    monkeypatch.undo()
    lone_node._answer(message)
    muscle.topics = real
    assert catchers['moment_arms'].count == 1
    assert report(lone_node)[0] == OK


def find_far_pose(muscle: BroadMuscle) -> tuple[float, float, float]:
    """Return angles, rad, with a moment arm longer than three times the insertion's reach."""
    rotations = Rotation.random(4000, np.random.default_rng(18)).as_matrix()
    moments = LinkedPlaneSolver(muscle).solve_batch(rotations).moment_vectors
    reach = np.linalg.norm(muscle.insertions, axis=1)
    k = int((np.linalg.norm(moments, axis=2) > 3.1 * reach).any(axis=1).argmax())
    a, b, c = JOINT_CONVENTIONS['flexion_abduction_rotation'].angles(rotations[k])
    return a, b, c


def test_a_moment_arm_beyond_its_bound_is_published_counted_and_warns(ros: None) -> None:
    pose = find_far_pose(BroadMuscle.load('deltoid_ackland2008'))
    node = MuscleStatePublisher(parameter_overrides=[as_sent('muscle', 'deltoid_ackland2008')])
    for angles in (POSE, pose, POSE):
        feed(node, *angles)
    level, line, values = report(node)
    later = report(node)
    node.destroy_node()
    assert values['answers with a moment arm beyond its bound'] == '1'
    assert values['messages answered'] == '3'
    assert level == WARN
    assert line.startswith('1 with a moment arm of more than 3 times')
    assert later[0] == OK


@pytest.mark.parametrize('convention', ['flexion_abduction_rotation', 'isb_yxy'])
@pytest.mark.parametrize('side', ['right', 'left'])
def test_poses_outside_the_range_of_motion_are_counted_and_warn_above_a_tenth(
    ros: None, convention: str, side: str
) -> None:
    given = {'muscle': 'deltoid_ackland2008', 'joint_convention': convention, 'side': side}
    node = MuscleStatePublisher(parameter_overrides=[as_sent(*pair) for pair in given.items()])
    thesis, chosen = JOINT_CONVENTIONS['flexion_abduction_rotation'], JOINT_CONVENTIONS[convention]
    limits = BroadMuscle.load('deltoid_ackland2008').range_of_motion
    middle = np.array([0.5 * (low + high) for low, high in limits])
    beyond = np.array([*middle[:2], limits[2][1] + 0.1])
    inside, outside = (chosen.angles(thesis.rotation(angles)) for angles in (middle, beyond))
    assert node._muscles[0]._outside.take_count() == 0
    for _ in range(270):
        feed(node, *inside, names=chosen.coordinates)
    for _ in range(30):
        feed(node, *outside, names=chosen.coordinates)
    level, _, values = report(node)
    assert (level, values['poses outside the range of motion']) == (OK, '30')
    for _ in range(2):
        feed(node, *inside, names=chosen.coordinates)
        feed(node, *outside, names=chosen.coordinates)
    level, line, values = report(node)
    assert (level, values['poses outside the range of motion']) == (WARN, '32')
    assert line == '2 of 4 poses outside the range of motion that the model is for'
    node.destroy_node()


def test_a_model_without_a_range_of_motion_has_no_pose_outside(ros: None, tmp_path: Path) -> None:
    bare = tmp_path / 'bare.yaml'
    dataclasses.replace(BroadMuscle.load('deltoid'), range_of_motion=None).to_yaml(bare)
    node = MuscleStatePublisher(parameter_overrides=[as_sent('muscle', str(bare))])
    feed(node, 3.0, -1.5, 3.0)
    assert report(node)[2]['poses outside the range of motion'] == '0'
    node.destroy_node()


def test_joints_that_fell_silent_are_shown_with_their_ages_and_warn(
    lone_node: MuscleStatePublisher, monkeypatch: pytest.MonkeyPatch
) -> None:
    feed(lone_node, *POSE)
    feed(lone_node, 0.4, names=NAMES[:1])
    level, _, values = report(lone_node)
    assert level == OK
    assert {f'age of joint {name} (s)' for name in NAMES} <= set(values)
    now = lone_node._read_clock() + 6.0
    monkeypatch.setattr('linkedplane_ros.node.muscle_state_publisher.perf_counter', lambda: now)
    monkeypatch.setattr('linkedplane_ros.node.outputs.perf_counter', lambda: now)
    feed(lone_node, 0.5, names=NAMES[:1])
    level, line, values = report(lone_node)
    assert float(values['age of joint flexion (s)']) == 0.0
    assert float(values['age of joint rotation (s)']) == pytest.approx(6.0, abs=0.5)
    assert level == WARN
    assert line.startswith("answering with joint 'abduction' as it was 6.0 s ago")


def test_a_joint_timeout_stops_stale_answers_and_can_be_changed(ros: None) -> None:
    node = MuscleStatePublisher(parameter_overrides=[as_sent('joint_timeout', 1.0)])
    feed(node, *POSE, stamp=100 * SECOND)
    feed(node, 0.4, names=NAMES[:1], stamp=100 * SECOND + 500 * 10**6)
    feed(node, 0.4, names=NAMES[:1], stamp=106 * SECOND)
    level, line, values = report(node)
    assert (values['messages answered'], values['rejected: stale']) == ('2', '1')
    assert level == WARN
    assert "'abduction' has not come for 6 s" in line
    assert node.set_parameters_atomically([as_sent('joint_timeout', 10)]).successful
    feed(node, 0.4, names=NAMES[:1], stamp=107 * SECOND)
    assert report(node)[2]['messages answered'] == '3'
    node.destroy_node()


def test_under_simulated_time_joints_without_stamps_grow_old_by_the_clock(peer: Peer) -> None:
    with running(peer, use_sim_time=True, joint_timeout=1.0) as node:
        clock = peer.create_publisher(Clock, '/clock', 10)

        def set_clock(seconds: int) -> None:
            message = Clock()
            message.clock.sec = seconds
            assert peer.until(lambda: clock.get_subscription_count() > 0)
            clock.publish(message)
            assert peer.until(lambda: node.get_clock().now().nanoseconds == seconds * SECOND)

        set_clock(50)
        feed(node, *POSE)
        feed(node, 0.4, names=NAMES[:1])
        assert report(node)[2]['messages answered'] == '2'
        set_clock(56)
        feed(node, 0.4, names=NAMES[:1])
        values = report(node)[2]
    assert (values['messages answered'], values['rejected: stale']) == ('2', '1')
    assert values['age of joint rotation (s)'] == '6.000'
