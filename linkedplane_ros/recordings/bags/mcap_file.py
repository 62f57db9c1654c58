# SPDX-License-Identifier: Apache-2.0
"""An MCAP file of a bag: its topics, and its messages in the order of time.

Nothing depends on the indexes of the file: all records are walked through once, chunks unread, so
that a file without indexes, or with wrong ones, is read as any other. rosbags 0.11.9 takes the
chunks from the index, refuses profiles, encodings and QoS texts that it does not know, and files
without an index whose messages are not sorted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from heapq import heappop, heappush, heapreplace
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

from ...errors import RecordingError
from .compression import decompress
from .connections import Connection, RecordedMessage, TypeDefinition
from .mcap_records import (
    CHANNEL,
    CHUNK,
    CHUNK_HEAD,
    DATA_END,
    FOOTER,
    FOOTER_SIZE,
    HEADER,
    MAGIC,
    MESSAGE,
    MESSAGE_HEAD,
    RECORD,
    SCHEMA,
    STATISTICS,
    Channel,
    Fields,
    McapFault,
    Record,
    Schema,
    Statistics,
    read_channel,
    read_schema,
    read_statistics,
    records_inside,
    walk_records,
)

SEGMENT_BYTES = 2**22  # of messages outside of chunks that are read at a time


class Segment(NamedTuple):
    """A part of a file that is read at a time: a chunk, or messages outside of chunks."""

    start: int
    """The time of its first message, ns."""
    end: int
    offset: int
    """Where its records begin in the file."""
    length: int
    """Of its bytes in the file."""
    compression: str = ''
    size: int | None = None
    """Of its bytes, uncompressed; None: they are not in a chunk."""
    crc: int = 0
    """Of its bytes, uncompressed; 0: not known."""


class McapFile:
    """An open MCAP file.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    RecordingError
        If it is no MCAP file, or damaged.
    """

    def __init__(self, path: Path) -> None:
        """Walk through the records; chunks are read where the summary does not list the topics."""
        self.path = path
        self.strays: Counter[str] = Counter()
        self.storage, self.profile = 'mcap', ''
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._segments: list[Segment] = []
        self._statistics: Statistics | None = None
        self._file = path.open('rb')
        try:
            self._open()
        except McapFault as fault:
            self.close()
            raise RecordingError(f'{path}: damaged: {fault}') from None
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        self._size = self._file.seek(0, 2)
        summary = self._check_ends()
        for record in walk_records(self._file, len(MAGIC), self._size - len(MAGIC)):
            if record.opcode in (DATA_END, FOOTER):
                break
            self._take_record(record)
        if summary:
            self._read_summary(summary)
        counts = self._statistics
        if (
            counts is None
            or counts.channels > len(self._channels)
            or counts.messages != sum(counts.by_channel.values())
        ):
            counts = self._count_messages()
        self.message_count = counts.messages
        self.start, self.end = counts.start, counts.end
        self.connections = {
            number: self._connection(number, channel, counts.by_channel.get(number, 0))
            for number, channel in sorted(self._channels.items())
        }

    def _check_ends(self) -> int:
        """Return where the summary begins, 0 if there is none; McapFault without both ends."""
        self._file.seek(0)
        if self._file.read(len(MAGIC)) != MAGIC:
            raise McapFault('not the beginning of an MCAP file')
        self._file.seek(max(0, self._size - FOOTER_SIZE - len(MAGIC)))
        end = self._file.read()
        opcode, size = RECORD.unpack_from(end)
        if not end.endswith(MAGIC) or (opcode, size) != (FOOTER, FOOTER_SIZE - RECORD.size):
            raise McapFault(
                f'the end is missing; `mcap recover {self.path.name} -o recovered.mcap` keeps what '
                'is there'
            )
        return Fields(end[RECORD.size :]).number(8)

    def _take_record(self, record: Record) -> None:
        """Note a record of the data section."""
        if record.opcode == MESSAGE:
            self._add_message(record)
        elif record.opcode == CHUNK:
            self._add_chunk(record)
        elif record.opcode == SCHEMA:
            self._schemas.update([read_schema(self._content(record))])
        elif record.opcode == CHANNEL:
            self._channels.update([read_channel(self._content(record))])
        elif record.opcode == HEADER:
            self.profile = Fields(self._content(record)).text()

    def _content(self, record: Record) -> bytes:
        self._file.seek(record.offset)
        return self._file.read(record.size)

    def _add_message(self, record: Record) -> None:
        """Add a message outside of chunks: to the segment that it follows, or as a new one."""
        head = self._file.read(MESSAGE_HEAD.size)
        if record.size < MESSAGE_HEAD.size:
            raise McapFault(f'byte {record.offset}: a message of {record.size} bytes')
        time = MESSAGE_HEAD.unpack(head)[2]
        begin, length = record.offset - RECORD.size, RECORD.size + record.size
        last = self._segments[-1] if self._segments else None
        if (
            last is not None
            and last.size is None
            and last.offset + last.length == begin
            and last.length < SEGMENT_BYTES
        ):
            start, end = min(last.start, time), max(last.end, time)
            self._segments[-1] = Segment(start, end, last.offset, last.length + length)
        else:
            self._segments.append(Segment(time, time, begin, length))

    def _add_chunk(self, record: Record) -> None:
        head = Fields(self._file.read(min(record.size, CHUNK_HEAD.size + 4 + 32 + 8)))
        start, end, size, crc = CHUNK_HEAD.unpack(head.raw(CHUNK_HEAD.size))
        compression, length = head.text(), head.number(8)
        offset = record.offset + CHUNK_HEAD.size + 4 + len(compression) + 8
        if offset + length > record.offset + record.size:
            raise McapFault(f'byte {record.offset}: a chunk of {length} bytes exceeds its record')
        self._segments.append(Segment(start, end, offset, length, compression, size, crc))

    def _read_summary(self, begin: int) -> None:
        for record in walk_records(self._file, begin, self._size - len(MAGIC)):
            if record.opcode == SCHEMA:
                self._schemas.update([read_schema(self._content(record))])
            elif record.opcode == CHANNEL:
                self._channels.update([read_channel(self._content(record))])
            elif record.opcode == STATISTICS:
                self._statistics = read_statistics(self._content(record))

    def _count_messages(self) -> Statistics:
        """Read all segments for what the summary leaves out: topics, counts, times."""
        counts: Counter[int] = Counter()
        for k, segment in enumerate(self._segments):
            content = self._read_segment(segment)
            times = []
            for opcode, begin, end in records_inside(content):
                if opcode == MESSAGE:
                    channel, _, time, _ = MESSAGE_HEAD.unpack_from(content, begin)
                    counts[channel] += 1
                    times.append(time)
                elif opcode == SCHEMA:
                    self._schemas.update([read_schema(content[begin:end])])
                elif opcode == CHANNEL:
                    self._channels.update([read_channel(content[begin:end])])
            if times:
                self._segments[k] = segment._replace(start=min(times), end=max(times))
        filled = [each for each in self._segments if each.start <= each.end]
        return Statistics(
            counts.total(),
            len(self._channels),
            min((each.start for each in filled), default=0),
            max((each.end for each in filled), default=0),
            dict(counts),
        )

    def _connection(self, number: int, channel: Channel, count: int) -> Connection:
        schema = self._schemas.get(channel.schema, Schema('', '', b''))
        definition = TypeDefinition(schema.encoding, schema.text)
        facts = channel.facts
        return Connection(
            number, channel.topic, schema.name, definition, channel.encoding, facts, count
        )

    def _read_segment(self, segment: Segment) -> bytes:
        """Return the records of a segment; McapFault if they are not as they were written."""
        self._file.seek(segment.offset)
        content = self._file.read(segment.length)
        if segment.size is None:
            return content
        where = f'the chunk at byte {segment.offset}'
        try:
            content = decompress(content, segment.compression)
        except Exception as error:  # each library has errors of its own
            raise McapFault(f'{where}: {error}') from None
        if len(content) != segment.size:
            raise McapFault(f'{where}: {len(content)} bytes, {segment.size} expected')
        if segment.crc and crc32(content) != segment.crc:
            raise McapFault(f'{where}: its CRC is not that of its bytes')
        return content

    def messages(self, wanted: Mapping[int, Connection], begin: int) -> Iterator[RecordedMessage]:
        """Yield messages in the order of time, and of the file where times are equal.

        Parameters
        ----------
        wanted
            What to read, by the file's numbers of its connections.
        begin
            The first time, ns since the epoch.

        Raises
        ------
        RecordingError
            Where the file is damaged.
        """
        chosen = [each for each in self._segments if each.end >= begin or begin <= 0]
        try:
            yield from merge_segments(
                (each.start, self._read_messages(each, wanted, begin)) for each in by_time(chosen)
            )
        except McapFault as fault:
            raise RecordingError(f'{self.path}: damaged: {fault}') from None

    def _read_messages(
        self, segment: Segment, wanted: Mapping[int, Connection], begin: int
    ) -> Iterator[RecordedMessage]:
        content = self._read_segment(segment)
        messages = []
        for opcode, place, end in records_inside(content):
            if opcode != MESSAGE:
                continue
            if end - place < MESSAGE_HEAD.size:
                raise McapFault(f'a message of {end - place} bytes')
            channel, sequence, time, sent = MESSAGE_HEAD.unpack_from(content, place)
            connection = wanted.get(channel)
            if connection is not None:
                if time >= begin:
                    data = content[place + MESSAGE_HEAD.size : end]
                    messages.append(RecordedMessage(connection, time, data, sent, sequence))
            elif channel not in self._channels:
                self.strays[f'channel {channel}, which {self.path.name} does not define'] += 1
        messages.sort(key=attrgetter('time'))
        yield from messages

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def by_time(segments: Iterable[Segment]) -> list[Segment]:
    """Return segments in the order in which they begin."""
    return sorted(segments, key=lambda each: (each.start, each.offset))


def merge_segments(
    parts: Iterable[tuple[int, Iterator[RecordedMessage]]],
) -> Iterator[RecordedMessage]:
    """Yield the messages of parts in the order of time.

    Parameters
    ----------
    parts
        When each begins, and its messages in the order of time; they are asked for only then, so
        that no more is held than what overlaps. In the order in which they begin.
    """
    heap: list[tuple[int, int, RecordedMessage, Iterator[RecordedMessage]]] = []

    def advance(until: int | None) -> Iterator[RecordedMessage]:
        while heap and (until is None or heap[0][0] < until):
            _, order, message, rest = heap[0]
            yield message
            following = next(rest, None)
            if following is None:
                heappop(heap)
            else:
                heapreplace(heap, (following.time, order, following, rest))

    for order, (start, messages) in enumerate(parts):
        yield from advance(start)
        first = next(messages, None)
        if first is not None:
            heappush(heap, (first.time, order, first, messages))
    yield from advance(None)
