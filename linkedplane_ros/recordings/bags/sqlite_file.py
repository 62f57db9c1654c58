# SPDX-License-Identifier: Apache-2.0
"""A .db3 file of a bag, by Python's sqlite3.

rosbags 0.11.9 opens it as unchangeable, so that SQLite passes over what a killed recorder left in a
-wal or -journal beside it; it drops messages without a topic, and stops at definitions in an
encoding that it does not know.
"""

from __future__ import annotations

import shutil
import sqlite3
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote

from ...errors import RecordingError
from .connections import CDR, QOS, TYPE_HASH, Connection, RecordedMessage, TypeDefinition

TABLES = ('topics', 'messages')
UNFINISHED = ('-wal', '-journal')  # beside a database that was not closed


class SqliteFile:
    """An open .db3 file.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    RecordingError
        If it is no database of rosbag2, or damaged.
    """

    def __init__(self, path: Path) -> None:
        """Read the topics."""
        self.path = path
        self.strays: Counter[str] = Counter()
        self.storage, self.profile = 'sqlite3', 'ros2'
        self._stack = ExitStack()
        try:
            self._database = self._connect()
            self._open()
        except sqlite3.Error as error:
            self.close()
            raise RecordingError(f'{path}: not a readable rosbag2: {error}') from None
        except BaseException:
            self.close()
            raise

    def _connect(self) -> sqlite3.Connection:
        """Open the file; with what a killed recorder left beside it, a copy of both.

        SQLite changes files to bring them to an end; the recording stays as it is.
        """
        path, rest = self.path, 'immutable=1'
        beside = [path.with_name(path.name + ending) for ending in UNFINISHED]
        beside = [each for each in beside if each.exists() and each.stat().st_size]
        if beside:
            folder = Path(self._stack.enter_context(TemporaryDirectory(prefix='linkedplane_')))
            for each in (path, *beside):
                shutil.copyfile(each, folder / each.name)
            path, rest = folder / path.name, 'mode=rw'
        database = sqlite3.connect(f'file:{quote(str(path.absolute()))}?{rest}', uri=True)
        self._stack.callback(database.close)
        database.text_factory = lambda data: data.decode(errors='surrogateescape')
        return database

    def _query(self, command: str, *values: Any) -> Iterator[tuple[Any, ...]]:
        return iter(self._database.execute(command, values))

    def _columns(self, table: str) -> set[str]:
        return {str(row[1]) for row in self._query(f'PRAGMA table_info({table})')}

    def _open(self) -> None:
        missing = [table for table in TABLES if not self._columns(table)]
        if missing:
            raise sqlite3.DatabaseError(f'no table {missing[0]!r} in it')
        definitions = self._read_definitions()
        held = self._columns('topics')
        names = ['id', 'name', 'type', 'serialization_format', QOS, 'type_description_hash']
        chosen = [name if name in held else "''" for name in names]
        counts = dict(self._query('SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id'))
        self.connections: dict[int, Connection] = {}
        rows = self._query(f'SELECT {", ".join(chosen)} FROM topics ORDER BY id')
        for number, topic, type_name, serialization, qos, type_hash in rows:
            facts = {QOS: str(qos or ''), TYPE_HASH: str(type_hash or '')}
            self.connections[number] = Connection(
                number,
                str(topic),
                str(type_name),
                definitions.get(str(type_name), TypeDefinition()),
                str(serialization or CDR),
                {name: fact for name, fact in facts.items() if fact},
                counts.get(number, 0),
            )
        for number, count in counts.items():
            if number not in self.connections:
                self.strays[f'topic {number}, which {self.path.name} does not define'] = count
        self.message_count: int = sum(counts.values())
        [(start, end)] = self._query('SELECT MIN(timestamp), MAX(timestamp) FROM messages')
        self.start, self.end = int(start or 0), int(end or 0)

    def _read_definitions(self) -> dict[str, TypeDefinition]:
        """Return the definitions of types; ROS distributions before Jazzy wrote none."""
        if not self._columns('message_definitions'):
            return {}
        rows = self._query(
            'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions '
            'ORDER BY id'
        )
        return {
            str(name): TypeDefinition(str(encoding), str(text).encode(errors='surrogateescape'))
            for name, encoding, text in rows
        }

    def messages(self, wanted: Mapping[int, Connection], begin: int) -> Iterator[RecordedMessage]:
        """Yield messages in the order of time, and of the file where times are equal.

        Parameters
        ----------
        wanted
            What to read, by the file's numbers of its topics.
        begin
            The first time, ns since the epoch.

        Raises
        ------
        RecordingError
            Where the file is damaged.
        """
        command = 'SELECT topic_id, timestamp, data FROM messages'
        values: list[int] = []
        if len(wanted) < len(self.connections):
            command += f' WHERE topic_id IN ({", ".join("?" * len(wanted))})'
            values += wanted
        try:
            for number, time, data in self._query(f'{command} ORDER BY timestamp, id', *values):
                if type(time) is not int or type(data) is not bytes:
                    raise sqlite3.DatabaseError(f'a message of {type(time)} and {type(data)}')
                connection = wanted.get(number)
                if connection is not None and time >= begin:
                    yield RecordedMessage(connection, time, data)
        except sqlite3.Error as error:
            raise RecordingError(f'{self.path}: damaged: {error}') from None

    def close(self) -> None:
        """Close the file."""
        self._stack.close()
