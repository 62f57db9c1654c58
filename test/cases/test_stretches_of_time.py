# SPDX-License-Identifier: Apache-2.0
"""Time that falls back, stands still, or was not filled in; and the place of a fault in a bag.

The right velocities are np.gradient's, on each stretch by itself; a lengthening is checked by the
slope of the length itself.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import STORE, T0, Sent, joint_state, read_csv, read_messages, write_bag
from scipy.signal import butter, sosfiltfilt

from linkedplane_ros.joints.joint_state import JointMap
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Report, Task, run_task
from linkedplane_ros.recordings import bag_motion, table_motion
from linkedplane_ros.recordings.stamps import find_unstamped
from linkedplane_ros.recordings.stretches import differentiate_stretches


def process(source: Path, out: Path, **options: object) -> tuple[Report, dict[str, np.ndarray]]:
    report = run_task(Task(source, out, Options(**options)))
    assert report.fault == ''
    _, names, values = read_csv(out)
    return report, dict(zip(names, values.T, strict=True))


def write_table(path: Path, times: list[float], turn: np.ndarray) -> Path:
    lines = [f'{t!r},{q!r},0.3,0.1' for t, q in zip(times, turn.tolist(), strict=True)]
    path.write_text('\n'.join(['time,flexion,abduction,rotation', *lines]) + '\n')
    return path


def with_stamp(sent: Sent, nanoseconds: int) -> Sent:
    """Return a joint state with another stamp, written into its bytes."""
    topic, kind, time, data = sent
    stamp = struct.pack('<iI', *divmod(nanoseconds, 10**9))
    return topic, kind, time, data[:4] + stamp + data[12:]


def test_case_time_backwards(cases: Path, tmp_path: Path) -> None:
    """Said; and no difference across: both sides as at an end (np.gradient of each half)."""
    report, columns = process(cases / 'time_backwards' / 'a.csv', tmp_path / 'o.csv')
    assert report.frames == 10
    [line] = report.notes
    assert 'time falls back from 0.04 s to 0 s at row 6' in line
    lengths, speeds = (columns[f'{kind}/anterior_1'] for kind in ('band_lengths', 'lengthening'))
    for half in (slice(0, 5), slice(5, 10)):
        slope = np.gradient(lengths[half], columns['time'][half])
        np.testing.assert_allclose(speeds[half], slope, rtol=0.03)  # of first order at the ends


def test_case_table_equal_times(cases: Path, tmp_path: Path) -> None:
    source = cases / 'table_equal_times' / 'a.csv'
    report, columns = process(source, tmp_path / 'a.csv')
    assert report.frames == 4
    assert report.notes == ('warning: time stands still at 0.01 s in row 3: no velocity there',)
    assert np.isnan(columns['lengthening/anterior_1']).tolist() == [False, True, True, False]
    report, _ = process(source, tmp_path / 'b.csv', differentiate=True)
    assert (report.frames, dict(report.refused)) == (3, {'same_time': 1})
    assert 'frame 2' in report.first['same_time']


def test_case_bag_zero_stamps(cases: Path, tmp_path: Path) -> None:
    for name, options in (('a.csv', {}), ('b.csv', {'differentiate': True})):
        report, columns = process(cases / 'bag_zero_stamps' / 'bag', tmp_path / name, **options)
        assert report.frames == 10
        np.testing.assert_allclose(np.diff(columns['time']), 0.01, atol=1e-6)
        [line] = report.notes
        assert 'without a stamp (0)' in line
        assert '(10 in all)' in line
    assert 'recorded times' in read_csv(tmp_path / 'a.csv')[0]['stamps']
    assert np.isfinite(columns['lengthening/anterior_1']).all()


def test_case_tf_place_of_fault(cases: Path, tmp_path: Path) -> None:
    frames = {'humerus': 'hum', 'scapula': 'scap', 'convention': 'isb_yxy'}
    report, _ = process(cases / 'tf_place_of_fault' / 'bag', tmp_path / 'o.csv', **frames)
    assert report.first['not_unit'].startswith('message 4, 0.02 s: quaternion (0, 0, 0, 0)')


def test_case_bag_no_names_first(cases: Path, tmp_path: Path) -> None:
    report, _ = process(cases / 'bag_no_names_first' / 'bag', tmp_path / 'o.csv')
    assert dict(report.refused) == {'no_joint': 1}
    assert report.first['no_joint'].startswith('message 1, 0.00 s')


@pytest.mark.parametrize('rows', [2, 3, 5, 5000])
def test_falls_at_any_place_of_a_chunk(
    tmp_path: Path, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table_motion, 'ROWS', rows)
    times = [0.0, 0.1, 0.3, 0.0, 0.1, 0.05, 0.2, 0.3, 0.1]
    turn = np.array([0.1, 0.2, 0.5, 0.9, 0.3, 0.4, 0.1, 0.2, 0.7])
    source = write_table(tmp_path / 'a.csv', times, turn)
    motion = table_motion.TableMotion(source, JOINTS, None)
    chunks = list(motion.chunks())
    speeds = np.concatenate([chunk.speeds[:, 0] for chunk in chunks])
    wanted = np.full(9, np.nan)  # the last row is a stretch by itself
    for part in (slice(0, 3), slice(3, 5), slice(5, 8)):
        wanted[part] = np.gradient(turn[part], np.array(times)[part])
    np.testing.assert_allclose(speeds, wanted, rtol=1e-12)
    [line] = motion.refused.warn()
    assert line.startswith('warning: time falls back from 0.3 s to 0 s at row 4')
    assert line.endswith('(3 in all)')
    recorded = np.concatenate([chunk.times for chunk in chunks])
    assert (np.diff(recorded) >= 0).all()  # a player goes by these: no stretch mixes with another


def test_a_filter_and_a_rate_begin_anew_after_a_fall(tmp_path: Path) -> None:
    once = 0.01 * np.arange(60)
    turn = np.concatenate((0.3 + 0.2 * np.sin(9.0 * once), 0.7 - 0.4 * once))
    source = write_table(tmp_path / 'a.csv', [*once.tolist(), *once.tolist()], turn)
    report, columns = process(source, tmp_path / 'o.csv', lowpass=6.0)
    assert (report.frames, dict(report.refused)) == (120, {})
    sections = butter(2, 6.0, fs=100.0, output='sos')
    halves = [sosfiltfilt(sections, half, padlen=9) for half in np.split(turn, 2)]
    np.testing.assert_allclose(columns['angles/flexion'], np.concatenate(halves), atol=1e-9)
    report, columns = process(source, tmp_path / 'p.csv', rate=50.0)
    assert report.frames == 60
    np.testing.assert_allclose(columns['time'], np.tile(once[::2], 2), atol=2e-9)


def test_a_short_stretch_after_a_fall_is_counted(tmp_path: Path) -> None:
    times = (0.01 * np.array([*range(60), *range(5)])).tolist()
    source = write_table(tmp_path / 'a.csv', times, np.linspace(0.1, 0.6, 65))
    report, _ = process(source, tmp_path / 'o.csv', lowpass=6.0)
    assert (report.frames, dict(report.refused)) == (60, {'too_short': 5})


def test_a_late_frame_is_no_fall_of_the_time(tmp_path: Path) -> None:
    times = [0.0, 0.01, 0.02, 0.03, 0.027, 0.04, 0.05, 0.06]
    turn = np.array([0.1, 0.12, 0.15, 0.19, 0.5, 0.24, 0.3, 0.37])
    source = write_table(tmp_path / 'in.csv', times, turn)
    report, columns = process(source, tmp_path / 'out.csv', differentiate=True)
    assert dict(report.refused) == {'earlier': 1}
    assert not any('falls back' in note for note in report.notes)
    on_time = [0, 1, 2, 3, 5, 6, 7]
    speeds = np.gradient(turn[on_time], np.array(times)[on_time])  # of the others: they go across
    arm = columns['moment_arms/middle_1/flexion']
    np.testing.assert_allclose(columns['lengthening/middle_1'], -arm * speeds, rtol=0, atol=1e-9)


def test_a_player_that_starts_again_keeps_the_recorded_times(tmp_path: Path) -> None:
    rounds = [joint_state(k % 20) for k in range(40)]
    sent = [(topic, kind, T0 + k * 10**7, data) for k, (topic, kind, _, data) in enumerate(rounds)]
    report = run_task(Task(write_bag(tmp_path / 'in', sent), tmp_path / 'out', Options(rate=50.0)))
    assert (report.fault, report.frames) == ('', 20)
    assert 'at message 21' in report.notes[0]
    found = read_messages(tmp_path / 'out')
    assert [each for each in found if each[0] == '/joint_states'] == sent
    angles = [time for topic, _, time, _ in found if topic == '/deltoid/joint_states']
    assert angles == sorted(angles)
    assert angles[-1] <= sent[-1][2]


def test_a_single_row_is_at_rest_and_one_between_two_falls_is_not_known() -> None:
    angles = np.zeros((3, 3))
    assert not differentiate_stretches(np.zeros(1), angles[:1]).any()
    assert np.isnan(differentiate_stretches(np.array([3.0, 2.0, 1.0]), angles)).all()
    assert np.isnan(differentiate_stretches(np.zeros(3), angles)).all()  # one time throughout


def test_a_clock_that_begins_at_0_is_left_as_it_is(tmp_path: Path) -> None:
    sent = [with_stamp(joint_state(k), k * 10**7) for k in range(20)]
    sent += [with_stamp(joint_state(20 + k), k * 10**7) for k in range(20)]  # and is reset
    report, columns = process(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv')
    np.testing.assert_allclose(columns['time'], np.tile(0.01 * np.arange(20), 2), atol=1e-9)
    assert len(report.notes) == 1  # the fall


@pytest.mark.parametrize('rows', [1, 4, 5000])
def test_some_stamps_that_are_missing_take_the_recorded_times(
    tmp_path: Path, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bag_motion, 'ROWS', rows)
    sent = [joint_state(k) for k in range(12)]
    for k in (0, 3, 4, 11):
        sent[k] = with_stamp(sent[k], 0)
    report, columns = process(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv')
    assert '(4 in all)' in report.notes[0]
    np.testing.assert_allclose(columns['time'], 1e-9 * T0 + 0.01 * np.arange(12), atol=1e-6)
    assert find_unstamped([0, 5, 0, 0], 10**9 + 1) == [2, 3]
    assert find_unstamped([0, 5, 0, 0], 1) == []


JOINTS = JointMap(('flexion', 'abduction', 'rotation'), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
SIMULATED = 5 * 10**9  # ns: where a simulation's clock stands when the recorder is started


def simulated(count: int, zeros: Sequence[int], begin: int = SIMULATED) -> list[Sent]:
    """Return joint states with the stamps of a simulation, 0 for some of them."""
    sent = []
    for k in range(count):
        topic, kind, _, data = with_stamp(joint_state(k), 0 if k in zeros else begin + k * 10**7)
        sent.append((topic, kind, 1717 * 10**15 + k * 10**7, data))
    return sent


@pytest.mark.parametrize('rows', [1, 3, 5000])
@pytest.mark.parametrize(
    'zeros', [(4, 5), (0, 1, 2, 3), (11,), (0, 5, 6, 11)], ids=['middle', 'first', 'last', 'some']
)
@pytest.mark.parametrize('differentiate', [False, True])
def test_missing_stamps_are_on_the_clock_of_the_others(
    tmp_path: Path,
    rows: int,
    zeros: tuple[int, ...],
    differentiate: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(bag_motion, 'ROWS', rows)
    bag = write_bag(tmp_path / 'in', simulated(12, zeros))
    report = run_task(Task(bag, tmp_path / 'o.csv', Options(differentiate=differentiate)))
    assert (report.fault, report.frames, dict(report.refused)) == ('', 12, {})
    lines = (tmp_path / 'o.csv').read_text().splitlines()[-12:]
    assert [line.split(',')[0] for line in lines] == [f'5.{k:02d}0000000' for k in range(12)]
    [line] = report.notes
    assert line.startswith('warning: a header without a stamp (0), ')
    said = ': the recorded time counts, shifted by -1716999995 s to the clock of the other stamps'
    count = f' ({len(zeros)} in all)' if len(zeros) > 1 else ''
    assert line.endswith(said + count)


def test_missing_transforms_are_on_the_clock_of_the_others(tmp_path: Path) -> None:
    stamps = [0 if k in (0, 7, 8) else SIMULATED + k * 10**7 for k in range(20)]
    sent = [transforms(k, stamp) for k, stamp in enumerate(stamps)]
    frames = {'humerus': 'hum', 'scapula': 'scap'}
    report, columns = process(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv', **frames)
    assert (report.frames, dict(report.refused)) == (20, {})
    np.testing.assert_allclose(columns['time'], 5.0 + 0.01 * np.arange(20), atol=1e-9)
    assert '(3 in all)' in report.notes[0]


def test_a_clock_a_little_beside_the_recorded_one_shifts_nothing(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / 'in', simulated(12, (4, 5), 1717 * 10**15 - 10**9))
    report = run_task(Task(bag, tmp_path / 'o.csv', Options()))
    lines = (tmp_path / 'o.csv').read_text().splitlines()[-12:]
    assert lines[4].split(',')[0] == '1717000000.040000000'
    assert 'shifted' not in report.notes[0]


@pytest.mark.parametrize('options', [{'differentiate': True}, {'rate': 100.0}])
def test_stamps_keep_their_nanoseconds_however_far_the_clock_jumps(
    tmp_path: Path, options: dict[str, Any]
) -> None:
    stamps = [begin + k * 10**7 for begin in (SIMULATED, 1717 * 10**15 + 40) for k in range(6)]
    sent = [with_stamp(joint_state(k), stamp) for k, stamp in enumerate(stamps)]
    report = run_task(
        Task(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv', Options(**options))
    )
    assert (report.fault, report.frames) == ('', 12)
    lines = (tmp_path / 'o.csv').read_text().splitlines()[-12:]
    assert [line.split(',')[0].replace('.', '') for line in lines] == list(map(str, stamps))


def pose(k: int, topic: str, w: float = 1.0) -> Sent:
    types = STORE.types
    stamp = types['builtin_interfaces/msg/Time'](*divmod(T0 + k * 10**7, 10**9))
    message = types['geometry_msgs/msg/PoseStamped'](
        types['std_msgs/msg/Header'](stamp, 'lab'),
        types['geometry_msgs/msg/Pose'](
            types['geometry_msgs/msg/Point'](0.0, 0.0, 0.0),
            types['geometry_msgs/msg/Quaternion'](0.0, 0.6 * w, 0.0, 0.8 * w),
        ),
    )
    kind = 'geometry_msgs/msg/PoseStamped'
    return topic, kind, T0 + k * 10**7, bytes(STORE.serialize_cdr(message, kind))


@pytest.mark.parametrize('w', [0.0, float('nan')])
def test_of_two_bodies_the_faulty_one_has_the_place(tmp_path: Path, w: float) -> None:
    sent = []
    for k in range(6):
        sent += [pose(k, '/scap', w if k == 2 else 1.0), pose(k, '/hum')]
    frames = {'humerus': '/hum', 'scapula': '/scap', 'convention': 'flexion_abduction_rotation'}
    report, _ = process(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv', **frames)
    assert report.frames == 5
    assert report.first['not_unit'].startswith('message 5, 0.02 s: quaternion')


def test_messages_of_other_joints_are_not_refused(tmp_path: Path) -> None:
    sent = []
    for k in range(10):
        sent += [joint_state(k), joint_state(k, ('finger', 'thumb'))]
    report, _ = process(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv')
    assert (report.frames, dict(report.refused)) == (10, {})
    assert report.notes[0].startswith('10 messages of other joints passed over, first at message 2')
    alone = write_bag(tmp_path / 'alone', [joint_state(k, ('finger',)) for k in range(3)])
    fault = run_task(Task(alone, tmp_path / 'p.csv', Options())).fault
    assert 'nothing was usable: message 1, 0.00 s: none of the joints' in fault


def transforms(k: int, stamp: int) -> Sent:
    """Return a message of /tf that moves the humerus."""
    types, kind = STORE.types, 'tf2_msgs/msg/TFMessage'
    header = types['std_msgs/msg/Header'](
        types['builtin_interfaces/msg/Time'](*divmod(stamp, 10**9)), 'lab'
    )
    half = 0.1 + k / 99
    turns = {'scap': (0.0, 0.0, 0.0, 1.0), 'hum': (0.0, -np.sin(half), 0.0, np.cos(half))}
    nowhere = types['geometry_msgs/msg/Vector3'](0.0, 0.0, 0.0)
    each = [
        types['geometry_msgs/msg/TransformStamped'](
            header,
            name,
            types['geometry_msgs/msg/Transform'](
                nowhere, types['geometry_msgs/msg/Quaternion'](*turn)
            ),
        )
        for name, turn in turns.items()
    ]
    data = bytes(STORE.serialize_cdr(types[kind](each), kind))
    return '/tf', kind, T0 + k * 10**7, data


@pytest.mark.parametrize(
    ('stamps', 'note'),
    [
        ([0] * 20, 'without a stamp (0)'),
        ([T0 + (k % 10) * 10**7 for k in range(20)], 'at message 11'),
    ],
)
def test_transforms_without_stamps_or_played_again_lose_no_frame(
    tmp_path: Path, stamps: list[int], note: str
) -> None:
    sent = [transforms(k, stamp) for k, stamp in enumerate(stamps)]
    frames = {'humerus': 'hum', 'scapula': 'scap'}
    report, columns = process(write_bag(tmp_path / 'in', sent), tmp_path / 'o.csv', **frames)
    assert (report.frames, dict(report.refused)) == (20, {})
    assert note in report.notes[0]
    abduction = 2.0 * (0.1 + np.arange(20) / 99)
    np.testing.assert_allclose(columns['angles/abduction'], abduction, atol=1e-9)
