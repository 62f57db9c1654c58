# SPDX-License-Identifier: Apache-2.0
"""An open bag: its files as one, and what is missing in them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Protocol

from ...errors import RecordingError
from ...files import require_regular
from ..formats import BAGS, METADATA
from .compression import decompress, decompress_file
from .connections import CDR, TYPE_HASH, Connection, RecordedMessage
from .mcap_file import McapFile
from .mcap_records import MAGIC
from .messages import MessageReader
from .metadata import BagMetadata, read_metadata
from .sqlite_file import SqliteFile

SQLITE_MAGIC = b'SQLite format 3\0'
EVER = -(2**63)  # ns: before any message
ROS1 = 'ros1'  # a serialization in MCAP files


class BagFile(Protocol):
    """An open file of a bag."""

    path: Path
    storage: str
    """mcap or sqlite3"""
    connections: dict[int, Connection]
    strays: Counter[str]
    faults: list[str]
    """What is damaged and was left out, a line each; some is met only as messages are read."""
    message_count: int
    start: int
    end: int

    def messages(self, wanted: dict[int, Connection], begin: int) -> Iterator[RecordedMessage]:
        """Yield messages in the order of time."""

    def check(self) -> None:
        """Look for damage that reading the messages does not meet.

        RecordingError where a message may be another than was written.
        """

    def close(self) -> None:
        """Close the file."""


class Loss(NamedTuple):
    """Messages that a bag should have, and that were not read."""

    topic: str
    """Empty: of no topic."""
    reason: str
    number: int
    where: str


class Bag:
    """An open bag.

    Parameters
    ----------
    path
        Its folder, or one of its files.
    reader
        What makes messages of bytes.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """

    def __init__(self, path: Path, reader: MessageReader) -> None:
        """Open all its files."""
        self.path = path
        self._reader = reader
        self._stack = ExitStack()
        self._metadata: BagMetadata | None = None
        self._read: Counter[str] = Counter()  # messages, by topic
        try:
            self._files = self._open_files()
        except BaseException:
            self.close()
            raise
        self.connections, self._merged = self._merge_connections()
        self.storage: str = self._files[0].storage
        filled = [each for each in self._files if each.message_count]
        self.message_count = sum(each.message_count for each in filled)
        self.start_time = min((each.start for each in filled), default=0)
        self.end_time = max((each.end + 1 for each in filled), default=0)

    def _open_files(self) -> list[BagFile]:
        if not self.path.is_dir():
            return [self._open_file(self.path)]
        self._metadata = read_metadata(self.path)
        paths = self._metadata.files
        if not paths:
            raise RecordingError(f'{self.path / METADATA}: no file listed in it')
        for path in paths:
            if not path.is_file():
                raise RecordingError(
                    f'{self.path}: {path.name} is listed in {METADATA} and not there; the '
                    'other files can be processed one by one'
                )
        if self._metadata.compression == 'file':
            folder = Path(self._stack.enter_context(TemporaryDirectory(prefix='linkedplane_')))
            paths = tuple(self._decompress_file(each, folder) for each in paths)
        return [self._open_file(each) for each in paths]

    @staticmethod
    def _decompress_file(path: Path, folder: Path) -> Path:
        try:
            decompress_file(path, folder / path.stem)
        except Exception as error:  # the library's own
            raise RecordingError(f'{path}: damaged: {error}') from None
        return folder / path.stem

    def _open_file(self, path: Path) -> BagFile:
        """Open a file by what stands in it: a name or a `storage_identifier` may be wrong."""
        require_regular(path, RecordingError)
        with path.open('rb') as file:
            begin = file.read(len(SQLITE_MAGIC))
        opened: BagFile
        if begin.startswith(MAGIC):
            opened = McapFile(path)
        elif begin == SQLITE_MAGIC:
            opened = SqliteFile(path)
        else:
            raise RecordingError(f'{path}: not a readable rosbag2: neither MCAP nor SQLite')
        self._stack.callback(opened.close)
        return opened

    def _merge_connections(self) -> tuple[list[Connection], list[dict[int, Connection]]]:
        """Return the topics of the bag, the same ones once; and by the numbers of each file."""
        merged: dict[object, Connection] = {}
        keys: list[dict[int, object]] = []
        hashes = {
            (each.topic, each.type_name): each.type_hash
            for each in (self._metadata.topics if self._metadata else ())
        }
        for file in self._files:
            numbers: dict[int, object] = {}
            for number, each in file.connections.items():
                facts = dict(each.facts)
                type_hash = hashes.get((each.topic, each.type_name))
                if type_hash and not facts.get(TYPE_HASH):
                    facts[TYPE_HASH] = type_hash
                head = each.topic, each.type_name, each.definition, each.serialization
                key = (*head, *sorted(facts.items()))
                before = merged.get(key)
                count = each.msgcount + (before.msgcount if before else 0)
                place = before.id if before else len(merged)
                merged[key] = replace(each, id=place, facts=facts, msgcount=count)
                numbers[number] = key
            keys.append(numbers)
        by_file = [{number: merged[key] for number, key in each.items()} for each in keys]
        return list(merged.values()), by_file

    def is_of_ros1(self) -> bool:
        """Return whether its messages are those of ROS 1."""
        serializations = {each.serialization for each in self.connections}
        return ROS1 in serializations and CDR not in serializations

    def messages(
        self, chosen: Collection[Connection] | None = None, start: int = EVER
    ) -> Iterator[RecordedMessage]:
        """Yield messages: file by file, in each in the order of time.

        Parameters
        ----------
        chosen
            Of which topics; None: of all.
        start
            The first time, ns since the epoch.

        Raises
        ------
        RecordingError
            Where the bag is damaged.
        """
        packed = self._metadata is not None and self._metadata.compression == 'message'
        ids = {each.id for each in (self.connections if chosen is None else chosen)}
        for file, numbers in zip(self._files, self._merged, strict=True):
            wanted = {number: each for number, each in numbers.items() if each.id in ids}
            for message in file.messages(wanted, start):
                self._read[message.connection.topic] += 1
                yield self._unpack(message) if packed else message

    def _unpack(self, message: RecordedMessage) -> RecordedMessage:
        """Return a message that is compressed by itself as it was before."""
        try:
            return message._replace(data=decompress(message.data, 'zstd'))
        except Exception as error:  # the library's own
            raise RecordingError(f'{self.path}: damaged: {error}') from None

    def read_message(self, connection: Connection, data: bytes) -> Any:
        """Return a message from its bytes; DamagedMessage if they are not one of its type."""
        return self._reader.read_message(connection, data)

    @property
    def faults(self) -> list[str]:
        """What is damaged and was left out as far as it was read, a line each."""
        inside = self._metadata is not None
        return [
            f'{file.path.name}: {fault}' if inside else fault
            for file in self._files
            for fault in file.faults
        ]

    def check(self) -> None:
        """Look for damage that was not met, after all messages have been read.

        Raises
        ------
        RecordingError
            Where a message may be another than was written.
        """
        for file in self._files:
            file.check()

    def require_whole(self) -> None:
        """Refuse a bag of which something was left out as it was read.

        Raises
        ------
        RecordingError
            With the first fault.
        """
        self.check()
        if self.faults:
            raise RecordingError(f'{self.path}: damaged: {self.faults[0]}')

    def losses(self) -> Iterator[Loss]:
        """Yield what is missing, after all messages have been read."""
        counted: Counter[str] = Counter()
        for each in self.connections:
            counted[each.topic] += each.msgcount
        listed = self._listed()
        unlisted = list(self._unlisted(self._metadata.files)) if self._metadata else []
        beside: Counter[str] = Counter()  # messages that are there, in files that are not listed
        for loss in unlisted:
            beside[loss.topic] += loss.number
        for topic in dict.fromkeys((*counted, *listed)):
            read, of_files = self._read[topic], counted[topic]
            of_metadata = listed[topic] - beside[topic]
            counter = METADATA if of_metadata > of_files else 'its summary'
            lost = max(of_files, of_metadata) - read
            if lost > 0:
                count = listed[topic] if of_metadata > of_files else of_files
                there = count - lost
                where = f'{topic}: {counter} counts {count:,}, {there:,} are there'
                yield Loss(topic, 'missing', lost, where)
        yield from unlisted
        for file in self._files:
            for where, count in file.strays.items():
                yield Loss('', 'no_topic', count, where)

    def surpluses(self) -> Iterator[str]:
        """Yield a line for each topic with more messages than metadata.yaml counts."""
        for topic, count in self._listed().items():
            if self._read[topic] > count:
                read = f'{self._read[topic]:,} are there'
                yield f'{METADATA} counts {count:,} on {topic}, {read}: all are read'

    def _listed(self) -> Counter[str]:
        """Return how many messages metadata.yaml counts, by topic."""
        listed: Counter[str] = Counter()
        for each in self._metadata.topics if self._metadata else ():
            listed[each.topic] += each.count
        return listed

    def _unlisted(self, listed: Collection[Path]) -> Iterator[Loss]:
        """Yield what the folder's files hold that metadata.yaml does not list."""
        names = {each.name for each in listed}
        for path in sorted(self.path.iterdir()):
            if path.suffix not in BAGS or path.name in names:
                continue
            where = f'{path.name}, which {METADATA} does not list'
            try:
                file = self._open_file(path)
            except RecordingError:
                yield Loss('', 'unlisted', 1, where)
                continue
            for each in file.connections.values():
                if each.msgcount:
                    yield Loss(each.topic, 'unlisted', each.msgcount, where)

    def close(self) -> None:
        """Close all files."""
        self._stack.close()
