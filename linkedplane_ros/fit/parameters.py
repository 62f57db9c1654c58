# SPDX-License-Identifier: Apache-2.0
"""What a fit may change: chosen numbers of a model, and where they may go.

A curve of which all coefficients are free is searched by its values at as many places along the
muscle's breadth: these are lengths or angles that one can think of, and small steps of them are
small steps of the muscle. The polynomials are the same; the file gets their coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ..errors import LinkedPlaneError
from ..linked_planes.layout import BAND_SIZE, FIRST_BAND, muscle_size
from ..muscle.definition import Definition
from ..muscle.parts import METRES, RADIANS, Curve, Polynomial
from ..muscle.validity import LIMIT
from ..types import Floats
from .places import (
    DISTANCE,
    THESIS,
    choose_places,
    curve_numbers,
    free_numbers,
    matches_place,
    place_names,
)
from .space import POINTS, SLOTS, Parameter, Space, pack_definition

SMALLEST = 1e-3  # m: no smaller radius is tried


@dataclass(frozen=True)
class Bound:
    """Where the parameters of some places may go, in the file's units."""

    pattern: str
    """Of the places."""
    low: float = -np.inf
    high: float = np.inf
    size: float = np.inf
    """How far from their start at most."""
    share: float = np.inf
    """How far from their start at most, as a share of the largest size of the quantity over the
    bands."""

    @staticmethod
    def from_text(text: str) -> Bound:
        """Return the bound that a text states.

        Parameters
        ----------
        text
            PATTERN=LOW:HIGH, PATTERN=+-SIZE or PATTERN=+-PERCENT%.

        Raises
        ------
        LinkedPlaneError
            For any other text.

        """
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
            raise LinkedPlaneError(
                f'bound {text!r}: PATTERN=LOW:HIGH, PATTERN=+-SIZE or PATTERN=+-PERCENT% expected'
            )
        return bound


def build_space(
    definition: Definition,
    free: Sequence[str] = THESIS,
    bounds: Sequence[Bound] = (),
    reach: tuple[float, float] = (0.03, 0.5),
) -> Space:
    """Return the parameters of a fit, and the model as they make it.

    Of a curve that is free as a whole, bounds and reach hold at the places along s where it is
    searched; between them it may go beyond.

    Parameters
    ----------
    definition
        The model to start from.
    free
        Patterns of the places whose numbers are free.
    bounds
        Where they may go; a later one counts before an earlier one.
    reach
        How far a value without a bound may move: m, rad.

    Raises
    ------
    LinkedPlaneError
        For a pattern that matches nothing, and for bounds without room or without the start.

    """
    builder = _Builder(definition, bounds, reach)
    left = choose_places(definition, free)
    names = place_names(definition)
    for key, curve in definition.curves().items():
        mine = [place for place in names[key] if place in left]
        if mine:
            builder.add_curve(key, curve, mine)
    for key in POINTS:
        for axis in range(3):
            if (place := f'{key}[{axis}]') in left:
                builder.add_point(key, axis, place)
    if DISTANCE in left:
        builder.add_distance()
    unused = [bound for bound in bounds if bound not in builder.used]
    if unused:
        known = ', '.join(dict.fromkeys(builder.bounded))
        raise LinkedPlaneError(
            f'bound: {unused[0].pattern!r} matches nothing that is free: {known}'
        )
    return builder.build()


class _Builder:
    """Gathers parameters one by one, each a column of what it adds."""

    def __init__(
        self, definition: Definition, bounds: Sequence[Bound], reach: tuple[float, float]
    ) -> None:
        self.definition, self.bounds, self.reach = definition, bounds, reach
        self.n = len(definition.band_names)
        self.metres, self.radians = METRES[definition.length], RADIANS[definition.angle]
        self.used: list[Bound] = []
        self.bounded: list[str] = []
        """What bounds can name: a curve that is free as a whole, otherwise a place."""
        self.parameters: list[Parameter] = []
        self.columns: list[Floats] = []
        self.rows: list[dict[str, float]] = []
        self.numbers = free_numbers(definition)
        if definition.humeral_point is not None:
            for axis, value in enumerate(definition.humeral_point):
                self.numbers[f'sphere.humeral_point[{axis}]'] = value

    def add_curve(self, key: str, curve: Curve, mine: Sequence[str]) -> None:
        """Add a curve, by values along s if all of it is free, else its free coefficients."""
        names = place_names(self.definition)[key]
        values = curve_numbers(curve)
        if not isinstance(curve, Polynomial):
            at_bands = np.eye(self.n)
        else:
            at_bands = np.vander(self.definition.s_of_bands, len(values))
        apart = len(set(np.asarray(self.definition.s_of_bands).tolist()))
        if isinstance(curve, Polynomial) and apart >= len(mine) == len(values) > 1:
            s = spread_places(self.definition.s_of_bands, len(values))
            from_values = np.linalg.inv(np.vander(s, len(values)))
            for j, value in enumerate(np.polyval(values, s).tolist()):
                name, column = f'{key}(s={s[j]:.2f})', from_values[:, j]
                rows = dict(zip(names, column.tolist(), strict=True))
                self._add_curve_parameter(name, key, key, value, at_bands @ column, rows, 1.0)
            return
        for place in mine:
            i = names.index(place)
            effect = max(float(np.abs(at_bands[:, i]).max()), 1e-12)
            column, rows = at_bands[:, i], {place: 1.0}
            self._add_curve_parameter(place, key, place, values[i], column, rows, effect)

    def _add_curve_parameter(
        self, name: str, key: str, bounded: str, start: float, at_bands: Floats,
        rows: Mapping[str, float], effect: float,
    ) -> None:  # fmt: skip
        """Add a parameter of a curve; it moves the value at a band by at most `effect` times."""
        angle = key == 'plane_angle'
        size, unit = self._unit(angle)
        column = np.zeros(muscle_size(self.n))
        column[FIRST_BAND + SLOTS[key] :: BAND_SIZE] = size * at_bands
        whole = float(np.abs(self.definition.values[key]).max()) / effect
        reach = self.reach[angle] / size / effect
        least = SMALLEST / size if key == 'sphere.radius' and effect == 1.0 else -np.inf
        most = LIMIT / size if effect == 1.0 else np.inf
        low, high = self._limits(bounded, start, whole, reach, least, most)
        self._add(Parameter(name, unit, start, low, high), column, rows)

    def add_point(self, key: str, axis: int, place: str) -> None:
        """Add a coordinate of N (which has no unit) or of SC."""
        is_point = key != 'reference_normal'
        size, unit = self._unit(False) if is_point else (1.0, '1')
        column = np.zeros(muscle_size(self.n))
        column[POINTS[key] + axis] = size
        start = self.numbers[place]
        reach = self.reach[0] / size if is_point else 0.5
        most = LIMIT / size if is_point else np.inf
        low, high = self._limits(place, start, abs(start), reach, most=most)
        self._add(Parameter(place, unit, start, low, high), column, {place: 1.0})

    def add_distance(self) -> None:
        """Add the distance of HM from the joint's centre."""
        point = np.array(self.definition.humeral_point)
        start = float(np.linalg.norm(point))
        if not start > 0.0:
            raise LinkedPlaneError(
                f'free: {DISTANCE}: HM lies in the joint centre; a direction expected'
            )
        size, unit = self._unit(False)
        column = np.zeros(muscle_size(self.n))
        k = POINTS['sphere.humeral_point']
        column[k : k + 3] = size * point / start
        rows = {f'sphere.humeral_point[{axis}]': v for axis, v in enumerate(point / start)}
        reach, most = self.reach[0] / size, LIMIT / size
        low, high = self._limits(DISTANCE, start, start, reach, most=most)
        self._add(Parameter(DISTANCE, unit, start, low, high), column, rows)

    def _unit(self, angle: bool) -> tuple[float, str]:
        """Return the unit of angles or of lengths, rad or m, and its name."""
        if angle:
            return self.radians, self.definition.angle
        return self.metres, self.definition.length

    def _limits(
        self,
        place: str,
        start: float,
        whole: float,
        reach: float,
        least: float = -np.inf,
        most: float = np.inf,
    ) -> tuple[float, float]:
        """Return the bounds of a parameter.

        A share is one of `whole`, `least` is the lowest; no model has a number of `most` or more.
        """
        self.bounded.append(place)
        bound = Bound('', size=reach)
        for each in self.bounds:
            if matches_place(each.pattern, place):
                bound = each
                self.used.append(each)
        room = min(bound.size, bound.share * whole)
        low, high = max(bound.low, start - room, least), min(bound.high, start + room)
        if not low < high:
            raise LinkedPlaneError(f'bound: {bound.pattern}: no room for {place} about {start:g}')
        if not low <= start <= high:
            raise LinkedPlaneError(
                f'bound: {bound.pattern}: {place} starts at {start:g}, outside {low:g} to {high:g}'
            )
        if max(-low, high) >= most:
            raise LinkedPlaneError(
                f'bound: {place}: {low:g} to {high:g} given, less than {most:g} expected: the '
                f'limit of a model, {LIMIT:g} m or rad'
            )
        return low, high

    def _add(self, parameter: Parameter, column: Floats, rows: Mapping[str, float]) -> None:
        self.parameters.append(parameter)
        self.columns.append(column)
        self.rows.append(dict(rows))

    def build(self) -> Space:
        """Return all of it as arrays."""
        start = np.array([parameter.start for parameter in self.parameters])
        flat = np.array(self.columns).T
        names = tuple(dict.fromkeys(place for rows in self.rows for place in rows))
        matrix = np.array([[rows.get(place, 0.0) for rows in self.rows] for place in names])
        now = np.array([self.numbers[place] for place in names])
        base = pack_definition(self.definition) - flat @ start
        rest = now - matrix @ start
        return Space(self.definition, tuple(self.parameters), base, flat, names, rest, matrix)


def spread_places(s: Floats, k: int) -> Floats:
    """Return k places, dense at the ends (Chebyshev's extremes), over the s of the bands."""
    low, high = float(s.min()), float(s.max())
    extremes = -np.cos(np.pi * np.arange(k) / (k - 1))
    return np.asarray(0.5 * (low + high) + 0.5 * (high - low) * extremes)
