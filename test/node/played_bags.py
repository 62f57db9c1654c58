# SPDX-License-Identifier: Apache-2.0
"""Recordings to be played, and `linkedplane play` in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from unhurried import PATIENCE

START = 1_700_000_000_000_000_000  # ns since the epoch
STEP = 50_000_000  # ns
COUNT = 21
PLUGINS = {'sqlite3': StoragePlugin.SQLITE3, 'mcap': StoragePlugin.MCAP}
TYPES = get_typestore(Stores.ROS2_JAZZY)
Sent = tuple[str, int, bytes]


def joint_states(topic: str = '/joint_states', count: int = COUNT) -> list[Sent]:
    """Return (topic, time, CDR) of joint states of many sizes, none like another."""
    made = []
    for k in range(count):
        names = ['flexion', 'abduction', 'rotation', 'elbow'][: 1 + k % 4]
        message = JointState(name=names, position=[0.01 * k + i for i in range(len(names))])
        message.velocity = [0.1] * len(names) if k % 2 else []
        message.header.frame_id = 'x' * (k % 5)
        message.header.stamp.sec = k
        made.append((topic, START + k * STEP, bytes(serialize_message(message))))
    return made


def notes(count: int = 3) -> list[Sent]:
    """Return (topic, time, CDR) of messages that are not joint states."""
    return [
        ('/notes', START + k * STEP + 1, bytes(serialize_message(String(data=f'note {k}'))))
        for k in range(count)
    ]


def write_bag(
    folder: Path, messages: Sequence[Sent], plugin: str = 'mcap', empty: Sequence[str] = ()
) -> Path:
    """Write a recording; the `empty` topics of joint states have no messages."""
    with Writer(folder, version=9, storage_plugin=PLUGINS[plugin]) as writer:
        kind = 'sensor_msgs/msg/JointState'
        connections = {t: writer.add_connection(t, kind, typestore=TYPES) for t in empty}
        for topic, time, data in messages:
            if topic not in connections:
                kind = 'std_msgs/msg/String' if topic == '/notes' else 'sensor_msgs/msg/JointState'
                connections[topic] = writer.add_connection(topic, kind, typestore=TYPES)
            writer.write(connections[topic], time, data)
    return folder


class Player:
    """`linkedplane play` in a process of its own."""

    def __init__(self, *arguments: object) -> None:
        """Start it; unless told otherwise it waits for its subscriber as long as a test does."""
        command = [sys.executable, '-m', 'linkedplane_ros.commands', 'play', '--wait', PATIENCE]
        command = [str(part) for part in (*command, *arguments)]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def ended(self) -> bool:
        """Whether it has come to its end."""
        return self.process.poll() is not None

    def result(self) -> tuple[int, str, str]:
        """Wait for its end; return its status, what it printed, and its stderr."""
        out, err = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, out, err


def bytes_on(messages: Sequence[Sent], topic: str = '/joint_states') -> list[bytes]:
    """Return the bytes of the messages on a topic."""
    return [message[2] for message in messages if message[0] == topic]
