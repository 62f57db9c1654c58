# SPDX-License-Identifier: Apache-2.0
"""From a muscle state to messages: layouts, row-major data, and what a receiver reads back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, MuscleState
from linkedplane_ros.node.messages import Answers, layout

THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
SOLVER = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
BANDS = SOLVER.muscle.band_names
ANGLES = np.array((0.3, 0.8, -0.2))
STATE = SOLVER.solve(THESIS.rotation(ANGLES))
ARMS = STATE.moment_vectors @ THESIS.axes(ANGLES)
STAMP = Time(sec=1_700_000_000, nanosec=123_456_789)


def received(message: Any) -> Any:
    """Return the message as it comes out of the middleware."""
    return deserialize_message(serialize_message(message), type(message))


def answers(
    state: MuscleState = STATE, arms: np.ndarray = ARMS, lengthening: np.ndarray | None = None
) -> Mapping[str, Any]:
    """Return the answers at a state."""
    return Answers(BANDS, THESIS.coordinates, 'scapula').update(STAMP, state, arms, lengthening)


def test_the_messages_check_their_fields_in_these_tests() -> None:
    with pytest.raises(AssertionError):
        JointState(name=[1])


def test_a_layout_names_its_dimensions_and_has_the_strides_of_multi_array_layout() -> None:
    form = answers()['moment_arms'].layout
    assert [dim.label for dim in form.dim] == [
        'band:anterior_1,anterior_2,anterior_3,middle_1,middle_2,middle_3,'
        'posterior_1,posterior_2,posterior_3',
        'coordinate:flexion,abduction,rotation',
    ]
    assert [(dim.size, dim.stride) for dim in form.dim] == [(9, 27), (3, 3)]
    assert form.data_offset == 0


@pytest.mark.parametrize('sizes', [(), (1,), (9,), (9, 3), (2, 3, 4), (2, 0, 3)])
def test_the_stride_of_a_dimension_is_the_number_of_values_from_it_inwards(
    sizes: tuple[int, ...],
) -> None:
    form = layout(*((f'kind{i}', 'abcdefghi'[:size]) for i, size in enumerate(sizes)))
    assert [dim.size for dim in form.dim] == list(sizes)
    assert [dim.stride for dim in form.dim] == [int(np.prod(sizes[i:])) for i in range(len(sizes))]


def test_every_value_lies_where_the_strides_say() -> None:
    for topic, values in (('moment_arms', ARMS), ('moment_vectors', STATE.moment_vectors)):
        message = received(answers()[topic])
        inner = message.layout.dim[1].stride
        for i in range(9):
            for j in range(3):
                assert message.data[message.layout.data_offset + inner * i + j] == values[i, j]
        assert len(message.data) == message.layout.dim[0].stride


@pytest.mark.parametrize('arms', [np.asfortranarray(ARMS), ARMS.T.copy().T, ARMS[::-1, ::-1]])
def test_data_are_row_major_however_the_array_lies_in_memory(arms: np.ndarray) -> None:
    assert not arms.flags.c_contiguous
    assert answers(arms=arms)['moment_arms'].data.tolist() == arms.ravel(order='C').tolist()


def test_an_array_comes_out_of_the_middleware_to_the_bit() -> None:
    lengths = received(answers()['band_lengths'])
    assert lengths.data.typecode == 'd'
    assert lengths.data.tolist() == STATE.lengths.tolist()
    assert [(dim.size, dim.stride) for dim in lengths.layout.dim] == [(9, 9)]


def test_wrap_states_come_out_of_the_middleware_as_bytes() -> None:
    message = received(answers()['wrap_states'])
    assert message.data.typecode == 'B'
    assert message.data.tolist() == STATE.wrap.tolist()
    assert message.layout.dim[0].label == 'band:' + ','.join(BANDS)


def test_the_axes_of_the_moment_vectors_are_named() -> None:
    labels = [dim.label for dim in answers()['moment_vectors'].layout.dim]
    assert labels == ['band:' + ','.join(BANDS), 'axis:x,y,z']


def test_a_state_of_a_batch_converts_as_a_single_one() -> None:
    poses = [THESIS.rotation(angles) for angles in (ANGLES, -ANGLES)]
    for state in SOLVER.solve_batch(np.array(poses)):
        alone = SOLVER.solve(state.rotation)
        assert answers(state) == answers(alone)


def test_bands_are_joints_with_lengths_as_positions_and_lengthening_as_velocities() -> None:
    speeds = -ARMS @ np.array((0.1, 1.0, 0.2))
    message = received(answers(lengthening=speeds)['band_states'])
    assert message.header.stamp == STAMP
    assert message.header.frame_id == 'scapula'
    assert message.name == list(BANDS)
    assert message.position.tolist() == STATE.lengths.tolist()
    assert message.velocity.tolist() == speeds.tolist()
    assert len(message.effort) == 0


def test_moment_arms_are_joints_named_by_band_and_coordinate_in_the_order_of_the_array() -> None:
    made = answers()
    message = received(made['moment_arm_states'])
    assert message.header == received(made['band_states']).header
    for i, band in enumerate(BANDS):
        for j, coordinate in enumerate(THESIS.coordinates):
            assert message.name[3 * i + j] == f'{band}/{coordinate}'
            assert message.position[3 * i + j] == ARMS[i, j]
    assert len(message.name) == len(message.position) == ARMS.size
    assert len(message.velocity) == len(message.effort) == 0


def test_the_names_of_moment_arms_are_the_conventions_coordinates() -> None:
    isb = JOINT_CONVENTIONS['isb_yxy']
    made = Answers(BANDS, isb.coordinates, 'scapula').update(STAMP, STATE, ARMS, None)
    assert made['moment_arm_states'].name[:4] == [
        'anterior_1/plane_of_elevation',
        'anterior_1/elevation',
        'anterior_1/axial_rotation',
        'anterior_2/plane_of_elevation',
    ]


def test_without_speeds_the_velocity_is_empty_though_the_last_ones_was_not() -> None:
    made = Answers(BANDS, THESIS.coordinates, 'scapula')
    assert len(made.update(STAMP, STATE, ARMS, STATE.lengths)['band_states'].velocity) == 9
    message = received(made.update(STAMP, STATE, ARMS, None)['band_states'])
    assert message.position.tolist() == STATE.lengths.tolist()
    assert len(message.velocity) == 0


def test_the_same_messages_are_filled_in_from_state_to_state() -> None:
    made = Answers(BANDS, THESIS.coordinates, 'scapula')
    first = {topic: id(message) for topic, message in made.update(STAMP, STATE, ARMS, None).items()}
    assert {
        topic: id(message) for topic, message in made.update(STAMP, STATE, ARMS, None).items()
    } == first
