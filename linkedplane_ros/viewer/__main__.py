# SPDX-License-Identifier: Apache-2.0
"""The executable muscle_viewer, also `python -m linkedplane_ros.viewer`."""

import sys

from ..node.command_line import mistakes_in_one_line
from ..node.environment import end_quietly_on_interrupt, prepare
from .arguments import parse_arguments


def main() -> None:
    """Prepare ROS, then run the viewer."""
    end_quietly_on_interrupt()
    parse_arguments(sys.argv)  # what is wrong in them needs no ROS
    prepare()
    from .main import main

    with mistakes_in_one_line('muscle_viewer'):
        main()


if __name__ == '__main__':
    main()
