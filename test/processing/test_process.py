# SPDX-License-Identifier: Apache-2.0
"""Bags processed: what the node would say, beside what was recorded."""

from __future__ import annotations

import math
from array import array
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import (
    EXACT,
    MCAP,
    SQLITE3,
    T0,
    Sent,
    answer_numbers,
    exit_status,
    joint_state,
    node_answers,
    odd_motion,
    read_messages,
    text_note,
    write_bag,
)
from geometry_msgs.msg import Pose
from rclpy.serialization import deserialize_message
from ros_harness import TOPICS
from rosbags.rosbag2 import StoragePlugin
from sensor_msgs.msg import JointState

from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task


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
    sent[8] = joint_state(4, position=[0.1, 90.0, 0.2])
    source = write_bag(tmp_path / 'in', sent, plugin)
    report = run_task(Task(source, tmp_path / 'out', Options(side=side, degrees=False)))
    assert report.fault == ''
    found = read_messages(tmp_path / 'out')
    assert [each for each in found if each[0] in ('/joint_states', '/notes')] == sent
    said = node_answers(sent, side=side, **{'markers.details': False})
    assert said.keys() == TOPICS.keys()
    del said['markers'][0]  # it clears what a viewer may show of before
    assert len(said['markers']) == 10  # every fourth of 40 frames at 100 Hz
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        assert len(ours) == len(answers)
        assert topic == 'markers' or len(ours) == report.frames
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (deserialize_message(each, TOPICS[topic]) for each in (mine, theirs))
            np.testing.assert_allclose(answer_numbers(a), answer_numbers(b), rtol=0, atol=EXACT)
            without_numbers(a)
            without_numbers(b)
            assert a == b
    assert dict(report.refused) == {'not_finite': 1, 'degrees': 1, 'sizes': 1}


def test_a_bag_may_end_with_a_chunk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('linkedplane_ros.recordings.bag_motion.ROWS', 10)
    sent = [joint_state(k) for k in range(20)]
    assert run_task(Task(write_bag(tmp_path / 'in', sent), tmp_path / 'out')).fault == ''
    assert [each for each in read_messages(tmp_path / 'out') if each[0] == '/joint_states'] == sent


def test_each_answer_stands_behind_its_message_and_has_its_time(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    run_task(Task(source, tmp_path / 'out'))
    found = read_messages(tmp_path / 'out')
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
    source = write_bag(tmp_path / 'in', sent, plugin, mode)
    assert run_task(Task(source, tmp_path / 'out')).fault == ''
    found = read_messages(tmp_path / 'out')
    assert [each for each in found if each[0] == '/joint_states'] == sent
    ending = '.mcap' if plugin is MCAP else '.db3'
    assert (tmp_path / 'out' / f'out{ending}').is_file()


def swing(tmp_path: Path, storage: StoragePlugin = MCAP) -> list[Sent]:
    """Return 4 s of a swing with some tremor at 100 Hz, recorded 5 ns late, and notes between."""
    sent = []
    for k in range(401):
        flexion = 0.5 + 0.3 * math.sin(math.pi * 0.01 * k) + 0.05 * math.sin(0.4 * math.pi * k)
        sent += [joint_state(k, position=[flexion, 0.3, 0.1]), text_note(k)]
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
    source = write_bag(tmp_path / 'in', sent, plugin)
    report = run_task(Task(source, tmp_path / 'out', Options(rate=rate, lowpass=6.0)))
    assert (report.fault, report.frames) == ('', 1 + 4 * rate)
    found = read_messages(tmp_path / 'out')
    assert [each for each in found if each[0] in ('/joint_states', '/notes')] == sent
    assert [time for _, _, time, _ in found] == sorted(time for _, _, time, _ in found)
    angles = [each for each in found if each[0] == '/deltoid/joint_states']
    messages = [deserialize_message(data, JointState) for *_, data in angles]
    stamps = [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for each in messages]
    assert stamps == [T0 + round(k * 1e9 / rate) for k in range(report.frames)]
    assert [time for _, _, time, _ in angles] == [stamp + 5 for stamp in stamps]
    again = [('/joint_states', *each[1:]) for each in angles]
    said = node_answers(again, **{'markers.details': False})
    del said['markers'][0]
    for topic, answers in said.items():
        ours = [data for name, _, _, data in found if name == f'/deltoid/{topic}']
        for mine, theirs in zip(ours, answers, strict=True):
            a, b = (answer_numbers(deserialize_message(x, TOPICS[topic])) for x in (mine, theirs))
            np.testing.assert_allclose(a, b, rtol=0, atol=EXACT)


def test_markers_may_be_left_out(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / 'out'), '--no-markers']) == 0
    topics = {topic for topic, *_ in read_messages(tmp_path / 'out')}
    assert '/deltoid/band_lengths' in topics
    assert '/deltoid/markers' not in topics
