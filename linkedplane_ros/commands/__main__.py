"""`python -m linkedplane_ros.commands`: the command `linkedplane`."""

import sys

from .main import main

if __name__ == '__main__':
    sys.exit(main())
