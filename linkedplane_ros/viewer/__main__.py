"""`python -m linkedplane_ros.viewer`: the executable muscle_viewer."""

from ..node.environment import prepare_executable


def main() -> None:
    """Make ROS importable, then run the viewer."""
    prepare_executable()
    from .main import main

    main()


if __name__ == '__main__':
    main()
