"""The executables that need ROS: each makes sure that it can be imported, then runs."""

from . import ros_environment


def muscle_state_publisher() -> None:
    """Run the node."""
    ros_environment.prepare()
    from .node import main

    main()


def demo() -> int:
    """Run the demonstration."""
    ros_environment.prepare()
    from .demo import main

    return main()
