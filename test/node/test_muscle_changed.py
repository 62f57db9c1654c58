# SPDX-License-Identifier: Apache-2.0
"""Another muscle while the node runs: its topics move, and viewers and the old one take no harm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from parameter_changes import (
    EXACT,
    POSE,
    agree,
    answer_to_pose,
    as_sent,
    change_parameters,
    connected,
    expected_answer,
)
from ros_harness import Peer, muscles_published
from visualization_msgs.msg import Marker

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

MODEL = (Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml').read_text()
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def test_a_change_of_muscle_moves_the_topics_there_and_back(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path
) -> None:
    path = tmp_path / 'thin.yaml'
    path.write_text(MODEL.replace('name: deltoid', 'name: thin').replace('37.294653', '35.294653'))
    thin = Peer('thin')
    peer.executor_of_its_own.add_node(thin)
    for _ in range(2):
        for muscle, reader in ((str(path), thin), ('deltoid', peer)):
            assert change_parameters(node, muscle=muscle).successful
            lengths = reader.got['band_lengths']
            lengths.clear()
            while not lengths:  # until the new topic's publisher and its reader have met
                peer.send(THESIS.coordinates, POSE)
                peer.until(lambda lengths=lengths: bool(lengths), 0.2)
            solver = LinkedPlaneSolver(BroadMuscle.load(muscle))
            want = solver.solve(THESIS.rotation(POSE)).lengths
            assert np.abs(np.array(lengths[-1].data) - want).max() <= EXACT
            assert peer.until(lambda name=solver.muscle.name: muscles_published(node) == {name})
    peer.executor_of_its_own.remove_node(thin)
    thin.destroy_node()


def thin_muscle(folder: Path) -> str:
    """Return the path of a model of another name and fewer bands."""
    model = yaml.safe_load(MODEL)
    model['name'] = 'thin'
    model['bands']['names'] = model['bands']['names'][:3]
    model['heads'] = {'anterior': model['heads']['anterior']}
    path = folder / 'thin.yaml'
    path.write_text(yaml.safe_dump(model))
    return str(path)


def test_a_muscle_changed_while_the_input_rests_does_no_harm_to_a_new_viewer(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path
) -> None:
    answer_to_pose(peer)
    assert change_parameters(node, muscle=thin_muscle(tmp_path)).successful
    thin = Peer('thin')
    thin.executor_of_its_own = peer.executor_of_its_own
    peer.executor_of_its_own.add_node(thin)
    count = len(peer.diagnostics)
    assert peer.until(lambda: len(peer.diagnostics) > count + 2)
    assert thin.got['markers'] == []
    while not thin.got['band_lengths']:
        peer.send(THESIS.coordinates, POSE)
        peer.until(lambda: bool(thin.got['band_lengths']), 0.2)
    assert len(thin.got['band_lengths'][0].data) == 3
    peer.executor_of_its_own.remove_node(thin)
    thin.destroy_node()


@pytest.mark.parametrize('how', ['disabled', 'another muscle'])
def test_no_muscle_is_left_behind_in_a_viewer(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path, how: str
) -> None:
    answer_to_pose(peer)
    assert peer.until(lambda: len(peer.got['markers']) >= 2)
    changes = {'markers.enabled': False} if how == 'disabled' else {
        'muscle': thin_muscle(tmp_path)}  # fmt: skip
    assert change_parameters(node, **changes).successful
    assert peer.until(lambda: peer.got['markers'][-1].markers[0].action == Marker.DELETEALL)


def test_a_muscle_with_a_wrong_quality_of_service_is_refused_and_the_old_one_works_on(
    ros: None, tmp_path: Path
) -> None:
    override = as_sent('qos_overrides./thin/markers.publisher.reliability', 'fast')
    made = MuscleStatePublisher(parameter_overrides=[override])
    with connected(made) as peer:
        result = change_parameters(made, muscle=thin_muscle(tmp_path))
        assert not result.successful
        assert 'reliable or best_effort' in result.reason
        assert agree(answer_to_pose(peer), expected_answer())
    made.destroy_node()


NO_TOPIC = 'my muscle'


def test_a_muscle_whose_name_cannot_be_a_topic_is_refused_while_it_runs(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path
) -> None:
    path = tmp_path / 'spaced.yaml'
    path.write_text(MODEL.replace('name: deltoid', f'name: {NO_TOPIC}'))
    result = change_parameters(node, muscle=str(path))
    assert not result.successful
    assert NO_TOPIC in result.reason
    assert agree(answer_to_pose(peer), expected_answer())


def test_a_muscle_whose_name_cannot_be_a_topic_is_refused_at_the_start(
    ros: None, tmp_path: Path
) -> None:
    path = tmp_path / 'spaced.yaml'
    path.write_text(MODEL.replace('name: deltoid', f'name: {NO_TOPIC}'))
    with pytest.raises(ValueError, match=NO_TOPIC) as caught:
        MuscleStatePublisher(parameter_overrides=[as_sent('muscle', str(path))])
    assert '\n' not in str(caught.value)
