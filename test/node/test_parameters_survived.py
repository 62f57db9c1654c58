# SPDX-License-Identifier: Apache-2.0
"""A running node survives what its parameters are set to: taken, or refused with a reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from parameter_changes import as_sent, change_parameters, connected
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.executors import ExternalShutdownException
from rclpy.parameter import Parameter
from ros_harness import muscles_published

from linkedplane_ros import BroadMuscle
from linkedplane_ros.errors import LinkedPlaneError
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.outputs import LONGEST_TOPIC, MuscleOutputs
from linkedplane_ros.node.run import spin
from linkedplane_ros.node.settings import Settings
from linkedplane_ros.solver.linked_plane_solver import LinkedPlaneSolver

MODELS = Path(__file__).parents[2] / 'linkedplane_ros' / 'models'
SERVICES = {SetParameters: 'set_parameters', SetParametersAtomically: 'set_parameters_atomically'}


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


def odd_parameter(name: str, kind: int) -> ParameterMessage:
    """Return a parameter as only a client that makes its own messages sends it."""
    message = ParameterMessage(name=name)
    message.value.type, message.value.string_value = kind, 'left'
    return message


def test_types_that_there_are_not_and_names_unknown_are_refused(
    lone_node: MuscleStatePublisher,
) -> None:
    with connected(lone_node) as peer:

        def ask(kind: Any, *given: tuple[str, int]) -> Any:
            client = peer.create_client(kind, f'muscle_state_publisher/{SERVICES[kind]}')
            assert peer.until(client.service_is_ready)
            request = kind.Request(parameters=[odd_parameter(*each) for each in given])
            answer = client.call_async(request)
            assert peer.until(answer.done)
            return answer.result()

        given = [('side', 200), ('', 4), ('side', 4), ('frame_id', 10), ('no such', 4)]
        results = ask(SetParameters, *given).results
        assert [each.successful for each in results] == [False, False, True, False, False]
        odd, empty, _, other, unknown = (each.reason for each in results)
        assert odd == (
            "parameter 'side': type 200 given, 0 to 9 expected (rcl_interfaces/ParameterType)"
        )
        assert other.startswith("parameter 'frame_id': type 10 given, 0 to 9 expected")
        assert empty == "parameter '': undeclared; a parameter of this node expected"
        assert unknown.startswith("parameter 'no such': undeclared")
        assert lone_node.get_parameter('side').value == 'left'
        assert not lone_node.has_parameter('')

        result = ask(SetParametersAtomically, ('frame_id', 4), ('side', 99)).result
        assert not result.successful
        assert result.reason.startswith("parameter 'side': type 99 given")
        result = ask(SetParametersAtomically, ('frame_id', 4), ('', 4), ('b', 4)).result
        assert not result.successful
        assert result.reason.startswith("parameter '': undeclared")
        assert ask(SetParametersAtomically).result.successful  # nothing to refuse
        assert lone_node.get_parameter('frame_id').value == 'scapula'
        assert ask(SetParametersAtomically, ('frame_id', 4)).result.successful


def test_an_unexpected_error_in_a_message_or_request_ends_no_node(
    lone_node: MuscleStatePublisher, capfd: pytest.CaptureFixture[str]
) -> None:
    class Failing:
        """Works after one error, until ROS is shut down."""

        times = 0

        def spin(self) -> None:
            self.times += 1
            raise ValueError('one\ntwo') if self.times == 1 else ExternalShutdownException

    executor: Any = Failing()
    with pytest.raises(ExternalShutdownException):
        spin(executor, lone_node)
    assert executor.times == 2
    assert 'unexpected ValueError, passed over: one\\ntwo' in capfd.readouterr().err
