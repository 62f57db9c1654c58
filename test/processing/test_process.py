"""Recordings processed: what the node would say, beside what was recorded."""

from __future__ import annotations

import math
import subprocess
import sys
from array import array
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import (
    EXACT,
    MCAP,
    NAMES,
    NONE,
    ONE,
    SQLITE3,
    STORE,
    T0,
    Sent,
    contents,
    exit_status,
    joint_state,
    node_says,
    note,
    numbers,
    odd_motion,
    rows,
    write,
)
from geometry_msgs.msg import Pose
from rclpy.serialization import deserialize_message
from ros_harness import TOPICS
from rosbags.rosbag2 import StoragePlugin
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.joints.joint_state import JointMap
from linkedplane_ros.processing.cdr import JointStates
from linkedplane_ros.processing.task import Task, run
from linkedplane_ros.recordings.bag_motion import BagMotion


def without_numbers(message: Any) -> None:
    """Take the numbers that may differ in the last bit out of a message."""
    for each in getattr(message, 'markers', ()):
        each.pose, each.points = Pose(), []
    for name in ('data', 'position', 'velocity'):
        if hasattr(message, name):
            old = getattr(message, name)
            setattr(message, name, array(old.typecode, bytes(len(old) * old.itemsize)))


@pytest.mark.parametrize('plugin', [MCAP, SQLITE3])
@pytest.mark.parametrize('side', ['right', 'left'])
def test_a_processed_bag_holds_what_the_node_says_message_by_message(
    ros: None, tmp_path: Path, plugin: StoragePlugin, side: str
) -> None:
    sent = odd_motion()
    source = write(tmp_path / 'in', sent, plugin)
    report = run(Task(source, tmp_path / 'out', side=side))
    assert report.fault == ''
    found = contents(tmp_path / 'out')
    assert [each for each in found if each[0] in ('/joint_states', '/notes')] == sent
    said = node_says(sent, side=side, **{'markers.details': False})
    assert said.keys() == TOPICS.keys()
    del said['markers'][0]  # it clears what a viewer may show of before
    assert len(said['markers']) == 10  # every fourth of 40 frames at 100 Hz
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        assert len(ours) == len(answers)
        assert topic == 'markers' or len(ours) == report.frames
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (deserialize_message(each, TOPICS[topic]) for each in (mine, theirs))
            np.testing.assert_allclose(numbers(a), numbers(b), rtol=0, atol=EXACT)
            without_numbers(a)
            without_numbers(b)
            assert a == b
    assert dict(report.refused) == {'not_finite': 1, 'degrees': 1, 'no_joint': 1, 'sizes': 1}


def test_a_bag_may_end_with_a_chunk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('linkedplane_ros.recordings.bag_motion.ROWS', 10)
    sent = [joint_state(k) for k in range(20)]
    assert run(Task(write(tmp_path / 'in', sent), tmp_path / 'out')).fault == ''
    assert [each for each in contents(tmp_path / 'out') if each[0] == '/joint_states'] == sent


def test_each_answer_stands_behind_its_message_and_has_its_time(tmp_path: Path) -> None:
    source = write(tmp_path / 'in', odd_motion())
    run(Task(source, tmp_path / 'out'))
    found = contents(tmp_path / 'out')
    times: dict[int, list[str]] = {}
    for topic, _, time, _ in found:
        times.setdefault(time, []).append(topic)
    answers = [f'/deltoid/{topic}' for topic in TOPICS if topic != 'markers']
    assert times[T0 + 5] == ['/joint_states', *answers, '/deltoid/markers']
    assert times[T0 + 10**7 + 5] == ['/joint_states', *answers]
    assert times[T0 + 3 * 10**7 + 5] == ['/joint_states']  # refused
    assert times[T0 + 7] == ['/notes']


@pytest.mark.parametrize('plugin', [MCAP, SQLITE3])
@pytest.mark.parametrize('mode', ['', 'MESSAGE', 'FILE', 'STORAGE'])
def test_compressed_bags_are_read_and_their_storage_is_kept(
    tmp_path: Path, plugin: StoragePlugin, mode: str
) -> None:
    if mode == ('FILE' if plugin is MCAP else 'STORAGE'):
        pytest.skip('the library does not write such a bag')
    sent = [joint_state(k) for k in range(5)]
    source = write(tmp_path / 'in', sent, plugin, mode)
    assert run(Task(source, tmp_path / 'out')).fault == ''
    found = contents(tmp_path / 'out')
    assert [each for each in found if each[0] == '/joint_states'] == sent
    ending = '.mcap' if plugin is MCAP else '.db3'
    assert (tmp_path / 'out' / f'out{ending}').is_file()


def test_a_motion_file_a_table_and_a_bag_of_one_motion_agree(shared: Path, tmp_path: Path) -> None:
    folder = shared / 'recordings'
    made = {}
    for name in ('abduction.mot', 'abduction.csv', 'abduction_mcap'):
        report = run(Task(folder / name, tmp_path / f'{name}.csv', convention='opensim_tsm'))
        assert (report.fault, report.frames) == ('', 1091)
        made[name] = rows(tmp_path / f'{name}.csv')
    _, names, mot = made['abduction.mot']
    solver, convention = (
        LinkedPlaneSolver(BroadMuscle.load('deltoid')),
        JOINT_CONVENTIONS['opensim_tsm'],
    )
    for values in (mot, made['abduction.csv'][2]):
        state = solver.solve(convention.rotation(values[500, 1:4]))
        np.testing.assert_allclose(values[500, 5:14], state.lengths, rtol=0, atol=EXACT)
    # rad and deg with eight decimals: a few micrometres at most
    for other in ('abduction.csv', 'abduction_mcap'):
        assert made[other][1] == names
        np.testing.assert_allclose(made[other][2][:, 1:14], mot[:, 1:14], rtol=0, atol=1e-6)
    assert made['abduction.mot'][0]['velocities'] == 'differentiated'
    assert made['abduction_mcap'][0]['velocities'].startswith('recorded')
    assert np.isnan(made['abduction_mcap'][2][:, names.index('lengthening/middle_1')]).all()


def test_lengthening_from_a_table_is_the_slope_of_the_length(tmp_path: Path) -> None:
    times = 0.01 * np.arange(201)
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{t!r},{0.5 + 0.4 * math.sin(2 * t)!r},0.3,0.1' for t in times.tolist()]
    (tmp_path / 'sine.csv').write_text('\n'.join(lines) + '\n')
    run(Task(tmp_path / 'sine.csv', tmp_path / 'out.csv'))
    _, names, values = rows(tmp_path / 'out.csv')
    length, speed = (values[:, names.index(f'{kind}/anterior_2')]
                     for kind in ('band_lengths', 'lengthening'))  # fmt: skip
    # m/s: both are differences over 10 ms of a motion of 2 rad/s
    np.testing.assert_allclose(speed[1:-1], np.gradient(length, times)[1:-1], rtol=0, atol=2e-5)


@pytest.mark.parametrize('size', [1, 2, 7, 1000])
def test_the_size_of_a_chunk_does_not_show(
    tmp_path: Path, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = write(tmp_path / 'in', odd_motion())
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{0.01 * k},{0.1 * math.sin(k)},0.3,{"nan" if k == 20 else 0.1}' for k in range(50)]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    whole = [run(Task(source, tmp_path / f'whole{k}.csv'))
             for k, source in enumerate((bag, tmp_path / 'in.csv'))]  # fmt: skip
    for module in ('bag_motion', 'table_motion'):
        monkeypatch.setattr(f'linkedplane_ros.recordings.{module}.ROWS', size)
    for k, report in enumerate(whole):
        again = run(Task(report.task.source, tmp_path / f'part{k}.csv'))
        assert again.refused == report.refused
        part, all_at_once = (rows(tmp_path / f'{name}{k}.csv')[2] for name in ('part', 'whole'))
        # differences in time and products of matrices round otherwise in other company
        np.testing.assert_allclose(part, all_at_once, rtol=1e-12, atol=1e-15)


def test_parquet_holds_the_numbers_of_csv(tmp_path: Path) -> None:
    parquet = pytest.importorskip('pyarrow.parquet')
    source = write(tmp_path / 'in', odd_motion())
    for name in ('out.csv', 'out.parquet'):
        assert run(Task(source, tmp_path / name)).fault == ''
    facts, names, values = rows(tmp_path / 'out.csv')
    table = parquet.read_table(tmp_path / 'out.parquet')
    assert table.column_names == ['stamp', *names]
    for i, name in enumerate(names):
        found = table[name].to_numpy(zero_copy_only=False)
        np.testing.assert_allclose(found, values[:, i], rtol=1e-15, atol=0)  # time: its last bit
    metadata = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    assert facts.items() <= metadata.items()
    assert table['stamp'][0].value == T0


def test_a_motion_file_becomes_a_bag_that_the_node_would_answer_alike(
    ros: None, shared: Path, tmp_path: Path
) -> None:
    task = Task(shared / 'recordings' / 'flexion.mot', tmp_path / 'out', convention='opensim_tsm')
    assert run(task).fault == ''
    found = contents(tmp_path / 'out')
    said = node_says(found, joint_convention='opensim_tsm', **{'markers.details': False})
    del said['markers'][0]
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        assert len(ours) == len(answers)
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (numbers(deserialize_message(x, TOPICS[topic])) for x in (mine, theirs))
            np.testing.assert_allclose(a, b, rtol=0, atol=EXACT)


def test_a_filter_and_a_rate_are_carried_out_and_recorded(tmp_path: Path) -> None:
    times = 0.01 * np.arange(401)
    noisy = 0.5 + 0.3 * np.sin(2 * np.pi * 0.5 * times) + 0.05 * np.sin(2 * np.pi * 20 * times)
    lines = ['time,flexion,abduction,rotation', *(f'{t!r},{q!r},0.3,0.1'
             for t, q in zip(times.tolist(), noisy.tolist(), strict=True))]  # fmt: skip
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    task = Task(tmp_path / 'in.csv', tmp_path / 'out.csv', rate=50.0, lowpass=6.0)
    assert run(task).frames == 201
    facts, _, values = rows(tmp_path / 'out.csv')
    assert (facts['resampled_to_hz'], facts['velocities']) == ('50', 'differentiated')
    assert facts['lowpass_hz'].startswith('6 ')
    np.testing.assert_allclose(np.diff(values[:, 0]), 0.02, atol=1e-9)
    middle = slice(20, -20)
    want = 0.5 + 0.3 * np.sin(2 * np.pi * 0.5 * values[:, 0])
    np.testing.assert_allclose(values[middle, 1], want[middle], rtol=0, atol=2e-3)  # rad


MEMORY = """
import resource, sys
from pathlib import Path
from linkedplane_ros.processing.task import Task, run
held = []
def progress(frames, share):
    held.append((frames, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))
report = run(Task(Path(sys.argv[1]), Path(sys.argv[2])), progress)
assert not report.fault, report.fault
print(held[-1][0], held[-1][1] - next(mib for count, mib in held if count >= 10_000))
"""


@pytest.mark.parametrize('ending', ['', '.csv', '.parquet'])
def test_memory_does_not_grow_with_the_recording(tmp_path: Path, ending: str) -> None:
    pytest.importorskip('resource')
    names = list(NAMES)
    stamps = T0 + np.arange(30_000) * 10**7
    angles = np.tile((0.5, 0.4, 0.2), (len(stamps), 1))
    messages = JointStates(STORE, names, '').filled(stamps, angles, angles)
    kind = 'sensor_msgs/msg/JointState'
    source = write(
        tmp_path / 'in',
        [('/joint_states', kind, t, m) for t, m in zip(stamps.tolist(), messages, strict=True)],
    )
    command = [sys.executable, '-c', MEMORY, str(source), str(tmp_path / f'out{ending}')]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    frames, growth = ended.stdout.split()
    assert int(frames) == 30_000
    assert float(growth) < 6.0  # MiB: the answers to the rest are 12


def swing(tmp_path: Path, storage: StoragePlugin = MCAP) -> list[Sent]:
    """Return 4 s of a swing with some tremor at 100 Hz, recorded 5 ns late, and notes between."""
    sent = []
    for k in range(401):
        flexion = 0.5 + 0.3 * math.sin(math.pi * 0.01 * k) + 0.05 * math.sin(0.4 * math.pi * k)
        sent += [joint_state(k, position=[flexion, 0.3, 0.1]), note(k)]
    return sent


@pytest.mark.parametrize('plugin', [MCAP, SQLITE3])
@pytest.mark.parametrize('rate', [25.0, 250.0])
@pytest.mark.parametrize('size', [7, 5000])
def test_a_filtered_bag_keeps_its_messages_and_has_its_new_angles_beside_them(
    ros: None,
    tmp_path: Path,
    plugin: StoragePlugin,
    rate: float,
    size: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in ('bag_motion', 'smoothing'):
        monkeypatch.setattr(f'linkedplane_ros.recordings.{module}.ROWS', size)
    sent = swing(tmp_path)
    source = write(tmp_path / 'in', sent, plugin)
    report = run(Task(source, tmp_path / 'out', rate=rate, lowpass=6.0))
    assert (report.fault, report.frames) == ('', 1 + 4 * rate)
    found = contents(tmp_path / 'out')
    assert [each for each in found if each[0] in ('/joint_states', '/notes')] == sent
    assert [time for _, _, time, _ in found] == sorted(time for _, _, time, _ in found)
    angles = [each for each in found if each[0] == '/deltoid/joint_states']
    messages = [deserialize_message(data, JointState) for *_, data in angles]
    stamps = [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for each in messages]
    assert stamps == [T0 + round(k * 1e9 / rate) for k in range(report.frames)]
    assert [time for _, _, time, _ in angles] == [stamp + 5 for stamp in stamps]
    again = [('/joint_states', *each[1:]) for each in angles]
    said = node_says(again, **{'markers.details': False})
    del said['markers'][0]
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (numbers(deserialize_message(x, TOPICS[topic])) for x in (mine, theirs))
            np.testing.assert_allclose(a, b, rtol=0, atol=EXACT)


def test_the_output_says_what_was_read_and_how(shared: Path, tmp_path: Path) -> None:
    motions = shared / 'recordings'
    tsm = {'convention': 'opensim_tsm'}
    bag = write(tmp_path / 'in', odd_motion())
    for task, said in (
        (Task(motions / 'flexion.mot', tmp_path / 'a.csv', **tsm),
         {'read_in': 'deg: inDegrees in the file', 'columns': 'plane_elv, shoulder_elv, axial_rot',
          'velocities': 'differentiated'}),
        (Task(motions / 'flexion.csv', tmp_path / 'b.csv', **tsm),
         {'read_in': 'rad: the names of the columns',
          'columns': 'plane_elv_rad, shoulder_elv_rad, axial_rot_rad'}),
        (Task(bag, tmp_path / 'c.csv'),
         {'topic': '/joint_states', 'velocities': 'recorded, where the recording has them',
          'angles_topic': ''}),
        (Task(bag, tmp_path / 'd.csv', rate=50.0),
         {'velocities': 'differentiated', 'angles_topic': '/deltoid/joint_states'}),
    ):  # fmt: skip
        report = run(task)
        assert report.fault == ''
        facts, _, _ = rows(task.target)
        assert said.items() <= facts.items()


def test_markers_may_be_left_out(tmp_path: Path) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'out'), '--no-markers']) == 0
    topics = {topic for topic, *_ in contents(tmp_path / 'out')}
    assert '/deltoid/band_lengths' in topics
    assert '/deltoid/markers' not in topics


def test_large_messages_do_not_fill_the_memory(tmp_path: Path) -> None:
    blob = STORE.types['std_msgs/msg/UInt8MultiArray'](
        STORE.types['std_msgs/msg/MultiArrayLayout']([], 0), np.zeros(500_000, np.uint8)
    )
    kind = 'std_msgs/msg/UInt8MultiArray'
    data = bytes(STORE.serialize_cdr(blob, kind))
    sent: list[Sent] = []
    for k in range(300):
        sent += [joint_state(k), ('/camera', kind, T0 + k * 10**7 + 8, data)]
    motion = BagMotion.of_joints(write(tmp_path / 'in', sent), JointMap(NAMES, ONE, NONE), None)
    held = [sum(len(each[2]) for each in chunk.records) for chunk in motion.chunks()]
    assert len(held) > 5
    assert max(held) < 2**24 + len(data)
    motion.keeps_records = False
    assert not any(chunk.records for chunk in motion.chunks())
