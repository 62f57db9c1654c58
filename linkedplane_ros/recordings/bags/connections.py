# SPDX-License-Identifier: Apache-2.0
"""What a bag says of its topics, and a message as it was recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

QOS = 'offered_qos_profiles'
TYPE_HASH = 'topic_type_hash'
CDR = 'cdr'


class TypeDefinition(NamedTuple):
    """The definition of a message type, as it stands in a recording."""

    encoding: str = ''
    """ros2msg, ros2idl, ...; empty: there is none."""
    text: bytes = b''


@dataclass(frozen=True, eq=False)
class Connection:
    """A topic of a bag with its type; a bag may have several of the same topic."""

    id: int
    """Its number in the bag."""
    topic: str
    type_name: str
    """As the recording spells it."""
    definition: TypeDefinition
    serialization: str
    """cdr, json, ..."""
    facts: Mapping[str, str]
    """What else was recorded: the offered quality of service, the hash of the type."""
    msgcount: int
    """How many messages the bag counts."""
    msgtype: str = field(init=False)
    """The type as ROS 2 spells it."""
    kind: str = field(init=False)
    """The type, and the serialization where it is not CDR, which alone is read."""

    def __post_init__(self) -> None:
        """Spell the type as ROS 2 does."""
        msgtype = ros2_type_name(self.type_name)
        other = '' if self.serialization == CDR else f' as {self.serialization or "?"}'
        object.__setattr__(self, 'msgtype', msgtype)
        object.__setattr__(self, 'kind', msgtype + other)


class RecordedMessage(NamedTuple):
    """One message, in the bytes of the recording."""

    connection: Connection
    time: int
    """When it was recorded, ns since the epoch."""
    data: bytes
    sent: int | None = None
    """When it was sent, ns since the epoch; None: not recorded."""
    sequence: int = 0

    @property
    def topic(self) -> str:
        """The name of its topic."""
        return self.connection.topic


def ros2_type_name(name: str) -> str:
    """Return the name of a message type with the `msg` that ROS 1 leaves out."""
    package, _, rest = name.partition('/')
    return f'{package}/msg/{rest}' if package and rest and '/' not in rest else name
