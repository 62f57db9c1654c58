"""Where processed recordings go: an annotated bag, CSV or Parquet.

Each output is written beside its place and takes it when all is done, so that nothing half-written
ever stands under the final name.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .motion import Chunk
from .recordings import JOINT_STATE, RecordingError, opened
from .serialized import TYPES, JointStates, SerializedAnswers
from .solver import MuscleStates

Floats = npt.NDArray[np.float64]

ENDINGS = {'csv': '.csv', 'parquet': '.parquet', 'bag': ''}


@dataclass(frozen=True, eq=False)
class Solved:
    """A chunk and the muscle at each of its k frames."""

    chunk: Chunk
    states: MuscleStates
    arms: Floats
    """(k, n, 3) m, about the coordinates."""
    lengthening: Floats
    """(k, n) m/s; NaN where not known."""


@dataclass(frozen=True)
class Described:
    """What an output says of itself."""

    muscle: str
    bands: tuple[str, ...]
    coordinates: tuple[str, str, str]
    frame_id: str
    facts: Mapping[str, str]
    """Written into the output: convention, side, source, what was done to the angles."""


class Output(Protocol):
    """Takes solved chunks, one after the other."""

    def write(self, solved: Solved) -> None:
        """Append a chunk."""

    def close(self) -> None:
        """Finish."""


@contextmanager
def in_place(path: Path, force: bool, bag: bool = False) -> Iterator[Path]:
    """Give a path to write to; what stands there at the end takes its place, or is removed."""
    if path.exists() and not force:
        raise RecordingError(f'{path}: exists; --force to replace it')
    if path.is_dir() and not (bag and (path / 'metadata.yaml').is_file()):
        raise RecordingError(f'{path}: a folder; only a bag is replaced, and by a bag alone')
    if not path.parent.is_dir():
        raise RecordingError(f'{path}: no folder {path.parent} to write into')
    # under its own name: a bag writes that into its files
    workshop = path.with_name(f'.{path.name}.{os.getpid()}.part')
    try:
        remove(workshop)
        workshop.mkdir()
        yield workshop / path.name
        if path.is_dir():
            path.rename(workshop / 'replaced')
        try:
            (workshop / path.name).replace(path)
        except OSError:
            if (workshop / 'replaced').exists():
                (workshop / 'replaced').rename(path)
            raise
    except OSError as error:
        raise RecordingError(f'{path}: not written: {error.strerror or error}') from None
    finally:
        remove(workshop)


def remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def columns(described: Described) -> list[str]:
    """Return the names of a table's columns: times in s, angles in rad, lengths in m."""
    bands = described.bands
    return [
        'time',
        *(f'angles/{coordinate}' for coordinate in described.coordinates),
        'theta',
        *(f'band_lengths/{band}' for band in bands),
        *(f'lengthening/{band}' for band in bands),
        *(f'moment_arms/{band}/{each}' for band in bands for each in described.coordinates),
        *(f'moment_vectors/{band}/{axis}' for band in bands for axis in 'xyz'),
        *(f'wrap_states/{band}' for band in bands),
    ]


def table(solved: Solved) -> tuple[Floats, npt.NDArray[np.uint8]]:
    """Return a chunk's rows: all columns of numbers, and the wrap states."""
    states, k = solved.states, len(solved.states)
    numbers = np.column_stack(
        (
            1e-9 * solved.chunk.stamps,
            solved.chunk.angles,
            states.theta,
            states.lengths,
            solved.lengthening,
            solved.arms.reshape(k, 3 * states.lengths.shape[1]),
            states.moment_vectors.reshape(k, 3 * states.lengths.shape[1]),
        )
    )
    return numbers, states.wrap


class CsvOutput:
    """A row a frame; the facts stand in lines with # before the header."""

    def __init__(self, path: Path, described: Described) -> None:
        """Write the header."""
        self._file = path.open('w', encoding='utf-8', newline='')
        for name, fact in described.facts.items():
            self._file.write(f'# {name}: {fact}\n')
        self._file.write(','.join(columns(described)) + '\n')

    def write(self, solved: Solved) -> None:
        """Append a chunk; every number to the last bit, an unknown one empty."""
        numbers, wrap = table(solved)
        for row, states, ns in zip(
            numbers.tolist(), wrap.tolist(), solved.chunk.stamps.tolist(), strict=True
        ):
            time = f'{"-" * (ns < 0)}{abs(ns) // 10**9}.{abs(ns) % 10**9:09d}'
            cells = ','.join(['' if x != x else repr(x) for x in row[1:]])
            self._file.write(f'{time},{cells},{",".join(map(str, states))}\n')

    def close(self) -> None:
        """Finish."""
        self._file.close()


class ParquetOutput:
    """A row a frame; the facts stand in the schema's metadata."""

    def __init__(self, path: Path, described: Described) -> None:
        """Open the file."""
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise RecordingError(
                "Parquet needs the pyarrow library: pip install 'linkedplane_ros[tools]'"
            ) from None
        self._arrow = pyarrow
        self._file = path.open('wb')
        names = columns(described)
        kinds = [
            pyarrow.uint8() if name.startswith('wrap_states/') else pyarrow.float64()
            for name in names
        ]
        fields = list(zip(names, kinds, strict=True))
        self._schema = pyarrow.schema(
            [('stamp', pyarrow.timestamp('ns')), *fields], metadata=dict(described.facts)
        )
        self._writer = pyarrow.parquet.ParquetWriter(self._file, self._schema)

    def write(self, solved: Solved) -> None:
        """Append a chunk; an unknown number is null."""
        numbers, wrap = table(solved)
        arrays = [solved.chunk.stamps.astype('datetime64[ns]'), *numbers.T, *wrap.T]
        made = [
            self._arrow.array(np.ascontiguousarray(each), type=kind.type, from_pandas=True)
            for each, kind in zip(arrays, self._schema, strict=True)
        ]
        self._writer.write_table(self._arrow.Table.from_arrays(made, schema=self._schema))

    def close(self) -> None:
        """Finish."""
        self._writer.close()
        self._file.close()


class BagOutput:
    """A bag's own messages, byte for byte, and the muscle's topics among them.

    The motion of a table becomes joint states.
    """

    def __init__(self, path: Path, described: Described, source: Path | None) -> None:
        """Open the bag; `source` is the bag whose messages are kept."""
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
        self._answers = SerializedAnswers(
            store, described.bands, described.coordinates, described.frame_id
        )
        plugin = StoragePlugin.MCAP
        originals: list[Any] = []
        if source is not None:
            with closing(opened(source)) as reader:
                originals = list(reader.connections)
                if any('.db3' in each.name for each in files_of(source)):
                    plugin = StoragePlugin.SQLITE3
        taken = {each.topic for each in originals}
        for full in (f'/{described.muscle}/{topic}' for topic in TYPES):
            if full in taken:
                raise RecordingError(f'{source}: {full} is in it already; it has been processed')
        self._writer = Writer(path, version=9, storage_plugin=plugin)
        for name, fact in described.facts.items():
            self._writer.set_custom_data(name, fact)
        self._writer.open()
        self._kept = {
            each.id: self._writer.add_connection(
                each.topic,
                each.msgtype,
                msgdef=each.msgdef.data,
                rihs01=each.digest or digest(each),
                serialization_format=each.ext.serialization_format,
                offered_qos_profiles=each.ext.offered_qos_profiles,
            )
            for each in originals
        }
        self._topics = {}
        for topic, kind in TYPES.items():
            full = f'/{described.muscle}/{topic}'
            self._topics[topic] = self._writer.add_connection(full, kind, typestore=store)
        self._joints: Any = None
        if source is None:
            self._joints = self._writer.add_connection(
                '/joint_states', JOINT_STATE, typestore=store
            )
            self._states = JointStates(store, described.coordinates, '')

    def write(self, solved: Solved) -> None:
        """Append a chunk: each message, and behind it its answers."""
        chunk, states = solved.chunk, solved.states
        made = self._answers.of(
            chunk.stamps,
            states.lengths,
            solved.arms,
            solved.lengthening,
            states.wrap,
            states.moment_vectors,
        )
        answers = list(zip(*made.values(), strict=True))
        topics = list(self._topics.values())
        write = self._writer.write
        if self._joints is not None:
            joints = self._states.filled(chunk.stamps, chunk.angles, chunk.speeds)
            for time, message, messages in zip(chunk.stamps.tolist(), joints, answers, strict=True):
                write(self._joints, time, message)
                for connection, answer in zip(topics, messages, strict=True):
                    write(connection, time, answer)
            return
        frame_of = {record: k for k, record in enumerate(chunk.answered)}
        for number, (connection, time, data) in enumerate(chunk.records):
            write(self._kept[connection.id], time, data)
            if number in frame_of:
                for topic, answer in zip(topics, answers[frame_of[number]], strict=True):
                    write(topic, time, answer)

    def close(self) -> None:
        """Finish."""
        self._writer.close()


def digest(connection: Any) -> str:
    """Return the hash of a message type, for a bag that does not tell it."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    if connection.msgtype not in store.fielddefs:
        store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    made: str = store.hash_rihs01(connection.msgtype)
    return made


def files_of(bag: Path) -> list[Path]:
    """Return the files of a bag."""
    return list(bag.iterdir()) if bag.is_dir() else [bag]


def format_of(path: Path, chosen: str | None) -> str:
    """Return the format of an output: the one chosen, else by its ending."""
    if chosen is not None:
        return chosen
    return {'.csv': 'csv', '.parquet': 'parquet'}.get(path.suffix.lower(), 'bag')


def output(path: Path, kind: str, described: Described, source: Path | None) -> Output:
    """Open an output of a kind: bag, csv or parquet."""
    if kind == 'csv':
        return CsvOutput(path, described)
    if kind == 'parquet':
        return ParquetOutput(path, described)
    return BagOutput(path, described, source)
