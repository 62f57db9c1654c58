# SPDX-License-Identifier: Apache-2.0
"""What is raised for a user's mistake: each kind of fault has its class, all have one base."""

from __future__ import annotations

import re
import reprlib
from typing import Any

LONGEST = 100  # characters of a value in a message
LONGEST_WORD, LONGEST_LINE = 1024, 8192  # of a line for a terminal
LONG_WORD = re.compile(rf'(\S{{{LONGEST_WORD}}})\S+')


class LinkedPlaneError(ValueError):
    """Whatever this package refuses; the message names what, where and what is expected."""


class ModelError(LinkedPlaneError):
    """A model that cannot be used; the message names the file or field, the key, the reason."""


class RecordingError(LinkedPlaneError):
    """A recording that cannot be read; the message names the file and the reason."""


class SkeletonError(LinkedPlaneError):
    """A URDF that cannot be used; the message names the file, the joint or link, the reason."""


class ArgumentError(LinkedPlaneError):
    """An argument of a command line that cannot be used; it ends an executable with status 2."""


class FieldError(ModelError):
    """A field that a model cannot have; the reader of a file names its key instead."""

    def __init__(self, field: str, reason: str, owner: str = '') -> None:
        """Keep the parts of the message: `owner` is the part of a model that has the field."""
        super().__init__(field, reason, owner)
        self.field, self.reason, self.owner = field, reason, owner

    def __str__(self) -> str:
        return f'{self.owner}: {self.field}: {self.reason}'.removeprefix(': ')


class _Shortener(reprlib.Repr):
    """Looks at no more of a value than a message shows: it may be large, or nested without end."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 4
        self.maxtuple = self.maxlist = self.maxdict = self.maxset = LONGEST
        self.maxfrozenset = self.maxarray = self.maxdeque = LONGEST
        self.maxstring = self.maxother = 10 * LONGEST

    def repr1(self, x: Any, level: int) -> str:
        """Return a value's text, NumPy's arrays and numbers as plain ones."""
        return super().repr1(x.tolist() if hasattr(x, 'tolist') else x, level)

    def repr_int(self, x: int, level: int) -> str:
        """Return a whole number, or how long it is: Python refuses to write very long ones."""
        return repr(x) if x.bit_length() < 8 * LONGEST else f'<{x.bit_length()} bits>'


SHORTENER = _Shortener()


def describe_value(value: Any) -> str:
    """Return a value as messages show it: in one line, NumPy's arrays and numbers as plain ones."""
    text = ' '.join(SHORTENER.repr(value).split())
    return text if len(text) <= LONGEST else f'{text[: LONGEST - 3]}...'


def escape_controls(text: str) -> str:
    """Return a message as one line: what does not print, as a line's end, is escaped.

    A word longer than a path, and a line longer than a page, are cut: names of others may be so.
    """
    if not text.isprintable():
        text = ''.join(each if each.isprintable() else repr(each)[1:-1] for each in text)
    if len(text) > LONGEST_WORD:
        text = LONG_WORD.sub(r'\1...', text)[:LONGEST_LINE]
    return text


def as_plain(value: Any) -> Any:
    """Return a value with lists and numbers of Python in place of NumPy's."""
    if type(value) in (list, tuple):
        return type(value)(map(as_plain, value))
    return value.tolist() if hasattr(value, 'tolist') else value
