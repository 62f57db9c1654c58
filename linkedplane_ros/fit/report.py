# SPDX-License-Identifier: Apache-2.0
"""What a fit has done, as Markdown: residuals, interference and bounds, in mm."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..drawing.markdown import markdown_table
from ..drawing.units import MILLIMETRES
from ..errors import LinkedPlaneError, escape_controls
from ..muscle.broad_muscle import BroadMuscle
from ..muscle.parts import COORDINATES
from ..types import Floats
from .criterion import Criterion
from .measurements import Data
from .states import FitStates
from .survey import Survey

AT_BOUND = 1e-3  # of the way between the bounds


@dataclass(frozen=True, eq=False)
class Stage:
    """The best model of a stage of a fit."""

    allowed: float
    """m, how deep bands were let into the interference spheres."""
    best: Floats
    """(p,) its parameters, in the file's units."""
    survey: Survey
    """Of its range of motion."""


@dataclass(frozen=True, eq=False)
class FinishedFit:
    """A fit that is done."""

    command: str
    """The command line that repeats it."""
    data: Data
    criterion: Criterion
    """As it was given to the fit, which may have added poses."""
    before: BroadMuscle
    after: BroadMuscle
    start: Floats
    """(p,) the parameters before."""
    survey_before: Survey
    """Of the range of motion before."""
    stages: tuple[Stage, ...]
    """In each, bands were let less deep into the spheres than in the one before; the last one is
    the end of the fit."""

    @property
    def title(self) -> str:
        """The title of the report and of the pictures."""
        return f'Fit of {self.after.name}'

    @property
    def end(self) -> Floats:
        """(p,) the parameters after."""
        return self.stages[-1].best

    @property
    def surveys(self) -> tuple[Survey, Survey]:
        """Of the range of motion before and after."""
        return self.survey_before, self.stages[-1].survey

    def states(self, x: Floats) -> FitStates:
        """Return the muscle at the criterion's poses; LinkedPlaneError if it has no path."""
        states = self.criterion.states(x)
        if isinstance(states, float):
            raise LinkedPlaneError(
                f'{self.before.name}: a band has no path: an end lies in its sphere'
            )
        return states

    def deviations(self, x: Floats) -> dict[str, list[tuple[str, str, float, float]]]:
        """Return of each measured 'length' and 'moment arm': part, motion, rad, mm off."""
        rows = self.data.measurements
        found = self.criterion.deviations(self.states(x))
        kinds: dict[str, list[tuple[str, str, float, float]]] = {}
        for kind, values, of in zip(
            ('length', 'moment arm'), found, ('length', 'arm'), strict=True
        ):
            measured = [row for row in rows if math.isfinite(getattr(row, of))]
            kinds[kind] = [
                (row.part, row.motion, row.angle, value)
                for row, value in zip(measured, values.tolist(), strict=True)
            ]
        return kinds


def report_text(outcome: FinishedFit, pictures: Mapping[str, str]) -> str:
    """Return the report; `pictures` has the names of the pictures' files by their titles."""
    lines = [f'# {outcome.title}', '', *_summary(outcome), '']
    lines += ['## Residuals', '', *_residuals(outcome), '']
    lines += ['## Interference and order', '', *_interference(outcome), '']
    if len(outcome.stages) > 1:
        lines += ['## Deviation and interference', '', *_trade_off(outcome), '']
    lines += [line for title, name in pictures.items() for line in (f'![{title}]({name})', '')]
    lines += ['## Parameters', '', *_parameters(outcome), '']
    return '\n'.join(lines)


def _summary(outcome: FinishedFit) -> Iterator[str]:
    one, weights = outcome.criterion, outcome.criterion.weights
    values = [one.value(x) for x in (outcome.start, outcome.end)]
    yield f'`{outcome.command}`'
    yield ''
    yield f'* Started from: {outcome.before.name} ({escape_controls(outcome.before.source)})'
    yield (
        f'* Data: `{outcome.data.path.name}`, {len(outcome.data.measurements)} rows; '
        f'{outcome.data.reading}'
    )
    taken = ' (poses taken in on the way left out)' if len(one.rotations) > one.measured else ''
    yield (
        f'* Criterion (thesis eq. 5.7){taken}: {values[0]:,.1f} mm² before, {values[1]:,.1f} mm² '
        f'after; weights: length {weights.length:g}, moment arm {weights.arm:g}, interference '
        f'{weights.interference:g}, order {weights.order:g}, jumps {weights.jumps:g}'
    )
    if weights.arm_scale != 1.0:
        yield f'* Modelled moment arms times {weights.arm_scale:g} before they are compared'
    yield (
        '* Right shoulder; angles are those of the humerus against the scapula. Moment arms are '
        'positive where shortening carries the motion on; all deviations are modelled less measured'
    )


def _residuals(outcome: FinishedFit) -> Iterator[str]:
    before, after = outcome.deviations(outcome.start), outcome.deviations(outcome.end)
    for kind in before:
        if not before[kind]:
            continue
        keys = dict.fromkeys((part, motion) for part, motion, _, _ in before[kind])
        rows = [_residual_row(', '.join(key), key, before[kind], after[kind]) for key in keys]
        rows.append(_residual_row('**all**', None, before[kind], after[kind]))
        columns = f'{kind}, mm', 'rows', 'mean before', 'mean after', 'rms after', 'worst after'
        yield markdown_table(columns, rows, 'lrrrrr')
        yield ''


def _residual_row(
    name: str,
    key: tuple[str, str] | None,
    before: Sequence[tuple[str, str, float, float]],
    after: Sequence[tuple[str, str, float, float]],
) -> tuple[str, ...]:
    mine = [
        [(angle, off) for part, motion, angle, off in rows if key in (None, (part, motion))]
        for rows in (before, after)
    ]
    old, new = (np.array([off for _, off in rows]) for rows in mine)
    angle, worst = max(mine[1], key=lambda row: abs(row[1]))
    return (
        name,
        str(len(new)),
        f'{np.abs(old).mean():.2f}',
        f'{np.abs(new).mean():.2f}',
        f'{math.sqrt(np.mean(new**2)):.2f}',
        f'{worst:+.2f} at {math.degrees(angle):.0f} deg',
    )


def _interference(outcome: FinishedFit) -> Iterator[str]:
    muscle, (_, after) = outcome.after, outcome.surveys
    yield markdown_table(('', 'before', 'after'), _interference_rows(outcome), 'lrr')
    yield ''
    ranges = ', '.join(
        f'{name} {math.degrees(low):.0f} to {math.degrees(high):.0f}'
        for name, (low, high) in zip(COORDINATES, after.ranges, strict=True)
    )
    yield (
        f'The range of motion, {ranges} deg, is checked on a grid of 10 deg and at random poses; '
        'jumps along the three coordinates and straight ways between random poses, every 0.25 deg.'
    )
    deepest = after.depths.max(axis=0, initial=-math.inf)
    bad = [
        f'{band} {in_millimetres(depth)}'
        for band, depth in zip(muscle.band_names, deepest.tolist(), strict=True)
        if depth >= 0.0
    ]
    if bad:
        yield ''
        yield f'Deepest entry by band: {", ".join(bad)}.'


def _interference_rows(outcome: FinishedFit) -> Iterator[tuple[str, ...]]:
    """Yield what is counted, before and after."""
    muscle, surveys, measured = outcome.after, outcome.surveys, outcome.criterion.measured
    spheres = len(muscle.interference_names)
    yield 'poses with measurements', str(measured), str(measured)
    if spheres:
        depths = (outcome.states(x).depths[:measured] for x in (outcome.start, outcome.end))
        yield '... bands and poses that enter a sphere', *map(_entered, depths)
    yield 'poses over the range of motion', *(str(len(each.angles)) for each in surveys)
    if spheres:
        entries = (_entered(each.depths) for each in surveys)
        yield '... bands and poses that enter a sphere', *entries
    if len(muscle.band_names) > 1:
        behind = (
            f'{each.disordered}, least gap {in_millimetres(each.gaps.min())}' for each in surveys
        )
        yield '... bands not behind the one before', *behind
        parted = (
            f'{each.parted}, by up to {in_millimetres((each.gaps - each.spacing).max())}'
            for each in surveys
        )
        yield '... bands farther from the one before than at their origins', *parted
    yield '... bands without a path', *(str(each.inside) for each in surveys)
    jumps = (f'{MILLIMETRES * each.jump:.2f}' for each in surveys)
    yield '... largest jump of a length, mm', *jumps


def in_millimetres(length: float) -> str:
    """Return a length, m, in mm."""
    return f'{MILLIMETRES * length:.1f} mm'


def mean_deviation(rows: Sequence[tuple[str, str, float, float]]) -> float:
    """Return the mean of the deviations' sizes, mm."""
    return float(np.abs([off for _, _, _, off in rows]).mean())


def _trade_off(outcome: FinishedFit) -> Iterator[str]:
    yield 'The best model while bands were let so deep into the spheres, over the range of motion:'
    yield ''
    kinds = [kind for kind, rows in outcome.deviations(outcome.end).items() if rows]
    rows = []
    for stage in outcome.stages:
        off = outcome.deviations(stage.best)
        means = (f'{mean_deviation(off[kind]):.2f}' for kind in kinds)
        entered, deepest = _entered(stage.survey.depths).split(',')[0], stage.survey.depths.max()
        allowed, reached = f'{MILLIMETRES * stage.allowed:g}', f'{MILLIMETRES * deepest:.1f}'
        rows.append((allowed, *means, entered, reached))
    means = (f'mean {kind}, mm' for kind in kinds)
    columns = ('let in, mm', *means, 'bands and poses that enter', 'deepest, mm')
    yield markdown_table(columns, rows, 'r' * len(columns))


def _entered(depths: Floats) -> str:
    count = int((depths >= 0.0).sum())
    deepest = f', up to {in_millimetres(depths.max())}' if count else ''
    return f'{count} of {depths.size}{deepest}'


def _parameters(outcome: FinishedFit) -> Iterator[str]:
    space = outcome.criterion.space
    bound = names_at_bounds(outcome.criterion, outcome.end)
    yield (
        f'{len(bound)} of {len(space.parameters)} at a bound'
        + (f': {", ".join(bound)}.' if bound else '.')
        + ' A value at s is that of a curve of which all coefficients were free.'
    )
    yield ''
    rows = [
        (
            f'{parameter.name}, {parameter.unit}',
            f'{parameter.start:.4f}',
            f'{value:.4f}',
            f'{parameter.low:.4g}',
            f'{parameter.high:.4g}',
        )
        for parameter, value in zip(space.parameters, outcome.end.tolist(), strict=True)
    ]
    yield markdown_table(('parameter', 'start', 'found', 'from', 'to'), rows, 'lrrrr')


def names_at_bounds(criterion: Criterion, x: Floats) -> list[str]:
    """Return the names of the parameters whose values x (p,) are at a bound."""
    low, high = criterion.space.low, criterion.space.high
    near = np.minimum(x - low, high - x) < AT_BOUND * (high - low)
    return [
        parameter.name
        for parameter, is_near in zip(criterion.space.parameters, near.tolist(), strict=True)
        if is_near
    ]
