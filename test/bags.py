# SPDX-License-Identifier: Apache-2.0
"""Bags and tables to be processed, and what comes of them."""

from __future__ import annotations

import csv
import math
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
from sensor_msgs.msg import JointState
from visualization_msgs.msg import MarkerArray

from linkedplane_ros.commands.main import main
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

NAMES = ('flexion', 'abduction', 'rotation')
BAG = Path(__file__).parent.parent / 'msg_examples' / 'arm_raise'
STORE = get_typestore(Stores.ROS2_JAZZY)
T0 = 1_700_000_000 * 10**9  # ns
MCAP, SQLITE3 = StoragePlugin.MCAP, StoragePlugin.SQLITE3
EXACT = 1e-12  # m
ONE, NONE = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
Sent = tuple[str, str, int, bytes]  # topic, type, time (ns), CDR


def read_messages(bag: Path) -> list[Sent]:
    """Return all messages of a bag."""
    with AnyReader([bag], default_typestore=STORE) as reader:
        return [(c.topic, c.msgtype, t, bytes(data)) for c, t, data in reader.messages()]


def write_bag(
    bag: Path,
    sent: Sequence[Sent],
    plugin: StoragePlugin = MCAP,
    compress: str = '',
    empty: Sequence[str] = (),
) -> Path:
    """Write a bag; the `empty` topics of joint states have no messages."""
    writer = Writer(bag, version=9, storage_plugin=plugin)
    if compress:
        writer.set_compression(CompressionMode[compress], CompressionFormat.ZSTD)
    with writer:
        made: dict[str, Any] = {
            topic: writer.add_connection(topic, 'sensor_msgs/msg/JointState', typestore=STORE)
            for topic in empty
        }
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


def text_note(k: int) -> Sent:
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
        sent.append(text_note(k))
    sent[4] = joint_state(2, ('flexion',))
    sent[6] = joint_state(3, position=[0.1, math.nan, 0.2])
    sent[10] = joint_state(5, ('elbow',))
    sent[12] = joint_state(6, position=[0.1, 0.2])
    sent[14] = joint_state(7, velocity=[0.1, math.nan, 0.2])
    sent[16] = joint_state(8, ('rotation', 'x', 'flexion'), velocity=[1.0, 2.0, 3.0])
    return sent


def read_csv(path: Path) -> tuple[dict[str, str], list[str], np.ndarray]:
    """Return the facts, the names of the columns and the numbers of a CSV output."""
    lines = path.read_text().splitlines()
    facts = dict(line[2:].split(': ', 1) for line in lines if line.startswith('#'))
    table = list(csv.reader(line for line in lines if not line.startswith('#')))
    values = [[float(cell) if cell else math.nan for cell in row] for row in table[1:]]
    return facts, table[0], np.array(values)


def refusal_line(capsys: pytest.CaptureFixture[str], *command: str) -> str:
    """Return the one line on stderr of a command that ends with 1."""
    status = exit_status(command)
    error = capsys.readouterr().err
    assert status == 1, error
    assert error.count('\n') == 1
    return error


def exit_status(command: Sequence[str]) -> int:
    """Return the exit status of the command line."""
    return main(['process', *command])


def count_frames(source: Path, target: Path) -> int:
    """Process a recording into a table; return its rows."""
    assert exit_status([str(source), str(target), '--force']) == 0
    return len(read_csv(target)[2])


class Kept:
    """Keeps what the node publishes on one topic, as if somebody listened."""

    def __init__(self) -> None:
        self.got: list[bytes] = []

    def get_subscription_count(self) -> int:
        return 1

    def publish(self, message: Any) -> None:
        self.got.append(bytes(serialize_message(message)))


def node_answers(sent: Sequence[Sent], **parameters: Any) -> dict[str, list[bytes]]:
    """Return what the node answers to the joint states, topic by topic."""
    from rclpy.parameter import Parameter

    node = MuscleStatePublisher(
        parameter_overrides=[Parameter(name, value=value) for name, value in parameters.items()]
    )
    [muscle] = node._muscles
    real, muscle.topics = muscle.topics, {name: Kept() for name in TOPICS}
    for topic, _, _, data in sent:
        if topic == '/joint_states':
            node._answer(deserialize_message(data, JointState))
    kept, muscle.topics = muscle.topics, real
    node.destroy_node()
    return {name: each.got for name, each in kept.items()}


def answer_numbers(message: Any) -> list[float]:
    """Return the numbers of an answer."""
    if isinstance(message, JointState):
        return [*message.position, *message.velocity]
    if isinstance(message, MarkerArray):
        places = [(*(m.pose.position,), *m.points, *(m.pose.orientation,)) for m in message.markers]
        return [x for each in places for p in each for x in (p.x, p.y, p.z)]
    return list(message.data)
