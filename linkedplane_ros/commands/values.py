"""The kinds of values that the commands take; argparse says in one line what is no such value."""

from __future__ import annotations

import argparse
import math


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


def sign(text: str) -> float:
    """Return 1.0 or -1.0, for argparse."""
    value = float(text)
    if abs(value) != 1.0:
        raise argparse.ArgumentTypeError(f'{text} given, 1 or -1 expected')
    return value


def counting(text: str) -> int:
    """Return a whole number of one or more, for argparse."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f'{text} given, 1 or more expected')
    return value
