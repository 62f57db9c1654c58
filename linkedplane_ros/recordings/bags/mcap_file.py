# SPDX-License-Identifier: Apache-2.0
"""An MCAP file of a bag: its topics, and its messages in the order of time.

rosbags 0.11.9 takes the chunks from the index, refuses profiles, encodings and QoS texts that it
does not know, files without an index whose messages are not sorted, and files without an end; it
reads neither the CRC of the data section nor those of the summary and of attachments.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from heapq import heappop, heappush, heapreplace
from operator import attrgetter
from pathlib import Path
from zlib import crc32

from ...errors import RecordingError
from .compression import decompress
from .connections import Connection, RecordedMessage, TypeDefinition
from .mcap_layout import McapLayout, Segment
from .mcap_records import (
    CHANNEL,
    MESSAGE,
    MESSAGE_HEAD,
    SCHEMA,
    Channel,
    McapFault,
    Schema,
    Statistics,
    read_channel,
    read_schema,
    records_inside,
)

NEVER = 2**63  # ns: beyond what ROS counts


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
        self.storage = 'mcap'
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
        self._layout = layout = McapLayout(self._file)
        self.faults = layout.faults
        self._schemas, self._channels = layout.schemas, layout.channels
        self._segments = layout.segments
        counts = self._settle_counts(layout.statistics)
        self.message_count = counts.messages
        self.start, self.end = counts.start, counts.end
        if layout.cut:
            self.faults.insert(0, self._describe_cut())
        self.connections = {
            number: self._connection(number, channel, counts.by_channel.get(number, 0))
            for number, channel in sorted(self._channels.items())
        }

    def _describe_cut(self) -> str:
        """Return what is read of a file without an end; McapFault if that is nothing."""
        layout = self._layout
        rest = layout.size - layout.whole
        if not self.message_count:
            raise McapFault(f'it ends without a footer, no message before is whole: {layout.cut}')
        seconds = 1e-9 * (self.end - self.start)
        return (
            f'ended without a footer, {self.message_count:,} messages to {seconds:.2f} s are '
            f'whole; {rest:,} bytes after them were not used ({layout.cut})'
        )

    def _settle_counts(self, told: Statistics | None) -> Statistics:
        """Return what the summary counts; what is there if it does not, or contradicts itself."""
        if (
            told is not None
            and told.channels <= len(self._channels)
            and told.messages == sum(told.by_channel.values())
        ):
            return told
        counted = self._count_messages()
        if told is not None:
            for name, count, there in (
                ('messages', told.messages, counted.messages),
                ('channels', told.channels, counted.channels),
            ):
                if count != there:
                    self.faults.append(f'its summary counts {count:,} {name}, {there:,} are there')
        return counted

    def _count_messages(self) -> Statistics:
        """Read all segments for what the summary leaves out: topics, counts, times."""
        counts: Counter[int] = Counter()
        good = []
        for segment in self._segments:
            heads = []
            definitions = []
            try:
                content = self._read_segment(segment)
                for opcode, begin, end in records_inside(content):
                    if opcode == MESSAGE:
                        channel, _, time, _ = MESSAGE_HEAD.unpack_from(content, begin)
                        heads.append((time, channel))
                    elif opcode in (SCHEMA, CHANNEL):
                        definitions.append((opcode, content[begin:end]))
                self._define(definitions)
            except McapFault as fault:
                self._leave_out(segment, fault)
                continue
            if heads:
                counts.update(channel for _, channel in heads)
                start, end = min(heads)[0], max(heads)[0]
                self._check_times(segment, start, end)
                good.append(segment._replace(start=start, end=end))
        self._segments = good
        start = min((each.start for each in good), default=0)
        end = max((each.end for each in good), default=0)
        channels = len(self._channels)
        return Statistics(counts.total(), channels, 0, 0, len(good), start, end, dict(counts))

    def _define(self, definitions: Iterable[tuple[int, bytes]]) -> None:
        """Take the schemas and channels of a segment."""
        for opcode, content in definitions:
            if opcode == SCHEMA:
                number, schema = read_schema(content)
                self._compare(f'schema {number}', schema, self._schemas.setdefault(number, schema))
            else:
                number, channel = read_channel(content)
                before = self._channels.setdefault(number, channel)
                self._compare(f'channel {number}', channel, before)

    def _compare(self, name: str, one: object, other: object) -> None:
        if one != other:
            self._add_fault(f'{name} is defined in two ways; the one of the summary is used')

    def _add_fault(self, text: str) -> None:
        if text not in self.faults:
            self.faults.append(text)

    def _check_times(self, segment: Segment, start: int, end: int) -> None:
        """Compare the times of messages with those in the head of their chunk."""
        if not segment.start <= start <= end <= segment.end:
            given, there = self._span(segment.start, segment.end), self._span(start, end)
            self._add_fault(
                f'the chunk at byte {segment.offset}: its head says {given}, its messages {there}'
            )

    def _span(self, *times: int) -> str:
        """Return times as s after the recording's start."""
        first = min(each.start for each in self._layout.segments)
        return ' to '.join(f'{1e-9 * (each - first):.2f}' for each in times) + ' s'

    def _leave_out(self, segment: Segment, fault: McapFault) -> None:
        """Say which part of the file is not read."""
        kind = 'messages' if segment.size is None else 'chunk'
        where = f'the {kind} at byte {segment.offset}, {self._span(segment.start, segment.end)}'
        self._add_fault(f'{where}: left out: {fault}')

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
        try:
            content = decompress(content, segment.compression)
        except Exception as error:  # each library has errors of its own
            raise McapFault(str(error)) from None
        if len(content) != segment.size:
            raise McapFault(f'{len(content)} bytes, {segment.size} expected')
        if segment.crc and crc32(content) != segment.crc:
            raise McapFault('its CRC is not that of its bytes')
        return content

    def messages(self, wanted: Mapping[int, Connection], begin: int) -> Iterator[RecordedMessage]:
        """Yield messages in the order of time, and of the file where times are equal.

        Parameters
        ----------
        wanted
            What to read, by the file's numbers of its connections.
        begin
            The first time, ns since the epoch.
        """
        chosen = [each for each in self._segments if each.end >= begin or begin <= 0]
        yield from merge_segments(
            (each.start, self._read_messages(each, wanted, begin)) for each in by_time(chosen)
        )

    def _read_messages(
        self, segment: Segment, wanted: Mapping[int, Connection], begin: int
    ) -> Iterator[RecordedMessage]:
        messages, definitions = [], []
        try:
            content = self._read_segment(segment)
            for opcode, place, end in records_inside(content):
                if opcode != MESSAGE:
                    if opcode in (SCHEMA, CHANNEL):
                        definitions.append((opcode, content[place:end]))
                    continue
                channel, sequence, time, sent = MESSAGE_HEAD.unpack_from(content, place)
                connection = wanted.get(channel)
                if time >= NEVER:
                    self._add_fault(f'a message of time {time} ns: left out')
                elif connection is not None:
                    if time >= begin:
                        data = content[place + MESSAGE_HEAD.size : end]
                        messages.append(RecordedMessage(connection, time, data, sent, sequence))
                elif channel not in self._channels:
                    self.strays[f'channel {channel}, which {self.path.name} does not define'] += 1
            self._define(definitions)
        except McapFault as fault:
            self._leave_out(segment, fault)
            return
        messages.sort(key=attrgetter('time'))
        if messages:
            self._check_times(segment, messages[0].time, messages[-1].time)
        yield from messages

    def check(self) -> None:
        """Compare the CRCs that are not those of chunks, after all messages have been read.

        Raises
        ------
        RecordingError
            If a message may be damaged, and nothing tells which.
        """
        for place in self._layout.damaged_attachments():
            self._add_fault(f'the attachment at byte {place}: its CRC is not that of its bytes')
        if self.faults or self._layout.has_whole_data():
            return
        fault = 'the CRC of its data is not that of the bytes'
        if not all(each.crc for each in self._segments):
            raise RecordingError(f'{self.path}: damaged: {fault}, and nothing tells where')
        self._add_fault(f'{fault}; each chunk is as it was written')

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
