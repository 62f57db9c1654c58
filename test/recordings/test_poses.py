# SPDX-License-Identifier: Apache-2.0
"""From the poses of bones to angles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import STORE, T0, Sent, read_csv, read_messages, write_bag
from rclpy.serialization import deserialize_message
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS
from linkedplane_ros.commands.main import main
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task


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
ON_TOPICS = Options(convention='isb_yxy', humerus='/humerus', scapula='/scapula')
IN_TREE = Options(convention='isb_yxy', humerus='humerus', scapula='scapula')


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
    source = write_bag(tmp_path / 'in', sent)
    options = replace(ON_TOPICS, frame_axes=axes)
    report = run_task(Task(source, tmp_path / 'out.csv', options))
    assert (report.fault, report.frames) == ('', 30)
    facts, _, values = read_csv(tmp_path / 'out.csv')
    np.testing.assert_allclose(values[:, 1:4], ANGLES, rtol=0, atol=1e-9)
    assert facts['scapulohumeral_rhythm'] == 'none: measured against the scapula'


def test_a_left_arms_poses_give_the_same_anatomical_angles(tmp_path: Path) -> None:
    convention, mirror = JOINT_CONVENTIONS['isb_yxy'], np.diag((-1.0, 1.0, 1.0))
    sent = []
    for k, angles in enumerate(ANGLES):
        left = mirror @ convention.rotation(angles) @ mirror
        sent += [pose(k, '/humerus', lab(k) @ left), pose(k, '/scapula', lab(k))]
    source = write_bag(tmp_path / 'in', sent)
    task = Task(source, tmp_path / 'out.csv', replace(ON_TOPICS, side='left'))
    assert run_task(task).frames == 30
    np.testing.assert_allclose(read_csv(tmp_path / 'out.csv')[2][:, 1:4], ANGLES, rtol=0, atol=1e-9)


def test_poses_on_topics_count_together_only_at_one_stamp(tmp_path: Path) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = [pose(k, '/humerus', lab(k) @ convention.rotation(ANGLES[k])) for k in range(30)]
    sent += [pose(k, '/scapula', lab(k)) for k in range(0, 30, 3)]
    sent.sort(key=lambda each: each[2])
    source = write_bag(tmp_path / 'in', sent)
    task = Task(source, tmp_path / 'out.csv', ON_TOPICS)
    assert run_task(task).frames == 10
    np.testing.assert_allclose(
        read_csv(tmp_path / 'out.csv')[2][:, 1:4], ANGLES[::3], rtol=0, atol=1e-9
    )


def test_frames_of_tf_are_found_by_their_names(tmp_path: Path) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = []
    for k, angles in enumerate(ANGLES):
        R, elbow = convention.rotation(angles), np.eye(3)
        sent.append(
            tree(
                k,
                ('torso', 'humerus', lab(k) @ R),
                ('humerus', 'ulna', elbow),
                ('map', 'torso', lab(7)),
                ('torso', 'scapula', lab(k)),
            )
        )
    source = write_bag(tmp_path / 'in', sent)
    task = Task(source, tmp_path / 'out.csv', IN_TREE)
    assert run_task(task).frames == 30
    np.testing.assert_allclose(read_csv(tmp_path / 'out.csv')[2][:, 1:4], ANGLES, rtol=0, atol=1e-9)


def tree(k: int, *hung: tuple[str, str, np.ndarray]) -> Sent:
    """Return the frames of a moment: parent, child and the turn between them."""
    message = STORE.types['tf2_msgs/msg/TFMessage']([transform(k, *each) for each in hung])
    data = bytes(STORE.serialize_cdr(message, 'tf2_msgs/msg/TFMessage'))
    return '/tf', 'tf2_msgs/msg/TFMessage', T0 + k * 10**7, data


@pytest.mark.parametrize(
    ('humerus', 'line'),
    [
        (
            'humerrus',
            "no pose of humerrus; frames met: 'humerus', 'lab', 'map', 'scapula'",
        ),
        (
            'humerus',
            "humerus is given in 'lab', scapula in 'map'; poses in one frame expected",
        ),
    ],
)
def test_frames_that_do_not_hang_together_are_named(
    tmp_path: Path, humerus: str, line: str
) -> None:
    sent = [tree(k, ('lab', 'humerus', lab(k)), ('map', 'scapula', lab(k))) for k in range(3)]
    source = write_bag(tmp_path / 'in', sent)
    report = run_task(Task(source, tmp_path / 'out', replace(IN_TREE, humerus=humerus)))
    assert report.fault == f'{source}: nothing was usable: {line}'


def test_poses_that_never_come_at_one_stamp_are_named(tmp_path: Path) -> None:
    sent = [pose(2 * k, '/humerus', lab(k)) for k in range(3)]
    sent += [pose(2 * k + 1, '/scapula', lab(k)) for k in range(3)]
    source = write_bag(tmp_path / 'in', sent)
    report = run_task(Task(source, tmp_path / 'out', ON_TOPICS))
    assert 'poses of /humerus or /scapula without the other at their stamp' in report.fault


def test_a_topic_may_lag_behind_the_other(tmp_path: Path) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    scapula = [pose(k, '/scapula', lab(k)) for k in range(30)]
    humerus = [
        pose(k, '/humerus', lab(k) @ convention.rotation(angles)) for k, angles in enumerate(ANGLES)
    ]
    late = [(topic, kind, time + 11 * 10**6, data) for topic, kind, time, data in humerus]
    del late[20]
    sent = sorted([*scapula, *late], key=lambda each: each[2])
    source = write_bag(tmp_path / 'in', sent)
    report = run_task(Task(source, tmp_path / 'out.csv', ON_TOPICS))
    assert (report.frames, dict(report.refused)) == (29, {'alone': 1})
    want = np.delete(ANGLES, 20, axis=0)
    np.testing.assert_allclose(read_csv(tmp_path / 'out.csv')[2][:, 1:4], want, rtol=0, atol=1e-9)


@pytest.mark.parametrize('slash', ['', '/'])
def test_frames_of_one_stamp_may_come_in_several_messages_among_bad_ones(
    tmp_path: Path, slash: str
) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = []
    for k, angles in enumerate(ANGLES):
        broken = tree(k, ('lab', 'camera', lab(k)))
        sent.append((*broken[:3], broken[3][:-32] + bytes(32)))  # no quaternion
        sent.append(tree(k, ('lab', 'humerus', lab(k) @ convention.rotation(angles))))
        sent.append(tree(k, ('lab', 'scapula', lab(k))))
    source = write_bag(tmp_path / 'in', sent)
    options = replace(IN_TREE, humerus=f'{slash}humerus', scapula=f'{slash}scapula')
    report = run_task(Task(source, tmp_path / 'out.csv', options))
    assert (report.fault, report.frames, dict(report.refused)) == ('', 30, {})
    np.testing.assert_allclose(read_csv(tmp_path / 'out.csv')[2][:, 1:4], ANGLES, rtol=0, atol=1e-9)


def test_a_bag_of_poses_gets_the_angles_and_can_be_plotted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = []
    for k, angles in enumerate(ANGLES):
        sent += [pose(k, '/scapula', lab(k))]
        sent += [pose(k, '/humerus', lab(k) @ convention.rotation(angles))]
    source = write_bag(tmp_path / 'in', sent)
    assert run_task(Task(source, tmp_path / 'out', ON_TOPICS)).frames == 30
    found = read_messages(tmp_path / 'out')
    assert [each for each in found if not each[0].startswith('/deltoid/')] == sent
    told = [
        deserialize_message(data, JointState)
        for topic, _, _, data in found
        if topic == '/deltoid/joint_states'
    ]
    assert list(told[0].name) == list(convention.coordinates)
    assert len(told[0].velocity) == 0
    np.testing.assert_allclose([each.position for each in told], ANGLES, rtol=0, atol=1e-9)
    assert main(['plot', str(tmp_path / 'out'), '--svg']) == 0
    assert 'out_over_time.svg' in capsys.readouterr().out


def test_against_the_thorax_the_scapula_takes_its_share_and_the_output_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = []
    for k, angles in enumerate(ANGLES):
        R = lab(k) @ convention.rotation(angles)
        sent += [pose(k, '/thorax', lab(k)), pose(k, '/humerus', R)]
    source = write_bag(tmp_path / 'in', sent)
    command = ['process', str(source), str(tmp_path / 'out.csv'), '--convention', 'isb_yxy']
    command += ['--humerus', '/humerus', '--thorax', '/thorax']
    assert main(command) == 0
    assert 'follows the humerus by constant_ratio 2 to 1' in capsys.readouterr().out
    facts, _, values = read_csv(tmp_path / 'out.csv')
    np.testing.assert_allclose(values[:, 1:4], ANGLES * (1.0, 2.0 / 3.0, 1.0), rtol=0, atol=1e-9)
    assert facts['scapulohumeral_rhythm'] == 'constant_ratio 2 to 1'
    assert main([*command, '--rhythm', '1', '--force']) == 0
    np.testing.assert_allclose(
        read_csv(tmp_path / 'out.csv')[2][:, 2], ANGLES[:, 1] / 2.0, rtol=0, atol=1e-9
    )


def test_a_published_rhythm_starts_from_the_rest_that_is_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    sent = []
    for k, angles in enumerate(ANGLES):
        sent += [pose(k, '/thorax', np.eye(3)), pose(k, '/humerus', convention.rotation(angles))]
    source = write_bag(tmp_path / 'in', sent)
    command = ['process', str(source), str(tmp_path / 'out.csv'), '--humerus', '/humerus']
    command += ['--thorax', '/thorax', '--rhythm', 'de_groot_brand_2001']
    assert main([*command, '--rest', '0.5', '0.1', '-0.2', '0.3', '0.2']) == 0
    facts, _, values = read_csv(tmp_path / 'out.csv')
    assert facts['scapulohumeral_rhythm'] == 'de_groot_brand_2001'
    assert facts['scapula_at_rest'] == '0.5 0.1 -0.2 0.3 0.2 rad'
    for row, (plane, elevation, axial) in zip(values, ANGLES, strict=True):
        # de Groot and Brand's slopes, in the model's axes: z up, -y back, x lateral
        p, e = plane - 0.3, elevation - 0.2
        slopes = np.array(((0.14, -0.049), (-0.079, 0.396), (-0.028, 0.184)))
        turns = (0.5, 0.1, -0.2) + slopes @ (p, e)
        S = Rotation.from_euler('ZYX', np.multiply(turns, (1, -1, 1)))
        H = Rotation.from_euler('ZYZ', (plane, -elevation, axial))
        flexion, minus_abduction, rotation = (S.inv() * H).as_euler('XYZ')
        found = flexion, -minus_abduction, rotation
        np.testing.assert_allclose(row[1:4], found, rtol=0, atol=1e-9)
    line = 'linkedplane: --rest: 4 numbers given; 3 expected'
    assert main([*command, '--rest', '1', '1', '1', '1', '--force']) == 1
    assert line in capsys.readouterr().err


@pytest.mark.parametrize('side', ['right', 'left'])
def test_the_rest_is_taken_from_the_first_still_second(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], side: str
) -> None:
    convention, mirror = JOINT_CONVENTIONS['isb_yxy'], np.diag((-1.0, 1.0, 1.0))
    angles = [(0.5, 0.3 + 0.02 * k, 0.2) for k in range(60)]
    angles += [(0.4, 0.25, 0.2)] * 101 + angles
    sent = []
    for k, each in enumerate(angles):
        R = convention.rotation(each)
        R = mirror @ R @ mirror if side == 'left' else R
        sent += [pose(k, '/thorax', lab(k)), pose(k, '/humerus', lab(k) @ R)]
    source = write_bag(tmp_path / 'in', sent)
    command = ['process', str(source), str(tmp_path / 'out.csv'), '--humerus', '/humerus']
    command += ['--thorax', '/thorax', '--rhythm', 'mobl', '--side', side]
    given = ['0.559332', '0.186211', '-0.180122', '0.4', '0.25']  # an average subject's scapula
    assert main([*command, '--rest', 'still']) == 0
    facts, _, values = read_csv(tmp_path / 'out.csv')
    assert facts['scapula_at_rest'] == ' '.join(given) + ' rad'
    assert main([*command, '--rest', *given[:3], 'still', '--force']) == 0
    np.testing.assert_array_equal(values, read_csv(tmp_path / 'out.csv')[2])
    assert main([*command, '--rest', *given, '--force']) == 0
    np.testing.assert_allclose(values, read_csv(tmp_path / 'out.csv')[2], rtol=0, atol=1e-6)


def test_without_a_still_second_the_line_says_what_to_give_instead(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = []
    for k, angles in enumerate(ANGLES):
        R = JOINT_CONVENTIONS['isb_yxy'].rotation(angles)
        sent += [pose(k, '/thorax', np.eye(3)), pose(k, '/humerus', R)]
    source = write_bag(tmp_path / 'in', sent)
    command = ['process', str(source), str(tmp_path / 'out.csv'), '--humerus', '/humerus']
    command += ['--thorax', '/thorax', '--rhythm', 'mobl']
    assert main([*command, '--rest', 'still']) == 1
    line = capsys.readouterr().err
    assert line.startswith(f'linkedplane: {source}: --rest still: the arm has not hung still')
    assert line.endswith(
        'give --rest PROTRACTION LATERAL TILT PLANE ELEVATION, rad, or leave it out\n'
    )
    assert not (tmp_path / 'out.csv').exists()
    wrong = 'stil', 'still 0.1 0.2', '0.1 0.2 nan', 'still still', '0 0 0 0 0 still', '0 0 still'
    for words in map(str.split, wrong):
        assert main([*command, '--rest', *words]) in (1, 2)
        assert 'rest' in capsys.readouterr().err
