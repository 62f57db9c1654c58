# SPDX-License-Identifier: Apache-2.0
"""Angles filtered, resampled and differentiated in time."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from bags import STORE, T0, Sent, joint_state, odd_motion, read_csv, read_messages, write_bag
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Report, Task, run_task


def turning(
    tmp_path: Path, times: Iterable[float], ending: str = '.csv', **options: float
) -> Report:
    """Process a table whose rotation goes at 1 rad/s, from 3 rad on, over pi to -pi."""
    lines = ['time,flexion,abduction,rotation']
    for t in times:
        angle = math.remainder(3.0 + t, math.tau)
        lines.append(f'{t!r},0.3,0.2,{angle!r}')
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    return run_task(Task(tmp_path / 'in.csv', tmp_path / 'out.csv', Options(**options)))


TENTHS = [0.01 * k for k in range(101)]


@pytest.mark.parametrize('options', [{'rate': 200.0}, {'lowpass': 6.0}, {}])
def test_an_angle_may_go_over_pi(tmp_path: Path, options: dict[str, float]) -> None:
    report = turning(tmp_path, TENTHS, **options)
    assert (report.fault, dict(report.refused)) == ('', {})
    _, names, values = read_csv(tmp_path / 'out.csv')
    rotation = values[:, names.index('angles/rotation')]
    off = np.exp(1j * rotation) / np.exp(1j * (3.0 + values[:, 0]))
    np.testing.assert_allclose(np.angle(off), 0.0, atol=5e-3)  # the filter's ends; else 1e-4
    lengthening = values[:, [name.startswith('lengthening/') for name in names]]
    assert np.abs(lengthening).max() < 0.05  # m/s, at 1 rad/s about arms below 5 cm


def test_a_gap_is_not_bridged(tmp_path: Path) -> None:
    times = [t for t in TENTHS if not 0.3 < t < 0.6]
    assert turning(tmp_path, times, rate=50.0).frames == 37
    stamps = read_csv(tmp_path / 'out.csv')[2][:, 0]
    assert not ((stamps > 0.31) & (stamps < 0.59)).any()
    np.testing.assert_allclose(np.sort(np.diff(stamps))[:-1], 0.02, atol=2e-9)


def test_a_stretch_too_short_for_the_filter_is_counted(tmp_path: Path) -> None:
    times = [t for t in TENTHS if not (0.3 < t < 0.6 or t > 0.64)]
    report = turning(tmp_path, times, lowpass=6.0)
    assert dict(report.refused) == {'too_short': len(times) - 31}
    assert '0.60 s: a stretch without gaps of 5 frames; at least 10' in report.first['too_short']


def test_a_jump_of_the_angles_is_not_filtered_away(tmp_path: Path) -> None:
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{0.01 * k},{0.1 if k < 20 else 0.1 + math.pi / 2},0.3,0.1' for k in range(50)]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    fault = run_task(Task(tmp_path / 'in.csv', tmp_path / 'out.csv', Options(lowpass=6.0))).fault
    assert 'in.csv: an angle jumps by 1.57 rad at 0.19 s, as at a singularity' in fault


def test_stamps_that_fall_back_begin_anew_and_of_equal_ones_the_last_counts(tmp_path: Path) -> None:
    sent: list[Sent] = []
    for k in range(50):
        sent += [joint_state(k, ('flexion', 'abduction'), position=[0.3 + 0.01 * k, 0.2]),
                 joint_state(k, ('rotation',), position=[0.1])]  # fmt: skip
    again = [(topic, kind, time + 10**9, data) for topic, kind, time, data in sent[20:24]]
    source = write_bag(tmp_path / 'in', sent + again)
    report = run_task(Task(source, tmp_path / 'out.csv', Options(rate=100.0)))
    assert (report.frames, dict(report.refused)) == (52, {'incomplete': 1, 'same_time': 51})
    assert report.first['same_time'].startswith('frame 2, stamp 1700000000.01 s: that of a later')
    [line] = report.notes
    assert 'time falls back from 1700000000.49 s to 1700000000.1 s at message 101' in line
    flexion = read_csv(tmp_path / 'out.csv')[2][:, 1]
    wanted = 0.3 + 0.01 * np.array([*range(50), 10, 11])
    np.testing.assert_allclose(flexion, wanted, rtol=0, atol=1e-9)


def test_a_little_lateness_is_no_fall(tmp_path: Path) -> None:
    """Two publishers of different joints: the second stamps 1 us early, and comes later."""
    sent: list[Sent] = []
    for k in range(50):
        topic, kind, time, data = joint_state(k, ('rotation',), position=[0.1])
        message = deserialize_message(data, JointState)
        nanoseconds = T0 + k * 10**7 - 1000
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(nanoseconds, 10**9)
        early = topic, kind, time + 1, bytes(serialize_message(message))
        sent += [joint_state(k, ('flexion', 'abduction'), position=[0.3 + 0.01 * k, 0.2]), early]
    source = write_bag(tmp_path / 'in', sent)
    report = run_task(Task(source, tmp_path / 'out.csv', Options(lowpass=6.0)))
    # the frame that the first message would be is incomplete; the second is then the first
    assert (report.frames, dict(report.refused)) == (50, {'incomplete': 1, 'earlier': 49})


def test_velocities_may_be_differences_in_a_bag_too(tmp_path: Path) -> None:
    sent = [joint_state(k, velocity=[]) for k in range(50)]
    source = write_bag(tmp_path / 'in', sent)
    assert run_task(Task(source, tmp_path / 'out', Options(differentiate=True))).frames == 50
    found = read_messages(tmp_path / 'out')
    assert [each for each in found if each[0] == '/joint_states'] == sent
    told = [
        deserialize_message(data, JointState)
        for topic, _, _, data in found
        if topic == '/deltoid/joint_states'
    ]
    np.testing.assert_allclose([each.velocity[0] for each in told], 1.0, atol=1e-6)  # rad/s
    assert [each.header.stamp.nanosec for each in told] == [10**7 * k for k in range(50)]
    assert T0 % 10**9 == 0


def test_a_bags_count_of_messages_may_be_wrong(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion()[16:])
    metadata = source / 'metadata.yaml'
    text = metadata.read_text()
    metadata.write_text(text.replace('message_count: 64', 'message_count: 1'))
    assert text != metadata.read_text()
    assert run_task(Task(source, tmp_path / 'out', Options(rate=30.0))).fault == ''
    times = [time for _, _, time, _ in read_messages(tmp_path / 'out')]
    assert times == sorted(times)
    assert STORE
