# SPDX-License-Identifier: Apache-2.0
"""The command `linkedplane`, assembled from the modules of `commands`.

Exit status: 0 done, 1 the input is at fault (one line on stderr says what and where), 2 usage.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from decimal import Decimal
from importlib import import_module

from .. import __version__
from ..errors import escape_controls
from ..node.command_line import exit_status, split_ros_arguments

COMMANDS = ('info', 'solve', 'play', 'fit', 'process', 'plot', 'study')  # a module each


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line, all commands in it."""
    top = argparse.ArgumentParser(
        prog='linkedplane',
        description='Muscle paths by linked-plane obstacle sets.',
        epilog='ROS arguments of `linkedplane play` follow --ros-args.',
    )
    top.add_argument('--version', action='version', version=__version__)
    commands = top.add_subparsers(
        title='commands', dest='command', required=True, metavar='COMMAND'
    )
    for name in COMMANDS:
        command = import_module(f'.{name}', __package__)
        does = command.run.__doc__
        parser = commands.add_parser(name, help=does, description=does)
        command.add_arguments(parser)
        parser.set_defaults(run=command.run)
    return top


def expand_exponent(argument: str) -> str:
    """Return an argument, -1e-3 as -0.001: argparse would take the former for an option."""
    if re.fullmatch(r'-\d*\.?\d+[eE][-+]?\d+', argument):
        return f'{Decimal(argument):f}'
    return argument


def read_command_line(args: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of a command; `words` are those as given, `ros_arguments` for ROS."""
    own, ros_arguments = split_ros_arguments(args)
    words = [expand_exponent(arg) for arg in own]
    parser = build_parser()
    options = parser.parse_args(words)
    if ros_arguments[1:] and options.command != 'play':
        parser.error(f'no ROS arguments expected: {" ".join(ros_arguments)}; only play is a node')
    options.words, options.ros_arguments = words, ros_arguments
    return options


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    try:
        options = read_command_line(sys.argv[1:] if args is None else args)
        options.run(options)
        sys.stdout.flush()
    except ValueError as error:  # ours, or a library's for what it found in a file
        print(f'linkedplane: {escape_controls(str(error))}', file=sys.stderr)
        return exit_status(error)
    except SystemExit as end:  # of argparse, or with what a command found out
        return end.code if isinstance(end.code, int) else 0
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # the reader of the output has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return 0
