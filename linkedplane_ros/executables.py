"""The executables that need ROS: each makes sure that it can be imported, then runs."""

import signal
import sys

from . import ros_environment


def prepare() -> None:
    """Make ROS importable; until it takes signals over itself, they end the process quietly."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    ros_environment.prepare()


def muscle_state_publisher() -> None:
    """Run the node."""
    prepare()
    from .node import main

    main()


def muscle_viewer() -> None:
    """Run the viewer."""
    prepare()
    from .viewer.main import main

    main()


def demo() -> int:
    """Run the demonstration."""
    prepare()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    from .demo import main

    return main()


if __name__ == '__main__':
    sys.exit(muscle_state_publisher())
