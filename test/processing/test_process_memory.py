# SPDX-License-Identifier: Apache-2.0
"""The memory that processing takes does not depend on the recording."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bags import NAMES, NONE, ONE, STORE, T0, Sent, joint_state, write_bag
from optional import requires

from linkedplane_ros.joints.joint_state import JointMap
from linkedplane_ros.processing.cdr import JointStateSerializer
from linkedplane_ros.recordings.bag_motion import BagMotion

MEMORY = """
import resource, sys
from pathlib import Path
from linkedplane_ros.processing.task import Task, run_task
held = []
def progress(frames, share):
    held.append((frames, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))
report = run_task(Task(Path(sys.argv[1]), Path(sys.argv[2])), progress)
assert not report.fault, report.fault
print(held[-1][0], held[-1][1] - next(mib for count, mib in held if count >= 10_000))
"""


@requires('resource')
@pytest.mark.parametrize(
    'ending', ['', '.csv', pytest.param('.parquet', marks=requires('pyarrow'))]
)
def test_memory_does_not_grow_with_the_recording(tmp_path: Path, ending: str) -> None:
    names = list(NAMES)
    stamps = T0 + np.arange(30_000) * 10**7
    angles = np.tile((0.5, 0.4, 0.2), (len(stamps), 1))
    messages = JointStateSerializer(STORE, names, '').serialize(stamps, angles, angles)
    kind = 'sensor_msgs/msg/JointState'
    source = write_bag(
        tmp_path / 'in',
        [('/joint_states', kind, t, m) for t, m in zip(stamps.tolist(), messages, strict=True)],
    )
    command = [sys.executable, '-c', MEMORY, str(source), str(tmp_path / f'out{ending}')]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    frames, growth = ended.stdout.split()
    assert int(frames) == 30_000
    assert float(growth) < 6.0  # MiB: the answers to the rest are 12


def test_large_messages_do_not_fill_the_memory(tmp_path: Path) -> None:
    blob = STORE.types['std_msgs/msg/UInt8MultiArray'](
        STORE.types['std_msgs/msg/MultiArrayLayout']([], 0), np.zeros(500_000, np.uint8)
    )
    kind = 'std_msgs/msg/UInt8MultiArray'
    data = bytes(STORE.serialize_cdr(blob, kind))
    sent: list[Sent] = []
    for k in range(300):
        sent += [joint_state(k), ('/camera', kind, T0 + k * 10**7 + 8, data)]
    joints = JointMap(NAMES, ONE, NONE)
    motion = BagMotion.from_joint_states(write_bag(tmp_path / 'in', sent), joints, None)
    held = [sum(len(each[2]) for each in chunk.records) for chunk in motion.chunks()]
    assert len(held) > 5
    assert max(held) < 2**24 + len(data)
    motion.keeps_records = False
    assert not any(chunk.records for chunk in motion.chunks())
