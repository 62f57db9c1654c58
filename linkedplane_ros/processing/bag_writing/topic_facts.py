# SPDX-License-Identifier: Apache-2.0
"""What a written bag says of a topic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import yaml

from ...recordings.bags.connections import CDR, QOS, TYPE_HASH, Connection, TypeDefinition

DURATIONS = ('deadline', 'lifespan', 'liveliness_lease_duration')
POLICIES = ('history', 'reliability', 'durability', 'liveliness')


class WrittenTopic(NamedTuple):
    """A topic of a bag that is written."""

    topic: str
    type_name: str
    definition: TypeDefinition
    serialization: str
    facts: Mapping[str, str]

    @property
    def type_hash(self) -> str:
        """The hash of its type; empty: not known."""
        return self.facts.get(TYPE_HASH, '')

    @property
    def qos(self) -> str:
        """The offered quality of service as YAML; empty: not known."""
        return self.facts.get(QOS, '')


def new_topic(topic: str, type_name: str, store: Any) -> WrittenTopic:
    """Return a topic of a type that a typestore of rosbags has."""
    text, _ = store.generate_msgdef(type_name, ros_version=2)
    facts = {QOS: '', TYPE_HASH: str(store.hash_rihs01(type_name))}
    return WrittenTopic(topic, type_name, TypeDefinition('ros2msg', text.encode()), CDR, facts)


def kept_topic(connection: Connection, store: Any) -> WrittenTopic:
    """Return a topic as it was recorded.

    The hash of a type that the typestore has is added where it is missing. A quality of service
    that rosbag2 cannot read is left out, since it would refuse the whole bag.
    """
    facts = dict(connection.facts)
    if facts.get(QOS) and not parse_qos(facts[QOS]):
        facts[QOS] = ''
    if not facts.get(TYPE_HASH) and connection.kind in store.fielddefs:
        facts[TYPE_HASH] = str(store.hash_rihs01(connection.kind))
    return WrittenTopic(
        connection.topic,
        connection.type_name,
        connection.definition,
        connection.serialization,
        facts,
    )


def parse_qos(text: str) -> list[dict[str, Any]]:
    """Return the profiles of a quality of service as YAML; none if rosbag2 could not read them.

    Its policies are numbers (to Iron) or names (from Jazzy on), as in rosbag2_storage's qos.cpp.
    """
    try:
        profiles = yaml.safe_load(text)
    except yaml.YAMLError:
        return []
    good = isinstance(profiles, list) and all(map(is_profile, profiles))
    return profiles if good else []


def is_profile(profile: Any) -> bool:
    """Return whether something is a profile of a quality of service."""
    if not isinstance(profile, dict):
        return False
    policies = {type(profile.get(name)) for name in POLICIES}
    times: list[Any] = [profile.get(name) for name in DURATIONS]
    return (
        policies in ({int}, {str})
        and type(profile.get('depth')) is int
        and type(profile.get('avoid_ros_namespace_conventions')) is bool
        and all(isinstance(each, dict) for each in times)
        and all(type(each.get(part)) is int for each in times for part in ('sec', 'nsec'))
    )
