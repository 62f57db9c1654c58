# SPDX-License-Identifier: Apache-2.0
"""Where the package stands, and Python with a minimal environment."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from unhurried import PATIENCE

TOP = Path(__file__).resolve().parents[2]


def run_python(code: str, *options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run code in Python with a minimal environment."""
    return subprocess.run(
        [sys.executable, *options, '-c', code],
        env={'PATH': os.defpath, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', **environment},
        cwd=TOP,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
