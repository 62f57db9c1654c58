# SPDX-License-Identifier: Apache-2.0
"""A running node survives what its parameters are set to: taken, or refused with a reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from parameter_changes import as_sent, change_parameters
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from ros_harness import NodeProcess, Peer, muscles_published

from linkedplane_ros import BroadMuscle
from linkedplane_ros.errors import LinkedPlaneError
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.outputs import LONGEST_TOPIC, MuscleOutputs
from linkedplane_ros.node.settings import Settings
from linkedplane_ros.solver.linked_plane_solver import LinkedPlaneSolver

MODELS = Path(__file__).parents[2] / 'linkedplane_ros' / 'models'
NAMES = ('flexion', 'abduction', 'rotation')


def renamed_model(folder: Path, name: str) -> str:
    """Write the deltoid under another name."""
    path = folder / 'renamed.yaml'
    text = (MODELS / 'deltoid.yaml').read_text()
    path.write_text(text.replace('name: deltoid\n', f'name: {name}\n', 1))
    assert BroadMuscle.load(path).name == name
    return str(path)


def fail(*given: Any, **named: Any) -> Any:
    """Fail as no one expects it."""
    raise ZeroDivisionError('line one\nline two')


@pytest.mark.parametrize(
    ('owner', 'method'),
    [
        (BroadMuscle, 'load'),
        (BroadMuscle, 'scaled'),
        (LinkedPlaneSolver, '__init__'),
        (Settings, 'from_values'),
        (MuscleOutputs, '__init__'),
    ],
)
def test_any_exception_in_a_check_is_a_refusal_with_its_reason(
    lone_node: MuscleStatePublisher, monkeypatch: pytest.MonkeyPatch, owner: Any, method: str
) -> None:
    monkeypatch.setattr(owner, method, fail)
    result = change_parameters(lone_node, muscle='deltoid_ackland2008', side='left')
    assert not result.successful
    assert 'ZeroDivisionError: line one' in result.reason
    assert '\n' not in result.reason
    monkeypatch.undo()
    assert lone_node.get_parameter('side').value == 'right'
    assert change_parameters(lone_node, side='left').successful


def test_any_exception_at_the_start_is_one_line(ros: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BroadMuscle, 'load', fail)
    with pytest.raises(LinkedPlaneError, match=r"muscle: 'deltoid': cannot be used: ZeroDivision"):
        MuscleStatePublisher()


@pytest.mark.parametrize('path', ['a\0b.yaml', '/' + 300 * 'x' + '.yaml', '/dev/null/x.yaml', '/'])
def test_odd_paths_of_models_and_measurements_are_refused(
    lone_node: MuscleStatePublisher, path: str
) -> None:
    for name in ('muscle', 'scale'):
        given = Parameter(name, value=path)
        result = lone_node.set_parameters_atomically([given])
        assert not result.successful
        assert len(result.reason) < 1000


def test_a_name_too_long_for_topics_is_refused_and_leaves_nothing_behind(
    lone_node: MuscleStatePublisher, tmp_path: Path
) -> None:
    longest = LONGEST_TOPIC - len('//moment_arm_states')
    for name, fits in (('m' * longest, True), ('m' * (longest + 1), False), ('m' * 5000, False)):
        result = change_parameters(lone_node, muscle=renamed_model(tmp_path, name))
        assert result.successful == fits
        if not fits:
            assert 'is no name for topics' in result.reason
            assert f'at most {LONGEST_TOPIC}' in result.reason
            assert len(result.reason) < 400
    assert muscles_published(lone_node) == {'m' * longest}


def test_a_name_too_long_for_topics_at_the_start_is_one_line(ros: None, tmp_path: Path) -> None:
    given = [as_sent('muscle', renamed_model(tmp_path, 'm' * 300))]
    with pytest.raises(LinkedPlaneError, match='is no name for topics') as caught:
        MuscleStatePublisher(parameter_overrides=given)
    assert '\n' not in str(caught.value)


def test_a_batch_that_another_check_refuses_opens_no_topics(
    lone_node: MuscleStatePublisher,
) -> None:
    batch = [as_sent('muscle', 'deltoid_ackland2008'), as_sent('use_sim_time', 'maybe')]
    assert not lone_node.set_parameters_atomically(batch).successful
    lone_node._report()
    assert muscles_published(lone_node) == {'deltoid'}


def test_a_request_that_rclpy_cannot_read_ends_no_node(tmp_path: Path, peer: Peer) -> None:
    with NodeProcess(tmp_path / 'log') as process:
        peer.connect(process)
        client = peer.create_client(SetParameters, 'muscle_state_publisher/set_parameters')
        assert peer.until(client.service_is_ready)
        odd = ParameterMessage(name='side')
        odd.value.type = 200  # there are ten
        client.call_async(SetParameters.Request(parameters=[odd]))
        good = ParameterMessage(name='side')
        good.value.type, good.value.string_value = 4, 'left'
        answer = client.call_async(SetParameters.Request(parameters=[good]))
        assert peer.until(answer.done)
        assert answer.result().results[0].successful
        peer.send(NAMES, (0.1, 0.2, 0.3))
        assert peer.answers(1)
        assert 'unexpected ValueError, passed over: 200 is not' in process.text
