"""What a fit has done, for people: Markdown with residuals, interference and bounds, in mm."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats
from .criterion import MM, Criterion, States
from .data import Data
from .over_range import OverRange

AT_BOUND = 1e-3  # of the way between the bounds


@dataclass(frozen=True, eq=False)
class Stage:
    """The best model while bands were let so deep into the interference spheres."""

    allowed: float
    """m"""
    found: Floats
    """(p,) the parameters"""
    over: OverRange


@dataclass(frozen=True, eq=False)
class Outcome:
    """A fit that is done."""

    command: str
    """How to do it again."""
    data: Data
    criterion: Criterion
    """As it was given: without poses that the fit has added."""
    before: BroadMuscle
    after: BroadMuscle
    start: Floats
    """(p,) the parameters before"""
    over_before: OverRange
    """The range of motion before."""
    stages: tuple[Stage, ...]
    """What the fit went through, bands let into the spheres less and less; the last is its end."""

    @property
    def title(self) -> str:
        """What report and pictures are called."""
        return f'Fit of {self.after.name}'

    @property
    def found(self) -> Floats:
        """(p,) the parameters after."""
        return self.stages[-1].found

    @property
    def over(self) -> tuple[OverRange, OverRange]:
        """The range of motion before and after."""
        return self.over_before, self.stages[-1].over

    def states(self, x: Floats) -> States:
        """Return the muscle at the criterion's poses."""
        states = self.criterion.states(x)
        if isinstance(states, float):
            raise ValueError(f'{self.before.name}: a band has no path: an end lies in its sphere')
        return states

    def deviations(self, x: Floats) -> dict[str, list[tuple[str, str, float, float]]]:
        """Return for 'length' and 'moment arm' of each row: part, motion, angle and mm off."""
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


def markdown(outcome: Outcome, pictures: Mapping[str, str]) -> str:
    """Return the report; `pictures` has the pictures' titles and the names of their files."""
    lines = [f'# {outcome.title}', '', *_what(outcome), '']
    lines += ['## Residuals', '', *_residuals(outcome), '']
    lines += ['## Interference and order', '', *_interference(outcome), '']
    if len(outcome.stages) > 1:
        lines += ['## Deviation and interference', '', *_trade_off(outcome), '']
    lines += [line for title, name in pictures.items() for line in (f'![{title}]({name})', '')]
    lines += ['## Parameters', '', *_parameters(outcome), '']
    return '\n'.join(lines)


def _what(outcome: Outcome) -> Iterator[str]:
    one, weights = outcome.criterion, outcome.criterion.weights
    values = [one.value(x) for x in (outcome.start, outcome.found)]
    yield f'`{outcome.command}`'
    yield ''
    yield f'* Started from: {outcome.before.name} ({outcome.before.source})'
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


def _residuals(outcome: Outcome) -> Iterator[str]:
    before, after = outcome.deviations(outcome.start), outcome.deviations(outcome.found)
    for kind in before:
        if not before[kind]:
            continue
        yield f'| {kind}, mm | rows | mean before | mean after | rms after | worst after |'
        yield '| --- | ---: | ---: | ---: | ---: | ---: |'
        keys = dict.fromkeys((part, motion) for part, motion, _, _ in before[kind])
        for part, motion in keys:
            yield _residual_row(f'{part}, {motion}', (part, motion), before[kind], after[kind])
        yield _residual_row('**all**', None, before[kind], after[kind])
        yield ''


def _residual_row(
    name: str,
    key: tuple[str, str] | None,
    before: Sequence[tuple[str, str, float, float]],
    after: Sequence[tuple[str, str, float, float]],
) -> str:
    mine = [
        [(angle, off) for part, motion, angle, off in rows if key in (None, (part, motion))]
        for rows in (before, after)
    ]
    old, new = (np.array([off for _, off in rows]) for rows in mine)
    angle, worst = max(mine[1], key=lambda row: abs(row[1]))
    return (
        f'| {name} | {len(new)} | {np.abs(old).mean():.2f} | {np.abs(new).mean():.2f} '
        f'| {math.sqrt(np.mean(new**2)):.2f} | {worst:+.2f} at {math.degrees(angle):.0f} deg |'
    )


def _interference(outcome: Outcome) -> Iterator[str]:
    muscle, measured = outcome.after, outcome.criterion.measured
    yield '| | before | after |'
    yield '| --- | ---: | ---: |'
    depths = [outcome.states(x).depths[:measured] for x in (outcome.start, outcome.found)]
    yield _row('poses with measurements', [str(measured)] * 2)
    if len(muscle.interference_names):
        yield _row('... bands and poses that enter a sphere', [_entered(each) for each in depths])
    over = outcome.over
    yield _row('poses over the range of motion', [str(len(each.angles)) for each in over])
    if len(muscle.interference_names):
        entries = [_entered(each.depths) for each in over]
        yield _row('... bands and poses that enter a sphere', entries)
    if len(muscle.band_names) > 1:
        behind = [f'{each.disordered}, least gap {MM * each.gaps.min():.1f} mm' for each in over]
        yield _row('... bands not behind the one before', behind)
        parted = [
            f'{each.parted}, by up to {MM * (each.gaps - each.spacing).max():.1f} mm'
            for each in over
        ]
        yield _row('... bands farther from the one before than at their origins', parted)
    yield _row('... bands without a path', [str(each.inside) for each in over])
    yield _row('... largest jump of a length, mm', [f'{MM * each.jump:.2f}' for each in over])
    yield ''
    ranges = ', '.join(
        f'{name} {math.degrees(low):.0f} to {math.degrees(high):.0f}'
        for name, (low, high) in zip(
            ('flexion', 'abduction', 'rotation'), over[1].ranges, strict=True
        )
    )
    yield (
        f'The range of motion, {ranges} deg, is looked at on a grid of 10 deg and at random poses; '
        'jumps along the three coordinates and straight ways between random poses, every 0.25 deg.'
    )
    deepest = over[1].depths.max(axis=0, initial=-math.inf)
    bad = [
        f'{band} {MM * depth:.1f} mm'
        for band, depth in zip(muscle.band_names, deepest.tolist(), strict=True)
        if depth >= 0.0
    ]
    if bad:
        yield ''
        yield f'Deepest entry by band: {", ".join(bad)}.'


def mean(rows: Sequence[tuple[str, str, float, float]]) -> float:
    """Return the mean size of deviations, mm."""
    return float(np.abs([off for _, _, _, off in rows]).mean())


def _trade_off(outcome: Outcome) -> Iterator[str]:
    yield 'The best model while bands were let so deep into the spheres, over the range of motion:'
    yield ''
    kinds = [kind for kind, rows in outcome.deviations(outcome.found).items() if rows]
    means = ' | '.join(f'mean {kind}, mm' for kind in kinds)
    yield f'| let in, mm | {means} | bands and poses that enter | deepest, mm |'
    yield '| ---: |' + ' ---: |' * (len(kinds) + 2)
    for stage in outcome.stages:
        off = outcome.deviations(stage.found)
        cells = [f'{MM * stage.allowed:g}', *(f'{mean(off[kind]):.2f}' for kind in kinds)]
        yield _row(cells[0], [*cells[1:], _entered(stage.over.depths).split(',')[0],
                              f'{MM * stage.over.depths.max():.1f}'])  # fmt: skip


def _entered(depths: Floats) -> str:
    count = int((depths >= 0.0).sum())
    return f'{count} of {depths.size}' + (f', up to {MM * depths.max():.1f} mm' if count else '')


def _row(name: str, cells: Sequence[str]) -> str:
    return f'| {name} | {" | ".join(cells)} |'


def _parameters(outcome: Outcome) -> Iterator[str]:
    space = outcome.criterion.space
    bound = at_bounds(outcome.criterion, outcome.found)
    yield (
        f'{len(bound)} of {len(space.parameters)} at a bound'
        + (f': {", ".join(bound)}.' if bound else '.')
        + ' A value at s is that of a curve of which all coefficients were free.'
    )
    yield ''
    yield '| parameter | start | found | from | to |'
    yield '| --- | ---: | ---: | ---: | ---: |'
    for parameter, value in zip(space.parameters, outcome.found.tolist(), strict=True):
        cells = f'{parameter.start:.4f}', f'{value:.4f}', f'{parameter.low:.4g}'
        yield _row(f'{parameter.name}, {parameter.unit}', [*cells, f'{parameter.high:.4g}'])


def at_bounds(criterion: Criterion, x: Floats) -> list[str]:
    """Return the names of the parameters that stand at a bound."""
    low, high = criterion.space.low, criterion.space.high
    near = np.minimum(x - low, high - x) < AT_BOUND * (high - low)
    return [
        parameter.name
        for parameter, at in zip(criterion.space.parameters, near.tolist(), strict=True)
        if at
    ]
