# SPDX-License-Identifier: Apache-2.0
"""Where processed recordings go: CSV, Parquet, or an annotated bag (`bag_output`).

Each output is written beside its final place and moved there when it is complete.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import yaml

from ..errors import RecordingError
from ..files import replace_when_complete
from ..libraries import advise_install
from ..muscle.broad_muscle import BroadMuscle
from ..recordings.motion import Chunk
from ..solver.states import MuscleStates
from ..types import Bytes, Floats
from .topics import moment_arm_names, wrench_names

ENDINGS = {'csv': '.csv', 'parquet': '.parquet', 'bag': ''}
TABLE_ENDINGS = {'.csv': 'csv', '.parquet': 'parquet'}
FACTS_BEGIN = b'made_by: linkedplane_ros '


@dataclass(frozen=True, eq=False)
class SolvedChunk:
    """A chunk and the muscle at each of its k frames."""

    chunk: Chunk
    states: MuscleStates
    arms: Floats
    """(k, n, d) m, about the coordinates."""
    lengthening: Floats
    """(k, n) m/s; NaN where not known."""


@dataclass(frozen=True)
class OutputDescription:
    """What an output says of itself."""

    muscle: BroadMuscle
    coordinates: tuple[str, ...]
    frame_id: str
    facts: Mapping[str, str]
    """Written into the output: convention, side, source, what was done to the angles."""
    angles_topic: str = ''
    """The topic of the angles as joint states in a bag; empty: they are in it as recorded."""
    markers: bool = True
    """Whether a bag gets the markers, too."""
    bones: tuple[str, ...] = ()
    """Those that move, where the output has the wrenches on them; else none."""

    @property
    def bands(self) -> tuple[str, ...]:
        """The names of the bands."""
        return self.muscle.band_names


class Output(Protocol):
    """Takes solved chunks, one after the other."""

    def write(self, solved: SolvedChunk) -> None:
        """Append a chunk."""

    def close(self) -> None:
        """Complete the output."""


@contextmanager
def replace_output(path: Path, force: bool, bag: bool = False) -> Iterator[Path]:
    """Give a path to write to, which takes the place of an output at the end of the block.

    Parameters
    ----------
    path
        Where the output is to appear; what is there before is kept if the block fails.
    force
        Whether an output that exists is replaced.
    bag
        Whether the output is a bag, a folder.

    Raises
    ------
    RecordingError
        If `path` may not be replaced, or cannot be written.
    """
    if path.exists() and not force:
        raise RecordingError(f'{path}: exists; --force to replace it')
    if path.is_dir() and not (bag and (path / 'metadata.yaml').is_file()):
        raise RecordingError(f'{path}: a folder; only a bag is replaced, and only by a bag')
    if bag and path.is_file():
        raise RecordingError(f'{path}: a file; a bag is a folder')
    if not path.parent.is_dir():
        raise RecordingError(f'{path}: no folder {path.parent} to write into')
    try:
        with replace_when_complete(path, RecordingError, force) as new:
            yield new
    except sqlite3.Error as error:
        raise RecordingError(f'{path}: cannot be written: {error}') from None


def column_names(description: OutputDescription) -> list[str]:
    """Return the names of a table's columns: times in s, angles in rad, lengths in m, m/s."""
    bands = description.bands
    return [
        'time',
        *(f'angles/{coordinate}' for coordinate in description.coordinates),
        'theta',
        *(f'band_lengths/{band}' for band in bands),
        *(f'lengthening/{band}' for band in bands),
        *(f'moment_arms/{each}' for each in moment_arm_names(bands, description.coordinates)),
        *(f'moment_vectors/{band}/{axis}' for band in bands for axis in 'xyz'),
        *(f'wrenches/{each}' for each in wrench_names(bands, description.bones)),
        *(f'wrap_states/{band}' for band in bands),
    ]


def table_rows(solved: SolvedChunk, wrenches: bool) -> tuple[Floats, Bytes]:
    """Return a chunk's rows: numbers (k, columns before the wrap states), wrap states (k, n)."""
    states, k = solved.states, len(solved.states)
    n, d = solved.arms.shape[1:]
    numbers = np.column_stack(
        (
            1e-9 * solved.chunk.stamps,
            solved.chunk.angles,
            states.theta,
            states.lengths,
            solved.lengthening,
            solved.arms.reshape(k, d * n),
            states.moment_vectors.reshape(k, 3 * n),
            states.wrenches.reshape(k, -1 if k else 0) if wrenches else np.empty((k, 0)),
        )
    )
    return numbers, states.wrap


def facts_file(path: Path) -> Path:
    """Return the file beside a plain CSV that has its facts: of `a.csv`, `a.csv.facts.yaml`."""
    return path.with_name(f'{path.name}.facts.yaml')


def is_facts_file(path: Path) -> bool:
    """Return whether a path is a file of facts, as `CsvOutput` writes it."""
    with suppress(OSError):
        if path.is_file() and not path.is_symlink():
            with path.open('rb') as file:
                return file.read(len(FACTS_BEGIN)) == FACTS_BEGIN
    return False


def encode_fact(fact: str) -> str:
    """Return a fact as it stands in one line of a CSV's head: as it is, or else as JSON's text."""
    plain = fact.isprintable() and fact.strip() == fact and not fact.startswith('"')
    return fact if plain else json.dumps(fact)


def decode_fact(text: str) -> str:
    """Return the fact that `encode_fact` has written."""
    return str(json.loads(text)) if text.startswith('"') else text


class CsvOutput:
    """A CSV file: a row for each frame; the facts are lines with # before the header.

    Parameters
    ----------
    path
        Where the table is written.
    description
        What the output says of itself.
    facts_path
        Where the facts are written, as YAML; None: into the table.
    """

    def __init__(
        self, path: Path, description: OutputDescription, facts_path: Path | None = None
    ) -> None:
        """Write the facts and the header."""
        self._file = path.open('w', encoding='utf-8', newline='')
        self._wrenches = bool(description.bones)
        if facts_path is not None:
            facts = dict(description.facts)
            text = yaml.safe_dump(facts, sort_keys=False, allow_unicode=True, width=10**6)
            facts_path.write_text(text, encoding='utf-8')
        else:
            for name, fact in description.facts.items():
                self._file.write(f'# {name}: {encode_fact(fact)}\n')
        self._file.write(','.join(column_names(description)) + '\n')

    def write(self, solved: SolvedChunk) -> None:
        """Append a chunk; numbers are exact, an unknown one is empty."""
        numbers, wrap = table_rows(solved, self._wrenches)
        for row, states, ns in zip(
            numbers.tolist(), wrap.tolist(), solved.chunk.stamps.tolist(), strict=True
        ):
            time = f'{"-" * (ns < 0)}{abs(ns) // 10**9}.{abs(ns) % 10**9:09d}'
            cells = ','.join(['' if x != x else repr(x) for x in row[1:]])
            self._file.write(f'{time},{cells},{",".join(map(str, states))}\n')

    def close(self) -> None:
        """Complete the output."""
        self._file.close()


class ParquetOutput:
    """A Parquet file: a row for each frame; the facts are in the schema's metadata."""

    def __init__(self, path: Path, description: OutputDescription) -> None:
        """Open the file."""
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise RecordingError(
                f'Parquet needs the pyarrow library: {advise_install("pyarrow")}'
            ) from None
        self._arrow = pyarrow
        self._wrenches = bool(description.bones)
        self._file = path.open('wb')
        names = column_names(description)
        kinds = [
            pyarrow.uint8() if name.startswith('wrap_states/') else pyarrow.float64()
            for name in names
        ]
        fields = list(zip(names, kinds, strict=True))
        self._schema = pyarrow.schema(
            [('stamp', pyarrow.timestamp('ns')), *fields], metadata=dict(description.facts)
        )
        self._writer = pyarrow.parquet.ParquetWriter(self._file, self._schema)

    def write(self, solved: SolvedChunk) -> None:
        """Append a chunk; an unknown number is null."""
        numbers, wrap = table_rows(solved, self._wrenches)
        arrays = [solved.chunk.stamps.astype('datetime64[ns]'), *numbers.T, *wrap.T]
        made = [
            self._arrow.array(np.ascontiguousarray(each), type=kind.type, from_pandas=True)
            for each, kind in zip(arrays, self._schema, strict=True)
        ]
        self._writer.write_table(self._arrow.Table.from_arrays(made, schema=self._schema))

    def close(self) -> None:
        """Complete the output."""
        self._writer.close()
        self._file.close()


def choose_format(path: Path, chosen: str | None) -> str:
    """Return the format of an output, bag, csv or parquet: the one chosen, else by its ending.

    RecordingError for an ending of another format; a bag's name may have dots, as in `run.01`.
    """
    ending = '.' if path.name.endswith('.') else path.suffix.lower()
    kind = chosen or TABLE_ENDINGS.get(ending, 'bag')
    if kind == 'bag' and ending in ('.mcap', '.db3'):
        raise RecordingError(f'{path}: a bag is a folder; name it without {path.suffix}')
    odd = ending[1:2].isalpha() or ending == '.'
    if kind == 'bag' and not chosen and odd and not path.is_dir():
        raise RecordingError(
            f'{path}: no {path.suffix or ending} is written; {", ".join(TABLE_ENDINGS)} or a bag, '
            'whose name has no ending (--format bag: it is the name of a bag)'
        )
    return kind
