# SPDX-License-Identifier: Apache-2.0
"""Processing recordings, beside copying what comes of them, and them, with the same library."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from linkedplane_ros.processing.cdr import JointStateSerializer
from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task
from linkedplane_ros.recordings.bags.topics import JOINT_STATE

FRAMES = 20_000
ROUNDS = 4
NAMES = ['flexion', 'abduction', 'rotation']
STORE = get_typestore(Stores.ROS2_JAZZY)
PLUGINS = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}


def motion() -> tuple[np.ndarray, np.ndarray]:
    """Return stamps (m,), ns, and angles (m, 3), rad, of an arm that goes to and fro at 100 Hz."""
    seconds = 0.01 * np.arange(FRAMES)
    swing = 0.8 + 0.7 * np.sin(seconds)
    stamps = 1_700_000_000 * 10**9 + np.arange(FRAMES) * 10**7
    return stamps, np.column_stack((swing, 0.4 + 0.2 * np.cos(seconds), 0.1 * swing))


def write_bag(path: Path, plugin: StoragePlugin) -> None:
    """Write the motion as joint states."""
    stamps, angles = motion()
    speeds = np.full_like(angles, 0.1)
    messages = JointStateSerializer(STORE, NAMES, '').serialize(stamps, angles, speeds)
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        topic = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE)
        for stamp, message in zip(stamps.tolist(), messages, strict=True):
            writer.write(topic, stamp, message)


def copy_bag(source: Path, target: Path, plugin: StoragePlugin) -> None:
    """Read every message of a bag and write it into another."""
    with AnyReader([source]) as reader, Writer(target, version=9, storage_plugin=plugin) as writer:
        topics = {
            each.id: writer.add_connection(each.topic, each.msgtype, typestore=STORE)
            for each in reader.connections
        }
        for connection, stamp, data in reader.messages():
            writer.write(topics[connection.id], stamp, data)


def write_mot(path: Path) -> None:
    """Write the motion as OpenSim does, in degrees."""
    stamps, angles = motion()
    header = [path.name, 'version=1', f'nRows={FRAMES}', 'nColumns=4', 'inDegrees=yes', 'endheader']
    rows = zip(1e-9 * (stamps - stamps[0]), np.degrees(angles), strict=True)
    lines = ['\t'.join(f'{x:.8f}' for x in (time, *row)) for time, row in rows]
    path.write_text('\n'.join([*header, '\t'.join(['time', *NAMES]), *lines]) + '\n')


def write_csv(path: Path) -> None:
    """Write the motion as a table of radians."""
    stamps, angles = motion()
    rows = zip(1e-9 * (stamps - stamps[0]), angles, strict=True)
    lines = [','.join(f'{x:.9f}' for x in (time, *row)) for time, row in rows]
    path.write_text('\n'.join([','.join(['time', *NAMES]), *lines]) + '\n')


def copy_table(source: Path, target: Path) -> None:
    """Read every number of a table and write it into another."""
    with source.open() as read, target.open('w') as written:
        for line in read:
            cells = line.rstrip('\n').replace('\t', ',').split(',')
            try:
                row = [float(cell) if cell else None for cell in cells]
            except ValueError:  # the head
                written.write(line)
                continue
            written.write(','.join(['' if cell is None else repr(cell) for cell in row]) + '\n')


def copy_parquet(source: Path, target: Path) -> None:
    """Read a Parquet file and write it again."""
    from pyarrow.parquet import read_table, write_table

    write_table(read_table(source), target)


def copy(source: Path, target: Path) -> None:
    """Read a recording or a result, and write it again with the same library."""
    if source.is_dir():
        sqlite = any(each.suffix == '.db3' for each in source.iterdir())
        copy_bag(source, target, PLUGINS['sqlite3' if sqlite else 'mcap'])
    elif source.suffix == '.parquet':
        copy_parquet(source, target)
    else:
        copy_table(source, target)


def time_work(work: Callable[[Path, Path], None], source: Path, target: Path) -> float:
    """Return the time that it takes to turn one path into another, s."""
    start = time.perf_counter()
    work(source, target)
    return time.perf_counter() - start


def measure() -> dict[str, dict[str, float]]:
    """Return, for each pair of formats, frames a second: processed, the result copied, the source.

    The three take turns.
    """
    found: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for storage, plugin in PLUGINS.items():
            write_bag(folder / storage, plugin)
        write_mot(folder / 'motion.mot')
        write_csv(folder / 'motion.csv')
        for source, ending in (
            ('mcap', ''),
            ('sqlite3', ''),
            ('mcap', '.csv'),
            ('mcap', '.parquet'),
            ('motion.mot', ''),
            ('motion.mot', '.csv'),
            ('motion.csv', '.csv'),
        ):
            task = Task(folder / source, folder / f'out{ending}', Options(force=True))
            copied = folder / f'copy{ending}'
            again = folder / f'again{Path(source).suffix}'
            times: dict[str, list[float]] = {'processing': [], 'result': [], 'source': []}
            for _ in range(ROUNDS):
                for each in (copied, again):
                    shutil.rmtree(each, ignore_errors=True)
                report = run_task(task)
                if report.fault:
                    raise RuntimeError(report.fault)
                times['processing'].append(report.seconds)
                times['result'].append(time_work(copy, task.target, copied))
                times['source'].append(time_work(copy, task.source, again))
            kind = Path(source).suffix or f'a bag ({source})'
            found[f'{kind} into {ending or "a bag"}'] = {
                key: FRAMES / min(each) for key, each in times.items()
            }
            shutil.rmtree(folder / 'out', ignore_errors=True)
    return found
