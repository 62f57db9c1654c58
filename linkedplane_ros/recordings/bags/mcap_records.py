# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file (https://mcap.dev/spec): where they are, and what stands in them."""

from __future__ import annotations

from collections.abc import Iterator
from struct import Struct
from typing import BinaryIO, NamedTuple

MAGIC = b'\x89MCAP0\r\n'
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = range(1, 7)
MESSAGE_INDEX, CHUNK_INDEX, ATTACHMENT = 7, 8, 9
STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = 11, 12, 13, 14, 15
FIRST_PRIVATE = 0x80  # opcodes from here on are for everybody's own use

RECORD = Struct('<BQ')  # opcode, bytes that follow
MESSAGE_HEAD = Struct('<HIQQ')  # channel, sequence, log time, publish time
RECORD_AND_MESSAGE = Struct('<BQHIQQ')
CHUNK_HEAD = Struct('<QQQI')  # first time, last time, uncompressed size, CRC
FOOTER_SIZE = RECORD.size + 20
CRC_SIZE = 4


class McapFault(Exception):
    """A file that is not as MCAP's specification says; the text says where."""


class Record(NamedTuple):
    """Where a record stands in a file."""

    opcode: int
    offset: int
    """Of its content."""
    size: int
    """Of its content."""


class Fields:
    """The fields of a record, read one after the other."""

    def __init__(self, content: bytes) -> None:
        """Begin with the first."""
        self._content = content
        self._place = 0

    def more(self) -> bool:
        """Return whether there are more."""
        return self._place < len(self._content)

    def number(self, size: int) -> int:
        """Return an unsigned integer of so many bytes."""
        return int.from_bytes(self.raw(size), 'little')

    def data(self) -> bytes:
        """Return bytes, before which their number stands."""
        return self.raw(self.number(4))

    def text(self) -> str:
        """Return a string."""
        return self.data().decode(errors='surrogateescape')

    def raw(self, size: int) -> bytes:
        """Return so many bytes."""
        end = self._place + size
        if end > len(self._content):
            raise McapFault('a field is longer than its record')
        part = self._content[self._place : end]
        self._place = end
        return part


class Schema(NamedTuple):
    """The definition of a type."""

    name: str
    encoding: str
    text: bytes


class Channel(NamedTuple):
    """A topic."""

    schema: int
    """0: it has none."""
    topic: str
    encoding: str
    facts: dict[str, str]


class Statistics(NamedTuple):
    """What the summary of a file counts."""

    messages: int
    channels: int
    attachments: int
    metadata: int
    chunks: int
    start: int
    end: int
    by_channel: dict[int, int]


def read_schema(content: bytes) -> tuple[int, Schema]:
    """Return the number and the content of a schema."""
    fields = Fields(content)
    return fields.number(2), Schema(fields.text(), fields.text(), fields.data())


def read_channel(content: bytes) -> tuple[int, Channel]:
    """Return the number and the content of a channel."""
    fields = Fields(content)
    number, schema = fields.number(2), fields.number(2)
    topic, encoding, rest = fields.text(), fields.text(), Fields(fields.data())
    facts = {}
    while rest.more():
        name = rest.text()
        facts[name] = rest.text()
    return number, Channel(schema, topic, encoding, facts)


def read_statistics(content: bytes) -> Statistics:
    """Return what a statistics record counts."""
    fields = Fields(content)
    messages, _, channels = fields.number(8), fields.number(2), fields.number(4)
    attachments, metadata, chunks = (fields.number(4) for _ in range(3))
    start, end, rest = fields.number(8), fields.number(8), Fields(fields.data())
    by_channel = {}
    while rest.more():
        channel = rest.number(2)
        by_channel[channel] = rest.number(8)
    others = attachments, metadata, chunks
    return Statistics(messages, channels, *others, start, end, by_channel)


def walk_records(file: BinaryIO, begin: int, end: int) -> Iterator[Record]:
    """Yield the records of a file from one byte to another, without what stands in them.

    Raises
    ------
    McapFault
        Where a record goes beyond the end.
    """
    while begin < end:
        file.seek(begin)
        head = file.read(RECORD.size)
        if len(head) < RECORD.size:
            raise McapFault(f'byte {begin}: the file ends in the head of a record')
        opcode, size = RECORD.unpack(head)
        if opcode == 0:
            raise McapFault(f'byte {begin}: 0, which begins no record')
        if begin + RECORD.size + size > end:
            raise McapFault(f'byte {begin}: a record of {size} bytes goes beyond the end')
        yield Record(opcode, begin + RECORD.size, size)
        begin += RECORD.size + size


def records_inside(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield the records of a chunk: opcode, where the content begins, where it ends."""
    place, end = 0, len(content)
    while place < end:
        if place + RECORD.size > end:
            raise McapFault('a chunk ends in the head of a record')
        opcode, size = RECORD.unpack_from(content, place)
        place += RECORD.size
        if place + size > end:
            raise McapFault('a record goes beyond the end of its chunk')
        if opcode == MESSAGE and size < MESSAGE_HEAD.size:
            raise McapFault(f'a message of {size} bytes')
        yield opcode, place, place + size
        place += size
