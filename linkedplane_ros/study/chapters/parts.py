# SPDX-License-Identifier: Apache-2.0
"""What a report is put together from: text, tables, pictures and animations."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ...drawing.markdown import markdown_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = str | int | float | None

UNITS = {'mm': 'mm', 'deg': 'deg', 'us': 'us', 's': 's'}  # what may end the name of a column
PLACES = 6  # decimals of a number in a file: nm, micro-degrees


@dataclass(frozen=True)
class TablePart:
    """A table: a CSV file for machines and, if it is shown, Markdown for people."""

    name: str
    """The file's, without its ending."""
    title: str
    columns: tuple[str, ...]
    """Names for machines; those of quantities end in _ and their unit: length_mm."""
    rows: Sequence[tuple[Cell, ...]]
    visible: bool = True
    """Whether the report has its rows, and not only a link to the file."""
    digits: int = 1
    """Decimals in the report."""

    def csv(self) -> str:
        """Return the file's text."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator='\n')
        writer.writerow(self.columns)
        writer.writerows([_exact(cell) for cell in row] for row in self.rows)
        return text.getvalue()

    def markdown(self) -> str:
        """Return the table as the report shows it."""
        numbers = [
            all(isinstance(row[k], (int, float, type(None))) for row in self.rows)
            for k in range(len(self.columns))
        ]
        return markdown_table(
            [column_heading(name) for name in self.columns],
            [[self._format(cell) for cell in row] for row in self.rows],
            ''.join('r' if each else 'l' for each in numbers),
        )

    def _format(self, cell: Cell) -> str:
        if isinstance(cell, float):
            text = f'{cell:.{self.digits}f}'
            return text.lstrip('-') if float(text) == 0.0 else text
        return '' if cell is None else str(cell)


@dataclass(frozen=True)
class PicturePart:
    """A figure, made when the report is written."""

    name: str
    """The file's, without its ending."""
    caption: str
    draw: Callable[[], Figure]


@dataclass(frozen=True)
class AnimationPart:
    """A GIF, made when the report is written."""

    name: str
    caption: str
    write: Callable[[Path], None]


Part = str | TablePart | PicturePart | AnimationPart
"""A string is a paragraph, or a list, of Markdown."""


@dataclass(frozen=True)
class Chapter:
    """A titled part of the report."""

    title: str
    parts: Sequence[Part]


def column_heading(name: str) -> str:
    """Return a column's name for people: 'length_mm' is 'length (mm)'."""
    words = name.split('_')
    if words[-1] in UNITS and len(words) > 1:
        return f'{" ".join(words[:-1])} ({UNITS[words[-1]]})'
    return ' '.join(words)


def _exact(cell: Cell) -> Cell:
    return round(cell, PLACES) + 0.0 if isinstance(cell, float) else cell
