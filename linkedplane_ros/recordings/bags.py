# SPDX-License-Identifier: Apache-2.0
"""JointStates out of ROS 2 recordings (rosbag2: sqlite3 and mcap), by the rosbags library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from ..errors import RecordingError
from ..libraries import advise_install

JOINT_STATE = 'sensor_msgs/msg/JointState'
DEFAULT_TOPIC = '/joint_states'


@dataclass(frozen=True)
class RecordedMessage:
    """One recorded message, in the bytes of the recording."""

    topic: str
    time: int
    """When it was recorded, ns since the epoch."""
    data: bytes
    """CDR."""


@dataclass(frozen=True)
class Recording:
    """A rosbag2 recording that holds JointStates; its messages stay on disk until asked for."""

    path: Path
    topics: tuple[str, ...]
    """The topics of its JointStates, without those that have none."""
    start: int
    """The time of its first message of any kind, ns since the epoch."""
    end: int
    """The time of its last message of any kind, ns since the epoch."""
    count: int
    """How many JointStates it holds."""

    @staticmethod
    def from_bag(path: str | Path) -> Recording:
        """Return what a bag holds.

        Parameters
        ----------
        path
            The bag's folder, or an .mcap or .db3 file.

        Raises
        ------
        RecordingError
            If it cannot be read, or holds no JointState.
        """
        path = Path(path)
        with closing(open_bag(path)) as reader:
            chosen = [c for c in reader.connections if c.msgtype == JOINT_STATE]
            count = sum(c.msgcount for c in chosen)
            if not count:
                kinds = ', '.join(sorted({c.msgtype for c in reader.connections})) or 'nothing'
                raise RecordingError(f'{path}: no {JOINT_STATE} in it, but {kinds}')
            topics = tuple(sorted({c.topic for c in chosen if c.msgcount}))
            return Recording(path, topics, reader.start_time, reader.end_time, count)

    def messages(self, start_offset: float = 0.0) -> Iterator[RecordedMessage]:
        """Yield the JointStates in recorded order.

        Parameters
        ----------
        start_offset
            Where to begin, s after the recording's start.

        Raises
        ------
        RecordingError
            Where the bag is damaged.
        """
        begin = self.start + round(1e9 * start_offset)
        with closing(open_bag(self.path)) as reader:
            chosen = [c for c in reader.connections if c.msgtype == JOINT_STATE]
            try:
                for connection, time, data in reader.messages(chosen, start=begin):
                    yield RecordedMessage(connection.topic, time, bytes(data))
            except Exception as error:  # a broken file breaks in many ways
                raise RecordingError(f'{self.path}: damaged: {error}') from None


def list_topics(path: Path) -> set[tuple[str, str]]:
    """Return the topics of a bag that have messages, each with its type.

    Parameters
    ----------
    path
        The bag's folder, which is read without any library, or an .mcap or .db3 file.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    listing = path / 'metadata.yaml'
    if not listing.is_file():
        with closing(open_bag(path)) as reader:
            return read_topics(reader)
    try:
        facts = yaml.safe_load(listing.read_text(encoding='utf-8'))['rosbag2_bagfile_information']
        counted = facts['topics_with_message_count']
        topics = [each['topic_metadata'] for each in counted if each['message_count']]
        return {(str(each['name']), str(each['type'])) for each in topics}
    except (KeyError, OSError, TypeError, UnicodeDecodeError, yaml.YAMLError):
        raise RecordingError(f'{listing}: not the metadata of a rosbag2') from None


def read_topics(reader: Any) -> set[tuple[str, str]]:
    """Return the topics of an open bag that have messages, each with its type.

    All, if none has: an .mcap file need not say how many messages a topic has.
    """
    counted = [each for each in reader.connections if each.msgcount]
    return {(each.topic, each.msgtype) for each in counted or reader.connections}


def choose_joint_topic(
    path: Path, topics: Iterable[tuple[str, str]], topic: str | None, option: str
) -> str:
    """Return the topic of a bag's joint states.

    Parameters
    ----------
    path
        The bag.
    topics
        Its topics, each with its type.
    topic
        The one that the user chose; None: /joint_states, or the only one.
    option
        How a user chooses one.

    Raises
    ------
    RecordingError
        If the bag has no such topic, or several of which none was chosen.
    """
    topics = set(topics)
    held = {name for name, kind in topics if kind == JOINT_STATE}
    if topic is None and DEFAULT_TOPIC in held:
        topic = DEFAULT_TOPIC
    if topic is None and len(held) > 1:
        raise RecordingError(
            f'{path}: joint states on {", ".join(sorted(held))}; choose one with {option}'
        )
    if not held or (topic is not None and topic not in held):
        kinds = ', '.join(sorted(f'{name} ({kind})' for name, kind in topics))
        wanted = f'no {JOINT_STATE}' + (f' on {topic}' if topic else '')
        raise RecordingError(f'{path}: {wanted} in it, but {kinds or "nothing"}')
    return topic or held.pop()


def deserialize_message(reader: Any, data: bytes, kind: str) -> Any:
    """Return a message from its bytes.

    Messages that rclpy serialised may end in up to 12 surplus bytes, which rosbags refuses; then
    they are cut off.
    """
    try:
        return reader.deserialize(data, kind)
    except Exception as error:
        for surplus in (4, 8, 12):
            with suppress(Exception):
                return reader.deserialize(data[:-surplus], kind)
        raise error


def open_bag(path: Path) -> Any:
    """Return an open reader of rosbags; RecordingError if the bag cannot be read."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise RecordingError(
            f'a recording needs the rosbags library: {advise_install("rosbags")}'
        ) from None
    if not path.exists():
        raise RecordingError(f'{path}: no such file or folder')
    if path.suffix == '.bag':
        raise RecordingError(f'{path}: a ROS 1 bag; convert it with rosbags-convert first')
    try:
        reader = AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY))
        reader.open()
    except Exception as error:  # a broken file breaks in many ways
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RecordingError(f'{path}: not a readable rosbag2: {text}') from None
    return reader
