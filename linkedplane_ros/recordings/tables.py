"""Motion tables as laboratories have them: OpenSim's .mot and .sto, and CSV, read in chunks."""

from __future__ import annotations

import csv
import re
from codecs import BOM_UTF8
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from itertools import chain, islice
from pathlib import Path

import numpy as np

from ..errors import RecordingError
from ..types import Floats

Row = tuple[int, list[str]]  # the number of its line, its cells

TIMES = ('time', 't', 'time_s', 'timestamp', 'time (s)')  # the first of them that is there
IN_DEGREES = re.compile(r'\s*inDegrees\s*=\s*(.*?)\s*', re.IGNORECASE)
QUOTED = re.compile(r'"[^"]*("|$)')
LONGEST = 2**20  # bytes of a line, thousands of columns: no file is read as a single line
PADDING = 9  # rows by which the filter prolongs a motion at each end, 3 for each coefficient


@dataclass(frozen=True)
class Table:
    """A table of motion: a column of times, and columns of numbers."""

    path: Path
    columns: tuple[str, ...]
    """The names of all columns but the time, as the file has them."""
    time_column: str
    """The name of the time in the file."""
    in_degrees: bool | None
    """What a .mot or .sto says by inDegrees; None where it says nothing, and for a CSV."""

    @classmethod
    def open(cls, path: str | Path) -> Table:
        """Read the header alone; RecordingError if it is no good.

        A .mot or .sto is OpenSim's. Any other file is CSV (RFC 4180) with a row of names, lines
        that start with # or none before it, and a comma, semicolon or tab between cells.
        """
        path = Path(path)
        with lines_of(path) as (lines, _):
            in_degrees, (line, names), _ = started(path, lines)
            found = (name for time in TIMES for name in names if name.lower() == time)
            time = next(found, None)
            if time is None:
                raise RecordingError(
                    f'{line}: names of columns expected, a time among them ({", ".join(TIMES)}); '
                    f'found {listed(names)}'
                )
            k = place(line, names, time)
        return cls(path, (*names[:k], *names[k + 1 :]), time, in_degrees)

    def chunks(
        self, names: Sequence[str], rows: int = 10_000
    ) -> Iterator[tuple[Floats, Floats, float]]:
        """Yield times (k,) s, the named columns (k, len(names)), and the share of the file read.

        k = rows until the last.

        The numbers are the file's, in its order and units; NaN for nan, and for an empty cell of a
        CSV. Cells of other columns are not looked at. RecordingError names the line of a fault.
        """
        if rows < 1:
            raise ValueError(f'chunks of {rows} rows; at least 1 expected')
        with lines_of(self.path) as (lines, share):
            _, (line, header), left = started(self.path, lines)
            places = [place(line, header, name) for name in (self.time_column, *names)]
            numbers = parsed(header, places, islice(left, rows))
            if not len(numbers):
                raise RecordingError(f'{line}: no rows of numbers after the names')
            while len(numbers):
                yield numbers[:, 0], numbers[:, 1:], share()
                numbers = parsed(header, places, islice(left, rows))


@contextmanager
def lines_of(path: Path) -> Iterator[tuple[Iterator[str], Callable[[], float]]]:
    """Open a file and give its lines, and the share of it that has been read, 0 to 1.

    A RecordingError meanwhile gets the path in front.
    """
    try:
        size = max(path.stat().st_size, 1)
        with path.open('rb') as file:
            lines = decoded(iter(partial(file.readline, LONGEST), b''))
            yield lines, lambda: min(file.tell() / size, 1.0)
    except OSError as error:
        raise RecordingError(f'{path}: cannot be read: {error.strerror}') from None
    except RecordingError as error:
        raise RecordingError(f'{path}:{error}') from None


def decoded(lines: Iterator[bytes]) -> Iterator[str]:
    """Yield the lines as text, with their ends."""
    number = 0
    for number, line in enumerate(lines, 1):
        if len(line) == LONGEST:
            raise RecordingError(f'{number}: a line of {LONGEST} bytes or more; not a table?')
        try:
            yield (line.removeprefix(BOM_UTF8) if number == 1 else line).decode()
        except UnicodeDecodeError:
            raise RecordingError(f'{number}: not UTF-8; save the table as UTF-8') from None
    if not number:
        raise RecordingError('1: empty; a header and rows of numbers expected')


def started(path: Path, lines: Iterator[str]) -> tuple[bool | None, Row, Iterator[Row]]:
    """Return inDegrees, the row of names and the rows after it."""
    if path.suffix.lower() in ('.mot', '.sto'):
        line, in_degrees, rows = opensim_rows(lines)
    else:
        line, in_degrees, rows = 1, None, csv_rows(lines)
    line, names = next(rows, (line, []))
    return in_degrees, (line, [name.strip() for name in names]), rows


def opensim_rows(lines: Iterator[str]) -> tuple[int, bool | None, Iterator[Row]]:
    """Return the line of OpenSim's `endheader`, what was said of inDegrees, the rows to come."""
    numbered, line, in_degrees = enumerate(lines, 1), 0, None
    for line, text in numbered:
        if text.strip().lower() == 'endheader':
            return line, in_degrees, ((n, cells) for n, row in numbered if (cells := row.split()))
        if said := IN_DEGREES.fullmatch(text):
            if said[1].lower() not in ('yes', 'no'):
                raise RecordingError(f'{line}: inDegrees is {said[1]!r}; yes or no expected')
            in_degrees = said[1].lower() == 'yes'
    raise RecordingError(f"{line}: the file ends, but a line 'endheader' was expected before")


def csv_rows(lines: Iterator[str]) -> Iterator[Row]:
    """Yield the rows of a CSV, its names first; the delimiter is what stands most in those."""
    for before, text in enumerate(lines):  # noqa: B007
        if text.strip() and not text.startswith('#'):
            break
    else:
        return
    delimiter = max(',;\t', key=QUOTED.sub('', text).count)
    reader = csv.reader(chain([text], lines), delimiter=delimiter, skipinitialspace=True)
    line = before + 1
    try:
        for cells in reader:
            if cells:
                yield line, cells
            line = before + reader.line_num + 1
    except csv.Error as error:
        raise RecordingError(f'{line}: not CSV: {error}') from None


def place(line: int, header: Sequence[str], name: str) -> int:
    """Return where a column stands."""
    if (count := header.count(name)) != 1:
        raise RecordingError(f'{line}: {count} columns are named {name!r}; one expected')
    return header.index(name)


def parsed(header: Sequence[str], places: Sequence[int], rows: Iterator[Row]) -> Floats:
    """Return the cells of k rows at n places, the time's first, as numbers (k, n)."""
    lines: list[int] = []
    cells: list[str] = []  # in one list: one a row would be slow to hold
    for line, row in rows:
        if len(row) != len(header):
            raise RecordingError(f'{line}: {len(row)} cells; {len(header)}, as the names, expected')
        lines.append(line)
        cells += [row[k] for k in places]
    n = len(places)
    try:
        if '_' in ''.join(cells):  # 1_0 is ten to Python alone
            raise ValueError
        flat = np.array(cells, dtype=float)
    except ValueError:
        named = ((lines[i // n], header[places[i % n]], cell) for i, cell in enumerate(cells))
        flat = np.array([number(*each) for each in named])
    numbers = flat.reshape(len(lines), n)
    for k in np.flatnonzero(~np.isfinite(numbers[:, 0])):
        raise RecordingError(f'{lines[k]}: its time is {cells[n * k]!r}; a finite number expected')
    return numbers


def number(line: int, name: str, cell: str) -> float:
    """Return the number in a cell, NaN if it is empty."""
    text = cell.strip() or 'nan'
    try:
        return float(text.replace('_', '?'))
    except ValueError:
        raise RecordingError(
            f'{line}: column {name!r}: {text[:40]!r} is no number; one like -0.5 expected'
        ) from None


def listed(names: Sequence[str]) -> str:
    """Return the first twelve names, none of them endless, in one line."""
    more = f' and {len(names) - 12} more' if len(names) > 12 else ''
    return (', '.join(' '.join(name.split())[:100] for name in names[:12]) or 'nothing') + more


def choose(columns: Sequence[str], wanted: Sequence[str]) -> tuple[str, ...]:
    """Return the column that each wanted joint stands in; RecordingError unless exactly one does.

    It has the joint's name, or else a path that ends with it, or with it and /value, as OpenSim's
    /jointset/shoulder/plane_elv/value does.
    """
    found = {
        name: [column for column in columns if column == name]
        or [column for column in columns if f'/{column}'.endswith((f'/{name}', f'/{name}/value'))]
        for name in wanted
    }
    if missing := [name for name in found if not found[name]]:
        near = near_ones(columns, missing)
        hint = f' (near: {listed(near)})' if near else ''
        raise RecordingError(
            f'no column for {listed(missing)}{hint}; the file has {listed(columns)}'
        )
    for name, several in found.items():
        if len(several) > 1:
            raise RecordingError(
                f'{len(several)} columns for {name}: {listed(several)}; one expected'
            )
    return tuple(found[name][0] for name in wanted)


def near_ones(columns: Sequence[str], missing: Sequence[str]) -> list[str]:
    """Return the columns with a name much like a missing one."""
    short = [column.lower().removesuffix('/value').rpartition('/')[2] for column in columns]
    close = chain.from_iterable(get_close_matches(name.lower(), short) for name in missing)
    return list(dict.fromkeys(columns[short.index(name)] for name in close))


def resampled(times: Floats, values: Floats, rate: float) -> tuple[Floats, Floats]:
    """Return times (n,) s at a constant rate (Hz), and the values (n, k) there, interpolated.

    times (m,) s, values (m, k); from times[0] on, never beyond times[-1], linearly. ValueError for
    fewer than 2 rows, times that do not increase, or no rate.
    """
    if len(times) < 2 or not 0.0 < rate < np.inf:
        raise ValueError(
            f'{len(times)} rows at {rate:g} Hz; at least 2 rows and a rate above 0 expected'
        )
    for late in np.flatnonzero(~(np.diff(times) > 0.0)):  # nor is NaN
        raise ValueError(f'times have to increase, but {times[late + 1]} s follows {times[late]} s')
    steps = int((times[-1] - times[0]) * rate + 1e-6)  # rounding may leave the last one short
    new = np.minimum(times[0] + np.arange(steps + 1) / rate, times[-1])
    there = np.empty((len(new), values.shape[1]))
    for k, column in enumerate(values.T):
        there[:, k] = np.interp(new, times, column)
    return new, there


def lowpassed(values: Floats, rate: float, cutoff: float) -> Floats:
    """Return values (m, k), sampled at a rate (Hz), without what is faster than the cutoff (Hz).

    Butterworth of second order, once forwards and once backwards: no lag, fourth order, half the
    amplitude left at the cutoff. ValueError for a cutoff that is not between 0 and rate / 2, for
    fewer than 10 rows, and for what is not finite: it would spread over its column.
    """
    if not 0.0 < cutoff < 0.5 * rate:
        raise ValueError(f'cutoff {cutoff:g} Hz; above 0 and below {0.5 * rate:g} Hz expected')
    if len(values) <= PADDING:
        raise ValueError(f'{len(values)} rows to filter; at least {PADDING + 1} expected')
    for row, column in np.argwhere(~np.isfinite(values)):
        raise ValueError(f'row {row + 1}, column {column + 1}: a gap; no filter goes across it')
    try:
        from scipy.signal import butter, sosfiltfilt  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise RecordingError('a low-pass filter needs SciPy: pip install scipy') from None
    sections = butter(2, cutoff, fs=rate, output='sos')
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=PADDING), dtype=float)


def differentiated(times: Floats, values: Floats) -> Floats:
    """Return the derivative (m, k) per s of values (m, k) at times (m,) s; zeros for a single row.

    Second order, but first at both ends; not finite, with NumPy's warning, where time stands still.
    """
    if len(times) < 2:
        return np.zeros(values.shape)
    return np.asarray(np.gradient(values, times, axis=0), dtype=float)
