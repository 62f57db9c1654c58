# SPDX-License-Identifier: Apache-2.0
"""The lines of a file, as text."""

from __future__ import annotations

from codecs import BOM_UTF8
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from ...errors import RecordingError
from ..formats import HEAD, describe_refusal, foreign_content

LONGEST_LINE = 2**20  # bytes of a line, thousands of columns: no file is read as a single line


@contextmanager
def open_lines(path: Path) -> Iterator[tuple[Iterator[str], Callable[[], float]]]:
    """Give a file's lines, and a function that returns the share read so far, 0 to 1.

    A RecordingError in the block gets the path in front.
    """
    try:
        size = max(path.stat().st_size, 1)
        with path.open('rb') as file:
            foreign = foreign_content(path, file.peek(HEAD)[:HEAD])
            if foreign is not None:
                raise RecordingError(f' {describe_refusal(path, foreign)}')
            lines = decode_lines(iter(partial(file.readline, LONGEST_LINE), b''))
            yield lines, lambda: min(file.tell() / size, 1.0)
    except OSError as error:
        raise RecordingError(f'{path}: cannot be read: {error.strerror}') from None
    except RecordingError as error:
        raise RecordingError(f'{path}:{error}') from None


def decode_lines(lines: Iterator[bytes]) -> Iterator[str]:
    """Yield the lines as text, with their ends."""
    number = 0
    for number, line in enumerate(lines, 1):
        if len(line) == LONGEST_LINE:
            raise RecordingError(f'{number}: a line of {LONGEST_LINE} bytes or more; not a table?')
        try:
            yield (line.removeprefix(BOM_UTF8) if number == 1 else line).decode()
        except UnicodeDecodeError:
            raise RecordingError(f'{number}: not UTF-8; save the table as UTF-8') from None
    if not number:
        raise RecordingError('1: empty; a header and rows of numbers expected')
