"""`python -m linkedplane_ros.node`: the executable muscle_state_publisher."""

from .environment import prepare_executable


def main() -> None:
    """Make ROS importable, then run the node."""
    prepare_executable()
    from .muscle_state_publisher import main

    main()


if __name__ == '__main__':
    main()
