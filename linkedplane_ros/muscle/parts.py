# SPDX-License-Identifier: Apache-2.0
"""What a definition consists of: quantities over the bands, heads, spheres, landmarks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import FieldError, describe_value
from ..types import Floats, Point
from .validity import check_names, require_array, require_point

METRES = {'m': 1.0, 'cm': 1e-2, 'mm': 1e-3}
RADIANS = {'rad': 1.0, 'deg': math.pi / 180.0}
COORDINATES = ('flexion', 'abduction', 'rotation')


@dataclass(frozen=True)
class Polynomial:
    """A quantity as a polynomial in s; with one coefficient, it is common to all bands."""

    coefficients: tuple[float, ...]
    """Highest power first."""

    def evaluate(self, s: Floats) -> Floats:
        """Return the values (n,) at s (n,)."""
        with np.errstate(all='ignore'):
            return np.asarray(np.polyval(self.coefficients, s), dtype=np.float64)

    def multiply(self, factor: float) -> Polynomial:
        """Return the quantity times a factor."""
        return Polynomial(tuple(factor * c for c in self.coefficients))


@dataclass(frozen=True)
class Listed:
    """A quantity as a list: a value for each band."""

    values: tuple[float, ...]

    def evaluate(self, s: Floats) -> Floats:
        """Return the values (n,), whatever s (n,) is."""
        return np.array(self.values)

    def multiply(self, factor: float) -> Listed:
        """Return the quantity times a factor."""
        return Listed(tuple(factor * value for value in self.values))


Curve = Polynomial | Listed
Curves = tuple[Curve, Curve, Curve]


@dataclass(frozen=True)
class Span:
    """The s of bands that are equally spaced."""

    first: float
    last: float


@dataclass(frozen=True)
class Head:
    """A part of a muscle.

    Raises
    ------
    ModelError
        Unless the bands' names differ, and the representing one is among them.

    """

    name: str
    bands: tuple[str, ...]
    """The names of its bands."""
    represented_by: str
    """The band that represents the head in comparisons (thesis ch. 6)."""

    def __post_init__(self) -> None:
        """Check the bands; FieldError names the field."""
        object.__setattr__(self, 'bands', tuple(self.bands))
        owner = f'head {self.name}'
        check_names('bands', self.bands, owner)
        if self.represented_by not in self.bands:
            reason = f'{describe_value(self.represented_by)} is not one of the bands of the head'
            raise FieldError('represented_by', reason, owner)


@dataclass(frozen=True)
class InterferenceSphere:
    """An interference sphere: bone that no band should enter."""

    name: str
    centre: Point
    radius: float
    """Both in the unit of length of the definition."""
    bone: str = 'scapula'
    """Its bone, in whose frame the centre is."""

    def __post_init__(self) -> None:
        """Check centre and radius; FieldError names the field."""
        owner = f'interference sphere {self.name}'
        object.__setattr__(self, 'centre', require_point('centre', self.centre, owner))
        radius = float(require_array('radius', self.radius, (), owner))
        if radius <= 0.0:
            raise FieldError('radius', f'{radius:g} given, > 0 expected', owner)
        object.__setattr__(self, 'radius', radius)


@dataclass(frozen=True)
class Landmark:
    """A place on a bone that can be found on a subject, who is measured by it.

    Raises
    ------
    ModelError
        Unless the place is three finite numbers. Whether the muscle has the bone is checked there.

    """

    name: str
    bone: str
    """One of the muscle's bones: `scapula`, `humerus`, ..."""
    at: Point
    """The place in the bone's frame: m in a BroadMuscle, the file's unit in a Definition."""

    def __post_init__(self) -> None:
        """Check the place; FieldError names the field."""
        owner = f'landmark {self.name}'
        object.__setattr__(self, 'at', require_point('at', self.at, owner))


def whole_head(name: str, bands: tuple[str, ...]) -> Head:
    """Return a muscle as its own only head, which its middle band represents."""
    return Head(name, bands, bands[len(bands) // 2])


def multiply_point(point: Point, factors: Point) -> Point:
    """Return a point with each coordinate times its factor."""
    x, y, z = (value * factor for value, factor in zip(point, factors, strict=True))
    return x, y, z
