# SPDX-License-Identifier: Apache-2.0
"""Damage bags in every way: none is read differently from what was written without a word.

    python bench/bag_fuzz.py [NUMBER [SEED]]

Each bag is processed into a table, whose stamps and angles are compared with those written. What no
format can notice (a flip where there is no CRC: in SQLite, in MCAP without) is counted apart.
"""

from __future__ import annotations

import random
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

from linkedplane_ros.commands.main import main as run_command

KIND = 'sensor_msgs/msg/JointState'
NAMES = ['flexion', 'abduction', 'rotation']
COUNT = 40
BEGIN = 1_700_000_000 * 10**9  # ns
STORE = get_typestore(Stores.ROS2_JAZZY)
Frames = dict[str, tuple[float, ...]]
Change = Callable[[random.Random, bytearray], None]


def angles_of(k: int) -> list[float]:
    """Return the angles of the k-th frame, rad."""
    return [0.3 + 0.01 * k, 0.2, 0.1 + 0.001 * k * k]


def encode_frame(k: int) -> tuple[int, bytes]:
    """Return the stamp, ns, and the bytes of the k-th frame at 100 Hz."""
    import numpy as np

    stamp = BEGIN + k * 10**7
    types, empty = STORE.types, np.array([])
    time = types['builtin_interfaces/msg/Time'](*divmod(stamp, 10**9))
    header = types['std_msgs/msg/Header'](time, '')
    message = types[KIND](header, NAMES, np.array(angles_of(k)), empty, empty)
    return stamp, bytes(STORE.serialize_cdr(message, KIND))


def written_frames() -> Frames:
    """Return what was written: the angles by the stamp as a table has it."""
    stamps = (BEGIN + k * 10**7 for k in range(COUNT))
    return {f'{s // 10**9}.{s % 10**9:09d}': tuple(angles_of(k)) for k, s in enumerate(stamps)}


def write_mcap(path: Path, compression: str, crcs: bool, chunks: bool = True) -> Path:
    """Write an MCAP file of several chunks."""
    from mcap.writer import CompressionType, Writer

    with path.open('wb') as file:
        writer = Writer(
            file,
            chunk_size=700,
            compression=CompressionType[compression],
            use_chunking=chunks,
            enable_crcs=crcs,
            enable_data_crcs=crcs,
        )
        writer.start('ros2')
        text, _ = STORE.generate_msgdef(KIND, ros_version=2)
        schema = writer.register_schema(KIND, 'ros2msg', text.encode())
        channel = writer.register_channel('/joint_states', 'cdr', schema)
        for k in range(COUNT):
            stamp, data = encode_frame(k)
            writer.add_message(channel, stamp + 5, data, stamp + 5, k)
        writer.finish()
    return path


def write_sqlite(path: Path) -> Path:
    """Write the .db3 file of a bag."""
    with BagWriter(path.with_suffix(''), version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        connection = bag.add_connection('/joint_states', KIND, typestore=STORE)
        for k in range(COUNT):
            stamp, data = encode_frame(k)
            bag.write(connection, stamp + 5, data)
    return path.with_suffix('') / path.name


ZSTD, LZ4, PLAIN = 'ZSTD', 'LZ4', 'NONE'  # as the mcap library calls them
FORMATS: dict[str, tuple[Callable[[Path], Path], bool]] = {  # and whether CRCs guard all of it
    'mcap with CRCs': (lambda path: write_mcap(path, PLAIN, True), True),
    'mcap zstd with CRCs': (lambda path: write_mcap(path, ZSTD, True), True),
    'mcap lz4 with CRCs': (lambda path: write_mcap(path, LZ4, True), True),
    'mcap': (lambda path: write_mcap(path, PLAIN, False), False),
    'mcap zstd': (lambda path: write_mcap(path, ZSTD, False), False),
    'mcap lz4': (lambda path: write_mcap(path, LZ4, False), False),
    'mcap without chunks': (lambda path: write_mcap(path, PLAIN, False, chunks=False), False),
    'sqlite3': (write_sqlite, False),
}


def flip_byte(chance: random.Random, content: bytearray) -> None:
    """Change a bit of one byte."""
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)


def overwrite_run(chance: random.Random, content: bytearray) -> None:
    """Write chance, or zeros, over some bytes."""
    begin, length = chance.randrange(len(content)), chance.randint(2, 100)
    filler = chance.choice([bytes(length), chance.randbytes(length)])
    content[begin : begin + length] = filler[: len(content) - begin]


def cut_end(chance: random.Random, content: bytearray) -> None:
    """Leave out the end, or leave zeros there as after a power cut."""
    begin = chance.randrange(len(content))
    zeros = chance.choice([0, 0, len(content) - begin, 4096])
    content[begin:] = bytes(zeros)


def take_out(chance: random.Random, content: bytearray) -> None:
    """Leave out some bytes."""
    begin = chance.randrange(len(content))
    del content[begin : begin + chance.randint(1, 600)]


def insert_twice(chance: random.Random, content: bytearray) -> None:
    """Repeat some bytes."""
    begin = chance.randrange(len(content))
    content[begin:begin] = content[begin : begin + chance.randint(1, 600)]


def lie_in_number(chance: random.Random, content: bytearray) -> None:
    """Write another number where lengths, counts, offsets and times may stand."""
    size = chance.choice([2, 4, 8])
    begin = chance.randrange(len(content) - size)
    value = chance.choice([0, 1, 2**31, 2 ** (8 * size) - 1, len(content), chance.randrange(300)])
    order = chance.choice(['little', 'big'])
    content[begin : begin + size] = (value % 2 ** (8 * size)).to_bytes(size, order)  # type: ignore


CHANGES: tuple[Change, ...] = (
    flip_byte,
    flip_byte,
    overwrite_run,
    cut_end,
    take_out,
    insert_twice,
    lie_in_number,
)


def read_table(path: Path) -> list[tuple[str, tuple[float, ...]]]:
    """Return the stamps and the angles of a table that `process` wrote."""
    if not path.exists():
        return []
    lines = [line for line in path.read_text().splitlines() if not line.startswith('#')]
    rows = [line.split(',')[:4] for line in lines[1:]]
    return [(time, tuple(map(float, angles))) for time, *angles in rows]


def judge(source: Path, target: Path, guarded: bool) -> tuple[str, str]:
    """Process a damaged bag; return the verdict, and what was printed."""
    out, err = StringIO(), StringIO()
    target.unlink(missing_ok=True)
    with redirect_stdout(out), redirect_stderr(err):
        try:
            status = run_command(['process', str(source), str(target)])
        except SystemExit as end:
            status = int(end.code or 0)
    text = out.getvalue() + err.getvalue()
    if 'Traceback' in text or 'not processed' in text:
        return 'broken', text
    written, frames = written_frames(), read_table(target)
    said = bool(status) or any(word in text for word in ('warning', 'refused', 'not read'))
    if frames == list(written.items()):
        return ('named' if said else 'as written'), text
    wrong = any(written.get(stamp) != angles for stamp, angles in frames)
    if not said or (wrong and guarded):
        return ('WRONG' if guarded else 'not to be noticed'), text
    return 'named', text


def fuzz(number: int, seed: int, folder: Path) -> tuple[Counter[tuple[str, str]], list[str]]:
    """Damage and read bags.

    Returns
    -------
    verdicts, faults
        How often each, by format; a line for each bag that was read wrongly.
    """
    chance = random.Random(seed)
    originals = {}
    for k, (name, (write, _)) in enumerate(FORMATS.items()):
        ending = '.db3' if name == 'sqlite3' else '.mcap'
        originals[name] = write(folder / f'original_{k}{ending}').read_bytes()
    verdicts: Counter[tuple[str, str]] = Counter()
    faults = []
    for k in range(number):
        name = chance.choice(list(FORMATS))
        change = chance.choice(CHANGES)
        content = bytearray(originals[name])
        change(chance, content)
        source = folder / f'damaged{".db3" if name == "sqlite3" else ".mcap"}'
        source.write_bytes(content)
        verdict, text = judge(source, folder / 'out.csv', FORMATS[name][1])
        if verdict == 'not to be noticed' and change is cut_end:
            verdict = 'WRONG'  # each format knows its end
        verdicts[name, verdict] += 1
        if verdict in ('WRONG', 'broken'):
            faults.append(f'{k}: {name}, {change.__name__}: {verdict}: {" ".join(text.split())}')
    return verdicts, faults


def main(words: list[str]) -> int:
    """Fuzz, print the verdicts; return the exit status."""
    number, seed = int((*words, '1000')[0]), int((*words, '', '')[1] or 1)
    with TemporaryDirectory() as folder:
        verdicts, faults = fuzz(number, seed, Path(folder))
    print(f'{number} damaged bags (seed {seed})')
    for (name, verdict), count in sorted(verdicts.items()):
        print(f'  {name:24} {verdict:18} {count:5}')
    print(*faults, sep='\n', end='\n' * bool(faults))
    return bool(faults)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
