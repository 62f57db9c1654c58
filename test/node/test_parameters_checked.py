# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: what is taken at the start, what is refused and how."""

from __future__ import annotations

from array import array
from pathlib import Path
from typing import Any

import pytest
from parameter_changes import (
    POSE,
    WRONG,
    agree,
    answer_to_pose,
    as_sent,
    connected,
    expected_answer,
)

from linkedplane_ros import JOINT_CONVENTIONS, LinkedPlaneError
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.parameters import NAMES, SPECS, ParameterSpec
from linkedplane_ros.node.settings import Settings

DEFAULTS = {spec.name: spec.default for spec in SPECS}
MODEL = (Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml').read_text()
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def test_every_default_is_valid_and_comes_out_as_it_is() -> None:
    for spec in SPECS:
        meant = [] if spec.name == 'joint_names' else spec.default
        assert spec.check(spec.default) == meant
        assert type(spec.check(spec.default)) is type(spec.default)
    settings = Settings.from_values(DEFAULTS)
    assert settings.solvers[0].muscle.name == 'deltoid'
    assert settings.solvers[0].side == 'right'
    assert settings.convention is THESIS
    assert settings.markers_points == 16


def test_every_wrong_kind_of_value_is_among_the_tests() -> None:
    assert {name for name, _, _ in WRONG} == set(NAMES)


@pytest.mark.parametrize(('name', 'value', 'right'), WRONG)
def test_a_wrong_value_is_refused_in_one_line_that_names_it_and_what_would_be_right(
    name: str, value: Any, right: str
) -> None:
    with pytest.raises(ValueError, match=name) as caught:
        Settings.from_values({**DEFAULTS, name: value})
    assert right in str(caught.value)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize('spec', [spec for spec in SPECS if spec.low is not None])
def test_the_ends_of_a_range_are_within_it(spec: ParameterSpec) -> None:
    kind = type(spec.default)
    for end, beyond in ((spec.low, -1.0), (spec.high, 1.0)):
        assert end is not None
        assert spec.check(kind(end)) == end
        with pytest.raises(LinkedPlaneError, match=f'{spec.low:g} to {spec.high:g} expected'):
            spec.check(kind(end + beyond))


def test_muscles_that_may_fail_are_left_out_with_their_reasons_as_long_as_one_is_left() -> None:
    may_fail = {'biceps', 'triceps'}
    given = ['biceps', 'deltoid', 'triceps', 'deltoid_ackland2008']
    settings = Settings.from_values(DEFAULTS | {'muscle': given}, may_fail)
    assert [solver.muscle.name for solver in settings.solvers] == given[1::2]
    assert set(settings.left_out) == may_fail
    for name, reason in settings.left_out.items():
        assert f'{name!r} is neither a bundled model' in reason
    for fails in (may_fail - {'triceps'}, set()):  # one of them may not
        with pytest.raises(LinkedPlaneError, match='is neither a bundled model'):
            Settings.from_values(DEFAULTS | {'muscle': given}, fails)
    with pytest.raises(LinkedPlaneError, match=r"'biceps' is neither .*; .*'triceps' is neither"):
        Settings.from_values(DEFAULTS | {'muscle': ['biceps', 'triceps', 'biceps']}, may_fail)


def test_a_model_file_at_fault_is_named_in_the_refusal(tmp_path: Path) -> None:
    path = tmp_path / 'broken.yaml'
    for content, reason in ((None, 'No such file'), (MODEL.replace('version: 1', ''), 'version')):
        if content is not None:
            path.write_text(content)
        with pytest.raises(ValueError, match=reason) as caught:
            Settings.from_values({**DEFAULTS, 'muscle': str(path)})
        assert str(path) in str(caught.value)
        assert '\n' not in str(caught.value)


def test_whole_numbers_are_taken_for_doubles() -> None:
    settings = Settings.from_values(
        {**DEFAULTS, 'joint_signs': [1, -1, 1], 'joint_offsets': [0, 1, -2], 'markers.rate': 5}
    )
    assert settings.joints.signs == (1.0, -1.0, 1.0)
    assert settings.joints.offsets == (0.0, 1.0, -2.0)
    assert settings.markers_rate == 5.0
    numbers = (*settings.joints.signs, *settings.joints.offsets, settings.markers_rate)
    assert all(type(number) is float for number in numbers)


def test_the_arrays_that_rclpy_gives_are_taken_for_lists() -> None:
    values = {**DEFAULTS, 'joint_offsets': array('d', (0.1, 0.2, 0.3))}
    assert Settings.from_values(values).joints.offsets == (0.1, 0.2, 0.3)


@pytest.mark.parametrize('convention', JOINT_CONVENTIONS)
@pytest.mark.parametrize('empty', [[], ['']], ids=['no name', 'an empty name'])
def test_no_joint_names_means_the_names_of_the_conventions_coordinates(
    convention: str, empty: list[str]
) -> None:
    values = {**DEFAULTS, 'joint_convention': convention, 'joint_names': empty}
    assert Settings.from_values(values).joints.names == JOINT_CONVENTIONS[convention].coordinates


def test_joint_names_are_taken_in_the_conventions_order() -> None:
    names = ['c', 'a', 'b']
    assert Settings.from_values({**DEFAULTS, 'joint_names': names}).joints.names == tuple(names)


def test_every_parameter_is_described_with_its_range_or_its_choices(
    lone_node: MuscleStatePublisher,
) -> None:
    for spec in SPECS:
        described = lone_node.describe_parameter(spec.name)
        assert described.description == spec.meaning
        assert len(spec.meaning) > 10
        for choice in spec.choices:
            assert choice in described.additional_constraints
        ranges = [*described.floating_point_range, *described.integer_range]
        if spec.low is None:
            assert ranges == []
        else:
            [allowed] = ranges
            assert (allowed.from_value, allowed.to_value) == (spec.low, spec.high)
    assert lone_node.describe_parameter('markers.points').integer_range
    assert lone_node.describe_parameter('markers.rate').floating_point_range


def test_the_node_has_each_parameter_at_its_default(lone_node: MuscleStatePublisher) -> None:
    for spec in SPECS:
        assert lone_node.get_parameter(spec.name).value == spec.default


@pytest.mark.parametrize(('name', 'value', 'right'), WRONG)
def test_a_wrong_override_at_the_start_is_a_value_error_in_one_line(
    ros: None, name: str, value: Any, right: str
) -> None:
    with pytest.raises(ValueError, match=name) as caught:
        MuscleStatePublisher(parameter_overrides=[as_sent(name, value)])
    assert right in str(caught.value)
    assert '\n' not in str(caught.value)


def test_overrides_at_the_start_count_and_an_unknown_one_does_no_harm(ros: None) -> None:
    overrides = {'no_such_thing': 3, 'side': 'left', 'joint_offsets': [0, 1, 0], 'markers.rate': 5}
    made = MuscleStatePublisher(
        parameter_overrides=[as_sent(name, value) for name, value in overrides.items()]
    )
    with connected(made) as peer:
        assert agree(
            answer_to_pose(peer),
            expected_answer(side='left', angles=(POSE[0], POSE[1] + 1.0, POSE[2])),
        )
        assert not made.has_parameter('no_such_thing')
    made.destroy_node()
