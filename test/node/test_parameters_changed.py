# SPDX-License-Identifier: Apache-2.0
"""The node's parameters changed while it runs: as a whole or not at all."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest
from parameter_changes import (
    EXACT,
    POSE,
    WRONG,
    agree,
    answer_to_pose,
    as_sent,
    change_parameters,
    expected_answer,
)
from rclpy.parameter import Parameter
from ros_harness import Peer
from visualization_msgs.msg import Marker

from linkedplane_ros import JOINT_CONVENTIONS
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.parameters import NAMES


def test_a_good_batch_is_taken_as_a_whole(node: MuscleStatePublisher, peer: Peer) -> None:
    assert agree(answer_to_pose(peer), expected_answer())
    result = change_parameters(
        node,
        joint_signs=[1.0, -1.0, 1.0],
        joint_offsets=[0.0, 0.1, 0.0],
        joint_names=['f', 'a', 'r'],
        frame_id='right_scapula',
    )
    assert result.successful, result.reason
    got = answer_to_pose(peer, ('f', 'a', 'r'))
    assert agree(got, expected_answer(angles=(POSE[0], 0.1 - POSE[1], POSE[2])))
    assert got[2].header.frame_id == 'right_scapula'


@pytest.mark.parametrize(('name', 'value', 'right'), WRONG)
def test_a_bad_change_is_refused_with_a_reason_and_changes_nothing(
    lone_node: MuscleStatePublisher, name: str, value: Any, right: str
) -> None:
    before = lone_node.get_parameter(name).value
    result = lone_node.set_parameters_atomically([as_sent(name, value)])
    assert not result.successful
    assert name in result.reason
    assert '\n' not in result.reason
    assert lone_node.get_parameter(name).value == before


def test_a_half_bad_batch_is_refused_as_a_whole(node: MuscleStatePublisher, peer: Peer) -> None:
    for bad in ({'joint_offsets': [math.nan] * 3}, {'markers__points': 1}, {'muscle': 'biceps'}):
        for batch in ({'side': 'left', **bad}, {**bad, 'side': 'left'}):
            result = change_parameters(node, frame_id='elsewhere', **batch)
            assert not result.successful
            assert result.reason
            assert node.get_parameter('side').value == 'right'
            assert node.get_parameter('frame_id').value == 'scapula'
    got = answer_to_pose(peer)
    assert agree(got, expected_answer())
    assert got[2].header.frame_id == 'scapula'


def test_a_refused_change_does_not_come_with_the_next_one(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    assert not change_parameters(node, side='left', joint_signs=[0.0] * 3).successful
    assert change_parameters(node, markers__rate=10.0).successful
    assert agree(answer_to_pose(peer), expected_answer())


def test_a_parameter_cannot_be_deleted(lone_node: MuscleStatePublisher) -> None:
    for name in NAMES:
        result = lone_node.set_parameters_atomically([Parameter(name, Parameter.Type.NOT_SET)])
        assert not result.successful
        assert lone_node.has_parameter(name)


def test_an_empty_list_of_joint_names_is_taken_whatever_it_is_a_list_of(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    for kind in ('STRING_ARRAY', 'BOOL_ARRAY', 'BYTE_ARRAY'):
        assert change_parameters(node, joint_names=['f', 'a', 'r']).successful
        empty = as_sent('joint_names', [], Parameter.Type[kind])
        assert node.set_parameters_atomically([empty]).successful
        assert agree(answer_to_pose(peer), expected_answer())


def test_whole_numbers_are_taken_for_doubles_while_it_runs(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    result = change_parameters(
        node, markers__rate=10, joint_signs=[1, 1, -1], joint_offsets=[0, 0, 0]
    )
    assert result.successful, result.reason
    assert agree(answer_to_pose(peer), expected_answer(angles=(POSE[0], POSE[1], -POSE[2])))


def test_a_change_of_convention_changes_the_joints_and_the_coordinates_label(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    for name, convention in JOINT_CONVENTIONS.items():
        assert change_parameters(node, joint_convention=name).successful
        got = answer_to_pose(peer, convention.coordinates)
        assert agree(got, expected_answer(name))
        label = got[3].layout.dim[1].label
        assert label == 'coordinate:' + ','.join(convention.coordinates)


def test_a_change_of_joints_forgets_the_values_of_the_old_ones(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    answer_to_pose(peer)
    assert change_parameters(node, joint_convention='opensim_tsm').successful
    answer_to_pose(peer, JOINT_CONVENTIONS['opensim_tsm'].coordinates)
    assert change_parameters(
        node, joint_convention='opensim_mobl'
    ).successful  # shares one name with it
    peer.send(('elv_angle', 'shoulder_rot'), (0.1, 0.2))
    assert peer.until(
        lambda: bool(peer.diagnostics) and peer.values()['rejected: incomplete'] == '1'
    )
    assert set(peer.counts().values()) == {2}


def test_a_change_of_side_keeps_the_moment_arms_and_mirrors_the_markers(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    right = answer_to_pose(peer)
    assert change_parameters(node, side='left').successful
    left = answer_to_pose(peer)
    assert agree(left, expected_answer(side='left'))
    # m: the mirror image has the same moment arms about the anatomical coordinates
    np.testing.assert_allclose(left[1], right[1], rtol=0.0, atol=EXACT)
    assert peer.until(
        lambda: any(
            m.action == Marker.DELETEALL for a in peer.got['markers'][1:] for m in a.markers
        )
    )
    assert peer.until(lambda: len(peer.got['markers'][-1].markers) > 1)
    first, last = (
        next(m for m in array.markers if m.ns == 'attachments' and m.id == 0)
        for array in (peer.got['markers'][1], peer.got['markers'][-1])
    )
    assert [p.x for p in last.points] == [-p.x for p in first.points]


def test_each_accepted_change_is_one_line_in_the_log_and_a_refused_one_is_none(
    lone_node: MuscleStatePublisher, capfd: pytest.CaptureFixture[str]
) -> None:
    capfd.readouterr()
    assert change_parameters(
        lone_node, frame_id='elsewhere', joint_offsets=[0.5, 0.0, 0.0], use_sim_time=True
    ).successful
    lines = [line.partition(']: ')[2] for line in capfd.readouterr().err.splitlines()]
    assert lines == [
        "parameter frame_id: 'elsewhere' from now on",
        'parameter joint_offsets: [0.5, 0.0, 0.0] from now on',
        'parameter use_sim_time: True from now on',
    ]
    assert not change_parameters(lone_node, frame_id='/elsewhere', side='left').successful
    assert capfd.readouterr().err == ''
    assert change_parameters(lone_node, muscle='deltoid_ackland2008').successful
    [line] = capfd.readouterr().err.splitlines()  # none for the quality of service of its topics
    assert line.endswith("parameter muscle: 'deltoid_ackland2008' from now on")


def test_a_humerothoracic_convention_is_warned_of_when_it_is_set_while_running(
    lone_node: MuscleStatePublisher, capfd: pytest.CaptureFixture[str]
) -> None:
    usual = 'streams usually measure the humerus against the'
    for name, convention in JOINT_CONVENTIONS.items():
        capfd.readouterr()
        assert change_parameters(lone_node, joint_convention=name, side='left').successful
        warnings = [line for line in capfd.readouterr().err.splitlines() if '[WARN]' in line]
        assert len(warnings) == (convention.relative_to != 'scapula')
        assert all(f'{name} {usual} {convention.relative_to};' in line for line in warnings)
    given = {'joint_convention': 'flexion_abduction_rotation', 'rhythm': 'de_groot_brand_2001'}
    for rhythm, lines in ('de_groot_brand_2001', 1), ('mobl', 0):
        capfd.readouterr()
        assert change_parameters(lone_node, **{**given, 'rhythm': rhythm}).successful
        assert capfd.readouterr().err.count('isb_yxy is smooth') == lines
    assert change_parameters(lone_node, joint_convention='opensim_mobl', rhythm='').successful
    capfd.readouterr()
    assert change_parameters(lone_node, side='right').successful
    assert usual not in capfd.readouterr().err


def test_a_change_that_compiles_is_noticed(
    lone_node: MuscleStatePublisher,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = 'linkedplane_ros.node.muscle_state_publisher'
    monkeypatch.setattr(f'{module}.COMPILED', True)
    monkeypatch.setattr(f'{module}.rehearse', lambda settings: time.sleep(1.5))
    capfd.readouterr()
    assert change_parameters(lone_node, side='left').successful
    assert capfd.readouterr().err.count('preparing the solver') == 1
