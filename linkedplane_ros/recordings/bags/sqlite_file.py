# SPDX-License-Identifier: Apache-2.0
"""A .db3 file of a bag, by Python's sqlite3.

rosbags 0.11.9 opens it as unchangeable, so that SQLite passes over what a killed recorder left in a
-wal or -journal beside it; it drops messages without a topic, and stops at definitions in an
encoding that it does not know.
"""

from __future__ import annotations

import shlex
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
HEAD_SIZE = 100  # bytes: https://www.sqlite.org/fileformat2.html, 1.3
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
        self.faults: list[str] = []
        self.storage = 'sqlite3'
        self._stack = ExitStack()
        try:
            self._database = self._connect()
            self._open()
        except sqlite3.Error as error:
            self.close()
            raise self._refusal('not a readable rosbag2', error) from None
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
        for wal in (each for each in beside if each.name.endswith('-wal')):
            self._check_wal(database, wal)
        return database

    def _check_wal(self, database: sqlite3.Connection, wal: Path) -> None:
        """Note what SQLite does not take of a -wal: pages that are torn, or not committed."""
        [(page,)] = database.execute('PRAGMA page_size')
        [(_, taken, _)] = database.execute('PRAGMA wal_checkpoint(PASSIVE)')
        written = count_wal_pages(wal, page)
        if written > max(0, taken):
            self.faults.append(
                f'{wal.name}: {written - max(0, taken)} of its {written} pages are damaged or were '
                'not committed; messages in them are lost'
            )

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
        if not {type(start), type(end)} <= {int, type(None)}:
            raise sqlite3.DatabaseError(f'the times of messages: {start!r} to {end!r}')
        self.start, self.end = start or 0, end or 0

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
            raise self._refusal('damaged', error) from None

    def check(self) -> None:
        """Let SQLite look at all pages and at the index, after all messages have been read.

        Raises
        ------
        RecordingError
            If something is not as it was written.
        """
        try:
            [(first,)] = self._query('PRAGMA integrity_check(1)')
        except sqlite3.Error as error:
            raise self._refusal('damaged', error) from None
        if first != 'ok':
            raise self._refusal('damaged', ' '.join(str(first).split()))

    def _refusal(self, what: str, reason: object) -> RecordingError:
        """Return the refusal of the file; with the way to what is whole if it is damaged."""
        text = f'{self.path}: {what}: {reason}'
        pages = self._missing_bytes()
        if pages:
            text += f'; the file is cut short, {pages:,} bytes are missing'
        if what == 'damaged' or pages or 'malformed' in text:
            name = shlex.quote(str(self.path))
            text += f'; `sqlite3 {name} .recover | sqlite3 recovered.db3` keeps what is whole'
        return RecordingError(text)

    def _missing_bytes(self) -> int:
        """Return how many bytes less the file has than its head says."""
        with self.path.open('rb') as file:
            head = file.read(HEAD_SIZE)
            size = file.seek(0, 2)
        if len(head) < HEAD_SIZE:
            return 0
        page, pages = int.from_bytes(head[16:18], 'big'), int.from_bytes(head[28:32], 'big')
        return max(0, pages * (2**16 if page == 1 else page) - size)

    def close(self) -> None:
        """Close the file."""
        self._stack.close()


def count_wal_pages(wal: Path, page: int) -> int:
    """Return how many pages a -wal has of its last use (sqlite.org/fileformat2.html, section 4).

    It is used again from its beginning: behind its last page may stand older ones, of other salts.
    """
    size, count, salts = 24 + page, 0, b''
    with wal.open('rb') as file:
        file.seek(32)
        while len(head := file.read(24)) == 24:
            salts = salts or head[8:16]
            if head[8:16] != salts:
                break
            count += 1
            file.seek(32 + count * size)
    return count
