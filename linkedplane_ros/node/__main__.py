# SPDX-License-Identifier: Apache-2.0
"""The executable muscle_state_publisher, also `python -m linkedplane_ros.node`."""

from .environment import prepare_executable


def main() -> None:
    """Prepare ROS, then run the node."""
    prepare_executable()
    from .muscle_state_publisher import main

    main()


if __name__ == '__main__':
    main()
