# SPDX-License-Identifier: Apache-2.0
"""The executable linkedplane_demo, also `make demo`: the demonstration."""

import signal
import sys

from ..node.environment import prepare_executable


def main() -> int:
    """Prepare ROS, then run the demonstration; return its exit status."""
    prepare_executable()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    from ..node.demo import main as run

    return int(run())


if __name__ == '__main__':
    sys.exit(main())
