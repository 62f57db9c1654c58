# SPDX-License-Identifier: Apache-2.0
"""Tables in Markdown, for reports and for the documentation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def markdown_table(
    columns: Sequence[str], rows: Iterable[Sequence[str]], align: str | None = None
) -> str:
    """Return a table in Markdown, without a line break at its end.

    Parameters
    ----------
    columns
        (c) the headings.
    rows
        c cells each; a `|` in one is escaped.
    align
        A letter for each column, l for left and r for right; None: all left.

    """
    rules = ['---:' if letter == 'r' else '---' for letter in align or 'l' * len(columns)]
    return '\n'.join(markdown_row(cells) for cells in (columns, rules, *rows))


def markdown_row(cells: Iterable[str]) -> str:
    """Return a line of a table."""
    escaped = (cell.replace('|', '\\|') for cell in cells)
    return '|' + ''.join(f' {cell} |' if cell else ' |' for cell in escaped)
