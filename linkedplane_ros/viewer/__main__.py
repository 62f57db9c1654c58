# SPDX-License-Identifier: Apache-2.0
"""The executable muscle_viewer, also `python -m linkedplane_ros.viewer`."""

from ..node.environment import prepare_executable


def main() -> None:
    """Prepare ROS, then run the viewer."""
    prepare_executable()
    from .main import main

    main()


if __name__ == '__main__':
    main()
