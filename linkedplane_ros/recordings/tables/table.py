# SPDX-License-Identifier: Apache-2.0
"""A table of motion, read in chunks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from ...errors import RecordingError
from ...types import Floats
from .cells import parse_rows
from .columns import find_column, join_names
from .header import read_header
from .lines import open_lines

TIMES = ('time', 't', 'time_s', 'timestamp', 'time (s)')  # the first of them that is there


@dataclass(frozen=True)
class Table:
    """A table of motion: a column of times, and columns of numbers; its rows stay in the file."""

    path: Path
    columns: tuple[str, ...]
    """The names of all columns but the time, as the file has them."""
    time_column: str
    """The name of the time in the file."""
    head: tuple[str, ...]
    """The lines above the names."""

    @classmethod
    def from_file(cls, path: str | Path) -> Table:
        """Read the header only.

        Parameters
        ----------
        path
            An OpenSim .mot or .sto; any other file is CSV (RFC 4180) with a row of names, possibly
            after lines that start with #, and a comma, semicolon or tab between cells.

        Raises
        ------
        RecordingError
            If the header cannot be read, or names no time; the message names the line.
        """
        path = Path(path)
        with open_lines(path) as (lines, _):
            head, (line, names), _ = read_header(path, lines)
            candidates = (name for time in TIMES for name in names if name.lower() == time)
            time = next(candidates, None)
            if time is None:
                raise RecordingError(
                    f'{line}: names of columns expected, a time among them ({", ".join(TIMES)}); '
                    f'found {join_names(names)}'
                )
            k = find_column(line, names, time)
        return cls(path, (*names[:k], *names[k + 1 :]), time, tuple(head))

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
            (k,) s.
        values
            (k, n), in the file's order and units; NaN for nan, and for an empty cell of a CSV.
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
            _, (line, header), left = read_header(self.path, lines)
            places = [find_column(line, header, name) for name in (self.time_column, *names)]
            numbers = parse_rows(header, places, islice(left, rows))
            if not len(numbers):
                raise RecordingError(f'{line}: no rows of numbers after the names')
            while len(numbers):
                yield numbers[:, 0], numbers[:, 1:], share()
                numbers = parse_rows(header, places, islice(left, rows))
