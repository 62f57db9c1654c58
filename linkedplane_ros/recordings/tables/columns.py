# SPDX-License-Identifier: Apache-2.0
"""The columns of a table, by their names."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from itertools import chain

from ...errors import RecordingError


def find_column(line: int, header: Sequence[str], name: str) -> int:
    """Return the index of a column; RecordingError unless exactly one has the name."""
    if (count := header.count(name)) != 1:
        raise RecordingError(f'{line}: {count} columns are named {name!r}; one expected')
    return header.index(name)


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
