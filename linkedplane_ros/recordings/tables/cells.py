# SPDX-License-Identifier: Apache-2.0
"""Numbers in the cells of a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...errors import RecordingError
from ...types import Floats

TableRow = tuple[int, list[str]]  # the number of its line, its cells


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
