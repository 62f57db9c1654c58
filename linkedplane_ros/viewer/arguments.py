# SPDX-License-Identifier: Apache-2.0
"""The arguments of the executable muscle_viewer; no ROS is needed to read them."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence

from ..node.command_line import ArgumentParser, split_ros_arguments

PORT = 8080
LOOPBACK = '127.0.0.1'
TOPIC = '/muscle_viewer/joint_states'
TOPIC_NAME = re.compile(r'(/[A-Za-z_][A-Za-z0-9_]*)+')


def parse_arguments(given: Sequence[str]) -> argparse.Namespace:
    """Return the arguments that follow a program's name; `ros_arguments` are those for ROS."""
    parser = ArgumentParser(
        prog='muscle_viewer',
        usage='%(prog)s [-h] [--host HOST] [--port PORT] [--node] [--topic TOPIC] [--take] '
        '[--ros-args ...]',
        description='Show the muscles that are published, in a browser, and move their arms.',
        epilog='ROS arguments follow --ros-args. With --node they are those of the muscle node, '
        'as in: muscle_viewer --node --ros-args -p muscle:=deltoid_ackland2008',
    )
    parser.add_argument('--host', default=LOOPBACK, help='address to listen on (%(default)s)')
    parser.add_argument(
        '--port', type=int, help=f'port to listen on ({PORT}, or the next free one)'
    )
    parser.add_argument('--node', action='store_true', help='start the muscle node as well')
    parser.add_argument(
        '--topic',
        action='append',
        dest='topics',
        metavar='TOPIC',
        help=f'topic of joint states that moves arms ({TOPIC}); once or more; '
        'the node of --node listens to the first',
    )
    parser.add_argument(
        '--take', action='store_true', help='move arms that other publishers of the topic move, too'
    )
    own, ros_arguments = split_ros_arguments(given[1:])
    options = parser.parse_args(own)
    options.ros_arguments = ros_arguments
    options.topics = ['/' + topic.removeprefix('/') for topic in options.topics or [TOPIC]]
    for topic in options.topics:
        if not TOPIC_NAME.fullmatch(topic) or '__' in topic:
            parser.error(f'--topic {topic[1:]}: a name as /joint_states expected')
    return options
