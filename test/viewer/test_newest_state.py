"""The newest state of a muscle: what the viewer shows, and what it knows of the node."""

from __future__ import annotations

from threading import Event

import numpy as np

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.viewer.newest import Facts, Newest, Values
from linkedplane_ros.viewer.panels.table import table

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
STATE = SOLVER.solve(THESIS.rotation((0.9, 0.3, 0.1)))
LABELS = (THESIS.coordinates, DELTOID.band_names)


def test_only_the_newest_is_handed_over_and_markers_once() -> None:
    fresh = Event()
    newest = Newest(fresh)
    for k in range(100):
        newest.put_answer([bytes([k])], None, lengths=np.full(9, k))
    assert fresh.is_set()
    _, values, messages = newest.take()
    assert values.lengths is not None
    assert values.lengths[0] == 99
    assert values.answered == 100
    assert messages[-1] == bytes([99])
    assert len(messages) <= 10
    assert newest.take()[2] == []


def test_a_node_that_does_not_answer_is_known_by_its_labels() -> None:
    isb = JOINT_CONVENTIONS['isb_yxy']
    facts = Facts.told(isb.coordinates, ('a', 'b'), '/joint_states', {})
    assert facts.convention is isb
    assert facts.joints.names == isb.coordinates
    assert facts.heads == (('a', 0), ('b', 1))
    assert facts.motion is None


def test_a_node_that_answers_is_known_before_its_first_state() -> None:
    parameters = {'joint_convention': 'rep155', 'side': 'left', 'joint_signs': [1.0, -1.0, 1.0]}
    facts = Facts.told((), (), '/arm', parameters)
    assert facts.coordinates == ('y_shoulder', 'p_shoulder', 'r_shoulder')
    assert (facts.side, facts.joints.signs) == ('left', (1.0, -1.0, 1.0))
    assert facts.bands == DELTOID.band_names
    assert facts.heads == (('anterior', 1), ('middle', 3), ('posterior', 7))


def test_of_several_muscles_of_a_node_the_one_with_the_bands_tells_the_heads() -> None:
    parameters = {'muscle': ['example_shared_sphere', 'deltoid', 'absent.yaml']}
    facts = Facts.told(THESIS.coordinates, DELTOID.band_names, '/joint_states', parameters)
    assert facts.heads == (('anterior', 1), ('middle', 3), ('posterior', 7))
    assert Facts.told((), (), '/joint_states', parameters).bands == ()


def test_the_table_has_the_numbers_in_millimetres() -> None:
    facts = Facts.told(*LABELS, '/joint_states', {})
    arms = STATE.moment_vectors @ THESIS.axes((0.9, 0.3, 0.1))
    values = Values(lengths=STATE.lengths, arms=arms, wrap=STATE.wrap)
    text = table(facts, values, 1, {4})
    assert f'{1e3 * STATE.lengths[0]:.1f}' in text
    assert f'{1e3 * arms[8, 1]:.1f}' in text
    assert text.count('interferes') == 1
    assert text.index('middle_2') < text.index('interferes') < text.index('middle_3')
    assert 'None' not in table(facts, Values(), 0, set())
