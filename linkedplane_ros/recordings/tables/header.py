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

IN_DEGREES = re.compile(r'\s*inDegrees\s*=\s*(.*?)\s*', re.IGNORECASE)
QUOTED = re.compile(r'"[^"]*("|$)')


def read_header(
    path: Path, lines: Iterator[str]
) -> tuple[bool | None, TableRow, Iterator[TableRow]]:
    """Return inDegrees, the row of names and the rows after it."""
    if path.suffix.lower() in ('.mot', '.sto'):
        line, in_degrees, rows = read_opensim_header(lines)
    else:
        line, in_degrees, rows = 1, None, csv_rows(lines)
    line, names = next(rows, (line, []))
    return in_degrees, (line, [name.strip() for name in names]), rows


def read_opensim_header(lines: Iterator[str]) -> tuple[int, bool | None, Iterator[TableRow]]:
    """Return the line of OpenSim's `endheader`, the value of inDegrees, and the rows after it."""
    numbered, line, in_degrees = enumerate(lines, 1), 0, None
    for line, text in numbered:
        if text.strip().lower() == 'endheader':
            return line, in_degrees, ((n, cells) for n, row in numbered if (cells := row.split()))
        if value := IN_DEGREES.fullmatch(text):
            if value[1].lower() not in ('yes', 'no'):
                raise RecordingError(f'{line}: inDegrees is {value[1]!r}; yes or no expected')
            in_degrees = value[1].lower() == 'yes'
    raise RecordingError(f"{line}: the file ends, but a line 'endheader' was expected before")


def csv_rows(lines: Iterator[str]) -> Iterator[TableRow]:
    """Yield the rows of a CSV, its names first; the delimiter is the most frequent one in those."""
    for before, text in enumerate(lines):  # noqa: B007
        if text.strip() and not text.startswith('#'):
            break
    else:
        return
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
