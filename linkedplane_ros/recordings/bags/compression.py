# SPDX-License-Identifier: Apache-2.0
"""Compressed bytes; what the rosbags library needs for it is there with it."""

from __future__ import annotations

import shutil
import sys
from importlib import import_module
from pathlib import Path
from typing import Any


def zstd_library() -> Any:
    """Return the library for zstd: Python's own from 3.14 on, else the one of rosbags."""
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd


def decompress(data: bytes, kind: str) -> bytes:
    """Return bytes decompressed; ValueError for an unknown compression, else the library's own."""
    if not kind:
        return data
    if kind == 'zstd':
        return bytes(zstd_library().decompress(data))
    if kind == 'lz4':
        lz4 = import_module('lz4.frame')  # has no types
        return bytes(lz4.decompress(data))
    raise ValueError(f'compressed by {kind!r}; zstd and lz4 are read')


def decompress_file(path: Path, target: Path) -> None:
    """Write a file of zstd decompressed."""
    with zstd_library().open(path, 'rb') as packed, target.open('wb') as file:
        shutil.copyfileobj(packed, file)
