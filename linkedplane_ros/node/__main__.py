# SPDX-License-Identifier: Apache-2.0
"""The executable muscle_state_publisher, also `python -m linkedplane_ros.node`."""

import sys
from argparse import RawDescriptionHelpFormatter

from .command_line import ArgumentParser, mistakes_in_one_line, split_ros_arguments
from .environment import end_quietly_on_interrupt, prepare

PROGRAM = 'muscle_state_publisher'


def build_parser() -> ArgumentParser:
    """Return the parser of the command line; all that the node takes are ROS arguments."""
    from .parameters import SPECS  # it loads the solver

    parameters = '\n'.join(f'  -p {spec.name}:={spec.default_text}' for spec in SPECS)
    return ArgumentParser(
        prog=PROGRAM,
        usage=f'{PROGRAM} [-h] [--ros-args ...]',
        description='A ROS node: joint states in, muscle states out.',
        epilog=f'ROS arguments follow --ros-args; parameters and their defaults:\n{parameters}',
        formatter_class=RawDescriptionHelpFormatter,
    )


def main() -> None:
    """Prepare ROS, then run the node."""
    end_quietly_on_interrupt()
    own, ros = split_ros_arguments(sys.argv[1:])
    if own:
        build_parser().parse_args(own)
    prepare()
    from .run import main

    with mistakes_in_one_line(PROGRAM):
        main(ros)


if __name__ == '__main__':
    main()
