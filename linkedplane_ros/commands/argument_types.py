# SPDX-License-Identifier: Apache-2.0
"""The kinds of values that the commands take; argparse says in one line what is no such value."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

from ..joints.sides import SIDES


def positive_number(text: str) -> float:
    """Return a finite number above zero, for argparse."""
    return _number(text, lambda value: 0.0 < value < math.inf, 'a number > 0')


def non_negative_number(text: str) -> float:
    """Return a finite number of zero or more, for argparse."""
    return _number(text, lambda value: 0.0 <= value < math.inf, 'a number >= 0')


def finite_number(text: str) -> float:
    """Return a finite number, for argparse."""
    return _number(text, math.isfinite, 'a finite number')


def sign(text: str) -> float:
    """Return 1.0 or -1.0, for argparse."""
    return _number(text, lambda value: abs(value) == 1.0, '1 or -1')


def number_or_still(text: str) -> float | str:
    """Return a finite number or the word still, for argparse."""
    if text == 'still':
        return text
    return _number(text, math.isfinite, 'a finite number or the word still')


def _number(text: str, is_valid: Callable[[float], bool], expected: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not is_valid(value):
        raise argparse.ArgumentTypeError(f'{text!r} given, {expected} expected')
    return value


def whole_number_from(least: int) -> Callable[[str], int]:
    """Return a type for argparse: whole numbers of `least` or more."""

    def whole_number(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f'{text!r} given, a whole number >= {least} expected')
        return value

    return whole_number


positive_count = whole_number_from(1)


def add_muscle(parser: argparse._ActionsContainer) -> None:
    """Declare --muscle, of the commands that take a model."""
    parser.add_argument('--muscle', default='deltoid', metavar='MODEL',
                        help='a bundled model or a .yaml file (default: %(default)s)')  # fmt: skip


def add_scale(parser: argparse._ActionsContainer) -> None:
    """Declare --scale, of the commands that take a muscle at a subject's size."""
    parser.add_argument('--scale', default='1', metavar='SCALE',
                        help="the subject's size against the model's: one factor, 3 factors x,y,z, "
                        "6 factors (the scapula's, then the humerus's), or a .yaml file of "
                        'measurements (default: %(default)s)')  # fmt: skip


def add_side(parser: argparse._ActionsContainer) -> None:
    """Declare --side, of the commands that solve."""
    parser.add_argument('--side', choices=SIDES, default='right',
                        help='which shoulder (default: %(default)s)')  # fmt: skip
