# SPDX-License-Identifier: Apache-2.0
"""The lines of a file, as text."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from io import BufferedReader
from pathlib import Path

from ...errors import RecordingError
from ...files import require_regular
from ..formats import HEAD, describe_refusal, foreign_content

MARK = '\ufeff'  # of UTF-8; some programs write it twice
LONGEST_LINE = 2**20  # bytes of a line, thousands of columns: no file is read as a single line


@contextmanager
def open_lines(path: Path) -> Iterator[tuple[Iterator[str], Callable[[], float]]]:
    """Give a file's lines, and a function that returns the share read so far, 0 to 1.

    A RecordingError in the block gets the path in front.
    """
    require_regular(path, RecordingError)
    try:
        size = max(path.stat().st_size, 1)
        with path.open('rb') as file:
            head = file.peek(HEAD)[:HEAD]
            foreign = foreign_content(path, head)
            if foreign is not None:
                raise RecordingError(f' {describe_refusal(path, foreign)}')
            yield decode_lines(split_lines(file, head)), lambda: min(file.tell() / size, 1.0)
    except OSError as error:
        raise RecordingError(f'{path}: cannot be read: {error.strerror}') from None
    except RecordingError as error:
        raise RecordingError(f'{path}:{error}') from None


def split_lines(file: BufferedReader, head: bytes) -> Iterator[bytes]:
    """Yield the lines of a file, which begins with head, with their ends.

    They end in a line feed; in a carriage return, where the head has those alone.
    """
    if head.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) or b'\0' in head:
        raise RecordingError(
            '1: UTF-16, or bytes that are zero; save the table as UTF-8 (in Excel: CSV UTF-8)'
        )
    if b'\r' in head[:-1] and b'\n' not in head:
        return split_at_returns(file)
    return iter(partial(file.readline, LONGEST_LINE), b'')


def split_at_returns(file: BufferedReader) -> Iterator[bytes]:
    """Yield the lines of a file that end in a carriage return, with their ends."""
    rest = b''
    while block := file.read(LONGEST_LINE):
        *lines, rest = (rest + block).split(b'\r')
        yield from (line + b'\r' for line in lines)
        if len(rest) >= LONGEST_LINE:
            break
    if rest:
        yield rest


def decode_lines(lines: Iterator[bytes]) -> Iterator[str]:
    """Yield the lines as text, with their ends: UTF-8, or else Latin-1.

    Only names and comments can differ between the two: a number is ASCII.
    """
    number = 0
    for number, line in enumerate(lines, 1):
        if len(line) >= LONGEST_LINE:
            raise RecordingError(f'{number}: a line of {LONGEST_LINE} bytes or more; not a table?')
        try:
            text = line.decode()
            yield text.lstrip(MARK) if number == 1 else text
        except UnicodeDecodeError:
            yield line.decode('latin-1')
    if not number:
        raise RecordingError('1: empty; a header and rows of numbers expected')
