# SPDX-License-Identifier: Apache-2.0
"""The motion in a table: columns of joints over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from ..errors import RecordingError
from ..joints.joint_state import FULL_CIRCLE, JointMap
from ..types import Bools, Floats, Stamps
from .head_units import head_words
from .motion import ROWS, Chunk, Refusals, seconds_to_nanoseconds
from .stretches import TimeWatch, differentiate_stretches
from .tables.columns import find_joint_columns
from .tables.table import Table
from .units import AngleRange, decide_unit, name_words


class TableMotion:
    """The motion in some columns of a table; velocities are differences in time.

    Parameters
    ----------
    path
        An OpenSim .mot or .sto, or a CSV file.
    joints
        Which columns are the coordinates.
    degrees
        Whether the columns are in degrees; None: as `units.decide_unit` finds.
    time
        The column of the time; None: one that is called as times usually are.

    Raises
    ------
    RecordingError
        If the header cannot be read, or lacks a column, or contradicts itself or `degrees`.
    """

    def __init__(
        self, path: Path, joints: JointMap, degrees: bool | None, time: str | None = None
    ) -> None:
        """Read the header; the rows are read by `chunks`."""
        self.path: Path = path
        self.refused: Refusals = Refusals()
        self.joints = joints
        self.table = Table.from_file(path, time)
        self.keeps_records = False
        self.wants_speeds = True
        try:
            self.columns = find_joint_columns(self.table.columns, joints.needed)
        except RecordingError as error:
            raise RecordingError(f'{path}: {error}') from None
        above = head_words(path, self.table.head)
        certain = [word for word in above if word.certain]
        turning = [
            column
            for column, name in zip(self.columns, joints.needed, strict=True)
            if name not in joints.sliding
        ]
        names = name_words(path, turning, alone=degrees is None and not certain)
        self.unit = decide_unit(path, degrees, (*names, *(certain if names else above)))
        self.met = AngleRange(joints.turning)
        self._needed = [joints.names.index(name) for name in joints.needed]
        self._turning = [joints.needed.index(name) for name in joints.turning]
        self._most = np.array([joints.most.get(name, FULL_CIRCLE) for name in joints.needed])
        self._to_si = np.array(
            [1.0 if name in joints.sliding else self.unit.radians for name in joints.needed]
        )
        self.facts: Mapping[str, str] = {
            'columns': ', '.join(self.columns),
            **({'times': self.table.time.description} if time or not self.table.time.plain else {}),
            'read_in': self.unit.fact,
            **joints.facts,
            'velocities': 'differentiated',
        }

    def chunks(self) -> Iterator[Chunk]:
        """Yield the rows that can be used."""
        times, rows = np.empty(0), np.empty(0, dtype=np.int64)
        angles = self._lay_out(np.empty((0, len(self._needed))))
        share = 0.0
        self._watch, self._fallen = TimeWatch(self.refused, 'row'), 0
        self._last: Stamps | None = None
        first = row = 0  # the first of the held rows that has not been yielded
        for new_times, values, share in self.table.chunks(self.columns, ROWS):
            if not self.unit.said:
                self.met.extend(values[:, self._turning])
                if self.met.largest > FULL_CIRCLE:
                    continue  # to refuse it with its whole range
            values = values * self._to_si
            good = self._find_usable(new_times, values, row)
            rows = np.concatenate((rows, row + 1 + np.flatnonzero(good)))
            row += len(new_times)
            self.refused.used += int(good.sum())
            times = np.concatenate((times, new_times[good]))
            angles = np.concatenate((angles, self._lay_out(values[good])))
            # a difference needs both neighbours: the last row waits for the next chunk
            if len(times) > 1 + first:
                yield self._chunk(times, angles, rows, slice(first, -1), share)
                times, angles, rows, first = times[-2:], angles[-2:], rows[-2:], 1
        self.met.check_circle(self.path)
        promised = self.table.promised_rows
        if promised is not None and promised != row:
            self.refused.notes.append(f'{row:,} rows are there, but its head says {promised:,}')
        if len(times) > first:
            yield self._chunk(times, angles, rows, slice(first, None), share)

    def _lay_out(self, values: Floats) -> Floats:
        """Return the coordinates (m, d) of columns; those that move no bone are 0."""
        joints = self.joints
        angles = np.zeros((len(values), len(joints.names)))
        signs, offsets = np.array(joints.signs), np.array(joints.offsets)
        angles[:, self._needed] = values * signs[self._needed] + offsets[self._needed]
        return angles

    def _chunk(
        self, times: Floats, angles: Floats, rows: Stamps, part: slice, share: float
    ) -> Chunk:
        speeds = np.full(angles.shape, np.nan)
        if self.wants_speeds:
            speeds = differentiate_stretches(times, angles)
            self._note_repeated(times[: part.stop], rows, part.start)
        try:
            stamps = seconds_to_nanoseconds(times[part])
        except RecordingError as error:
            raise RecordingError(f'{self.path}: {error}') from None
        self._watch.check(stamps, rows[part].tolist())
        before = [-1] * len(stamps)
        recorded = self._continue_times(stamps)
        return Chunk(stamps, angles[part], speeds[part], recorded, share, (), before)

    def _note_repeated(self, times: Floats, rows: Stamps, first: int) -> None:
        """Note the rows, from the first one on, that repeat the time of the row before."""
        same = np.flatnonzero(np.diff(times[max(first - 1, 0) :]) == 0) + max(first, 1)
        if len(same):
            k = int(same[0])
            line = f'time stands still at {times[k]:.10g} s in row {rows[k]}: no velocity there'
            self.refused.note('still', line, len(same))

    def _continue_times(self, stamps: Stamps) -> Stamps:
        """Return when rows would have been recorded: as their stamps, but without a fall.

        Whoever plays a bag goes by these times; those of two stretches must not mix.
        """
        before = stamps[:1] if self._last is None else self._last
        falls = np.minimum(np.diff(np.concatenate((before, stamps))), 0)
        recorded = stamps + (self._fallen - np.cumsum(falls))
        self._fallen = int(recorded[-1] - stamps[-1])
        self._last = stamps[-1:]
        return np.asarray(recorded, dtype=np.int64)

    def _find_usable(self, times: Floats, angles: Floats, row: int) -> Bools:
        """Return which rows are angles; the others are refused, as the node does."""
        finite = np.isfinite(angles).all(axis=1)
        small = ~(np.abs(angles) > self._most).any(axis=1)
        for reason, bad, hint in (
            ('not_finite', ~finite, 'a finite angle expected'),
            ('degrees', finite & ~small, f'at most 2 pi rad expected; read in {self.unit.fact}'),
        ):
            if bad.any():
                k = int(np.argmax(bad))
                where = f'row {row + k + 1}, {times[k]:.2f} s: {angles[k].tolist()}: {hint}'
                self.refused.add(reason, where, int(bad.sum()))
        return np.asarray(finite & small)
