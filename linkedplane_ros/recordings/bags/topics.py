# SPDX-License-Identifier: Apache-2.0
"""The topics of a bag, and which of them has its joint states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from contextlib import closing, suppress
from pathlib import Path

from ...errors import RecordingError
from ..formats import METADATA
from .bag import Bag
from .connections import ros2_type_name
from .messages import DamagedMessage
from .metadata import read_metadata
from .opening import open_bag

JOINT_STATE = 'sensor_msgs/msg/JointState'
DEFAULT_TOPIC = '/joint_states'
LOOKED_AT = 100  # messages of a topic, for the names of its joints
NAMED, LONGEST = 6, 40  # joints of a topic that a message lists, and letters of each


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


def read_joint_names(bag: Bag) -> dict[str, list[str]]:
    """Return the joints of each topic of joint states, by its first messages."""
    chosen = [each for each in bag.connections if each.kind == JOINT_STATE and each.msgcount]
    names: dict[str, dict[str, None]] = {each.topic: {} for each in chosen}
    looked_at: Counter[str] = Counter()
    for message in bag.messages(chosen):
        looked_at[message.topic] += 1
        if looked_at[message.topic] <= LOOKED_AT:
            with suppress(DamagedMessage):  # counted where it is read
                state = bag.read_message(message.connection, message.data)
                names[message.topic] |= dict.fromkeys(state.name)
        elif all(looked_at[each] > LOOKED_AT for each in names):
            break
    return {topic: list(each) for topic, each in names.items()}


def choose_joint_topic(
    path: Path,
    topics: Iterable[tuple[str, str]],
    topic: str | None,
    option: str,
    joints: Mapping[str, Collection[str]] | None = None,
    wanted: Collection[str] = (),
) -> str:
    """Return the topic of a bag's joint states.

    Parameters
    ----------
    path
        The bag.
    topics
        Its topics, each with its type.
    topic
        The one that the user chose; None: the only one that has all joints that are wanted, else
        /joint_states, if it has one of them, or the only one.
    option
        How a user chooses one, with {} for it.
    joints
        The joints of each topic of joint states; None: not known.
    wanted
        The joints to be read.

    Raises
    ------
    RecordingError
        If the bag has no such topic, or several of which none was chosen.
    """
    topics = set(topics)
    held = {name for name, kind in topics if kind == JOINT_STATE}
    if not held or (topic is not None and topic not in held):
        kinds = ', '.join(sorted(f'{name} ({kind})' for name, kind in topics))
        missing = f'no {JOINT_STATE}' + (f' on {topic}' if topic else '')
        hints = hint_topics(joints or {}, option)
        raise RecordingError(f'{path}: {missing} in it, but {kinds or "nothing"}{hints}')
    if topic is not None or len(held) == 1:
        return topic or held.pop()
    if joints is None:
        if DEFAULT_TOPIC in held:
            return DEFAULT_TOPIC
        choice = option.format('TOPIC')
        raise RecordingError(
            f'{path}: joint states on {", ".join(sorted(held))}; choose one with {choice}'
        )
    complete = [name for name in held if set(wanted) <= set(joints.get(name, ()))]
    if len(complete) == 1:
        return complete[0]
    if DEFAULT_TOPIC in (complete or held) and set(wanted) & set(joints.get(DEFAULT_TOPIC, ())):
        return DEFAULT_TOPIC
    those = 'several topics have' if complete else 'no topic has'
    hints = hint_topics(joints, option)
    raise RecordingError(f'{path}: {those} the joints {", ".join(wanted)}{hints}')


def hint_topics(joints: Mapping[str, Collection[str]], option: str) -> str:
    """Return how each topic of joint states is chosen, and its joints."""
    hints = (f'; {option.format(name)}: {list_joints(joints[name])}' for name in sorted(joints))
    return ''.join(hints)


def list_joints(names: Collection[str]) -> str:
    """Return the first joints of a topic, as they are shown to a user."""
    shown = [name if name.isprintable() else repr(name) for name in list(names)[:NAMED]]
    return ', '.join([each[:LONGEST] for each in shown] + ['...'] * (len(names) > NAMED)) or 'none'
