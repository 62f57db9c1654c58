# SPDX-License-Identifier: Apache-2.0
"""The command lines of the executables: what is theirs, what is for ROS, how a mistake ends.

No ROS is needed here: `--help` answers without it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NoReturn

from ..errors import ArgumentError, LinkedPlaneError

ROS_ARGUMENTS = '--ros-args'


class ArgumentParser(argparse.ArgumentParser):
    """A parser that says in one line what is wrong; exit status 2."""

    def error(self, message: str) -> NoReturn:
        """End the process."""
        self.exit(2, f'{self.prog}: {message}; --help says what it takes\n')


def split_ros_arguments(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return an executable's own arguments, and those for ROS from the first `--ros-args` on."""
    own: list[str] = []
    ros: list[str] = []
    section = own
    for word in words:
        if word == ROS_ARGUMENTS:
            section = ros
        if section is ros and word == '--':  # it ends them
            section = own
            ros.append(word)
        else:
            section.append(word)
    return own, ros


@contextmanager
def mistakes_in_one_line(program: str) -> Iterator[None]:
    """End the process with one line for a user's mistake: status 2 for arguments, 1 for others."""
    try:
        yield
    except LinkedPlaneError as error:
        print(f'{program}: {error}', file=sys.stderr)
        sys.exit(exit_status(error))


def exit_status(error: ValueError) -> int:
    """Return the exit status for a mistake: 2 for arguments, 1 for others."""
    return 2 if isinstance(error, ArgumentError) else 1
