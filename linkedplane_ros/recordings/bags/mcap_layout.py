# SPDX-License-Identifier: Apache-2.0
"""Where everything stands in an MCAP file, and where the file is damaged.

Nothing depends on the indexes of the file: all records are walked through once, chunks unread, so
that a file without indexes, or with wrong ones, is read as any other; and one that its recorder
did not finish as far as it is whole. What is not whole is left out and named in `faults`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO, NamedTuple
from zlib import crc32

from .mcap_records import (
    ATTACHMENT,
    CHANNEL,
    CHUNK,
    CHUNK_HEAD,
    CRC_SIZE,
    DATA_END,
    FIRST_PRIVATE,
    FOOTER,
    FOOTER_SIZE,
    HEADER,
    MAGIC,
    MESSAGE,
    MESSAGE_HEAD,
    MESSAGE_INDEX,
    METADATA,
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
    walk_records,
)

SEGMENT_BYTES = 2**22  # of messages outside of chunks that are read at a time
BLOCK_BYTES = 2**20  # of a file whose CRC is computed


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


class McapLayout:
    """What was found on the walk through a file.

    Parameters
    ----------
    file
        The open file.

    Raises
    ------
    McapFault
        If it does not begin as an MCAP file does.
    """

    def __init__(self, file: BinaryIO) -> None:
        """Walk through the records."""
        self.faults: list[str] = []
        """What is damaged, a line each."""
        self.cut = ''
        """Why the walk ended before the footer; empty: it did not."""
        self.whole = len(MAGIC)
        """Where the last whole record of the data section ends."""
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.segments: list[Segment] = []
        self.attachments: list[Record] = []
        self.statistics: Statistics | None = None
        self.data_crc = 0
        """Of the data section; 0: not known."""
        self._summary: list[Record] = []
        self._data_end = self._metadata = 0
        self._file = file
        self.size = file.seek(0, 2)
        file.seek(0)
        if file.read(len(MAGIC)) != MAGIC:
            raise McapFault('not the beginning of an MCAP file')
        self._walk()

    def _walk(self) -> None:
        last = None
        for record in self._whole_records():
            if record.opcode == FOOTER and record.size == FOOTER_SIZE - RECORD.size:
                self._read_end(record)
                return
            if self._data_end:
                self._summary.append(record)
                continue
            try:
                self._take_record(record)
                last = record
            except McapFault as fault:
                self.faults.append(f'byte {record.offset - RECORD.size}: {fault}: left out')
                last = None
            self.whole = record.offset + record.size
        self.cut = self.cut or 'the file ends'
        if last is not None:
            self._leave_out_zeros(last)

    def _leave_out_zeros(self, last: Record) -> None:
        """Leave out a last record without a CRC where zeros begin in it or behind it.

        After a power cut a file has its size and its last blocks are zeros: only a CRC tells
        whether a record that ends in zeros is whole.
        """
        self._file.seek(self.whole - 1)
        if self._file.read(2) != bytes(2) or last.opcode not in (MESSAGE, CHUNK):
            return
        segment = self.segments.pop()
        if last.opcode == CHUNK and segment.crc:
            self.segments.append(segment)
            return
        self.whole = last.offset - RECORD.size
        if segment.size is None and segment.offset < self.whole:
            self.segments.append(segment._replace(length=self.whole - segment.offset))

    def _whole_records(self) -> Iterator[Record]:
        """Yield records up to the first that is not whole."""
        try:
            yield from walk_records(self._file, len(MAGIC), self.size)
        except McapFault as fault:
            self.cut = str(fault)

    def _take_record(self, record: Record) -> None:
        """Note a record of the data section."""
        opcode = record.opcode
        if opcode == MESSAGE:
            self._add_message(record)
        elif opcode == CHUNK:
            self._add_chunk(record)
        elif opcode == MESSAGE_INDEX:
            check_message_index(self._file.read(6), record.size)
        elif opcode == SCHEMA:
            self.schemas.update([read_schema(self._content(record))])
        elif opcode == CHANNEL:
            self.channels.update([read_channel(self._content(record))])
        elif opcode == ATTACHMENT:
            self.attachments.append(record)
        elif opcode == METADATA:
            self._metadata += 1
        elif opcode == DATA_END and record.size == CRC_SIZE:
            self.data_crc = Fields(self._content(record)).number(CRC_SIZE)
            self._data_end = record.offset + record.size
        elif opcode != HEADER and opcode < FIRST_PRIVATE:
            raise McapFault(f'a record 0x{opcode:02x} of {record.size} bytes among the data')

    def _content(self, record: Record) -> bytes:
        self._file.seek(record.offset)
        return self._file.read(record.size)

    def _add_message(self, record: Record) -> None:
        """Add a message outside of chunks: to the segment that it follows, or as a new one."""
        if record.size < MESSAGE_HEAD.size:
            raise McapFault(f'a message of {record.size} bytes')
        time = MESSAGE_HEAD.unpack(self._file.read(MESSAGE_HEAD.size))[2]
        begin, length = record.offset - RECORD.size, RECORD.size + record.size
        last = self.segments[-1] if self.segments else None
        if (
            last is not None
            and last.size is None
            and last.offset + last.length == begin
            and last.length < SEGMENT_BYTES
        ):
            start, end = min(last.start, time), max(last.end, time)
            self.segments[-1] = Segment(start, end, last.offset, last.length + length)
        else:
            self.segments.append(Segment(time, time, begin, length))

    def _add_chunk(self, record: Record) -> None:
        head = Fields(self._file.read(min(record.size, CHUNK_HEAD.size + 4 + 32 + 8)))
        start, end, size, crc = CHUNK_HEAD.unpack(head.raw(CHUNK_HEAD.size))
        compression, length = head.text(), head.number(8)
        offset = record.offset + CHUNK_HEAD.size + 4 + len(compression) + 8
        if offset + length > record.offset + record.size:
            raise McapFault(f'a chunk of {length} bytes in a record of {record.size}')
        self.segments.append(Segment(start, end, offset, length, compression, size, crc))

    def _read_end(self, footer: Record) -> None:
        """Read the footer, and the summary if it is as it was written."""
        end = footer.offset + footer.size
        self._file.seek(end)
        if self.size - end != len(MAGIC) or self._file.read() != MAGIC:
            self.faults.append(f'{self.size - end} bytes after its footer, where 8 end an MCAP')
        fields = Fields(self._content(footer))
        begin, _, crc = fields.number(8), fields.number(8), fields.number(CRC_SIZE)
        data_end = self._data_end or self.whole
        if begin != data_end and (begin or self._summary):
            self.faults.append(f'its footer has the summary at byte {begin}, it is at {data_end}')
        if crc and crc != self.compute_crc(data_end, end - CRC_SIZE):
            self.faults.append('the CRC of its summary is not that of its bytes: not used')
            return
        try:
            self._read_summary()
        except McapFault as fault:
            self.faults.append(f'its summary: {fault}: not used')
        self._check_counts()

    def _read_summary(self) -> None:
        for record in self._summary:
            if record.opcode == SCHEMA:
                self.schemas.update([read_schema(self._content(record))])
            elif record.opcode == CHANNEL:
                self.channels.update([read_channel(self._content(record))])
            elif record.opcode == STATISTICS:
                self.statistics = read_statistics(self._content(record))

    def _check_counts(self) -> None:
        """Compare the records that the summary counts with those that are there."""
        told = self.statistics
        if told is None:
            return
        chunks = sum(each.size is not None for each in self.segments)
        for name, count, there in (
            ('chunks', told.chunks, chunks),
            ('attachments', told.attachments, len(self.attachments)),
            ('metadata records', told.metadata, self._metadata),
        ):
            if count != there:
                self.faults.append(f'its summary counts {count} {name}, {there} are there')

    def compute_crc(self, begin: int, end: int) -> int:
        """Return the CRC of the file from one byte to another."""
        crc = 0
        self._file.seek(begin)
        while begin < end:
            block = self._file.read(min(BLOCK_BYTES, end - begin))
            crc = crc32(block, crc)
            begin += len(block) or end
        return crc

    def damaged_attachments(self) -> Iterator[int]:
        """Yield where attachments begin whose CRC is not that of their bytes."""
        for record in self.attachments:
            end = record.offset + record.size - CRC_SIZE
            self._file.seek(end)
            crc = int.from_bytes(self._file.read(CRC_SIZE), 'little')
            if crc and crc != self.compute_crc(record.offset, end):
                yield record.offset - RECORD.size

    def has_whole_data(self) -> bool:
        """Return whether the data section is as it was written, as far as its CRC tells."""
        end = self._data_end - CRC_SIZE - RECORD.size
        return not self.data_crc or self.data_crc == self.compute_crc(0, end)


def check_message_index(head: bytes, size: int) -> None:
    """Refuse an index whose entries do not fill its record."""
    if len(head) < 6 or int.from_bytes(head[2:], 'little') != size - 6:
        raise McapFault(f'a message index that does not fill its {size} bytes')
