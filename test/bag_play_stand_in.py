# SPDX-License-Identifier: Apache-2.0
"""Stands in for `ros2 bag play`: writes down its arguments, publishes one pose again and again.

It publishes where the topic /recorded of a recording goes by `--remap`.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path


def parse_arguments(words: Sequence[str]) -> argparse.Namespace:
    """Return the arguments, as rosbag2 0.26's ros2bag/verb/play.py declares them."""
    parser = argparse.ArgumentParser(exit_on_error=False)
    parser.add_argument('command', choices=['bag'])
    parser.add_argument('verb', choices=['play'])
    parser.add_argument('bag_path')
    parser.add_argument('-l', '--loop', action='store_true')
    parser.add_argument('-m', '--remap', default='', nargs='+')
    parser.add_argument('--clock', type=float, nargs='?', const=40, default=0)
    parser.add_argument('-d', '--delay', type=float, default=0.0)
    parser.add_argument('--topics', default=[], nargs='+')
    return parser.parse_args(words)


def main() -> None:
    """Publish until interrupted."""
    arguments = parse_arguments(sys.argv[1:])
    Path('bag_play.json').write_text(json.dumps(vars(arguments)))
    from linkedplane_ros.node.environment import prepare

    prepare()
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from sensor_msgs.msg import JointState

    rclpy.init(args=['ros2', '--ros-args', *(x for rule in arguments.remap for x in ('-r', rule))])
    publisher = rclpy.create_node('rosbag2_player').create_publisher(JointState, '/recorded', 10)
    pose = JointState(name=['flexion', 'abduction', 'rotation'], position=[0.3, 0.2, 0.1])
    try:
        while rclpy.ok():
            publisher.publish(pose)
            time.sleep(0.05)
    except (KeyboardInterrupt, ExternalShutdownException):
        sys.exit(0)


if __name__ == '__main__':
    main()
