# SPDX-License-Identifier: Apache-2.0
"""An MCAP file that is written: chunks with indexes and CRCs, uncompressed."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from struct import pack
from zlib import crc32

from ... import __version__
from ...recordings.bags.connections import TypeDefinition
from ...recordings.bags.mcap_records import (
    CHANNEL,
    CHUNK,
    CHUNK_INDEX,
    DATA_END,
    FOOTER,
    HEADER,
    MAGIC,
    MESSAGE,
    MESSAGE_INDEX,
    METADATA,
    METADATA_INDEX,
    RECORD,
    RECORD_AND_MESSAGE,
    SCHEMA,
    STATISTICS,
    SUMMARY_OFFSET,
)
from .topic_facts import WrittenTopic

CHUNK_BYTES = 2**20
NEVER = 2**63 - 1


class McapWriter:
    """Writes an MCAP file.

    Parameters
    ----------
    stem
        The file without its ending.
    """

    def __init__(self, stem: Path) -> None:
        """Write the head."""
        self.path = stem.with_name(f'{stem.name}.mcap')
        self._file = self.path.open('xb')
        self._crc = 0
        self._place = 0
        self._schemas: dict[tuple[str, TypeDefinition], int] = {}
        self._definitions: list[tuple[int, bytes]] = []  # records of schemas and channels
        self._counts: dict[int, int] = {}
        self._start, self._end = NEVER, 0
        self._indexes: list[bytes] = []
        self._begin_chunk()
        self._emit(MAGIC + record(HEADER, text('ros2') + text(f'linkedplane_ros {__version__}')))

    def _emit(self, data: bytes | bytearray) -> None:
        self._file.write(data)
        self._crc = crc32(data, self._crc)
        self._place += len(data)

    def _begin_chunk(self) -> None:
        self._chunk = bytearray()
        self._chunk_times: dict[int, list[tuple[int, int]]] = defaultdict(list)

    def _define(self, opcode: int, content: bytes) -> None:
        """Add a schema or a channel: to the chunk, and later to the summary."""
        self._definitions.append((opcode, record(opcode, content)))
        self._chunk += self._definitions[-1][1]

    def add_topic(self, number: int, topic: WrittenTopic) -> None:
        """Add a topic; one without a schema gets an empty one, without which rosbag2 stops."""
        key = topic.type_name, topic.definition
        if key not in self._schemas:
            self._schemas[key] = schema = len(self._schemas) + 1
            name, (encoding, content) = topic.type_name, topic.definition
            self._define(SCHEMA, pack('<H', schema) + text(name) + text(encoding) + data(content))
        head = pack('<HH', number, self._schemas[key])
        facts = text_map(topic.facts)
        self._define(CHANNEL, head + text(topic.topic) + text(topic.serialization) + facts)
        self._counts[number] = 0

    def write(self, number: int, time: int, data: bytes, sent: int, sequence: int) -> None:
        """Append a message to a topic."""
        self._chunk_times[number].append((time, len(self._chunk)))
        self._chunk += RECORD_AND_MESSAGE.pack(
            MESSAGE, len(data) + 22, number, sequence, time, sent
        )
        self._chunk += data
        self._counts[number] += 1
        if len(self._chunk) > CHUNK_BYTES:
            self._end_chunk()

    def _end_chunk(self) -> None:
        times = [time for each in self._chunk_times.values() for time, _ in each]
        start, end = min(times, default=0), max(times, default=0)
        if times:
            self._start, self._end = min(start, self._start), max(end, self._end)
        size, begin = len(self._chunk), self._place
        head = pack('<QQQI', start, end, size, crc32(self._chunk)) + text('') + pack('<Q', size)
        self._emit(RECORD.pack(CHUNK, len(head) + size) + head)
        self._emit(self._chunk)
        length, places = self._place - begin, b''
        for number, index in self._chunk_times.items():
            places += pack('<HQ', number, self._place)
            entries = b''.join(pack('<QQ', *each) for each in index)
            self._emit(record(MESSAGE_INDEX, pack('<H', number) + data(entries)))
        self._indexes.append(
            pack('<QQQQ', start, end, begin, length)
            + data(places)
            + pack('<Q', self._place - begin - length)
            + text('')
            + pack('<QQ', size, size)
        )
        self._begin_chunk()

    def finish(self, version: int, metadata: str) -> None:
        """Write what is left, and the summary."""
        if self._chunk:
            self._end_chunk()
        begin = self._place
        facts = text_map({'serialized_metadata': metadata})
        self._emit(record(METADATA, text('rosbag2') + facts))
        metadata_index = pack('<QQ', begin, self._place - begin) + text('rosbag2')
        self._emit(record(DATA_END, pack('<I', self._crc)))
        groups = [
            (SCHEMA, [each for opcode, each in self._definitions if opcode == SCHEMA]),
            (CHANNEL, [each for opcode, each in self._definitions if opcode == CHANNEL]),
            (CHUNK_INDEX, [record(CHUNK_INDEX, each) for each in self._indexes]),
            (METADATA_INDEX, [record(METADATA_INDEX, metadata_index)]),
            (STATISTICS, [record(STATISTICS, self._statistics())]),
        ]
        summary_begin, self._crc = self._place, 0
        offsets = []
        for opcode, records in groups:
            begin = self._place
            self._emit(b''.join(records))
            if records:
                offset = pack('<BQQ', opcode, begin, self._place - begin)
                offsets.append(record(SUMMARY_OFFSET, offset))
        offsets_begin = self._place
        self._emit(b''.join(offsets))
        self._emit(RECORD.pack(FOOTER, 20) + pack('<QQ', summary_begin, offsets_begin))
        self._emit(pack('<I', self._crc) + MAGIC)
        self._file.flush()

    def _statistics(self) -> bytes:
        count, channels = sum(self._counts.values()), len(self._counts)
        start = self._start if count else 0
        counts = b''.join(pack('<HQ', *each) for each in sorted(self._counts.items()))
        head = pack('<QHIIII', count, len(self._schemas), channels, 0, 1, len(self._indexes))
        return head + pack('<QQ', start, self._end) + data(counts)

    def close(self) -> None:
        """Close the file, complete or not."""
        self._file.close()


def record(opcode: int, content: bytes) -> bytes:
    """Return a record."""
    return RECORD.pack(opcode, len(content)) + content


def data(content: bytes) -> bytes:
    """Return bytes with their number before them."""
    return pack('<I', len(content)) + content


def text(content: str) -> bytes:
    """Return a string with its size before it."""
    return data(content.encode(errors='surrogateescape'))


def text_map(content: Mapping[str, str]) -> bytes:
    """Return a map of strings."""
    return data(b''.join(text(part) for each in content.items() for part in each))
