# SPDX-License-Identifier: Apache-2.0
"""What a path model is made of: each kind of field with its check, and its numbers for kernels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from ..errors import describe_value

Bone = Literal['scapula', 'humerus']
Turn = Literal['right-handed', 'left-handed', 'shorter']

ON_HUMERUS = {'scapula': 0.0, 'humerus': 1.0}
TURNS = {'right-handed': 1.0, 'left-handed': -1.0, 'shorter': 0.0}


class Kind(NamedTuple):
    """A kind of field."""

    fits: Callable[[Any], bool]
    expected: str
    numbers: Callable[[Any], tuple[float, ...]]


def is_point(value: Any) -> bool:
    """Return whether a value is three finite numbers."""
    return len(value) == 3 and all(map(math.isfinite, value))


def is_axis(value: Any) -> bool:
    """Return whether a value is a direction: three finite numbers, not all 0."""
    return len(value) == 3 and 0.0 < math.hypot(*value) < math.inf


def unit_axis(axis: Any) -> tuple[float, ...]:
    """Return a direction at length 1."""
    size = math.hypot(*axis)
    return tuple(x / size for x in axis)


POINT = Kind(is_point, '3 finite numbers in m', tuple)
AXIS = Kind(is_axis, '3 finite numbers, not all 0,', unit_axis)
RADIUS = Kind(lambda value: 0.0 < value < math.inf, 'a finite length > 0 in m', lambda r: (r,))
BONE = Kind(ON_HUMERUS.__contains__, "'scapula' or 'humerus'", lambda bone: (ON_HUMERUS[bone],))
TURN = Kind(TURNS.__contains__, f'one of {", ".join(TURNS)}', lambda turn: (TURNS[turn],))
KINDS = {
    'origin': POINT,
    'insertion': POINT,
    'centre': POINT,
    'axis': AXIS,
    'radius': RADIUS,
    'bone': BONE,
    'turn': TURN,
    'on_scapula': POINT,
    'on_humerus': POINT,
}
"""By the names of fields."""


def field_kind(name: str) -> Kind:
    """Return the kind of `centre`, of `second_centre`, of `on_scapula[2]`."""
    return KINDS[name.removeprefix('second_').partition('[')[0]]


def field_fault(name: str, value: Any) -> str:
    """Return what is wrong with the value of a field; empty if nothing is."""
    kind = field_kind(name)
    try:
        fits = kind.fits(value)
    except TypeError:
        fits = False
    return '' if fits else f'{name}: {describe_value(value)} given, {kind.expected} expected'
