# SPDX-License-Identifier: Apache-2.0
"""Names of others, as they are shown: one line, not too long, and harmless in HTML.

Names of bands and coordinates come from labels of messages, names of muscles and nodes from the
graph: anybody on the network may choose them.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ..errors import escape_controls

LONGEST_NAME = 40  # characters: what a panel has room for


def short_name(text: str, longest: int = LONGEST_NAME) -> str:
    """Return a name in one line; the middle of a long one is left out."""
    text = escape_controls(text)
    if len(text) <= longest:
        return text
    half = (longest - 1) // 2
    return f'{text[:half]}…{text[-half:]}'


def html_name(text: str) -> str:
    """Return a name as HTML shows it."""
    return escape(short_name(text))


def distinct_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return short names that differ; those that would not have their number behind them."""
    short = [short_name(name) for name in names]
    return tuple(
        f'{name} {i + 1}' if short.count(name) > 1 else name for i, name in enumerate(short)
    )
