"""The kinds of values that the commands take; argparse says in one line what is no such value."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable


def positive(text: str) -> float:
    """Return a number above zero, for argparse."""
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f'{text} given, a number > 0 expected')
    return value


def not_negative(text: str) -> float:
    """Return a finite number of zero or more, for argparse."""
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f'{text} given, a number >= 0 expected')
    return value


def finite(text: str) -> float:
    """Return a finite number, for argparse."""
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f'{text} given, a finite number expected')
    return value


def sign(text: str) -> float:
    """Return 1.0 or -1.0, for argparse."""
    value = float(text)
    if abs(value) != 1.0:
        raise argparse.ArgumentTypeError(f'{text} given, 1 or -1 expected')
    return value


def whole(least: int) -> Callable[[str], int]:
    """Return what takes a whole number of `least` or more, for argparse."""

    def number(text: str) -> int:
        value = int(text)
        if value < least:
            raise argparse.ArgumentTypeError(f'{text} given, {least} or more expected')
        return value

    return number


counting = whole(1)


def scalable(parser: argparse.ArgumentParser) -> None:
    """Declare --scale, of the commands that take a muscle at a subject's size."""
    parser.add_argument('--scale', default='1', metavar='SCALE',
                        help="the subject's size: a factor, 3 (x,y,z), 6 (the scapula's, then the "
                        "humerus's), or a .yaml file of measurements")  # fmt: skip
