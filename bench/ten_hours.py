# SPDX-License-Identifier: Apache-2.0
"""Process a recording of ten hours at 100 Hz, and print the most memory that it took.

Run as `python bench/ten_hours.py [HOURS]`; ten hours need 12 GB of disk and some ten minutes.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from recordings import NAMES, STORE
from rosbags.rosbag2 import StoragePlugin, Writer

from linkedplane_ros.processing.cdr import JointStateSerializer
from linkedplane_ros.recordings.bags.topics import JOINT_STATE

RATE = 100  # Hz
LIMIT = 300.0  # MiB


def write_long(path: Path, frames: int) -> None:
    """Write joint states of an arm that goes to and fro."""
    states = JointStateSerializer(STORE, NAMES, '')
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE)
        for start in range(0, frames, 10_000):
            k = np.arange(start, min(start + 10_000, frames))
            swing = 0.8 + 0.7 * np.sin(k / RATE)
            angles = np.column_stack((swing, 0.5 * swing, 0.1 * swing))
            stamps = 1_700_000_000 * 10**9 + k * (10**9 // RATE)
            messages = states.serialize(stamps, angles, np.full_like(angles, 0.1))
            for stamp, message in zip(stamps.tolist(), messages, strict=True):
                writer.write(topic, stamp, message)


def main() -> None:
    """Write, process, and print what it took; status 1 if that is too much."""
    hours = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    frames = round(3600 * hours * RATE)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_long(folder / 'long', frames)
        command = ['-m', 'linkedplane_ros.commands', 'process', str(folder / 'long')]
        subprocess.run([sys.executable, *command, str(folder / 'out')], check=True)
        written = sum(each.stat().st_size for each in (folder / 'out').iterdir())
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f'{frames:,} frames, {hours:g} h at {RATE} Hz: at most {peak:.0f} MiB held, '
          f'{written / 2**30:.1f} GiB written')  # fmt: skip
    sys.exit(peak > LIMIT)


if __name__ == '__main__':
    main()
