# SPDX-License-Identifier: Apache-2.0
"""The topics of a bag, and which of them has its joint states."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

from ...errors import RecordingError
from ..formats import METADATA
from .connections import ros2_type_name
from .metadata import read_metadata
from .opening import Bag, open_bag

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
    if not (path / METADATA).is_file():
        with closing(open_bag(path)) as bag:
            return read_topics(bag)
    topics = read_metadata(path).topics
    return {(each.topic, ros2_type_name(each.type_name)) for each in topics if each.count}


def read_topics(bag: Bag) -> set[tuple[str, str]]:
    """Return the topics of an open bag that have messages, each with its type."""
    return {(each.topic, each.kind) for each in bag.connections if each.msgcount}


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
