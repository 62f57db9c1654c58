# SPDX-License-Identifier: Apache-2.0
"""The executable linkedplane_demo, also `make demo`: the demonstration."""

import signal
import sys

from ..node.command_line import ArgumentParser, mistakes_in_one_line, split_ros_arguments
from ..node.environment import end_quietly_on_interrupt, prepare

PROGRAM = 'linkedplane_demo'


def main() -> int:
    """Prepare ROS, then run the demonstration; return its exit status."""
    end_quietly_on_interrupt()
    own, ros_arguments = split_ros_arguments(sys.argv[1:])
    ArgumentParser(
        prog=PROGRAM,
        usage=f'{PROGRAM} [-h] [--ros-args ...]',
        description='Run the muscle node, fed from a recording of an arm that is raised and '
        'lowered, and show what it answers.',
        epilog='ROS arguments follow --ros-args; they are those of the node that listens.',
    ).parse_args(own)
    prepare()
    from ..node.demo import main as run

    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with mistakes_in_one_line(PROGRAM):
            return int(run(ros_arguments))
    except KeyboardInterrupt:
        return 130


if __name__ == '__main__':
    sys.exit(main())
