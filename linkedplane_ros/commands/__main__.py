# SPDX-License-Identifier: Apache-2.0
"""The command `linkedplane`, as `python -m linkedplane_ros.commands`."""

import sys

from .main import main

if __name__ == '__main__':
    sys.exit(main())
