# SPDX-License-Identifier: Apache-2.0
"""A table of motion, read in chunks."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from ...errors import RecordingError
from ...types import Floats
from .cells import parse_rows
from .columns import find_column
from .dialect import PADDING, has_decimal_commas
from .header import read_header
from .lines import open_lines
from .times import TimeColumns, find_time

ROWS_PROMISED = re.compile(r'(?:nRows|datarows)\s*[= \t]\s*([0-9]{1,15})', re.IGNORECASE)
FIRST_ROWS = 200  # by which the mark of decimals is found


@dataclass(frozen=True)
class Table:
    """A table of motion: a column of times, and columns of numbers; its rows stay in the file."""

    path: Path
    columns: tuple[str, ...]
    """The names of all columns but the time, as the file has them."""
    time: TimeColumns
    head: tuple[str, ...]
    """The lines above the names."""

    @classmethod
    def from_file(cls, path: str | Path, time: str | None = None) -> Table:
        """Read the header only.

        Parameters
        ----------
        path
            An OpenSim .mot or .sto; any other file is CSV (RFC 4180) with a row of names, possibly
            after lines that start with #, and a comma, semicolon or tab between cells.
        time
            The name of the time; None: one that it usually has.

        Raises
        ------
        RecordingError
            If the header cannot be read, or names no time; the message names the line.
        """
        path = Path(path)
        with open_lines(path) as (lines, _):
            header = read_header(path, lines)
            found = find_time(header.line, header.names, time)
        columns = tuple(name for name in header.names if name not in found.names)
        return cls(path, columns, found, tuple(header.lines))

    @property
    def promised_rows(self) -> int | None:
        """How many rows an OpenSim header says that there are; None where it does not say."""
        for line in self.head:
            if match := ROWS_PROMISED.fullmatch(line.strip(PADDING)):
                return int(match[1])
        return None

    def chunks(
        self, names: Sequence[str], rows: int = 10_000
    ) -> Iterator[tuple[Floats, Floats, float]]:
        """Yield the rows, k at a time.

        Parameters
        ----------
        names
            n columns; cells of others are not looked at.
        rows
            k; the last chunk may have fewer.

        Yields
        ------
        times
            (k,) s; of more digits than float64 has, where seconds since the epoch need them.
        values
            (k, n), in the file's order and units; NaN for a gap: nan and its spellings, and an
            empty cell of a CSV.
        share
            Of the file, read so far, 0 to 1.

        Raises
        ------
        RecordingError
            Where a row cannot be read; the message names the line.
        """
        if rows < 1:
            raise RecordingError(f'chunks of {rows} rows; at least 1 expected')
        with open_lines(self.path) as (lines, share):
            header = read_header(self.path, lines)
            places = [
                find_column(header.line, header.names, name) for name in (*self.time.names, *names)
            ]
            first, left = header.peek_rows(FIRST_ROWS)
            if not first:
                raise RecordingError(f'{header.line}: no rows of numbers after the names')
            comma, source = False, ''
            if header.delimiter != ',':
                comma = has_decimal_commas(first, places)
                source = f'as its first {FIRST_ROWS} rows show'
            m = len(self.time.names)
            while True:
                times, values = parse_rows(
                    header.names, m, places, islice(left, rows), comma, source
                )
                if not len(times):
                    return
                yield self.time.to_seconds(header.line, times), values, share()
