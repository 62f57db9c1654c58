"""What a fit may change: chosen coefficients of a model, and where they may go.

A curve of which all coefficients are free is searched by its values at as many places along the
muscle's breadth: these are lengths or angles that one can think of, and small steps of them are
small steps of the muscle. The polynomials are the same; the file gets their coefficients.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from ..linked_planes.layout import (
    BAND_SIZE,
    CENTRE,
    FIRST_BAND,
    GROUND_POINT,
    HUMERAL_POINT,
    INSERTION,
    NORMAL,
    ORIGIN,
    RADIUS,
    muscle_size,
    pack_muscle,
)
from ..muscle.definition import Definition, expand_frame
from ..muscle.parts import METRES, RADIANS, Curve, Listed, Polynomial
from ..types import Floats
from .kernel import PHI, combined

THESIS = ('sphere.centre', 'sphere.radius', 'plane_angle', 'humeral_point')
"""What the thesis fitted: 25 coefficients and the distance of HM (ch. 5)."""
DISTANCE = 'humeral_point'
"""The distance of HM from the joint's centre, along its own direction."""

# Where the curves' values stand in the flat layout of a band, and the points in that of a muscle.
SLOTS = {
    'origin.x': ORIGIN, 'origin.y': ORIGIN + 1, 'origin.z': ORIGIN + 2,
    'insertion.x': INSERTION, 'insertion.y': INSERTION + 1, 'insertion.z': INSERTION + 2,
    'sphere.centre.x': CENTRE, 'sphere.centre.y': CENTRE + 1, 'sphere.centre.z': CENTRE + 2,
    'sphere.radius': RADIUS, 'plane_angle': PHI,
}  # fmt: skip
POINTS = {
    'reference_normal': NORMAL,
    'sphere.ground_point': GROUND_POINT,
    'sphere.humeral_point': HUMERAL_POINT,
}
SMALLEST = 1e-3  # m: no radius is sought below


@dataclass(frozen=True)
class Bound:
    """Where the parameters of some places may go, in the file's units.

    Between low and high; or at most a size from where they start, or a share of the largest size
    that the quantity has over the bands.
    """

    pattern: str
    low: float = -np.inf
    high: float = np.inf
    size: float = np.inf
    share: float = np.inf

    @staticmethod
    def of(text: str) -> Bound:
        """Return the bound that PATTERN=LOW:HIGH, PATTERN=+-SIZE or PATTERN=+-SHARE% states."""
        pattern, _, limits = text.rpartition('=')
        bound, numbers = Bound(pattern), [math.inf]
        with suppress(ValueError):
            if limits.startswith('+-') and limits.endswith('%'):
                numbers = [0.01 * float(limits[2:-1])]
                bound = Bound(pattern, share=numbers[0])
            elif limits.startswith('+-'):
                numbers = [float(limits[2:])]
                bound = Bound(pattern, size=numbers[0])
            else:
                low, high = map(float, limits.split(':'))
                bound, numbers = Bound(pattern, low, high), [low, high]
        room = bound.low < bound.high and bound.size > 0.0 < bound.share
        if not (pattern and room and all(map(math.isfinite, numbers))):
            raise ValueError(
                f'bound {text!r}: PATTERN=LOW:HIGH, PATTERN=+-SIZE or PATTERN=+-PERCENT% expected'
            )
        return bound


@dataclass(frozen=True)
class Parameter:
    """A number that is sought, in the file's units."""

    name: str
    unit: str
    start: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Space:
    """The p parameters of a fit, and what they make of the model."""

    definition: Definition
    parameters: tuple[Parameter, ...]
    base: Floats
    """The flat muscle (kernel.py) with all parameters zero."""
    flat: Floats
    """(size, p) what each parameter adds to the flat muscle, by its unit."""
    places: tuple[str, ...]
    """The q places of the model file that change, by the names of `BroadMuscle.coefficients`."""
    place_base: Floats
    """(q,) their numbers with all parameters zero."""
    place_rows: Floats
    """(q, p) what each parameter adds to them, by its unit."""

    @property
    def start(self) -> Floats:
        """(p,) where the model stands."""
        return np.array([parameter.start for parameter in self.parameters])

    @property
    def low(self) -> Floats:
        """(p,) in the order of the parameters."""
        return np.array([parameter.low for parameter in self.parameters])

    @property
    def high(self) -> Floats:
        """(p,) in the order of the parameters."""
        return np.array([parameter.high for parameter in self.parameters])

    def muscle(self, x: Floats) -> Floats:
        """Return the flat muscle at the parameters x (p,)."""
        return np.asarray(combined(self.base, self.flat, x))

    def coefficients(self, x: Floats) -> dict[str, float]:
        """Return the numbers of the model file at the parameters x (p,), by their places."""
        numbers = self.place_base + self.place_rows @ x
        return dict(zip(self.places, numbers.tolist(), strict=True))


def places(definition: Definition) -> dict[str, float]:
    """Return every number that can be free by its place; HM by its distance alone."""
    numbers: dict[str, float] = {}
    names = place_names(definition)
    for key, curve in definition.curves().items():
        numbers.update(zip(names[key], _values(curve), strict=True))
    given = {'reference_normal': definition.reference_normal}
    if definition.ground_point is not None and definition.humeral_point is not None:
        given['sphere.ground_point'] = definition.ground_point
        numbers[DISTANCE] = float(np.linalg.norm(definition.humeral_point))
    for key, point in given.items():
        numbers.update({f'{key}[{axis}]': value for axis, value in enumerate(point)})
    return numbers


def matches(pattern: str, place: str) -> bool:
    """Return whether a place, or the beginning of it up to a . or [, is what a pattern says."""
    place = f'sphere.{place}' if place == DISTANCE != pattern else place
    starts = [place, *(place[: found.start()] for found in re.finditer(r'[.\[]', place))]
    escaped = pattern.replace('[', '[[]')  # an index, not a set of characters
    return any(fnmatchcase(start, escaped) for start in starts)


def chosen(definition: Definition, patterns: Sequence[str]) -> list[str]:
    """Return the places that the patterns choose, in the file's order; ValueError for none."""
    known = places(definition)
    for pattern in patterns:
        if not any(matches(pattern, place) for place in known):
            heads = dict.fromkeys(re.split(r'\[|\.list', place)[0] for place in known)
            raise ValueError(
                f'free: {pattern!r} is nothing of {definition.name}; it has {", ".join(heads)}'
            )
    return [place for place in known if any(matches(pattern, place) for pattern in patterns)]


def space(
    definition: Definition,
    free: Sequence[str] = THESIS,
    bounds: Sequence[Bound] = (),
    reach: tuple[float, float] = (0.03, 0.5),
) -> Space:
    """Return the parameters that patterns of places free, and the model as they make it.

    A later bound goes before an earlier one; without one, no parameter may move a value by more
    than `reach`, m or rad. Of a curve that is free as a whole, bounds and reach hold at the places
    along s where it is sought; between them it may go beyond. ValueError for a pattern that fits
    nothing, and for bounds that leave no room or leave the start out.
    """
    builder = _Builder(definition, bounds, reach)
    left = chosen(definition, free)
    names = place_names(definition)
    for key, curve in definition.curves().items():
        mine = [place for place in names[key] if place in left]
        if mine:
            builder.curve(key, curve, mine)
    for key in POINTS:
        for axis in range(3):
            if (place := f'{key}[{axis}]') in left:
                builder.point(key, axis, place)
    if DISTANCE in left:
        builder.distance()
    for bound in bounds:
        if bound not in builder.used:
            sought = ', '.join(dict.fromkeys(builder.sought))
            raise ValueError(f'bound: {bound.pattern!r} is none of what is free: {sought}')
    return builder.made()


class _Builder:
    """Gathers parameters one by one, each a column of what it adds."""

    def __init__(
        self, definition: Definition, bounds: Sequence[Bound], reach: tuple[float, float]
    ) -> None:
        self.definition, self.bounds, self.reach = definition, bounds, reach
        self.n = len(definition.band_names)
        self.metres, self.radians = METRES[definition.length], RADIANS[definition.angle]
        self.used: list[Bound] = []
        self.sought: list[str] = []
        """What bounds can name: a curve that is free as a whole, a place else."""
        self.parameters: list[Parameter] = []
        self.columns: list[Floats] = []
        self.rows: list[dict[str, float]] = []
        self.numbers = places(definition)
        if definition.humeral_point is not None:
            for axis, value in enumerate(definition.humeral_point):
                self.numbers[f'sphere.humeral_point[{axis}]'] = value

    def curve(self, key: str, curve: Curve, mine: Sequence[str]) -> None:
        """Add a curve, by values along s if all of it is free, else its free coefficients."""
        names = place_names(self.definition)[key]
        values = _values(curve)
        if not isinstance(curve, Polynomial):
            at_bands = np.eye(self.n)
        else:
            at_bands = np.vander(self.definition.s_of_bands, len(values))
        apart = len(set(np.asarray(self.definition.s_of_bands).tolist()))
        if isinstance(curve, Polynomial) and apart >= len(mine) == len(values) > 1:
            at = nodes(self.definition.s_of_bands, len(values))
            from_values = np.linalg.inv(np.vander(at, len(values)))
            for j, value in enumerate(np.polyval(values, at).tolist()):
                rows = dict(zip(names, from_values[:, j].tolist(), strict=True))
                name = f'{key}(s={at[j]:.2f})'
                self._of_curve(name, key, key, value, at_bands @ from_values[:, j], rows, 1.0)
            return
        for place in mine:
            i = names.index(place)
            effect = max(float(np.abs(at_bands[:, i]).max()), 1e-12)
            self._of_curve(place, key, place, values[i], at_bands[:, i], {place: 1.0}, effect)

    def _of_curve(
        self, name: str, key: str, bounded: str, start: float, at_bands: Floats,
        rows: Mapping[str, float], effect: float,
    ) -> None:  # fmt: skip
        """Add a parameter of a curve; at a band it counts `effect` times at the most."""
        angle = key == 'plane_angle'
        size, unit = self._unit(angle)
        column = np.zeros(muscle_size(self.n))
        column[FIRST_BAND + SLOTS[key] :: BAND_SIZE] = size * at_bands
        whole = float(np.abs(self.definition.values[key]).max()) / effect
        reach = self.reach[angle] / size / effect
        least = SMALLEST / size if key == 'sphere.radius' and effect == 1.0 else -np.inf
        low, high = self._limits(bounded, start, whole, reach, least)
        self._add(Parameter(name, unit, start, low, high), column, rows)

    def point(self, key: str, axis: int, place: str) -> None:
        """Add a coordinate of N (which has no unit) or of SC."""
        is_point = key != 'reference_normal'
        size, unit = self._unit(False) if is_point else (1.0, '1')
        column = np.zeros(muscle_size(self.n))
        column[POINTS[key] + axis] = size
        start = self.numbers[place]
        reach = self.reach[0] / size if is_point else 0.5
        low, high = self._limits(place, start, abs(start), reach)
        self._add(Parameter(place, unit, start, low, high), column, {place: 1.0})

    def distance(self) -> None:
        """Add the distance of HM from the joint's centre."""
        point = np.array(self.definition.humeral_point)
        start = float(np.linalg.norm(point))
        if not start > 0.0:
            raise ValueError(f'free: {DISTANCE}: HM lies in the joint centre, without a direction')
        size, unit = self._unit(False)
        column = np.zeros(muscle_size(self.n))
        k = POINTS['sphere.humeral_point']
        column[k : k + 3] = size * point / start
        rows = {f'sphere.humeral_point[{axis}]': v for axis, v in enumerate(point / start)}
        low, high = self._limits(DISTANCE, start, start, self.reach[0] / size)
        self._add(Parameter(DISTANCE, unit, start, low, high), column, rows)

    def _unit(self, angle: bool) -> tuple[float, str]:
        if angle:
            return self.radians, self.definition.angle
        return self.metres, self.definition.length

    def _limits(
        self, place: str, start: float, whole: float, reach: float, least: float = -np.inf
    ) -> tuple[float, float]:
        self.sought.append(place)
        bound = Bound('', size=reach)
        for each in self.bounds:
            if matches(each.pattern, place):
                bound = each
                self.used.append(each)
        room = min(bound.size, bound.share * whole)
        low, high = max(bound.low, start - room, least), min(bound.high, start + room)
        if not low < high:
            raise ValueError(f'bound: {bound.pattern}: no room for {place} about {start:g}')
        if not low <= start <= high:
            raise ValueError(
                f'bound: {bound.pattern}: {place} starts at {start:g}, outside {low:g} to {high:g}'
            )
        return low, high

    def _add(self, parameter: Parameter, column: Floats, rows: Mapping[str, float]) -> None:
        self.parameters.append(parameter)
        self.columns.append(column)
        self.rows.append(dict(rows))

    def made(self) -> Space:
        """Return all of it as arrays."""
        start = np.array([parameter.start for parameter in self.parameters])
        flat = np.array(self.columns).T
        names = tuple(dict.fromkeys(place for rows in self.rows for place in rows))
        matrix = np.array([[rows.get(place, 0.0) for rows in self.rows] for place in names])
        now = np.array([self.numbers[place] for place in names])
        base = flat_numbers(self.definition) - flat @ start
        rest = now - matrix @ start
        return Space(self.definition, tuple(self.parameters), base, flat, names, rest, matrix)


def nodes(s: Floats, k: int) -> Floats:
    """Return k places, dense at the ends (Chebyshev's extremes), over the s of the bands."""
    low, high = float(s.min()), float(s.max())
    ways = -np.cos(np.pi * np.arange(k) / (k - 1))
    return np.asarray(0.5 * (low + high) + 0.5 * (high - low) * ways)


def flat_numbers(definition: Definition) -> Floats:
    """Return a definition as `kernel.evaluate` takes it: m and rad."""
    metres, values = METRES[definition.length], definition.values
    origins, insertions, centres = (
        metres * np.column_stack([values[f'{key}.{axis}'] for axis in 'xyz'])
        for key in ('origin', 'insertion', 'sphere.centre')
    )
    ground_point, humeral_point = (
        None if point is None else metres * np.array(point)
        for point in (definition.ground_point, definition.humeral_point)
    )
    phi = RADIANS[definition.angle] * values['plane_angle']
    return pack_muscle(
        definition.reference_normal,
        ground_point,
        humeral_point,
        origins,
        insertions,
        centres,
        metres * values['sphere.radius'],
        phi,
        np.zeros_like(phi),
        expand_frame(definition.sphere_frame, len(phi)),
    )


def place_names(definition: Definition) -> dict[str, list[str]]:
    """Return the places of each curve's numbers, as `BroadMuscle.coefficients` names them."""
    curves = definition.curves()
    names = {}
    for key, curve in curves.items():
        count = len(_values(curve))
        point, _, axis = key.rpartition('.')
        if isinstance(curve, Polynomial):
            names[key] = [key] if count == 1 else [f'{key}[{i}]' for i in range(count)]
        elif axis in 'xyz' and all(isinstance(curves[f'{point}.{a}'], Listed) for a in 'xyz'):
            names[key] = [f'{point}.list[{i}][{"xyz".index(axis)}]' for i in range(count)]
        else:
            names[key] = [f'{key}.list[{i}]' for i in range(count)]
    return names


def _values(curve: Curve) -> tuple[float, ...]:
    return curve.coefficients if isinstance(curve, Polynomial) else curve.values
