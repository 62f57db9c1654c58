"""Recordings processed: what the node would say, beside what was recorded."""

from __future__ import annotations

import csv
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from ros_harness import TOPICS
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.cli import main
from linkedplane_ros.frames import Bones, glenohumeral
from linkedplane_ros.joint_input import JointMap
from linkedplane_ros.motion import BagMotion
from linkedplane_ros.node import MuscleStatePublisher
from linkedplane_ros.process import Task, recordings_in, run, run_all
from linkedplane_ros.serialized import JointStates

NAMES = ('flexion', 'abduction', 'rotation')
BAG = Path(__file__).parent.parent / 'msg_examples' / 'arm_raise'
STORE = get_typestore(Stores.ROS2_JAZZY)
T0 = 1_700_000_000 * 10**9  # ns
MCAP, SQLITE3 = StoragePlugin.MCAP, StoragePlugin.SQLITE3
EXACT = 1e-12  # m
ONE, NONE = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
Sent = tuple[str, str, int, bytes]  # topic, type, time (ns), CDR


def contents(bag: Path) -> list[Sent]:
    """Return all messages of a bag."""
    with AnyReader([bag], default_typestore=STORE) as reader:
        return [(c.topic, c.msgtype, t, bytes(data)) for c, t, data in reader.messages()]


def write(
    bag: Path, sent: Sequence[Sent], plugin: StoragePlugin = MCAP, compress: str = ''
) -> Path:
    """Write a bag."""
    writer = Writer(bag, version=9, storage_plugin=plugin)
    if compress:
        writer.set_compression(CompressionMode[compress], CompressionFormat.ZSTD)
    with writer:
        made: dict[str, Any] = {}
        for topic, kind, time, data in sent:
            if topic not in made:
                made[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(made[topic], time, data)
    return bag


def joint_state(k: int, names: Sequence[str] = NAMES, **fields: Any) -> Sent:
    """Return the k-th joint state of a motion at 100 Hz."""
    fields.setdefault('position', [0.3 + 0.01 * k, 0.2, 0.1][: len(names)])
    message = JointState(name=list(names), **fields)
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(T0 + k * 10**7, 10**9)
    return (
        '/joint_states',
        'sensor_msgs/msg/JointState',
        T0 + k * 10**7 + 5,
        bytes(serialize_message(message)),
    )


def note(k: int) -> Sent:
    """Return a message that has nothing to do with joints."""
    text = STORE.types['std_msgs/msg/String'](data=f'note {k}')
    data = bytes(STORE.serialize_cdr(text, 'std_msgs/msg/String'))
    return '/notes', 'std_msgs/msg/String', T0 + k * 10**7 + 7, data


def odd_motion() -> list[Sent]:
    """Return a motion with all that may be odd about one, and notes between."""
    sent = []
    for k in range(40):
        velocity = [0.1 * k, 0.2, 0.3] if k % 3 else []
        sent.append(joint_state(k, velocity=velocity))
        sent.append(note(k))
    sent[4] = joint_state(2, ('flexion',))
    sent[6] = joint_state(3, position=[0.1, math.nan, 0.2])
    sent[8] = joint_state(4, position=[0.1, 90.0, 0.2])
    sent[10] = joint_state(5, ('elbow',))
    sent[12] = joint_state(6, position=[0.1, 0.2])
    sent[14] = joint_state(7, velocity=[0.1, math.nan, 0.2])
    sent[16] = joint_state(8, ('rotation', 'x', 'flexion'), velocity=[1.0, 2.0, 3.0])
    return sent


class Kept:
    """Keeps what the node publishes on one topic."""

    def __init__(self) -> None:
        self.got: list[bytes] = []

    def get_subscription_count(self) -> int:
        return 0

    def publish(self, message: Any) -> None:
        self.got.append(bytes(serialize_message(message)))


def node_says(sent: Sequence[Sent], **parameters: Any) -> dict[str, list[bytes]]:
    """Return what the node answers to the joint states, topic by topic."""
    from rclpy.parameter import Parameter

    node = MuscleStatePublisher(
        parameter_overrides=[Parameter(name, value=value) for name, value in parameters.items()]
    )
    real, node._outputs = node._outputs, {name: Kept() for name in TOPICS}
    for topic, _, _, data in sent:
        if topic == '/joint_states':
            node._answer(deserialize_message(data, JointState))
    kept, node._outputs = node._outputs, real
    node.destroy_node()
    return {name: each.got for name, each in kept.items() if name != 'markers'}


def numbers(message: Any) -> list[float]:
    """Return the numbers of an answer."""
    if isinstance(message, JointState):
        return [*message.position, *message.velocity]
    return list(message.data)


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
    said = node_says(sent, side=side)
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        assert len(ours) == len(answers) == report.frames
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (deserialize_message(each, TOPICS[topic]) for each in (mine, theirs))
            np.testing.assert_allclose(numbers(a), numbers(b), rtol=0, atol=EXACT)
            if topic == 'band_states':
                assert (a.header, a.name) == (b.header, b.name)
                assert len(a.velocity) == len(b.velocity)
            else:
                assert a.layout == b.layout
    assert dict(report.refused) == {'not_finite': 1, 'degrees': 1, 'no_joint': 1, 'sizes': 1}


def test_a_bag_may_end_with_a_chunk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('linkedplane_ros.motion.ROWS', 10)
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
    assert times[T0 + 5] == ['/joint_states', *answers]
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


def rows(path: Path) -> tuple[dict[str, str], list[str], np.ndarray]:
    """Return the facts, the names of the columns and the numbers of a CSV output."""
    lines = path.read_text().splitlines()
    facts = dict(line[2:].split(': ', 1) for line in lines if line.startswith('#'))
    table = list(csv.reader(line for line in lines if not line.startswith('#')))
    values = [[float(cell) if cell else math.nan for cell in row] for row in table[1:]]
    return facts, table[0], np.array(values)


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
    monkeypatch.setattr('linkedplane_ros.motion.ROWS', size)
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
    said = node_says(found, joint_convention='opensim_tsm')
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (numbers(deserialize_message(x, TOPICS[topic])) for x in (mine, theirs))
            np.testing.assert_allclose(a, b, rtol=0, atol=EXACT)


# From frames to angles


def pose(k: int, topic: str, R: np.ndarray, kind: str = 'PoseStamped') -> Sent:
    """Return a pose on a topic."""
    types = STORE.types
    x, y, z, w = Rotation.from_matrix(R).as_quat().tolist()
    turn = types['geometry_msgs/msg/Quaternion'](x, y, z, w)
    stamp = types['builtin_interfaces/msg/Time'](*divmod(T0 + k * 10**7, 10**9))
    header = types['std_msgs/msg/Header'](stamp=stamp, frame_id='lab')
    if kind == 'PoseStamped':
        place = types['geometry_msgs/msg/Point'](0.1, 0.2, 0.3)
        message = types['geometry_msgs/msg/PoseStamped'](
            header, types['geometry_msgs/msg/Pose'](place, turn)
        )
    else:
        message = transform(k, 'lab', topic, R)
    full = f'geometry_msgs/msg/{kind}'
    return topic, full, T0 + k * 10**7, bytes(STORE.serialize_cdr(message, full))


def transform(k: int, parent: str, child: str, R: np.ndarray) -> Any:
    """Return a TransformStamped."""
    types = STORE.types
    x, y, z, w = Rotation.from_matrix(R).as_quat().tolist()
    stamp = types['builtin_interfaces/msg/Time'](*divmod(T0 + k * 10**7, 10**9))
    return types['geometry_msgs/msg/TransformStamped'](
        types['std_msgs/msg/Header'](stamp=stamp, frame_id=parent),
        child,
        types['geometry_msgs/msg/Transform'](
            types['geometry_msgs/msg/Vector3'](0.0, 0.0, 0.0),
            types['geometry_msgs/msg/Quaternion'](x, y, z, w),
        ),
    )


ANGLES = np.array([(0.5, 0.3 + 0.02 * k, 0.2) for k in range(30)])  # rad, isb_yxy
ISB = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def lab(k: int) -> np.ndarray:
    """Return where the base is turned to in the laboratory at frame k."""
    return Rotation.from_rotvec((0.3, 0.02 * k, -0.5)).as_matrix()


@pytest.mark.parametrize('kind', ['PoseStamped', 'TransformStamped'])
@pytest.mark.parametrize('axes', ['model', 'isb'])
def test_two_poses_give_the_angles_between_them(tmp_path: Path, kind: str, axes: str) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    frame = ISB if axes == 'isb' else np.eye(3)
    sent = []
    for k, angles in enumerate(ANGLES):
        R = frame.T @ convention.rotation(angles) @ frame
        sent += [pose(k, '/scapula', lab(k), kind), pose(k, '/humerus', lab(k) @ R, kind)]
    source = write(tmp_path / 'in', sent)
    bones = Bones('/humerus', '/scapula', axes=axes)
    report = run(Task(source, tmp_path / 'out.csv', convention='isb_yxy', bones=bones))
    assert (report.fault, report.frames) == ('', 30)
    facts, _, values = rows(tmp_path / 'out.csv')
    np.testing.assert_allclose(values[:, 1:4], ANGLES, rtol=0, atol=1e-9)
    assert facts['scapulohumeral_rhythm'] == 'none: measured against the scapula'


def test_a_left_arms_poses_give_the_same_anatomical_angles(tmp_path: Path) -> None:
    convention, mirror = JOINT_CONVENTIONS['isb_yxy'], np.diag((-1.0, 1.0, 1.0))
    sent = []
    for k, angles in enumerate(ANGLES):
        left = mirror @ convention.rotation(angles) @ mirror
        sent += [pose(k, '/humerus', lab(k) @ left), pose(k, '/scapula', lab(k))]
    source = write(tmp_path / 'in', sent)
    bones = Bones('/humerus', '/scapula')
    task = Task(source, tmp_path / 'out.csv', convention='isb_yxy', bones=bones, side='left')
    assert run(task).frames == 30
    np.testing.assert_allclose(rows(tmp_path / 'out.csv')[2][:, 1:4], ANGLES, rtol=0, atol=1e-9)


def test_poses_on_topics_count_together_only_at_one_stamp(tmp_path: Path) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = [pose(k, '/humerus', lab(k) @ convention.rotation(ANGLES[k])) for k in range(30)]
    sent += [pose(k, '/scapula', lab(k)) for k in range(0, 30, 3)]
    sent.sort(key=lambda each: each[2])
    source = write(tmp_path / 'in', sent)
    task = Task(source, tmp_path / 'out.csv', convention='isb_yxy',
                bones=Bones('/humerus', '/scapula'))  # fmt: skip
    assert run(task).frames == 10
    np.testing.assert_allclose(
        rows(tmp_path / 'out.csv')[2][:, 1:4], ANGLES[::3], rtol=0, atol=1e-9
    )


def test_frames_of_tf_are_found_by_their_names(tmp_path: Path) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = []
    for k, angles in enumerate(ANGLES):
        R, elbow = convention.rotation(angles), np.eye(3)
        tree = [
            transform(k, 'torso', 'humerus', lab(k) @ R),
            transform(k, 'humerus', 'ulna', elbow),
            transform(k, 'map', 'torso', lab(7)),
            transform(k, 'torso', 'scapula', lab(k)),
        ]
        message = STORE.types['tf2_msgs/msg/TFMessage'](tree)
        data = bytes(STORE.serialize_cdr(message, 'tf2_msgs/msg/TFMessage'))
        sent.append(('/tf', 'tf2_msgs/msg/TFMessage', T0 + k * 10**7, data))
    source = write(tmp_path / 'in', sent)
    task = Task(
        source, tmp_path / 'out.csv', convention='isb_yxy', bones=Bones('humerus', 'scapula')
    )
    assert run(task).frames == 30
    np.testing.assert_allclose(rows(tmp_path / 'out.csv')[2][:, 1:4], ANGLES, rtol=0, atol=1e-9)


def test_against_the_thorax_the_scapula_takes_its_share_and_the_output_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = []
    for k, angles in enumerate(ANGLES):
        R = lab(k) @ convention.rotation(angles)
        sent += [pose(k, '/thorax', lab(k)), pose(k, '/humerus', R)]
    source = write(tmp_path / 'in', sent)
    command = ['process', str(source), str(tmp_path / 'out.csv'), '--convention', 'isb_yxy']
    command += ['--humerus', '/humerus', '--thorax', '/thorax']
    assert main(command) == 0
    assert 'the scapula takes 1 part of an elevation to 2' in capsys.readouterr().out
    facts, _, values = rows(tmp_path / 'out.csv')
    np.testing.assert_allclose(values[:, 1:4], ANGLES * (1.0, 2.0 / 3.0, 1.0), rtol=0, atol=1e-9)
    assert facts['scapulohumeral_rhythm'] == '2 to 1'
    assert main([*command, '--rhythm', '1', '--force']) == 0
    np.testing.assert_allclose(
        rows(tmp_path / 'out.csv')[2][:, 2], ANGLES[:, 1] / 2.0, rtol=0, atol=1e-9
    )


def test_the_rhythm_leaves_plane_and_axial_rotation_alone() -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    found = convention.angles(glenohumeral(convention.rotation((0.4, 1.5, -0.3)), 2.0))
    np.testing.assert_allclose(found, (0.4, 1.0, -0.3), atol=EXACT)


# Resampled and filtered


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


# Faults


def refused(capsys: pytest.CaptureFixture[str], *command: str) -> str:
    """Return the one line on stderr of a command that ends with 1."""
    status = exit_status(command)
    error = capsys.readouterr().err
    assert status == 1, error
    assert error.count('\n') == 1
    return error


def exit_status(command: Sequence[str]) -> int:
    """Return the exit status of the command line."""
    try:
        return main(['process', *command])
    except SystemExit as end:
        return int(end.code or 0)


def test_an_output_that_exists_is_left_alone_without_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / 'out.csv'
    out.write_text('precious')
    assert '--force' in refused(capsys, str(BAG), str(out))
    assert out.read_text() == 'precious'
    assert exit_status([str(BAG), str(out), '--force']) == 0
    assert out.read_text() != 'precious'


def truncated(tmp_path: Path) -> Path:
    """Return a bag whose file ends early."""
    bag = write(tmp_path / 'short', [joint_state(k) for k in range(4000)])
    data = (bag / 'short.mcap').read_bytes()
    (bag / 'short.mcap').write_bytes(data[: len(data) // 2])
    return bag


def faulty(tmp_path: Path) -> dict[str, tuple[Path, str]]:
    """Return inputs that are no good, and a word of the line that says why."""
    (tmp_path / 'empty.csv').touch()
    (tmp_path / 'columns.csv').write_text('time,flex,abduction,rotation\n0,0.1,0.2,0.3\n')
    (tmp_path / 'cell.csv').write_text('time,flexion,abduction,rotation\n0,0.1,x,0.3\n')
    (tmp_path / 'all_bad.csv').write_text('time,flexion,abduction,rotation\n0,90,20,30\n')
    return {
        'truncated bag': (truncated(tmp_path), 'short'),
        'no joint states': (write(tmp_path / 'notes', [note(k) for k in range(3)]), 'std_msgs'),
        'empty file': (tmp_path / 'empty.csv', 'empty.csv'),
        'missing column': (tmp_path / 'columns.csv', 'no column for flexion (near: flex)'),
        'no number': (tmp_path / 'cell.csv', 'cell.csv:2'),
        'nothing usable': (tmp_path / 'all_bad.csv', 'degrees?'),
        'missing file': (tmp_path / 'nowhere.mot', 'nowhere.mot'),
    }


@pytest.mark.parametrize('kind', ['csv', 'parquet', 'bag'])
def test_a_faulty_input_is_one_line_and_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    (tmp_path / 'out').mkdir()
    for source, word in faulty(tmp_path).values():
        line = refused(capsys, str(source), str(tmp_path / 'out' / 'x'), '--format', kind)
        assert word in line
        assert str(source) in line
        assert list((tmp_path / 'out').iterdir()) == []


def test_the_other_recordings_are_still_done(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / 'lab'
    folder.mkdir()
    for _, (source, _) in faulty(tmp_path).items():
        if source.exists():
            shutil.move(source, folder / source.name)
    good = write(folder / 'good', [joint_state(k) for k in range(9)])
    assert exit_status([str(folder), str(tmp_path / 'out'), '--format', 'csv']) == 1
    told = capsys.readouterr()
    assert sorted(each.name for each in (tmp_path / 'out').iterdir()) == ['good.csv']
    assert told.err.count('\n') == len(list(folder.iterdir())) - 1
    assert f'{good} -> ' in told.out
    assert '1 of 7 recordings processed' in told.out


def test_refused_frames_are_counted_with_their_first_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'out.csv')]) == 0
    told = capsys.readouterr().out
    assert '36 frames' in told
    assert '4 refused' in told
    assert "1 refused as degrees, first at message 5, 0.04 s: joint 'abduction' is 90" in told


def test_frames_outside_the_models_range_are_counted(tmp_path: Path) -> None:
    inside, outside = (0.5, 0.4, 0.2), (-1.0, 0.2, 0.1)
    lines = ['time,flexion,abduction,rotation']
    lines += [f'{k},{",".join(map(str, outside if k < 3 else inside))}' for k in range(10)]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    assert run(Task(tmp_path / 'in.csv', tmp_path / 'out.csv')).outside == 3


def test_a_full_disk_is_one_line(tmp_path: Path) -> None:
    resource = pytest.importorskip('resource')
    code = (
        'import resource, signal, sys; from linkedplane_ros.cli import main\n'
        'signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n'
        'resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n'
        f'sys.exit(main(["process", {str(BAG)!r}, {str(tmp_path / "out.csv")!r}]))'
    )
    assert resource
    ended = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, env=None)
    assert ended.returncode == 1
    assert ended.stderr.count('\n') == 1
    assert 'out.csv: not written: File too large' in ended.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_recording_is_not_its_own_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('time,flexion,abduction,rotation\n0,0.1,0.2,0.3\n')
    before = source.read_bytes()
    assert 'its own output' in refused(capsys, str(source), str(source), '--force')
    assert source.read_bytes() == before


def test_a_folder_that_is_no_bag_is_not_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'arm_raise').mkdir()
    (tmp_path / 'arm_raise' / 'thesis.txt').write_text('precious')
    line = refused(capsys, str(BAG), str(BAG.parent), str(tmp_path), '--force')
    assert 'a folder; only a bag is replaced' in line
    assert (tmp_path / 'arm_raise' / 'thesis.txt').read_text() == 'precious'


@pytest.mark.parametrize('kind', ['csv', 'bag'])
def test_force_does_not_replace_the_folder_that_the_source_lies_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    bag = write(tmp_path / 'rec', odd_motion())
    inner = bag / 'rec.mcap'
    before = inner.read_bytes()
    refused(capsys, str(inner), str(bag), '--force', '--format', kind)
    refused(capsys, str(BAG), str(bag), '--force', '--format', 'csv')
    assert inner.read_bytes() == before


def test_a_bag_is_replaced_by_a_bag_with_force(tmp_path: Path) -> None:
    source = write(tmp_path / 'in', odd_motion())
    target = write(tmp_path / 'old', [note(0)])
    assert exit_status([str(source), str(target), '--force']) == 0
    assert {topic for topic, *_ in contents(target)} >= {'/joint_states', '/deltoid/band_states'}


def test_a_bags_file_alone_becomes_an_annotated_bag(tmp_path: Path) -> None:
    sent = odd_motion()
    source = write(tmp_path / 'in', sent) / 'in.mcap'
    assert run(Task(source, tmp_path / 'out')).fault == ''
    found = contents(tmp_path / 'out')
    assert [each for each in found if each[0] in ('/joint_states', '/notes')] == sent


def test_times_before_zero_keep_their_values(tmp_path: Path) -> None:
    lines = ['time,flexion,abduction,rotation', *(f'{t},0.1,0.2,0.3' for t in (-1.5, -0.4, 0.25))]
    (tmp_path / 'in.csv').write_text('\n'.join(lines) + '\n')
    run(Task(tmp_path / 'in.csv', tmp_path / 'out.csv'))
    assert rows(tmp_path / 'out.csv')[2][:, 0].tolist() == [-1.5, -0.4, 0.25]


def test_times_that_cannot_be_seconds_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / 'in.csv'
    source.write_text('timestamp,flexion,abduction,rotation\n1700000000000,0.1,0.2,0.3\n')
    assert 'ms?' in refused(capsys, str(source), str(tmp_path / 'out.csv'))


@pytest.mark.parametrize(
    ('options', 'word'),
    [
        (('--joints', 'flexion', 'flexion', 'rotation'), '3 different joints'),
        (('--offsets', 'nan', '0', '0'), 'finite numbers expected'),
        (('--rate', '1e13'), 'in: '),
        (('--humerus', '', '--thorax', 'b'), 'a name expected'),
        (('--humerus', '/h', '--scapula', '/s'), '/h is neither a topic'),
        (('--rhythm', '2'), '--thorax'),
        (('--topic', '/other'), 'on /other'),
    ],
)
def test_odd_options_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], word: str
) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert word in refused(capsys, str(source), str(tmp_path / 'out.csv'), *options)


def test_patterns_are_matched_where_the_shell_has_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for k in range(3):
        write(tmp_path / f'walk_{k}', odd_motion())
    command = [str(tmp_path / 'walk_*'), str(tmp_path / 'out'), '--format', 'csv']
    assert exit_status(command) == 0
    assert '3 of 3 recordings' in capsys.readouterr().out
    assert 'run_*: nothing matches' in refused(capsys, str(tmp_path / 'run_*'), 'out')


def test_folders_with_a_dot_in_their_names_keep_them(tmp_path: Path) -> None:
    sources = [write(tmp_path / f'walk.0{k}', odd_motion()) for k in (1, 2)]
    assert exit_status([*map(str, sources), str(tmp_path / 'out')]) == 0
    assert sorted(each.name for each in (tmp_path / 'out').iterdir()) == ['walk.01', 'walk.02']


def test_a_worker_that_dies_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('linkedplane_ros.process.BroadMuscle.load', lambda name: os._exit(3))
    made = [Task(BAG, tmp_path / f'{k}.csv') for k in range(2)]
    reports = list(run_all(made, 2, None, lambda frames: None))
    assert all('not processed: BrokenProcessPool' in report.fault for report in reports)


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
    assert [len(chunk.records) for chunk in motion.chunks()] == [0]


def test_a_bag_is_not_processed_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'once')]) == 0
    assert 'in it already' in refused(capsys, str(tmp_path / 'once'), str(tmp_path / 'twice'))


# Many


def test_the_results_do_not_depend_on_how_many_work_at_a_time(tmp_path: Path) -> None:
    sources = [write(tmp_path / f'in{k}', odd_motion()[: 20 + 2 * k]) for k in range(4)]
    for jobs in (1, 2):
        (tmp_path / str(jobs)).mkdir()
        made = [Task(s, tmp_path / str(jobs) / f'{s.name}.csv') for s in sources]
        reports = list(run_all(made, jobs, None, lambda frames: None))
        assert all(not report.fault for report in reports)
    for s in sources:
        one, two = (tmp_path / str(jobs) / f'{s.name}.csv' for jobs in (1, 2))
        assert one.read_bytes() == two.read_bytes()


def test_a_folder_holds_bags_and_tables_in_the_order_of_their_names(tmp_path: Path) -> None:
    write(tmp_path / 'b', [joint_state(0)])
    for name in ('c.mot', 'a.sto', 'notes.txt', 'd.CSV'):
        (tmp_path / name).touch()
    assert [each.name for each in recordings_in(tmp_path)] == ['a.sto', 'b', 'c.mot', 'd.CSV']


def test_a_cluster_gives_what_one_process_gives(tmp_path: Path) -> None:
    distributed = pytest.importorskip('dask.distributed')
    sources = [write(tmp_path / f'in{k}', odd_motion()[: 20 + 2 * k]) for k in range(3)]
    for place in ('here', 'there'):
        (tmp_path / place).mkdir()
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        for place, address in (('here', None), ('there', cluster.scheduler_address)):
            made = [Task(s, tmp_path / place / f'{s.name}.csv') for s in sources]
            reports = list(run_all(made, 1, address, lambda frames: None))
            assert [report.fault for report in reports] == [''] * 3
    for s in sources:
        here, there = (tmp_path / place / f'{s.name}.csv' for place in ('here', 'there'))
        assert here.read_bytes() == there.read_bytes()


def test_a_cluster_that_is_not_there_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip('dask.distributed')
    source = write(tmp_path / 'in', odd_motion())
    line = refused(capsys, str(source), str(tmp_path / 'x'), '--dask', 'tcp://127.0.0.1:9')
    assert '--dask tcp://127.0.0.1:9: not reached' in line


MEMORY = """
import resource, sys
from pathlib import Path
from linkedplane_ros.process import Task, run
seen, held = [0], []
def progress(frames):
    seen[0] += frames
    held.append((seen[0], resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))
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


# Plots


@pytest.mark.parametrize('name', ['out', 'out.csv', 'out.parquet'])
def test_every_kind_of_output_is_plotted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / name), '--side', 'left']) == 0
    capsys.readouterr()
    assert main(['plot', str(tmp_path / name), '--svg']) == 0
    files = capsys.readouterr().out.split()
    against = [f'out_against_{coordinate}.svg' for coordinate in NAMES]
    assert [Path(each).name for each in files] == ['out_over_time.svg', *against]
    assert 'left' in Path(files[0]).read_text()


def test_what_is_no_output_is_not_plotted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'other.csv').write_text('time,a\n0,1\n')
    bag = write(tmp_path / 'in', odd_motion())
    for path in (tmp_path / 'other.csv', bag, tmp_path / 'nowhere.csv'):
        assert main(['plot', str(path)]) == 1
        error = capsys.readouterr().err
        assert str(path) in error
        assert error.count('\n') == 1
