# SPDX-License-Identifier: Apache-2.0
"""ROS with the arguments of a command line; what is wrong in them is one line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from typing import Any

import rclpy
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.exceptions import ParameterException
from rclpy.logging import LoggingSeverity, set_logger_level
from rclpy.node import Node
from rclpy.utilities import remove_ros_args

from ..errors import ArgumentError
from .interruption import end_on_hangup

SOURCE = re.compile(r',? at /\S+?:\d+')  # where in its own sources rcl found the fault
UNUSABLE = re.compile(r"Couldn't parse .+?: '(.*)'\. Error: (.*)")
EXPECTED = (  # what is in rcl's message, and what would be right
    ('Sequence should be of same type', 'a list of one type expected, as [1.0, 2.5]'),
    ('__node:=', "a node's name expected: letters, digits and '_'"),
    ('__ns:=', "a namespace expected: it starts with '/', then letters, digits, '_' and '/'"),
    ('remap rule', "FROM:=TO expected, of names with letters, digits, '_' and '/'"),
    ('parameter override rule', 'NAME:=VALUE expected, the value in YAML'),
    ('log level', 'debug, info, warn, error or fatal expected, or LOGGER:= and one of these'),
    ('opening YAML', 'a file that can be read expected'),
)


def initialise_ros(arguments: Sequence[str], **options: Any) -> None:
    """Initialise rclpy with the ROS arguments of a command line.

    Parameters
    ----------
    arguments
        From `--ros-args` on.
    options
        Further ones of `rclpy.init`.

    Raises
    ------
    ArgumentError
        It names the argument and what is expected.

    """
    check_ros_arguments(arguments)
    try:
        rclpy.init(args=list(arguments), **options)
    except RCLError as error:
        raise ArgumentError(explain_fault(str(error))) from None
    end_on_hangup()


def check_ros_arguments(arguments: Sequence[str]) -> None:
    """Raise an ArgumentError, as `initialise_ros`, for arguments that ROS cannot read."""
    set_logger_level('rcl', LoggingSeverity.FATAL)  # it logs what it also returns as an error
    try:
        remove_ros_args(arguments)
    except UnknownROSArgsError as error:
        raise ArgumentError(
            f'{str(error).strip("[]")} behind --ros-args: no argument of ROS; those of the '
            'executable itself stand before --ros-args'
        ) from None
    except RCLError as error:
        raise ArgumentError(explain_fault(str(error))) from None
    finally:
        set_logger_level('rcl', LoggingSeverity.UNSET)


def explain_fault(text: str) -> str:
    """Return one line for what rcl says of an argument that it cannot use."""
    line = ' '.join(SOURCE.sub('', text).split())
    found = UNUSABLE.search(line)
    if not found:
        return line.partition(': ')[2] or line
    argument, reason = found.groups()
    return f'{argument}: {next((right for word, right in EXPECTED if word in line), reason)}'


@contextmanager
def argument_errors() -> Iterator[None]:
    """Turn what rclpy raises for wrong arguments, while a node is created, into ArgumentErrors."""
    try:
        yield
    except ParameterException as error:
        raise ArgumentError(describe_parameter_fault(error)) from None
    except RCLError as error:
        if not rclpy.ok():  # a signal came in the middle of a call
            raise
        raise ArgumentError(explain_fault(str(error))) from None


def describe_parameter_fault(error: ParameterException) -> str:
    """Return what rclpy says of a parameter, without the parameter's name that it appends."""
    return str(error).rpartition(': ')[0]


def warn_of_unknown_parameters(node: Node) -> None:
    """Log in one line the parameters that were given to a node and that it does not have."""
    known = node.list_parameters([], 0).names
    unknown = []
    for name in sorted(set(node._parameter_overrides) - set(known)):
        near = get_close_matches(name, known, 1)
        unknown.append(f'{name} (did you mean {near[0]}?)' if near else name)
    if unknown:
        node.get_logger().warning(f'given, but no parameter of this node: {", ".join(unknown)}')
