# SPDX-License-Identifier: Apache-2.0
"""What the node tells of itself: its level, its counters and its times."""

from __future__ import annotations

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.parameter import Parameter
from ros_harness import Peer
from sensor_msgs.msg import JointState

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.joints.joint_state import REASONS
from linkedplane_ros.node.diagnostics import (
    STALE_AFTER,
    TIMED,
    Tally,
    build_status,
    summarise_times,
)
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

OK, WARN, ERROR, STALE = (
    DiagnosticStatus.OK,
    DiagnosticStatus.WARN,
    DiagnosticStatus.ERROR,
    DiagnosticStatus.STALE,
)
NAMES = ('flexion', 'abduction', 'rotation')
NOW = 1000.0  # s


def tally_of(*, answered: int = 0, rejected: int = 0, age: float = 0.1) -> Tally:
    """Return a tally that has heard so many messages, the last `age` s ago."""
    tally = Tally(received=answered + rejected, answered=answered, last_arrival=NOW - age)
    tally.rejected['degrees'] = rejected
    if rejected:
        tally.last_rejection = 'degrees?'
    return tally


def reported_values(tally: Tally) -> dict[str, str]:
    """Return the values of a status."""
    told = build_status(tally, 'node: deltoid', 'deltoid, right', NOW, {'side': 'any'})
    return {item.key: item.value for item in told.values}


def test_without_input_the_level_is_stale() -> None:
    assert Tally().assess(NOW) == (STALE, 'no joint states received yet')


def test_input_that_has_ended_is_stale() -> None:
    level, line = tally_of(answered=5, age=7.5).assess(NOW)
    assert level == STALE
    assert '7.5 s' in line
    assert tally_of(answered=5, age=STALE_AFTER).assess(NOW)[0] == OK


def test_answered_input_is_ok() -> None:
    assert tally_of(answered=5).assess(NOW)[0] == OK


def test_input_of_which_nothing_was_usable_is_an_error_that_says_why() -> None:
    tally = tally_of(rejected=3)
    for _ in range(2):
        level, line = tally.assess(NOW)
        assert level == ERROR
        assert 'degrees?' in line


def test_rejected_input_warns_once_and_says_why() -> None:
    tally = tally_of(answered=5, rejected=2)
    level, line = tally.assess(NOW)
    assert level == WARN
    assert line.startswith('2 rejected')
    assert 'degrees?' in line
    assert tally.assess(NOW)[0] == OK
    tally.rejected['sizes'] += 1
    level, line = tally.assess(NOW)
    assert level == WARN
    assert line.startswith('1 rejected')
    assert tally.assess(NOW)[0] == OK


def test_near_the_singularity_the_line_says_so_and_the_level_stays() -> None:
    tally = tally_of(answered=5)
    tally.near_singular = 3
    assert tally.assess(NOW) == (
        OK,
        'answering; 3 near the singularity, where two moment arms are nearly equal: use the '
        'moment vectors',
    )
    assert tally.assess(NOW) == (OK, 'answering')
    assert reported_values(tally)['answers near the singularity'] == '3'


def test_near_the_side_the_line_says_what_the_rhythm_lacks() -> None:
    tally = tally_of(answered=5)
    tally.without_plane = 3
    level, line = tally.assess(NOW)
    assert level == OK
    assert line.startswith('answering; 3 near the singularity, the arm at the side')


def test_peers_that_do_not_fit_warn_and_explain_why_nothing_comes() -> None:
    tally = tally_of(answered=5)
    tally.incompatible_peers = ['nothing comes from lab']
    assert tally.assess(NOW) == (WARN, 'nothing comes from lab')
    silent = Tally(incompatible_peers=['nothing comes from lab'])
    assert silent.assess(NOW) == (STALE, 'nothing comes from lab')


def test_a_status_has_what_it_was_given_and_every_counter() -> None:
    tally = tally_of(answered=5, rejected=2)
    made = build_status(tally, 'node: deltoid', 'deltoid, right', NOW, {'side': 'any'})
    assert (made.name, made.hardware_id, made.level) == (
        'node: deltoid',
        'deltoid, right',
        WARN,
    )
    values = reported_values(tally)
    assert values['side'] == 'any'
    assert values['messages received'] == '7'
    assert values['messages answered'] == '5'
    assert {key for key in values if key.startswith('rejected: ')} == {
        f'rejected: {reason}' for reason in REASONS
    }
    assert values['rejected: degrees'] == '2'
    assert values['input age (s)'] == '0.100'


def test_no_key_stands_twice() -> None:
    tally = tally_of(answered=1)
    tally.last_state = LinkedPlaneSolver(BroadMuscle.load('deltoid')).solve(np.eye(3))
    keys = [item.key for item in build_status(tally, 'n', 'h', NOW, {}).values]
    assert len(set(keys)) == len(keys)


def test_before_the_first_answer_there_are_no_times() -> None:
    values = reported_values(Tally())
    assert values['input age (s)'] == 'none'
    assert values['solve time mean (ms)'] == 'none'
    assert 'theta (rad)' not in values


def test_times_are_mean_99th_percentile_and_worst_in_ms() -> None:
    tally = tally_of(answered=100)
    tally.solve_times.extend(k * 1e-3 for k in range(101))
    tally.callback_times.append(0.25)
    values = reported_values(tally)
    assert [values[f'solve time {name} (ms)'] for name in ('mean', 'p99', 'worst')] == [
        '50.000',
        '99.000',
        '100.000',
    ]
    assert values['callback time worst (ms)'] == '250.000'


def test_times_look_back_on_the_newest_callbacks_alone() -> None:
    tally = Tally()
    tally.solve_times.extend([1.0] + [0.001] * TIMED)
    assert summarise_times(tally.solve_times)['worst'] == '1.000'


def test_the_last_state_is_told_as_theta_and_how_the_bands_lie() -> None:
    tally = tally_of(answered=1)
    state = LinkedPlaneSolver(BroadMuscle.load('deltoid')).solve(np.eye(3))
    tally.last_state = state
    values = reported_values(tally)
    assert float(values['theta (rad)']) == pytest.approx(state.theta, abs=5e-7)  # six decimals
    counts = [int(values[f'bands {wrap}']) for wrap in ('wrapped', 'clear', 'missed', 'inside')]
    assert counts == [int((state.wrap == wrap).sum()) for wrap in range(4)]
    assert sum(counts) == 9


def level(peer: Peer) -> bytes:
    return peer.diagnostics[-1].status[0].level


def test_the_node_reports_once_a_second_from_the_start(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    assert [timer.timer_period_ns for timer in node.timers] == [10**9]
    assert peer.until(lambda: len(peer.diagnostics) >= 2)
    assert level(peer) == STALE
    stamps = [array.header.stamp for array in peer.diagnostics]
    times = [stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]
    assert times == sorted(times)
    assert times[0] > 0.0
    [status] = peer.diagnostics[-1].status
    assert status.name == 'muscle_state_publisher: deltoid'
    assert status.hardware_id == 'deltoid, right'


def test_the_nodes_counters_add_up_and_its_times_are_numbers(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    peer.send(('flexion',), (0.1,))
    peer.send(NAMES, (0.0, 90.0, 0.0))
    peer.send(NAMES, (0.0, math.nan, 0.0))
    peer.send(NAMES, (0.1, 0.2))
    peer.send(('elbow',), (0.1,))
    for _ in range(4):
        peer.send(NAMES, (0.1, 0.2, 0.3))
    assert peer.answers(4)
    assert peer.until(lambda: bool(peer.diagnostics) and peer.values()['messages received'] == '9')
    values = peer.values()
    assert values['messages answered'] == '4'
    rejected = {key: value for key, value in values.items() if key.startswith('rejected: ')}
    assert {key for key, value in rejected.items() if value == '1'} == {
        f'rejected: {reason}' for reason in ('incomplete', 'degrees', 'not_finite', 'sizes')
    }
    assert values['messages of other joints'] == '1'
    assert 4 + 1 + sum(map(int, rejected.values())) == 9
    for kind in ('solve', 'callback'):
        mean, p99, worst = (
            float(values[f'{kind} time {figure} (ms)']) for figure in ('mean', 'p99', 'worst')
        )
        assert 0.0 < mean <= worst
        assert 0.0 < p99 <= worst
    assert math.isfinite(float(values['theta (rad)']))
    assert float(values['input age (s)']) >= 0.0
    assert values['joint convention'] == 'flexion_abduction_rotation'
    assert values['side'] == 'right'


def test_the_node_is_in_error_until_something_was_usable_then_ok_or_warning_then_stale(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    def until(wanted: bytes, *message: tuple) -> None:
        """Send a message again and again until the node reports a level."""
        for _ in range(600):
            if message:
                peer.send(*message)
            if peer.until(lambda: bool(peer.diagnostics) and level(peer) == wanted, 0.1):
                return
        raise AssertionError(f'the level {wanted!r} was not reported')

    until(STALE)
    until(ERROR, NAMES, (0.0, 90.0, 0.0))
    assert "joint 'abduction' is 90: degrees?" in peer.diagnostics[-1].status[0].message
    until(OK, NAMES, (0.0, 0.9, 0.0))
    until(WARN, NAMES, (0.0, 90.0, 0.0))
    assert 'rejected in the last second' in peer.diagnostics[-1].status[0].message
    until(OK, NAMES, (0.0, 0.9, 0.0))
    until(STALE)
    assert 'no joint states for' in peer.diagnostics[-1].status[0].message


@pytest.mark.parametrize(
    ('convention', 'angles', 'near'),
    [
        ('isb_yxy', (0.3, 0.019, 0.1), True),
        ('isb_yxy', (0.3, 0.021, 0.1), False),
        ('opensim_mobl', (0.3, 0.019, 0.1), True),
        ('opensim_mobl', (0.3, 0.021, 0.1), False),
        ('rep155', (0.3, math.pi - 0.019, 0.1), True),
        ('flexion_abduction_rotation', (0.3, 0.0, 0.1), False),
        ('flexion_abduction_rotation', (0.3, 1.56, 0.1), True),
    ],
)
@pytest.mark.parametrize('side', ['right', 'left'])
def test_the_node_counts_answers_near_the_singularity(
    ros: None, convention: str, angles: tuple[float, ...], near: bool, side: str
) -> None:
    given = {'joint_convention': convention, 'side': side}
    made = MuscleStatePublisher(
        parameter_overrides=[Parameter(name, value=value) for name, value in given.items()]
    )
    names = made._settings.convention.coordinates
    made._answer(JointState(name=names, position=angles))
    tally = made._muscles[0].tally
    counts = tally.answered, tally.near_singular
    made.destroy_node()
    assert counts == (1, int(near))


def test_the_node_counts_answers_whose_plane_a_rhythm_lacks_and_those_beyond_limits(
    ros: None,
) -> None:
    lost = {'rhythm': 'de_groot_brand_2001'}
    girdle = {'muscle': 'deltoid_girdle', 'skeleton': 'shoulder_girdle'}
    for given, joints, key, words in (
        (lost, (0.01, 0.0, 0.1), 'answers near the singularity', ''),
        (girdle, (3.0, *8 * (0.0,)), 'answers beyond limits of joints', 'answering'),
        (girdle, (0, 0, 0, 3.0, *5 * (0,)), 'answers beyond limits of joints', '1 of 1 with'),
    ):
        made = MuscleStatePublisher(
            parameter_overrides=[Parameter(name, value=value) for name, value in given.items()]
        )
        names = made._settings.joints.names
        made._answer(JointState(name=names, position=joints))
        status = made._muscles[0].build_status({})
        made.destroy_node()
        values = {each.key: each.value for each in status.values}
        assert values[key] == ('0' if words == 'answering' else '1')
        assert words in status.message
