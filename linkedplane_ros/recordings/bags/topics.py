# SPDX-License-Identifier: Apache-2.0
"""The topics of a bag, and which of them has its joint states."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

import yaml

from ...errors import RecordingError
from .opening import open_bag

JOINT_STATE = 'sensor_msgs/msg/JointState'
DEFAULT_TOPIC = '/joint_states'


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
