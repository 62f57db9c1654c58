# SPDX-License-Identifier: Apache-2.0
"""How the rows of a table are cut into cells, and which mark stands before decimals."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from itertools import chain

from ...errors import RecordingError
from .cells import NUMBER, TableRow

DELIMITERS = {',': 'commas', ';': 'semicolons', '\t': 'tabs'}
PADDING = ',;" \t\r\n'  # what a spreadsheet leaves around the lines of a header
QUOTED = re.compile(r'"[^"]*("|$)')
SEPARATOR = re.compile(r'\s*"?sep=(.)"?[\r\n]*', re.IGNORECASE)  # for Excel, in the first line
THOUSANDS = re.compile(r'[+-]?[1-9][0-9]{0,2}(,[0-9]{3})+')


def csv_rows(lines: Iterator[str]) -> tuple[list[str], str, Iterator[TableRow]]:
    """Return the lines above the names of a CSV, its delimiter, and its rows, the names first.

    The delimiter is what a first line `sep=;` says, or else the most frequent one in the names.
    """
    head: list[str] = []
    delimiter = ''
    for text in lines:
        if not head and (separator := SEPARATOR.fullmatch(text)):
            delimiter = separator[1]
            if delimiter not in DELIMITERS:
                raise RecordingError(f'1: sep={delimiter}: a comma, semicolon or tab expected')
        elif text.strip() and not text.startswith('#'):
            before = len(head)
            delimiter = delimiter or find_delimiter(before + 1, text)
            return head, delimiter, split_rows(text, lines, before, delimiter)
        head.append(text)
    return head, delimiter, iter(())


def find_delimiter(line: int, names: str) -> str:
    """Return the delimiter in a row of names; RecordingError where two are as frequent."""
    bare = QUOTED.sub('', names)
    first, second, _ = sorted(DELIMITERS, key=bare.count, reverse=True)
    if 0 < bare.count(first) == bare.count(second):
        raise RecordingError(
            f'{line}: as many {DELIMITERS[first]} as {DELIMITERS[second]} between the names; '
            f'a first line sep={first} or sep={second} settles it'
        )
    return first


def split_rows(names: str, lines: Iterator[str], before: int, delimiter: str) -> Iterator[TableRow]:
    """Yield the rows of a CSV that are not empty, the names first.

    A quote that does not end is refused, but where cells have spaces behind their quotes, as the
    names show: those are not told apart.

    Parameters
    ----------
    names
        The line of the names.
    lines
        The lines after it.
    before
        How many lines there are before it.
    delimiter
        What stands between cells.
    """
    rows = csv.reader(
        chain([names], lines),
        delimiter=delimiter,
        skipinitialspace=True,
        strict='" ' not in names,
    )
    line = before + 1
    try:
        for cells in rows:
            if any(cells):
                yield line, cells
            line = before + rows.line_num + 1
    except csv.Error as error:
        raise RecordingError(f'{line}: not CSV: {error}') from None


def opensim_rows(lines: Iterator[str]) -> tuple[list[str], str, Iterator[TableRow]]:
    """Return OpenSim's header, the delimiter below it, and the rows, the names first.

    The delimiter is empty for white space. It is a comma or a semicolon where a spreadsheet has
    written the table again.
    """
    head: list[str] = []
    for text in lines:
        head.append(text)
        if text.strip(PADDING).lower() == 'endheader':
            break
    else:
        raise RecordingError(
            f"{len(head)}: the file ends, but a line 'endheader' was expected before"
        )
    for line, text in enumerate(lines, len(head) + 1):
        if text.strip():
            if '\t' not in text and (',' in text or ';' in text):
                delimiter = find_delimiter(line, text)
                return head, delimiter, split_rows(text, lines, line - 1, delimiter)
            numbered = enumerate(chain([text], lines), line)
            return head, '', ((n, cells) for n, row in numbered if (cells := row.split()))
    return head, '', iter(())


def has_decimal_commas(rows: Sequence[TableRow], places: Sequence[int]) -> bool:
    """Return whether the first rows of a table have commas before decimals.

    RecordingError where they can be read in two ways: with points, too, or with commas that may as
    well stand between thousands.
    """
    cells = [(line, row[k].strip()) for line, row in rows for k in places if k < len(row)]
    commas = [(line, cell) for line, cell in cells if NUMBER.fullmatch(cell.replace(',', ''))]
    commas = [(line, cell) for line, cell in commas if ',' in cell and '.' not in cell]
    if not commas:
        return False
    points = [(line, cell) for line, cell in cells if NUMBER.fullmatch(cell) and '.' in cell]
    line, cell = commas[0]
    if points:
        other, point = points[0]
        raise RecordingError(
            f'{line}: {cell!r} has a comma, {point!r} in line {other} a point; one mark of '
            'decimals expected, and none of thousands'
        )
    if all(THOUSANDS.fullmatch(cell) for _, cell in commas):
        raise RecordingError(
            f'{line}: {cell!r} can be read in two ways, with decimals or with thousands; save the '
            'table with decimal points'
        )
    return True
