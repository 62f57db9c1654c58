# SPDX-License-Identifier: Apache-2.0
"""Reading measured lengths and moment arms from a table (doc/how_to/fitting.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import RecordingError
from ..joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION, JointConvention
from ..muscle.broad_muscle import BroadMuscle
from ..recordings.tables.cells import parse_number
from ..recordings.tables.columns import find_column, join_names
from ..recordings.tables.dialect import csv_rows
from ..recordings.tables.lines import open_lines
from ..types import Floats
from .measurements import MOTIONS, Data, Measurement

PARTS = ('band', 'head')  # one of these names the column that says what was measured
UNITS = {'deg': math.pi / 180.0, 'rad': 1.0, 'mm': 1e-3, 'm': 1.0}
SAME = 1e-9  # rad: rounding of angles that are the same


def read_data(
    path: str | Path,
    muscle: BroadMuscle,
    convention: str = THESIS_CONVENTION.name,
    angle_scale: float = 1.0,
    step: float | None = None,
) -> Data:
    """Return the measurements in a CSV file (doc/how_to/fitting.md).

    Parameters
    ----------
    path
        The file.
    muscle
        The model whose heads or bands the table names.
    convention
        What three angles mean, a name of JOINT_CONVENTIONS.
    angle_scale
        What the angles of motions are multiplied by; 1 for a table of poses.
    step
        rad: the curves of motions are taken at its multiples, linear between the rows. None: at the
        table's own angles; always so for a table of poses.

    Raises
    ------
    RecordingError
        One line with file, line and reason.

    """
    path = Path(path)
    with open_lines(path) as (lines, _):
        *_, rows = csv_rows(lines)
        line, names = next(rows, (1, []))
        columns = Columns.from_names(line, [name.strip() for name in names], convention)
        measured = [columns.read_row(muscle, line, cells) for line, cells in rows]
        if not measured:
            raise RecordingError(f'{line}: no rows of measurements after the names')
    if columns.convention is not None:
        if step is not None or angle_scale != 1.0:
            raise RecordingError(
                f'{path}: has poses; only angles of a motion are scaled or stepped'
            )
        return Data(path, tuple(measured), 1.0, None)
    scaled = [replace(each, angles=(angle_scale * each.angles[0],)) for each in measured]
    if step is not None:
        try:
            scaled = list(_resample(scaled, step))
        except RecordingError as error:
            raise RecordingError(f'{path}: {error}') from None
    return Data(path, tuple(scaled), angle_scale, step)


@dataclass(frozen=True)
class Columns:
    """The columns of a table by their numbers; -1: there is none."""

    names: tuple[str, ...]
    part: int
    motion: int
    angles: tuple[tuple[int, float], ...]
    """Each angle's column, and its unit in rad."""
    length: tuple[int, float]
    """Its column, and its unit in m."""
    arm: tuple[int, float]
    """Its column, and its unit in m."""
    weight: int
    convention: JointConvention | None

    @staticmethod
    def from_names(line: int, names: Sequence[str], convention: str) -> Columns:
        """Return the columns of a table; RecordingError for names missing, unknown or unclear."""
        turns = JOINT_CONVENTIONS[convention]
        by_motion = 'motion' in names
        if by_motion == ('about' in names):
            raise RecordingError(
                f"{line}: a column 'motion' (with angle_deg) or 'about' (with "
                f'{", ".join(f"{each}_deg" for each in turns.coordinates)}) expected; found '
                f'{join_names(names)}'
            )
        angles = ('angle',) if by_motion else turns.coordinates
        part = next((name for name in PARTS if name in names), PARTS[0])
        columns = Columns(
            tuple(names),
            find_column(line, names, part),
            find_column(line, names, 'motion' if by_motion else 'about'),
            tuple(_unit_column(line, names, each, ('deg', 'rad')) for each in angles),
            _unit_column(line, names, 'length', ('mm', 'm'), needed=False),
            _unit_column(line, names, 'moment_arm', ('mm', 'm'), needed=False),
            names.index('weight') if 'weight' in names else -1,
            None if by_motion else turns,
        )
        known = {k for k, _ in (*columns.angles, columns.length, columns.arm)}
        known |= {columns.part, columns.motion, columns.weight}
        unknown = [name for k, name in enumerate(names) if k not in known and name != 'note']
        if unknown:
            raise RecordingError(f'{line}: unknown column {unknown[0]!r}')
        if columns.length[0] < 0 and columns.arm[0] < 0:
            raise RecordingError(f'{line}: a column length_mm or moment_arm_mm expected')
        return columns

    def read_row(self, muscle: BroadMuscle, line: int, cells: Sequence[str]) -> Measurement:
        """Return the measurement of a row; RecordingError with line and reason."""
        if len(cells) != len(self.names):
            raise RecordingError(f'{line}: {len(cells)} cells; {len(self.names)} expected')

        def value(column: tuple[int, float]) -> float:
            k, unit = column
            return unit * parse_number(line, self.names[k], cells[k]) if k >= 0 else math.nan

        part, motion = cells[self.part].strip(), cells[self.motion].strip()
        motions = tuple(MOTIONS) if self.convention is None else self.convention.coordinates
        if motion not in motions:
            raise RecordingError(
                f'{line}: column {self.names[self.motion]!r}: {motion[:40]!r}; one of '
                f'{", ".join(motions)} expected'
            )
        measurement = Measurement(
            part,
            find_band(muscle, part, line),
            motion,
            tuple(value(column) for column in self.angles),
            value(self.length),
            value(self.arm),
            value((self.weight, 1.0)) if self.weight >= 0 else 1.0,
            self.convention,
        )
        _check_measurement(measurement, line)
        return measurement


def find_band(muscle: BroadMuscle, part: str, line: int) -> int:
    """Return the number of the band that a part names: itself, or a head's representing one."""
    represented = {head.name: head.represented_by for head in muscle.heads}
    band = part if part in muscle.band_names else represented.get(part)
    if band is None:
        raise RecordingError(
            f'{line}: {part[:40]!r} is neither a head of {muscle.name} ({", ".join(represented)}) '
            f'nor one of its bands ({", ".join(muscle.band_names)})'
        )
    return muscle.band_names.index(band)


def _check_measurement(row: Measurement, line: int) -> None:
    if not all(map(math.isfinite, row.angles)):
        raise RecordingError(f'{line}: an angle is missing or not finite')
    if max(map(abs, row.angles)) > 2.0 * math.pi:
        raise RecordingError(f'{line}: an angle of more than a full turn: in degrees, or in rad?')
    if math.isnan(row.length) and math.isnan(row.arm):
        raise RecordingError(f'{line}: neither a length nor a moment arm')
    values = {'length': row.length, 'moment arm': row.arm}
    large = [name for name, value in values.items() if abs(value) > 1.0]
    if large:
        name, value = large[0], values[large[0]]
        raise RecordingError(f'{line}: a {name} of {value:g} m; in mm, or in m?')
    if row.length <= 0.0:
        raise RecordingError(f'{line}: a length of {row.length:g} m; above 0 expected')
    if not 0.0 <= row.weight < math.inf:
        raise RecordingError(f'{line}: a weight of {row.weight:g}; 0 or more expected')


def _unit_column(
    line: int, names: Sequence[str], name: str, units: Sequence[str], needed: bool = True
) -> tuple[int, float]:
    """Return the column of a quantity, by its name and unit, and the unit in rad or m."""
    found = [unit for unit in units if f'{name}_{unit}' in names]
    if len(found) > 1 or (needed and not found):
        raise RecordingError(
            f'{line}: one column {" or ".join(f"{name}_{unit}" for unit in units)} expected; '
            f'found {join_names(names)}'
        )
    if not found:
        return -1, 1.0
    return find_column(line, names, f'{name}_{found[0]}'), UNITS[found[0]]


def _resample(measurements: Sequence[Measurement], step: float) -> Iterator[Measurement]:
    """Yield each curve at the multiples of a step (rad), linear between its rows.

    RecordingError for a curve with two rows at an angle, and for one without any multiple.
    """
    curves: dict[tuple[str, str], list[Measurement]] = {}
    for each in measurements:
        curves.setdefault((each.motion, each.part), []).append(each)
    for (motion, part), curve in curves.items():
        curve.sort(key=lambda each: each.angle)
        q = np.array([each.angle for each in curve])
        twice = np.flatnonzero(np.diff(q) < SAME)
        if len(twice):
            raise RecordingError(
                f'{motion}, {part}: two rows at {math.degrees(q[twice[0]]):g} deg, one expected '
                'of a curve that is taken at steps'
            )
        first, last = math.ceil(q[0] / step - SAME), math.floor(q[-1] / step + SAME)
        angles = step * np.arange(first, last + 1)
        columns = np.array([(each.length, each.arm, each.weight) for each in curve]).T
        lengths, arms, weights = (_interpolate(angles, q, column) for column in columns)
        taken = np.isfinite(lengths) | np.isfinite(arms)
        if not taken.any():
            raise RecordingError(
                f'{motion}, {part}: no multiple of {math.degrees(step):g} deg between '
                f'{math.degrees(q[0]):g} and {math.degrees(q[-1]):g} deg'
            )
        rows = np.array((angles, lengths, arms, weights))[:, taken].T.tolist()
        for angle, length, arm, weight in rows:
            yield replace(curve[0], angles=(angle,), length=length, arm=arm, weight=weight)


def _interpolate(angles: Floats, q: Floats, values: Floats) -> Floats:
    """Return values at angles, linear between those at q that are not NaN; NaN outside of these."""
    known = np.isfinite(values)
    if not known.any():
        return np.full(len(angles), math.nan)
    found = np.interp(angles, q[known], values[known])
    beyond = (angles < q[known][0] - SAME) | (angles > q[known][-1] + SAME)
    return np.where(beyond, math.nan, found)
