# SPDX-License-Identifier: Apache-2.0
"""metadata.yaml of a bag's folder, versions 1 to 9: the files of the bag, and what it counts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import yaml

from ...errors import RecordingError
from ...files import require_regular
from ..formats import BAGS, METADATA

BEFORE_FOLDERS = 4  # the version from which on paths are relative to the bag's folder


@dataclass(frozen=True)
class CountedTopic:
    """A topic as metadata.yaml has it."""

    topic: str
    type_name: str
    count: int
    type_hash: str


@dataclass(frozen=True)
class BagMetadata:
    """What metadata.yaml says of a bag."""

    files: tuple[Path, ...]
    """Where the files of the bag are."""
    topics: tuple[CountedTopic, ...]
    compression: str
    """'file' or 'message', what is compressed; empty: neither."""
    compression_format: str


def read_metadata(bag: Path) -> BagMetadata:
    """Return what a bag's folder says of it.

    Raises
    ------
    RecordingError
        If it has no metadata.yaml of rosbag2.
    """
    path = bag / METADATA
    require_regular(path, RecordingError)
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))['rosbag2_bagfile_information']
        version = int(content.get('version') or BEFORE_FOLDERS)
        names = [read_word(each) for each in content.get('relative_file_paths') or ()]
        topics = tuple(map(read_topic, content['topics_with_message_count'] or ()))
        mode = str(content.get('compression_mode') or '').lower()
        packed = str(content.get('compression_format') or '')
    except FileNotFoundError:
        inside = [each for each in sorted(bag.iterdir()) if each.suffix.lower() in BAGS]
        advice = f'; name {" or ".join(map(str, inside))}' if inside else ''
        raise RecordingError(f'{bag}: no {METADATA} in it{advice}') from None
    except OSError as error:
        raise RecordingError(f'{path}: cannot be read: {error.strerror}') from None
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError, yaml.YAMLError):
        raise RecordingError(f'{path}: not the metadata of a rosbag2') from None
    if mode in ('none', 'storage'):
        mode = ''
    if mode and (mode not in ('file', 'message') or packed != 'zstd'):
        raise RecordingError(f'{path}: compressed by {packed!r} ({mode}); zstd is read')
    files = tuple(locate_file(bag, name, version) for name in names)
    return BagMetadata(files, topics, mode, packed)


def read_topic(entry: Any) -> CountedTopic:
    """Return a topic of `topics_with_message_count`."""
    facts = entry['topic_metadata']
    type_hash = read_word(facts.get('type_description_hash') or '')
    name, type_name = read_word(facts['name']), read_word(facts['type'])
    return CountedTopic(name, type_name, int(entry['message_count']), type_hash)


def read_word(value: Any) -> str:
    """Return a value as text; TypeError for a list or a mapping, which aliases make endless."""
    if isinstance(value, (list, dict)):
        raise TypeError
    return str(value)


def locate_file(bag: Path, name: str, version: int) -> Path:
    """Return where a file of a bag is: where rosbag2 looks for it, else of its name in the folder.

    rosbag2 takes absolute paths as they are; before version 4, relative ones begin with the name of
    the bag's folder (`resolve_relative_paths` in its sequential_reader.cpp).
    """
    path = (bag.parent if version < BEFORE_FOLDERS else bag) / name
    if path.exists():
        return path
    windows = '\\' in name
    return bag / (PureWindowsPath(name) if windows else PurePosixPath(name)).name
