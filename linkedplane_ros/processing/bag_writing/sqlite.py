# SPDX-License-Identifier: Apache-2.0
"""A .db3 file that is written, in the tables of rosbag2 Jazzy."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from ...recordings.bags.connections import TypeDefinition
from .topic_facts import WrittenTopic

TABLES = """
    CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
    CREATE TABLE metadata(
      id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
    CREATE TABLE topics(
      id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
      serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
      type_description_hash TEXT NOT NULL);
    CREATE TABLE message_definitions(
      id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
      encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
    CREATE TABLE messages(
      id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
      data BLOB NOT NULL);
    CREATE INDEX timestamp_idx ON messages (timestamp ASC);
    INSERT INTO schema(schema_version, ros_distro) VALUES (4, 'jazzy');
"""
TEXT = 'CAST(? AS TEXT)'  # of bytes: names and definitions need not be UTF-8


class SqliteWriter:
    """Writes a .db3 file.

    Parameters
    ----------
    stem
        The file without its ending.
    """

    def __init__(self, stem: Path) -> None:
        """Make the tables."""
        self.path = stem.with_name(f'{stem.name}.db3')
        self._database = sqlite3.connect(self.path)
        self._database.executescript(TABLES)
        self._cursor = self._database.cursor()
        self._defined: set[tuple[str, TypeDefinition]] = set()

    def add_topic(self, number: int, topic: WrittenTopic) -> None:
        """Add a topic, and the definition of its type where there is one."""
        texts = (topic.topic, topic.type_name, topic.serialization, topic.qos, topic.type_hash)
        name, kind, serialization, qos, type_hash = (
            each.encode(errors='surrogateescape') for each in texts
        )
        self._cursor.execute(
            f'INSERT INTO topics VALUES(?, {", ".join([TEXT] * 5)})',
            (number, name, kind, serialization, qos, type_hash),
        )
        encoding, text = topic.definition
        key = topic.type_name, topic.definition
        if (encoding or text) and key not in self._defined:
            self._defined.add(key)
            self._cursor.execute(
                'INSERT INTO message_definitions(topic_type, encoding, encoded_message_definition, '
                f'type_description_hash) VALUES({", ".join([TEXT] * 4)})',
                (kind, encoding.encode(errors='surrogateescape'), text, type_hash),
            )

    def write(self, number: int, time: int, data: bytes, sent: int, sequence: int) -> None:
        """Append a message to a topic; the tables know neither when it was sent nor its number."""
        self._cursor.execute(
            'INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)', (number, time, data)
        )

    def finish(self, version: int, metadata: str) -> None:
        """Write the metadata and all that waits."""
        self._cursor.execute(
            'INSERT INTO metadata(metadata_version, metadata) VALUES(?, ?)', (version, metadata)
        )
        self._database.commit()

    def close(self) -> None:
        """Close the file, complete or not."""
        self._database.close()
