"""Processing recordings, beside reading them and writing the result again with the same library."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from linkedplane_ros.process import Task, run
from linkedplane_ros.recordings import JOINT_STATE
from linkedplane_ros.serialized import JointStates

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
    messages = JointStates(STORE, NAMES, '').filled(stamps, angles, np.full_like(angles, 0.1))
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


def copy_csv(source: Path, target: Path) -> None:
    """Read every number of a CSV file and write it into another."""
    lines = [line for line in source.read_text().splitlines() if not line.startswith('#')]
    rows = [[float(cell) if cell else None for cell in line.split(',')] for line in lines[1:]]
    with target.open('w') as file:
        file.write(lines[0] + '\n')
        for row in rows:
            file.write(','.join(['' if cell is None else repr(cell) for cell in row]) + '\n')


def copy_parquet(source: Path, target: Path) -> None:
    """Read a Parquet file and write it again."""
    from pyarrow.parquet import read_table, write_table

    write_table(read_table(source), target)


def measure() -> dict[str, dict[str, float]]:
    """Return, for each format, frames a second of processing and of copying the result."""
    found: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for storage, plugin in PLUGINS.items():
            write_bag(folder / storage, plugin)
        cases: dict[str, tuple[str, Callable[[Path, Path], Any]]] = {
            'mcap': ('', lambda a, b: copy_bag(a, b, StoragePlugin.MCAP)),
            'sqlite3': ('', lambda a, b: copy_bag(a, b, StoragePlugin.SQLITE3)),
            'csv': ('.csv', copy_csv),
            'parquet': ('.parquet', copy_parquet),
        }
        for case, (ending, copy) in cases.items():
            source = folder / (case if case in PLUGINS else 'mcap')
            target, second = folder / f'out_{case}{ending}', folder / f'copy_{case}{ending}'
            times: dict[str, list[float]] = {'processing': [], 'copying': []}
            for _ in range(ROUNDS):
                start = time.perf_counter()
                report = run(Task(source, target, force=True))
                times['processing'].append(time.perf_counter() - start)
                if report.fault:
                    raise RuntimeError(report.fault)
                if second.is_dir():
                    shutil.rmtree(second)
                start = time.perf_counter()
                copy(target, second)
                times['copying'].append(time.perf_counter() - start)
            found[case] = {key: FRAMES / min(each) for key, each in times.items()}
    return found
