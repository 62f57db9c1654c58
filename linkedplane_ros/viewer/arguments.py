# SPDX-License-Identifier: Apache-2.0
"""The arguments of the executable muscle_viewer; no ROS is needed to read them."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from ..node.command_line import ArgumentParser, split_ros_arguments

PORT = 8080
LOOPBACK = '127.0.0.1'


def parse_arguments(given: Sequence[str]) -> argparse.Namespace:
    """Return the arguments that follow a program's name; `ros_arguments` are those for ROS."""
    parser = ArgumentParser(
        prog='muscle_viewer',
        usage='%(prog)s [-h] [--host HOST] [--port PORT] [--node] [--ros-args ...]',
        description='Show the muscles that are published, in a browser, and move their arms.',
        epilog='ROS arguments follow --ros-args. With --node they are those of the muscle node, '
        'as in: muscle_viewer --node --ros-args -p muscle:=deltoid_ackland2008',
    )
    parser.add_argument('--host', default=LOOPBACK, help='address to listen on (%(default)s)')
    parser.add_argument(
        '--port', type=int, help=f'port to listen on ({PORT}, or the next free one)'
    )
    parser.add_argument('--node', action='store_true', help='start the muscle node as well')
    own, ros_arguments = split_ros_arguments(given[1:])
    options = parser.parse_args(own)
    options.ros_arguments = ros_arguments
    return options
