# SPDX-License-Identifier: Apache-2.0
"""Which column of a table is the time, and in which unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import RecordingError
from ...types import Floats
from .columns import find_column, join_names

PLAIN_TIMES = ('time', 't', 'time_s', 'timestamp', 'time (s)')  # the first that is there counts
UNITS = {  # how many are a second, by every name of the unit
    's': 1.0, 'sec': 1.0, 'secs': 1.0, 'second': 1.0, 'seconds': 1.0,
    'ms': 1e3, 'msec': 1e3, 'msecs': 1e3, 'millis': 1e3, 'millisecond': 1e3, 'milliseconds': 1e3,
    'us': 1e6, 'µs': 1e6, 'μs': 1e6, 'usec': 1e6, 'micros': 1e6, 'microseconds': 1e6,
    'ns': 1e9, 'nsec': 1e9, 'nanos': 1e9, 'nanosecond': 1e9, 'nanoseconds': 1e9,
}  # fmt: skip
NO_UNITS = {  # what a time may be in, but is not read in
    'min', 'mins', 'minute', 'minutes', 'h', 'hr', 'hour', 'hours', 'd', 'day', 'days', 'cs', 'ds',
    'frame', 'frames', 'sample', 'samples', 'index', 'tick', 'ticks', 'cycle', 'cycles',
}  # fmt: skip
ROSTOPIC = '%time'  # of rostopic echo -p, in ns
UNIT = (
    r'(?:\s*[\[({]\s*(?P<bracketed>[^\])}]*?)\s*[\])}]|\s*[_/,.: ]\s*(?P<ending>[^\W_]+)'
    r'|(?<=[a-z])(?P<camel>[MUN]s|M?Sec|MS|NS|US)'
    r'|(?i:(?:(?<=time)|(?<=stamp))(?P<glued>[mun]s(?:ec)?|sec|millis|micros|nanos)))'
)
TIME = re.compile(
    rf'_*(?:(?i:time|t|time[ _]?stamp|elapsed(?:[ _]?time)?|zeit|temps|tiempo|tempo))(?:{UNIT})?'
)
WITH_UNIT = re.compile(rf'.*?{UNIT}')
SECONDS = re.compile(r'(?P<stamp>.*[._/]|)(?P<sec>secs?)')
NANOSECONDS = {'sec': ('nanosec', 'nsec'), 'secs': ('nsecs', 'nanosecs')}


@dataclass(frozen=True)
class TimeColumns:
    """The time in a table: the sum of its columns, mostly a single one."""

    names: tuple[str, ...]
    per_second: tuple[float, ...]
    """How many of each column's unit are a second."""

    @property
    def plain(self) -> bool:
        """Whether it is a single column in s."""
        return self.per_second == (1.0,)

    @property
    def description(self) -> str:
        """The columns with their units."""
        units = {1.0: 's', 1e3: 'ms', 1e6: 'us', 1e9: 'ns'}
        return ' + '.join(
            f'{name} in {units[per]}' for name, per in zip(self.names, self.per_second, strict=True)
        )

    def to_seconds(self, line: int, values: Floats) -> Floats:
        """Return the times (k,) in s, out of the cells of these columns (k, m).

        RecordingError unless two columns are whole seconds and the nanoseconds of each.
        """
        if len(self.names) == 2:
            whole, rest = values.T
            bad = (whole != np.floor(whole)) | (rest < 0.0) | (rest >= 1e9)
            if bad.any():
                raise RecordingError(
                    f'{line}: {self.names[0]!r} and {self.names[1]!r} are not whole seconds and '
                    f'nanoseconds below 1e9: {values[np.argmax(bad)].tolist()}; --time NAME'
                )
        return np.asarray((values / self.per_second).sum(axis=1))


def find_time(line: int, names: Sequence[str], wanted: str | None = None) -> TimeColumns:
    """Return the time among the columns of a table.

    Parameters
    ----------
    line
        Of the names.
    names
        Of all columns.
    wanted
        The time's name; None: by the names that it usually has.

    Raises
    ------
    RecordingError
        If no column or several can be the time, or its unit is not known.
    """
    candidates = [wanted] if wanted is not None else usual_times(names)
    stamps = [(name, other) for name in names for other in nanosecond_names(name) if other in names]
    if set(candidates) <= {name for pair in stamps for name in pair} and len(stamps) == 1:
        for name in stamps[0]:
            find_column(line, names, name)
        return TimeColumns(stamps[0], (1.0, 1e9))
    if len(set(candidates)) > 1:
        raise RecordingError(
            f'{line}: {len(candidates)} columns can be the time: {join_names(candidates)}; one '
            'expected, or --time NAME'
        )
    if not candidates:
        hint = '; commas, semicolons or tabs expected between them' if len(names) == 1 else ''
        raise RecordingError(
            f'{line}: names of columns expected, a time among them ({", ".join(PLAIN_TIMES)}, or '
            f'another unit; else --time NAME); found {join_names(names)}{hint}'
        )
    find_column(line, names, candidates[0])
    return TimeColumns((candidates[0],), (units_per_second(line, candidates[0]),))


def usual_times(names: Sequence[str]) -> list[str]:
    """Return the columns that are called as times usually are, only the plainest if there are such.

    Others are `Time (Seconds)`, `t [ms]`, `__time`.
    """
    for plain in PLAIN_TIMES:
        if found := [name for name in names if name.lower() == plain]:
            return found
    matches = ((name, TIME.fullmatch(name)) for name in names)
    return [
        name
        for name, match in matches
        if (match and (match['ending'] is None or match['ending'].lower() in UNITS))
        or (len(name) > 1 and name.lower() in UNITS)
        or name == ROSTOPIC
    ]


def units_per_second(line: int, name: str) -> float:
    """Return how many units of a time are a second: the unit that its name says, or else s."""
    match = WITH_UNIT.fullmatch(name)
    said = next(filter(None, match.groups()), '') if match else name
    unit = 'ns' if name == ROSTOPIC else said.lower()
    if unit in UNITS:
        return UNITS[unit]
    if unit in NO_UNITS or (match and match['ending'] is None):
        raise RecordingError(f'{line}: the time {name!r} is in {unit!r}; s, ms, us or ns expected')
    return 1.0


def nanosecond_names(name: str) -> list[str]:
    """Return what the column beside one of whole seconds may be called; none if it is no such."""
    match = SECONDS.fullmatch(name)
    if match is None:
        return []
    return [match['stamp'] + rest for rest in NANOSECONDS[match['sec']]]
