# SPDX-License-Identifier: Apache-2.0
"""What stands above the numbers of a table: how its rows are cut, and the names."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from ...errors import RecordingError
from .cells import TableRow

QUOTED = re.compile(r'"[^"]*("|$)')


def read_header(path: Path, lines: Iterator[str]) -> tuple[list[str], TableRow, Iterator[TableRow]]:
    """Return the lines above the names, the row of names and the rows after it."""
    head: list[str] = []
    if path.suffix.lower() in ('.mot', '.sto'):
        rows = opensim_rows(lines, head)
    else:
        rows = csv_rows(lines, head)
    line, names = next(rows, (max(len(head), 1), []))
    return head, (line, [name.strip() for name in names]), rows


def opensim_rows(lines: Iterator[str], head: list[str]) -> Iterator[TableRow]:
    """Yield the rows after OpenSim's `endheader`; append the lines up to it to the head."""
    for text in lines:
        head.append(text)
        if text.strip().lower() == 'endheader':
            break
    else:
        raise RecordingError(
            f"{len(head)}: the file ends, but a line 'endheader' was expected before"
        )
    numbered = enumerate(lines, len(head) + 1)
    yield from ((n, cells) for n, row in numbered if (cells := row.split()))


def csv_rows(lines: Iterator[str], head: list[str]) -> Iterator[TableRow]:
    """Yield the rows of a CSV, its names first; append the lines above them to the head.

    The delimiter is the most frequent one in the names.
    """
    for text in lines:
        if text.strip() and not text.startswith('#'):
            break
        head.append(text)
    else:
        return
    before = len(head)
    delimiter = max(',;\t', key=QUOTED.sub('', text).count)
    reader = csv.reader(chain([text], lines), delimiter=delimiter, skipinitialspace=True)
    line = before + 1
    try:
        for cells in reader:
            if cells:
                yield line, cells
            line = before + reader.line_num + 1
    except csv.Error as error:
        raise RecordingError(f'{line}: not CSV: {error}') from None
