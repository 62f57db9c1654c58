# SPDX-License-Identifier: Apache-2.0
"""The newest state of a muscle: what the viewer shows, and what it knows of the node."""

from __future__ import annotations

from threading import Event
from typing import Any

import numpy as np

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.viewer.newest import MuscleInfo, NewestState, Values, group_by_arm
from linkedplane_ros.viewer.panels.table import bands_table_html

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
STATE = SOLVER.solve(THESIS.rotation((0.9, 0.3, 0.1)))
LABELS = (THESIS.coordinates, DELTOID.band_names)


def test_only_the_newest_is_handed_over_and_markers_once() -> None:
    fresh = Event()
    newest = NewestState(fresh)
    for k in range(100):
        newest.add_answer([bytes([k])], None, lengths=np.full(9, k))
    assert fresh.is_set()
    _, values, messages = newest.take_newest()
    assert values.lengths is not None
    assert values.lengths[0] == 99
    assert values.answered == 100
    assert messages[-1] == bytes([99])
    assert len(messages) <= 10
    assert newest.take_newest()[2] == []


def test_a_node_that_does_not_answer_is_known_by_its_labels() -> None:
    isb = JOINT_CONVENTIONS['isb_yxy']
    info = MuscleInfo.from_parameters(isb.coordinates, ('a', 'b'), '/joint_states', {})
    assert info.convention is isb
    assert info.joints.names == isb.coordinates
    assert info.heads == (('a', 0), ('b', 1))
    assert info.motion is None


def test_a_node_that_answers_is_known_before_its_first_state() -> None:
    parameters = {'joint_convention': 'rep155', 'side': 'left', 'joint_signs': [1.0, -1.0, 1.0]}
    info = MuscleInfo.from_parameters((), (), '/arm', parameters)
    assert info.coordinates == ('y_shoulder', 'p_shoulder', 'r_shoulder')
    assert (info.side, info.joints.signs) == ('left', (1.0, -1.0, 1.0))
    assert info.bands == DELTOID.band_names
    assert info.heads == (('anterior', 1), ('middle', 3), ('posterior', 7))


def test_of_several_muscles_of_a_node_the_one_with_the_bands_tells_the_heads() -> None:
    parameters = {'muscle': ['example_shared_sphere', 'deltoid', 'absent.yaml']}
    info = MuscleInfo.from_parameters(
        THESIS.coordinates, DELTOID.band_names, '/joint_states', parameters
    )
    assert info.heads == (('anterior', 1), ('middle', 3), ('posterior', 7))
    assert MuscleInfo.from_parameters((), (), '/joint_states', parameters).bands == ()


def test_each_of_several_muscles_of_a_node_is_known_by_its_name_before_its_first_state() -> None:
    names = ['deltoid', 'example_shared_sphere', 'deltoid_ackland2008']
    for labels in (((), ()), LABELS):  # two of the three have the same bands
        for name in names:
            model = BroadMuscle.load(name)
            if labels[1] not in ((), model.band_names):
                continue
            info = MuscleInfo.from_parameters(*labels, '/joint_states', {'muscle': names}, name)
            assert info.bands == model.band_names
            assert [head for head, _ in info.heads] == [head.name for head in model.heads]
            assert info.motion == model.range_of_motion


def test_a_model_whose_bands_are_not_those_of_the_labels_is_another_one() -> None:
    info = MuscleInfo.from_parameters(
        THESIS.coordinates, ('a', 'b'), '/joint_states', {}, 'deltoid'
    )
    assert info.heads == (('a', 0), ('b', 1))


def test_muscles_that_the_same_joint_states_move_are_one_arm() -> None:
    def learn(topic: str, **parameters: Any) -> MuscleInfo:
        return MuscleInfo.from_parameters((), (), topic, parameters)

    muscles = {
        '/deltoid': learn('/joint_states'),
        '/left/deltoid': learn('/left/joint_states', side='left'),
        '/other': learn('/joint_states', muscle='deltoid_ackland2008'),
        '/named': learn('/joint_states', joint_names=['a', 'b', 'c']),
    }
    assert group_by_arm(muscles) == [['/deltoid', '/other'], ['/left/deltoid'], ['/named']]


def test_the_table_has_the_numbers_in_millimetres() -> None:
    info = MuscleInfo.from_parameters(*LABELS, '/joint_states', {})
    arms = STATE.moment_vectors @ THESIS.axes((0.9, 0.3, 0.1))
    values = Values(lengths=STATE.lengths, arms=arms, wrap=STATE.wrap)
    text = bands_table_html(info, values, 1, {4})
    assert f'{1e3 * STATE.lengths[0]:.1f}' in text
    assert f'{1e3 * arms[8, 1]:.1f}' in text
    assert text.count('interferes') == 1
    assert text.index('middle_2') < text.index('interferes') < text.index('middle_3')
    assert 'None' not in bands_table_html(info, Values(), 0, set())
