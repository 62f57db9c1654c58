# SPDX-License-Identifier: Apache-2.0
"""How old the other joints of a message may be: by stamps, by arrival, and when time goes back."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from linkedplane_ros.joints.joint_state import JointMap, JointMemory, Rejected

NAMES = ('flexion', 'abduction', 'rotation')
VALUES = {'flexion': 0.1, 'abduction': 0.2, 'rotation': 0.3}  # rad


def memory_of(timeout: float) -> JointMemory:
    return JointMemory(JointMap(NAMES, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)), timeout=timeout)


def take(memory: JointMemory, *names: str, stamp: float = 0.0, arrival: float = 0.0) -> str:
    """Take the joints in; return the reason why there is no answer, or no text."""
    sec, rest = divmod(round(1e9 * stamp), 10**9)
    time = SimpleNamespace(sec=sec, nanosec=rest)
    try:
        memory.take_message(names, [VALUES[name] for name in names], (), time, arrival)
    except Rejected as error:
        return f'{error.reason}: {error}'
    return ''


@pytest.mark.parametrize('clock', ['stamp', 'arrival'])
def test_a_joint_that_fell_silent_stops_the_answers_until_it_comes_again(clock: str) -> None:
    memory = memory_of(1.0)
    assert take(memory, *NAMES, **{clock: 100.0}) == ''
    assert take(memory, 'flexion', **{clock: 100.9}) == ''
    assert take(memory, 'flexion', **{clock: 106.0}) == (
        "stale: joint 'abduction' has not come for 6 s; 1 s at most expected (joint_timeout)"
    )
    assert take(memory, 'abduction', **{clock: 106.1}).startswith("stale: joint 'rotation'")
    assert take(memory, 'rotation', **{clock: 106.2}) == ''


def test_without_a_timeout_joints_count_for_ever() -> None:
    memory = memory_of(0.0)
    take(memory, *NAMES, stamp=1.0, arrival=1.0)
    assert take(memory, 'flexion', stamp=1e9, arrival=1e6) == ''
    assert take(memory, 'flexion', stamp=0.5, arrival=1e6) == ''


def test_joints_that_come_one_by_one_are_all_of_the_time_of_a_message() -> None:
    memory = memory_of(0.05)
    reasons = [
        take(memory, NAMES[k % 3], stamp=100.0 + 0.01 * k, arrival=0.01 * k) for k in range(300)
    ]
    assert [reason.partition(':')[0] for reason in reasons[:3]] == ['incomplete'] * 2 + ['']
    assert not any(reasons[2:])


def test_a_stamp_that_stands_still_does_not_keep_a_silent_joint_young() -> None:
    memory = memory_of(1.0)
    take(memory, *NAMES, stamp=7.0, arrival=0.0)
    assert take(memory, 'flexion', stamp=7.0, arrival=0.5) == ''
    assert take(memory, 'flexion', stamp=7.0, arrival=1.5).startswith('stale')


def test_stamps_of_some_joints_alone_are_compared_by_arrival() -> None:
    memory = memory_of(1.0)
    take(memory, 'abduction', 'rotation', stamp=1.7e9, arrival=0.0)
    assert take(memory, 'flexion', arrival=0.5) == ''
    assert take(memory, 'flexion', arrival=1.5).startswith('stale')


def test_when_time_goes_back_joints_from_before_are_never_used_again() -> None:
    memory = memory_of(1.0)
    take(memory, *NAMES, stamp=100.0, arrival=0.0)
    assert take(memory, 'flexion', 'abduction', stamp=1.0, arrival=0.1) == (
        "stale: joint 'rotation' has not come since time went back; 1 s at most expected "
        '(joint_timeout)'
    )
    assert take(memory, 'flexion', 'abduction', stamp=100.0, arrival=0.2).startswith('stale')
    assert take(memory, 'rotation', stamp=100.1, arrival=0.3) == ''


def test_a_whole_message_is_answered_wherever_its_stamp_jumps() -> None:
    memory = memory_of(0.1)
    for stamp in (100.0, 1.0, 0.0, 5000.0, 4999.0):
        assert take(memory, *NAMES, stamp=stamp, arrival=0.0) == ''


def test_messages_a_little_out_of_order_are_answered() -> None:
    memory = memory_of(0.1)
    take(memory, *NAMES, stamp=100.0, arrival=0.0)
    assert take(memory, 'flexion', stamp=99.95, arrival=0.01) == ''


def test_the_age_of_each_joint_is_that_of_its_arrival() -> None:
    memory = memory_of(0.0)
    take(memory, 'flexion', arrival=1.0)
    take(memory, 'rotation', arrival=3.0)
    assert memory.find_ages(5.0) == {'flexion': 4.0, 'rotation': 2.0}


def test_a_message_without_a_stamp_is_as_old_as_its_arrival() -> None:
    memory = memory_of(0.1)
    take(memory, *NAMES, stamp=100.0, arrival=7.0)
    memory.take_message(NAMES[:1], (0.1,), (), None, 7.05)
    with pytest.raises(Rejected, match=r"'abduction' has not come for 0\.15 s"):
        memory.take_message(NAMES[:1], (0.1,), (), None, 7.15)


def test_arrivals_that_are_not_given_are_at_0_s() -> None:
    memory = memory_of(0.0)
    memory.take_message(NAMES, (0.1, 0.2, 0.3), ())
    assert memory.find_ages(2.0) == dict.fromkeys(NAMES, 2.0)
