# SPDX-License-Identifier: Apache-2.0
"""The columns of a table, by their names."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from itertools import chain

from ...errors import RecordingError
from ..units import split_unit


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
    /jointset/shoulder/plane_elv/value does. A unit may stand behind the name, as in flexion_deg;
    where all joints have columns in several units, those in radians are taken, then degrees.

    Raises
    ------
    RecordingError
        Unless each joint has exactly one column.
    """
    split = [(column, *split_unit(column)) for column in columns]
    plain = [(column, column) for column in columns]
    radians = [(column, stem) for column, stem, unit in split if unit is False]
    degrees = [(column, stem) for column, stem, unit in split if unit is True]
    for labels in (radians, degrees, plain):
        candidates = {name: matching_columns(labels, name) for name in wanted}
        if all(candidates.values()):
            break
    else:  # in different units, or some with and some without one
        either = [*plain, *radians, *degrees]
        candidates = {name: matching_columns(either, name) for name in wanted}
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


def matching_columns(labels: Sequence[tuple[str, str]], name: str) -> list[str]:
    """Return the columns whose label, the second of a pair, is a joint's name or path."""
    return [column for column, label in labels if label == name] or [
        column for column, label in labels if f'/{label}'.endswith((f'/{name}', f'/{name}/value'))
    ]


def similar_columns(columns: Sequence[str], missing: Sequence[str]) -> list[str]:
    """Return the columns with a name similar to a missing one."""
    short = [column.lower().removesuffix('/value').rpartition('/')[2] for column in columns]
    close = chain.from_iterable(get_close_matches(name.lower(), short) for name in missing)
    return list(dict.fromkeys(columns[short.index(name)] for name in close))
