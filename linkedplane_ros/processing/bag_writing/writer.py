# SPDX-License-Identifier: Apache-2.0
"""A bag that is written: its folder, its one file, and metadata.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

import yaml

from ...recordings.formats import METADATA
from .mcap import McapWriter
from .sqlite import SqliteWriter
from .topic_facts import WrittenTopic, parse_qos

VERSION = 9  # of metadata.yaml


class FileWriter(Protocol):
    """Writes the one file of a bag."""

    path: Path

    def add_topic(self, number: int, topic: WrittenTopic) -> None:
        """Add a topic, under a number that is not used yet."""

    def write(self, number: int, time: int, data: bytes, sent: int, sequence: int) -> None:
        """Append a message to a topic."""

    def finish(self, version: int, metadata: str) -> None:
        """Complete the file."""

    def close(self) -> None:
        """Close the file, complete or not."""


class BagWriter:
    """Writes a bag.

    Parameters
    ----------
    path
        The folder to be made.
    storage
        mcap or sqlite3.
    facts
        What the bag says of itself.
    """

    def __init__(self, path: Path, storage: str, facts: Mapping[str, str]) -> None:
        """Make the folder and open its file."""
        path.mkdir(parents=True)
        make_file = McapWriter if storage == 'mcap' else SqliteWriter
        self._path, self._storage, self._facts = path, storage, dict(facts)
        self._file: FileWriter = make_file(path / path.name)
        self._topics: list[WrittenTopic] = []
        self._counts: list[int] = []
        self._start, self._end = 2**63 - 1, 0

    def add_topic(self, topic: WrittenTopic) -> int:
        """Add a topic and return its number."""
        self._topics.append(topic)
        self._counts.append(0)
        self._file.add_topic(len(self._topics), topic)
        return len(self._topics)

    def write(
        self, number: int, time: int, data: bytes, sent: int | None = None, sequence: int = 0
    ) -> None:
        """Append a message, recorded and sent at times in ns since the epoch, to a topic."""
        self._file.write(number, time, data, time if sent is None else sent, sequence)
        self._counts[number - 1] += 1
        self._start = min(self._start, time)
        self._end = max(self._end, time)

    def finish(self) -> None:
        """Complete the file and write metadata.yaml."""
        metadata = self._metadata()
        try:
            self._file.finish(VERSION, format_metadata(metadata))
        finally:
            with suppress(OSError):  # what it could not write was raised by then
                self._file.close()
        text = format_metadata({'rosbag2_bagfile_information': metadata})
        (self._path / METADATA).write_text(text, encoding='utf-8')

    def _metadata(self) -> dict[str, Any]:
        count = sum(self._counts)
        start, name = max(0, self._start if count else 0), self._file.path.name  # no less: rosbag2
        times = {
            'starting_time': {'nanoseconds_since_epoch': start},
            'duration': {'nanoseconds': max(0, self._end - start)},
            'message_count': count,
        }
        return {
            'version': VERSION,
            'storage_identifier': self._storage,
            'relative_file_paths': [name],
            **times,
            'topics_with_message_count': [
                {'topic_metadata': topic_metadata(topic), 'message_count': number}
                for topic, number in zip(self._topics, self._counts, strict=True)
            ],
            'compression_format': '',
            'compression_mode': '',
            'files': [{'path': name, **times}],
            'custom_data': self._facts,
            'ros_distro': 'jazzy',
        }


def topic_metadata(topic: WrittenTopic) -> dict[str, Any]:
    """Return what metadata.yaml says of a topic."""
    return {
        'name': topic.topic,
        'type': topic.type_name,
        'serialization_format': topic.serialization,
        'offered_qos_profiles': parse_qos(topic.qos),
        'type_description_hash': topic.type_hash,
    }


def format_metadata(content: Any) -> str:
    """Return YAML with one line an entry."""
    return str(yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=10**6))
