# SPDX-License-Identifier: Apache-2.0
"""MCAP files written and read by the `mcap` library, which is no part of what is tested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from bags import STORE, joint_state

JOINT_STATE = 'sensor_msgs/msg/JointState'
JOINT_STATE_TEXT = STORE.generate_msgdef(JOINT_STATE, ros_version=2)[0].encode()


class Schema(NamedTuple):
    """The schema of a topic."""

    name: str = JOINT_STATE
    encoding: str = 'ros2msg'
    text: bytes = JOINT_STATE_TEXT


class Topic(NamedTuple):
    """A topic beside the joint states."""

    topic: str
    schema: Schema | None
    encoding: str = 'cdr'
    facts: Mapping[str, str] = {}


def write_mcap(
    path: Path,
    beside: Sequence[Topic] = (),
    ours: Topic | None = None,
    profile: str = 'ros2',
    compression: str = 'NONE',
    index: str = 'ALL',
    **options: Any,
) -> Path:
    """Write 10 joint states, and after each a message of every other topic."""
    from mcap.writer import CompressionType, IndexType, Writer

    options['compression'], options['index_types'] = CompressionType[compression], IndexType[index]
    ours = ours or Topic('/joint_states', Schema())
    with path.open('wb') as file:
        writer = Writer(file, **options)
        writer.start(profile, 'test')
        channels = []
        for each in (ours, *beside):
            schema = writer.register_schema(*each.schema) if each.schema else 0
            channels.append(
                writer.register_channel(each.topic, each.encoding, schema, dict(each.facts))
            )
        for k in range(10):
            _, _, time, data = joint_state(k)
            writer.add_message(channels[0], time, data, time - 9, k)
            for number, channel in enumerate(channels[1:]):
                writer.add_message(channel, time + 1, bytes([0, 1, 0, 0, k, number]), time, k)
        writer.finish()
    return path


def read_mcap(path: Path, ours: str = '/deltoid') -> list[tuple[Any, ...]]:
    """Return all messages, with what the file says of their topics, but those of our answers."""
    from mcap.reader import NonSeekingReader

    with path.open('rb') as file:
        reader = NonSeekingReader(file, validate_crcs=True)
        return sorted(
            (
                channel.topic,
                message.log_time,
                message.publish_time,
                message.sequence,
                bytes(message.data),
                channel.message_encoding,
                (schema.name, schema.encoding, schema.data) if schema else ('', '', b''),
            )
            for schema, channel, message in reader.iter_messages()
            if not channel.topic.startswith(ours)
        )
