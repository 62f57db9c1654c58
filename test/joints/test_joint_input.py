# SPDX-License-Identifier: Apache-2.0
"""From the joints of a message to three angles: what is taken, what is refused, and why."""

from __future__ import annotations

import math
from array import array
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from unhurried import unhurried

from linkedplane_ros.joints.joint_state import (
    REASONS,
    JointMap,
    JointMemory,
    OtherJoints,
    Rejected,
    summarize_names,
)

NAMES = ('flexion', 'abduction', 'rotation')
PLAIN = JointMap(NAMES, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))


@pytest.fixture
def memory() -> JointMemory:
    """A memory that has seen nothing."""
    return JointMemory(PLAIN)


def refusal(memory: JointMemory, *message: Any) -> tuple[str, str]:
    """Return the reason and the line of a message that must be refused."""
    with pytest.raises(Rejected) as caught:
        memory.take_message(*message)
    assert caught.value.reason in REASONS
    assert '\n' not in str(caught.value)
    return caught.value.reason, str(caught.value)


def test_an_angle_is_sign_times_position_plus_offset() -> None:
    memory = JointMemory(JointMap(NAMES, (1.0, -1.0, -1.0), (0.5, 0.75, -0.25)))
    angles, speeds, warning = memory.take_message(NAMES, (0.1, 0.2, 0.3), (1.0, 2.0, 3.0))
    assert angles == (0.1 + 0.5, 0.75 - 0.2, -0.3 - 0.25)
    assert speeds is not None
    assert speeds == (1.0, -2.0, -3.0)
    assert warning == ''


@pytest.mark.parametrize('order', [(0, 1, 2), (2, 0, 1), (2, 1, 0), (1, 0, 2)])
def test_the_order_of_the_joints_does_not_matter(
    memory: JointMemory, order: tuple[int, ...]
) -> None:
    position, velocity = (0.1, 0.2, 0.3), (1.0, 2.0, 3.0)
    angles, speeds, _ = memory.take_message(
        *([values[k] for k in order] for values in (NAMES, position, velocity))
    )
    assert angles == (0.1, 0.2, 0.3)
    assert speeds is not None
    assert speeds == (1.0, 2.0, 3.0)


def test_other_joints_do_not_matter_whatever_their_values(memory: JointMemory) -> None:
    names = ('elbow', 'rotation', 'wrist', 'abduction', 'flexion', 'thumb')
    angles, speeds, warning = memory.take_message(
        names, (math.nan, 0.3, 900.0, 0.2, 0.1, -math.inf), (math.nan, 3.0, math.inf, 2.0, 1.0, 0.0)
    )
    assert angles == (0.1, 0.2, 0.3)
    assert speeds is not None
    assert speeds == (1.0, 2.0, 3.0)
    assert warning == ''


@pytest.mark.parametrize('twice', NAMES)
def test_a_message_with_one_of_our_joints_twice_is_rejected(
    memory: JointMemory, twice: str
) -> None:
    reason, text = refusal(memory, (twice, *NAMES), (0.4, 0.1, 0.2, 0.3), ())
    assert (reason, text) == ('duplicate', f'joint {twice!r} is in it 2 times; once expected')
    assert not memory.positions
    names = ('thumb', *NAMES, 'thumb')  # joints that are not ours do not matter
    assert memory.take_message(names, (9e9, 0.1, 0.2, 0.3, 9e9), ())[0] == (0.1, 0.2, 0.3)
    for place in range(3):  # also after a good message
        assert refusal(memory, (*NAMES, NAMES[place]), (0.1, 0.2, 0.3, 0.3), ())[0] == 'duplicate'


def test_the_arrays_of_a_ros_message_are_taken_as_they_are(memory: JointMemory) -> None:
    angles, speeds, _ = memory.take_message(list(NAMES), array('d', (0.1, 0.2, 0.3)), array('d'))
    assert angles == (0.1, 0.2, 0.3)
    assert speeds is None


REFUSED = [
    ('sizes', NAMES, (0.1, 0.2), '3 names but 2 positions; one each expected'),
    ('sizes', (), (0.1,), '0 names but 1 positions; one each expected'),
    ('no_joint', (), (), 'none of the joints flexion, abduction, rotation in it, but no joint at '
     'all; set joint_names or joint_convention'),
    ('no_joint', ('elbow', 'wrist'), (0.1, 0.2), "in it, but 'elbow', 'wrist'; set joint_names"),
    ('no_joint', tuple('abcdefgh'), (0.0,) * 8, "but 'a', 'b', 'c', 'd', 'e', 'f' and 2 more; set"),
    ('not_finite', NAMES, (0.1, math.nan, 0.3), "joint 'abduction' is nan; a finite angle"),
    ('not_finite', NAMES, (0.1, 0.2, math.inf), "joint 'rotation' is inf; a finite angle"),
    ('not_finite', ('flexion',), (-math.inf,), "joint 'flexion' is -inf; a finite angle"),
    ('degrees', NAMES, (0.1, 90.0, 0.3), "joint 'abduction' is 90: degrees? radians expected"),
    ('degrees', NAMES, (-6.3, 0.0, 0.0), "joint 'flexion' is -6.3: degrees? radians expected"),
]  # fmt: skip


@pytest.mark.parametrize(('reason', 'names', 'positions', 'line'), REFUSED)
def test_a_refusal_has_its_reason_and_a_line_that_says_what_was_found(
    memory: JointMemory,
    reason: str,
    names: tuple[str, ...],
    positions: tuple[float, ...],
    line: str,
) -> None:
    found, text = refusal(memory, names, positions, ())
    assert found == reason
    assert line in text


@pytest.mark.parametrize(('reason', 'names', 'positions', 'line'), REFUSED)
def test_a_refused_message_changes_nothing_that_is_remembered(
    memory: JointMemory,
    reason: str,
    names: tuple[str, ...],
    positions: tuple[float, ...],
    line: str,
) -> None:
    memory.take_message(NAMES, (0.4, 0.5, 0.6), (4.0, 5.0, 6.0))
    refusal(memory, names, positions, (9.0,) * len(names))
    angles, speeds, _ = memory.take_message(('flexion',), (0.4,), (4.0,))
    assert angles == (0.4, 0.5, 0.6)
    assert speeds is not None
    assert speeds == (4.0, 5.0, 6.0)


def test_a_full_turn_is_still_an_angle(memory: JointMemory) -> None:
    turn = 2.0 * math.pi
    assert memory.take_message(NAMES, (turn, -turn, 0.0), ())[0] == (turn, -turn, 0.0)
    beyond = math.nextafter(turn, 7.0)
    assert refusal(memory, NAMES, (0.0, 0.0, beyond), ())[0] == 'degrees'


def test_an_offset_does_not_make_an_angle_look_like_degrees() -> None:
    memory = JointMemory(JointMap(NAMES, (1.0, 1.0, 1.0), (6.0, 0.0, 0.0)))
    assert memory.take_message(NAMES, (1.0, 0.0, 0.0), ())[0] == (7.0, 0.0, 0.0)


def test_joints_split_over_messages_are_answered_once_all_three_are_known(
    memory: JointMemory,
) -> None:
    assert refusal(memory, ('rotation',), (0.3,), ()) == (
        'incomplete',
        "waiting for joint 'flexion', not seen so far",
    )
    assert refusal(memory, ('flexion',), (0.1,), ()) == (
        'incomplete',
        "waiting for joint 'abduction', not seen so far",
    )
    assert memory.take_message(('abduction',), (0.2,), ())[0] == (0.1, 0.2, 0.3)
    assert memory.take_message(('rotation', 'flexion'), (0.6, 0.4), ())[0] == (0.4, 0.2, 0.6)


def test_velocities_split_over_messages_are_known_once_all_three_are(memory: JointMemory) -> None:
    refusal(memory, ('flexion',), (0.1,), (1.0,))
    refusal(memory, ('abduction',), (0.2,), (2.0,))
    _, speeds, _ = memory.take_message(('rotation',), (0.3,), (3.0,))
    assert speeds is not None
    assert speeds == (1.0, 2.0, 3.0)


def test_velocities_of_two_joints_alone_are_none(memory: JointMemory) -> None:
    memory.take_message(NAMES, (0.1, 0.2, 0.3), ())
    assert memory.take_message(('flexion', 'rotation'), (0.1, 0.3), (1.0, 3.0))[1] is None


def test_a_message_without_velocities_has_none_though_earlier_ones_had(
    memory: JointMemory,
) -> None:
    memory.take_message(NAMES, (0.1, 0.2, 0.3), (1.0, 2.0, 3.0))
    angles, speeds, warning = memory.take_message(NAMES, (0.4, 0.5, 0.6), ())
    assert angles == (0.4, 0.5, 0.6)
    assert speeds is None
    assert warning == ''


@pytest.mark.parametrize(
    ('velocities', 'line'),
    [
        ((1.0,), 'velocities left out: 1 for 3 names'),
        ((1.0, 2.0, 3.0, 4.0), 'velocities left out: 4 for 3 names'),
        ((1.0, math.nan, 3.0), "velocities left out: that of joint 'abduction' is nan"),
        ((1.0, 2.0, -math.inf), "velocities left out: that of joint 'rotation' is -inf"),
        ((1.0, 2.0, 1e308), "velocities left out: that of joint 'rotation' is 1e+308"),
    ],
)
def test_unusable_velocities_are_left_out_with_a_warning_and_not_remembered(
    memory: JointMemory, velocities: tuple[float, ...], line: str
) -> None:
    memory.take_message(NAMES, (0.1, 0.2, 0.3), (7.0, 8.0, 9.0))
    angles, speeds, warning = memory.take_message(NAMES, (0.4, 0.5, 0.6), velocities)
    assert angles == (0.4, 0.5, 0.6)
    assert speeds is None
    assert warning == line
    # a velocity is no older than the position that it came with
    assert memory.take_message(('flexion',), (0.4,), (6.0,))[1] is None


@pytest.mark.parametrize(
    ('count', 'text'),
    [
        (0, 'no joint at all'),
        (1, "'a'"),
        (6, "'a', 'b', 'c', 'd', 'e', 'f'"),
        (8, "'a', 'b', 'c', 'd', 'e', 'f' and 2 more"),
        (13, "'a', 'b', 'c', 'd', 'e', 'f' and 7 more"),
    ],
)
def test_a_list_of_names_is_cut_short(count: int, text: str) -> None:
    assert summarize_names('abcdefghijklm'[:count]) == text


def test_of_several_faults_the_first_joints_is_told(memory: JointMemory) -> None:
    reason, line = refusal(memory, NAMES, (0.1, math.inf, 90.0), ())
    assert (reason, line) == ('not_finite', "joint 'abduction' is inf; a finite angle expected")
    reason, line = refusal(memory, NAMES, (90.0, math.inf, 0.3), ())
    assert (reason, line[:20]) == ('degrees', "joint 'flexion' is 9")
    warning = memory.take_message(NAMES, (0.1, 0.2, 0.3), (1.0, math.nan, math.inf))[2]
    assert warning == "velocities left out: that of joint 'abduction' is nan"


def test_the_fastest_velocity_of_a_joint_is_still_one(memory: JointMemory) -> None:
    fast = (1e9, -1e9, 0.0)
    assert memory.take_message(NAMES, (0.1, 0.2, 0.3), fast)[1:] == (fast, '')
    assert memory.take_message(NAMES, (0.1, 0.2, 0.3), (math.nextafter(1e9, 2e9), 0.0, 0.0))[2]


def test_other_joints_are_kept_apart_from_a_message_without_any(memory: JointMemory) -> None:
    with pytest.raises(OtherJoints) as other:
        memory.take_message(['elbow'], (0.1,), ())
    assert (other.value.reason, other.value.names) == ('no_joint', "'elbow'")
    with pytest.raises(Rejected) as empty:
        memory.take_message([], (), ())
    assert not isinstance(empty.value, OtherJoints)


numbers = st.one_of(
    st.floats(-7.0, 7.0), st.floats(), st.sampled_from([0.0, math.nan, math.inf, 2.0 * math.pi])
)
names = st.lists(st.one_of(st.sampled_from(NAMES), st.text(max_size=4)), max_size=6)


@st.composite
def messages(draw: st.DrawFn) -> tuple[list[str], list[float], list[float]]:
    """Return names, positions and velocities, most often of one size."""
    found = draw(names)
    fitting = st.lists(numbers, min_size=len(found), max_size=len(found))
    values = st.one_of(fitting, fitting, fitting, st.lists(numbers, max_size=6))
    return found, draw(values), draw(st.one_of(st.just([]), values))


@unhurried
@given(st.lists(messages(), max_size=6))
def test_no_message_raises_anything_but_a_refusal_or_gives_what_is_not_finite(
    sent: list[tuple[list[str], list[float], list[float]]],
) -> None:
    memory = JointMemory(JointMap(NAMES, (1.0, -1.0, 1.0), (0.1, 0.0, -3.0)))
    for message in sent:
        try:
            angles, speeds, warning = memory.take_message(*message)
        except Rejected:
            continue
        assert len(angles) == 3
        assert np.isfinite(angles).all()
        assert speeds is None or (len(speeds) == 3 and np.isfinite(speeds).all())
        assert not (warning and speeds is not None)
