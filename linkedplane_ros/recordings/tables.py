# SPDX-License-Identifier: Apache-2.0
"""Motion tables as laboratories have them: OpenSim's .mot and .sto, and CSV, read in chunks."""

from __future__ import annotations

import csv
import re
from codecs import BOM_UTF8
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from itertools import chain, islice
from pathlib import Path

import numpy as np

from ..errors import RecordingError
from ..types import Floats

TableRow = tuple[int, list[str]]  # the number of its line, its cells

TIMES = ('time', 't', 'time_s', 'timestamp', 'time (s)')  # the first of them that is there
IN_DEGREES = re.compile(r'\s*inDegrees\s*=\s*(.*?)\s*', re.IGNORECASE)
QUOTED = re.compile(r'"[^"]*("|$)')
LONGEST_LINE = 2**20  # bytes of a line, thousands of columns: no file is read as a single line


@dataclass(frozen=True)
class Table:
    """A table of motion: a column of times, and columns of numbers; its rows stay in the file."""

    path: Path
    columns: tuple[str, ...]
    """The names of all columns but the time, as the file has them."""
    time_column: str
    """The name of the time in the file."""
    in_degrees: bool | None
    """What a .mot or .sto says by inDegrees; None where it says nothing, and for a CSV."""

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
            in_degrees, (line, names), _ = read_header(path, lines)
            candidates = (name for time in TIMES for name in names if name.lower() == time)
            time = next(candidates, None)
            if time is None:
                raise RecordingError(
                    f'{line}: names of columns expected, a time among them ({", ".join(TIMES)}); '
                    f'found {join_names(names)}'
                )
            k = find_column(line, names, time)
        return cls(path, (*names[:k], *names[k + 1 :]), time, in_degrees)

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


@contextmanager
def open_lines(path: Path) -> Iterator[tuple[Iterator[str], Callable[[], float]]]:
    """Give a file's lines, and a function that returns the share read so far, 0 to 1.

    A RecordingError in the block gets the path in front.
    """
    try:
        size = max(path.stat().st_size, 1)
        with path.open('rb') as file:
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


def find_column(line: int, header: Sequence[str], name: str) -> int:
    """Return the index of a column; RecordingError unless exactly one has the name."""
    if (count := header.count(name)) != 1:
        raise RecordingError(f'{line}: {count} columns are named {name!r}; one expected')
    return header.index(name)


def parse_rows(header: Sequence[str], places: Sequence[int], rows: Iterator[TableRow]) -> Floats:
    """Return the cells of k rows in n columns, the time's first, as numbers (k, n)."""
    lines: list[int] = []
    cells: list[str] = []  # in one list: one a row would be slow to hold
    for line, row in rows:
        if len(row) != len(header):
            raise RecordingError(f'{line}: {len(row)} cells; {len(header)}, as the names, expected')
        lines.append(line)
        cells += [row[k] for k in places]
    n = len(places)
    flat = parse_cells(cells)
    if flat is None:
        named = ((lines[i // n], header[places[i % n]], cell) for i, cell in enumerate(cells))
        flat = np.array([parse_number(*each) for each in named])
    numbers = flat.reshape(len(lines), n)
    is_time = np.isfinite(numbers[:, 0])
    if not is_time.all():
        k = int(np.argmin(is_time))
        raise RecordingError(f'{lines[k]}: its time is {cells[n * k]!r}; a finite number expected')
    return numbers


def parse_cells(cells: list[str]) -> Floats | None:
    """Return the numbers in cells; None if one is empty, or no number, or has an underscore."""
    if '_' in ''.join(cells):  # only Python takes 1_0 for ten
        return None
    try:
        return np.array(cells, dtype=float)
    except ValueError:
        return None


def parse_number(line: int, name: str, cell: str) -> float:
    """Return the number in a cell, NaN if it is empty."""
    text = cell.strip() or 'nan'
    try:
        return float(text.replace('_', '?'))
    except ValueError:
        raise RecordingError(
            f'{line}: column {name!r}: {text[:40]!r} is not a number; one like -0.5 expected'
        ) from None


def join_names(names: Sequence[str]) -> str:
    """Return the first twelve names in one line, each cut at 100 characters."""
    more = f' and {len(names) - 12} more' if len(names) > 12 else ''
    return (', '.join(' '.join(name.split())[:100] for name in names[:12]) or 'nothing') + more


def find_joint_columns(columns: Sequence[str], wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the column of each wanted joint.

    It has the joint's name, or else a path that ends with it, or with it and /value, as OpenSim's
    /jointset/shoulder/plane_elv/value does.

    Raises
    ------
    RecordingError
        Unless each joint has exactly one column.
    """
    candidates = {
        name: [column for column in columns if column == name]
        or [column for column in columns if f'/{column}'.endswith((f'/{name}', f'/{name}/value'))]
        for name in wanted
    }
    if missing := [name for name in candidates if not candidates[name]]:
        near = similar_columns(columns, missing)
        hint = f' (near: {join_names(near)})' if near else ''
        raise RecordingError(
            f'no column for {join_names(missing)}{hint}; the file has {join_names(columns)}'
        )
    if unclear := [name for name in candidates if len(candidates[name]) > 1]:
        several = candidates[unclear[0]]
        raise RecordingError(
            f'{len(several)} columns for {unclear[0]}: {join_names(several)}; one expected'
        )
    return tuple(candidates[name][0] for name in wanted)


def similar_columns(columns: Sequence[str], missing: Sequence[str]) -> list[str]:
    """Return the columns with a name similar to a missing one."""
    short = [column.lower().removesuffix('/value').rpartition('/')[2] for column in columns]
    close = chain.from_iterable(get_close_matches(name.lower(), short) for name in missing)
    return list(dict.fromkeys(columns[short.index(name)] for name in close))
