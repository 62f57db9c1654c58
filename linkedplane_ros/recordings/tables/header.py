# SPDX-License-Identifier: Apache-2.0
"""What stands above the numbers of a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

from ...errors import RecordingError
from .cells import TableRow
from .dialect import csv_rows, opensim_rows

ROWS_LOOKED_AT = 100  # for an end of OpenSim's header


@dataclass(frozen=True, eq=False)
class Header:
    """The header of a table, and the rows below it."""

    lines: list[str]
    """Those above the names."""
    line: int
    """The number of the line of the names."""
    names: list[str]
    delimiter: str
    """Between the cells; empty for white space."""
    rows: Iterator[TableRow]

    def peek_rows(self, count: int) -> tuple[list[TableRow], Iterator[TableRow]]:
        """Return the first rows, at most count, and all rows from the first on."""
        first = list(islice(self.rows, count))
        return first, chain(first, self.rows)


def read_header(path: Path, lines: Iterator[str]) -> Header:
    """Read the header of a table, by the ending of its name: OpenSim's, or that of a CSV."""
    opensim = path.suffix.lower() in ('.mot', '.sto')
    head, delimiter, rows = opensim_rows(lines) if opensim else csv_rows(lines)
    line, names = next(rows, (max(len(head), 1), []))
    if not opensim and sum(map(bool, names)) < 4:  # as a time and three angles have
        rows = check_no_opensim(path, chain([(line, names)], rows))
        next(rows)
    return Header(head, line, [name.strip() for name in names], delimiter, rows)


def check_no_opensim(path: Path, rows: Iterator[TableRow]) -> Iterator[TableRow]:
    """Return the rows of a CSV; RecordingError if one of the first ends OpenSim's header."""
    first = list(islice(rows, ROWS_LOOKED_AT))
    for line, cells in first:
        if ''.join(cells).strip().lower() == 'endheader':
            raise RecordingError(
                f"{line}: 'endheader', as in OpenSim's tables; rename this {path.suffix} to .mot "
                'or .sto'
            )
    return chain(first, rows)
