# SPDX-License-Identifier: Apache-2.0
"""Damaged tables: flipped, cut, changed at random; none is read as what it does not say.

`make soak` runs 1,000 of them; `python bench/table_fuzz.py COUNT SEED` others. It ends with status
1 if one was read differently from what stands in it, or ended in anything but a line of ours.

The judge is a plain split of the changed file in the dialect in which it was written, by Python's
`csv` and `str.split`; it does not use the code that is tested.
"""

from __future__ import annotations

import csv
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from linkedplane_ros.errors import RecordingError
from linkedplane_ros.recordings.tables.table import Table
from linkedplane_ros.types import Floats

NAMES = ('time', 'a', 'b', 'c', 'rest')
WANTED = NAMES[1:4]
TIMES = {
    'time': 1.0, 'Time (Seconds)': 1.0, '__time': 1.0, 'time [s]': 1.0, 'Time (ms)': 1e3,
    'timestamp_ns': 1e9,
}  # fmt: skip
MISSPELT = {'Time (s)': 1.0, 'timestamp_s': 1.0}  # what a lost letter makes of them
DECIMAL = re.compile(r' *[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)? *', re.ASCII)
GAPS = ('', 'nan', 'NaN', '-nan(ind)', '1.#QNAN', 'N/A')
HEAD = 'Coordinates\nversion=1\nnRows={rows}\nnColumns=5\ninDegrees=no\n\nendheader\n'


@dataclass(frozen=True)
class Dialect:
    """How a table was written."""

    opensim: bool
    delimiter: str
    comma: bool
    """Whether commas stand before decimals."""
    end: str
    time: str


def write_table(rng: np.random.Generator) -> tuple[Dialect, bytes]:
    """Return a table in a random dialect."""
    opensim = bool(rng.random() < 0.4)
    delimiter = str(rng.choice(['\t', ',', ';', '\t' if opensim else ',']))
    comma = delimiter != ',' and bool(rng.random() < 0.4)
    time = 'time' if opensim else str(rng.choice(list(TIMES)))
    end = str(rng.choice(['\n', '\r\n'] if opensim else ['\n', '\n', '\r\n', '\r']))
    count = int(rng.integers(3, 12))
    numbers = rng.normal(size=(count, 5))
    numbers[:, 0] = np.arange(count) * 0.01 * TIMES[time]
    rows = [[f'{value:.5f}' for value in row] for row in numbers.tolist()]
    if opensim and delimiter == '\t':
        gaps: tuple[str, ...] = GAPS[1:]  # white space has no empty cells
    else:
        gaps = GAPS
    if rng.random() < 0.3:
        rows[int(rng.integers(count))][int(rng.integers(1, 4))] = str(rng.choice(list(gaps)))
    if comma:
        rows = [[cell.replace('.', ',') for cell in row] for row in rows]
    if not opensim and rng.random() < 0.2:
        rows = [[f'"{cell}"' for cell in row] for row in rows]
    lines = [delimiter.join(row) for row in [[time, *NAMES[1:]], *rows]]
    head: list[str] = []
    if opensim:
        head = HEAD.format(rows=count).splitlines()
        if delimiter != '\t':
            head = [line + 4 * delimiter for line in head]
    elif rng.random() < 0.2:
        head = [f'sep={delimiter}']
    elif rng.random() < 0.3:
        head = ['# by hand']
    mark = b'\xef\xbb\xbf' if rng.random() < 0.2 else b''
    content = mark + ''.join(line + end for line in [*head, *lines]).encode()
    return Dialect(opensim, delimiter, comma, end, time), content


def damage(rng: np.random.Generator, content: bytes) -> bytes:
    """Return a table with something changed at random."""
    changed = bytearray(content)
    k = int(rng.integers(len(content)))
    match int(rng.integers(7)):
        case 0:
            changed[k] ^= 1 << int(rng.integers(8))
        case 1:
            del changed[k:]
        case 2:
            del changed[k : k + int(rng.integers(1, 30))]
        case 3:
            changed[k:k] = bytes(rng.choice(list(b',;\t\r\n". -e#=x0\0'), int(rng.integers(1, 3))))
        case 4:
            changed[k:k] = bytes(changed[int(rng.integers(len(content))) :][:40])
        case 5:
            words = [b'inf', b'1_0', b'0x1F', b'1,5', b'1.5', '\u0664'.encode(), b'nan', b'\xb0']
            changed[k : k + 3] = words[int(rng.integers(len(words)))]
        case _:
            old, new = (bytes([b]) for b in rng.choice(list(b',;\t.\n\r"'), 2, replace=False))
            changed = changed.replace(old, new)
    return bytes(changed)


def judge(dialect: Dialect, content: bytes) -> list[list[float]] | None:
    """Return what a table says, in s; None if it is no table any more."""
    text = content.removeprefix(b'\xef\xbb\xbf').decode('utf-8', 'replace')
    if dialect.opensim and dialect.delimiter == '\t':
        rows = [line.split() for line in text.split('\n')]
    else:
        lines = re.findall('[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+', text)
        try:
            rows = list(csv.reader(lines, delimiter=dialect.delimiter, skipinitialspace=True))
        except csv.Error:
            return None
    names = [tuple(cell.strip() for cell in row[:4]) for row in rows]
    units = {(name, *WANTED): unit for name, unit in (TIMES | MISSPELT).items()}
    places = [k for k, each in enumerate(names) if each in units]
    if not places:
        return None
    numbers = []
    for row in rows[places[0] + 1 :]:
        if any(row):
            cells = [read_cell(dialect, cell) for cell in row[:4]]
            if len(row) != 5 or None in cells:
                return None
            numbers.append([float(cell) for cell in cells if cell is not None])
            numbers[-1][0] /= units[names[places[0]]]
    return numbers


def read_cell(dialect: Dialect, cell: str) -> float | None:
    """Return the number in a cell; None if it is none, nor a gap."""
    text = cell.strip()
    if text.replace(',', '.') in GAPS or text.lower() in ('+nan', '-nan', 'nan'):
        return float('nan')
    if text.lower().lstrip('+-') == 'inf':
        return float(text)
    if dialect.comma:
        text = text.replace('.', '?').replace(',', '.')
    return float(text) if DECIMAL.fullmatch(text) else None


def read_table(path: Path) -> Floats:
    """Return what our reader makes of a table, (k, 4): the time in s, and the wanted columns."""
    chunks = [
        np.column_stack((times.astype(float), values))
        for times, values, _ in Table.from_file(path).chunks(WANTED, 4)
    ]
    return np.concatenate(chunks)


def find_faults(folder: Path, count: int, seed: int) -> tuple[list[str], int]:
    """Return a line for each damaged table that is read wrongly, and how many are read at all."""
    faults, read = [], 0
    for k in range(count):
        rng = np.random.default_rng((seed, k))
        dialect, content = write_table(rng)
        changed = damage(rng, content) if k % 10 else content
        path = folder / f'{k}.{"mot" if dialect.opensim else "csv"}'
        path.write_bytes(changed)
        try:
            found = read_table(path)
        except RecordingError as error:
            if '\n' in str(error) or changed == content:
                faults.append(f'{path}: {dialect}: refused: {error}')
            continue
        except Exception as error:
            faults.append(f'{path}: {dialect}: {type(error).__name__}: {error}')
            continue
        read += 1
        said = [judge(dialect, text) for text in (changed, content)]
        if not any(np.array_equal(found, each, equal_nan=True) for each in said if each):
            faults.append(f'{path}: {dialect}: read {found.tolist()}, but it says {said}')
    return faults, read


def main(words: list[str]) -> int:
    """Read damaged tables; print each that is read wrongly."""
    count, seed = (*map(int, words), *(1000, 17)[len(words) :])
    with tempfile.TemporaryDirectory() as folder:
        faults, read = find_faults(Path(folder), count, seed)
    print(*faults, sep='\n', end='\n' * bool(faults))
    print(f'{count:,} tables, most of them damaged: {read:,} read, {len(faults)} of them wrongly')
    return bool(faults)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
