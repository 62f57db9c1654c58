# SPDX-License-Identifier: Apache-2.0
"""Numbers in the cells of a table."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

import numpy as np

from ...errors import RecordingError
from ...types import Floats

TableRow = tuple[int, list[str]]  # the number of its line, its cells

NUMBER = re.compile(r'[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?')
EXACT_TIME = 1e6  # in any unit of time: float64 has nanoseconds of a smaller one in s
COMMENT = 'a comment among the rows? leave it out'
# of words of these characters, Python takes for a number what is one, and nan
PLAIN = b'0123456789+-.eE nNaA'
GAP = re.compile(
    r'|[+-]?nan(\(\w*\))?|[+-]?1[.,]#(qnan|snan|ind|nan)0*|n/?a|null|none'
    r'|#(n/a|num!|div/0!|value!|ref!|name\?|null!)',
    re.IGNORECASE,
)
INFINITE = re.compile(r'[+-]?(inf|infinity|∞|1[.,]#inf0*)', re.IGNORECASE)
CLOCK = re.compile(r'[0-9]{1,4}[-/.][0-9]{1,2}[-/.][0-9]{1,4}(?![0-9.])|[0-9]+:[0-9]+')
COMMA_TO_POINT = {ord(','): '.', ord('.'): '?'}  # a point is none, and no number then
UNIT = re.compile(
    r'[\[(]?(s|sec|seconds?|ms|us|ns|rad|radians?|deg|degrees?|°)[\])]?', re.IGNORECASE
)


def parse_rows(
    header: Sequence[str],
    times: int,
    places: Sequence[int],
    rows: Iterator[TableRow],
    comma: bool,
    source: str,
) -> tuple[Floats, Floats]:
    """Return the cells of k rows in n columns as numbers: times (k, m), and the rest (k, n - m).

    Parameters
    ----------
    header
        The names of all columns.
    times
        m: how many of the n columns, the first ones, are times and must be finite.
    places
        The n columns.
    rows
        The k rows.
    comma
        Whether commas stand before decimals, else points.
    source
        What shows this, for a message; empty: nothing else was possible.
    """
    lines: list[int] = []
    cells: list[str] = []  # in one list: one a row would be slow to hold
    for line, row in rows:
        if len(row) != len(header):
            hint = f'; {COMMENT}' if row[0].startswith('#') else ''
            raise RecordingError(
                f'{line}: {len(row)} cells; {len(header)}, as the names, expected{hint}'
            )
        lines.append(line)
        cells += [row[k] for k in places]
    n = len(places)
    flat = parse_cells(cells, comma)
    if flat is None:
        named = ((lines[i // n], header[places[i % n]], cell) for i, cell in enumerate(cells))
        flat = np.array([parse_number(*each, comma, source) for each in named])
    numbers = flat.reshape(len(lines), n)
    is_time = np.isfinite(numbers[:, :times])
    if not is_time.all():
        k, j = np.argwhere(~is_time)[0]
        cell = cells[n * k + j]
        raise RecordingError(f'{lines[k]}: its time is {cell!r}; a finite number expected')
    of_time = numbers[:, :times]
    if np.abs(of_time).max(initial=0.0) > EXACT_TIME:
        texts = [cell for k in range(0, len(cells), n) for cell in cells[k : k + times]]
        of_time = parse_exactly(texts, comma).reshape(-1, times)
    return of_time, numbers[:, times:]


def parse_exactly(cells: Sequence[str], comma: bool) -> Floats:
    """Return numbers as exact as the machine has them, of 64 bits or more where it can.

    Seconds since the epoch have nine digits behind the point; float64 has six of them.
    """
    plain = [cell.strip().replace(',', '.') if comma else cell.strip() for cell in cells]
    return np.array(plain, dtype=np.longdouble)  # type: ignore[return-value, unused-ignore]


def parse_cells(cells: list[str], comma: bool) -> Floats | None:
    """Return the numbers in cells; None if one of them is no number that is written plainly."""
    text = ''.join(cells)
    if comma:
        if '.' in text:
            return None
        cells = [cell.replace(',', '.') for cell in cells]
        text = text.replace(',', '.')
    if not text.isascii() or text.encode().translate(None, PLAIN):
        return None
    try:
        return np.array(cells, dtype=float)
    except ValueError:
        return None


def parse_number(line: int, name: str, cell: str, comma: bool = False, source: str = '') -> float:
    """Return the number in a cell; NaN for a gap, inf for what is infinite."""
    text = cell.strip()
    plain = text.translate(COMMA_TO_POINT) if comma else text
    if NUMBER.fullmatch(plain):
        return float(plain)
    if GAP.fullmatch(text):
        return math.nan
    if INFINITE.fullmatch(text):
        return -math.inf if text.startswith('-') else math.inf
    hint = 'one like -0,5 expected' if comma else 'one like -0.5 expected'
    if source and NUMBER.fullmatch(text.replace(',', '.')):
        hint += f': decimals have {"commas" if comma else "points"} in this table, {source}'
    if text.startswith('#'):
        hint = COMMENT
    elif CLOCK.match(text):
        hint = 'a date or a time of day? seconds as a plain number expected'
    elif UNIT.fullmatch(text):
        hint = (
            'a row of units? leave it out; --degrees or --radians, or names like flexion_deg, '
            'say the unit'
        )
    raise RecordingError(f'{line}: column {name!r}: {text[:40]!r} is not a number; {hint}')
