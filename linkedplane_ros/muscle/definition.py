"""A model as its file states it: polynomials stay polynomials, and lengths in the file's unit.

Nothing is lost between a file and its definition. What the solver works with, arrays in m and rad,
is evaluated here and nowhere else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import ModelError
from ..types import Floats, Interval, Point

METRES = {'m': 1.0, 'cm': 1e-2, 'mm': 1e-3}
RADIANS = {'rad': 1.0, 'deg': math.pi / 180.0}
FRAMES = ('moving', 'ground', 'humerus')
"""What a sphere moves with: its band's moving frame, the scapula, the humerus."""
BONES = ('scapula', 'humerus')
COORDINATES = ('flexion', 'abduction', 'rotation')


@dataclass(frozen=True)
class Polynomial:
    """A quantity as a polynomial in s, highest power first; one coefficient: common to all."""

    coefficients: tuple[float, ...]

    def at(self, s: Floats) -> Floats:
        """Return the values (n,) at the bands' s (n,)."""
        with np.errstate(all='ignore'):
            return np.asarray(np.polyval(self.coefficients, s), dtype=np.float64)

    def times(self, factor: float) -> Polynomial:
        """Return the quantity times a factor."""
        return Polynomial(tuple(factor * c for c in self.coefficients))


@dataclass(frozen=True)
class Listed:
    """A quantity as a list: a value for each band."""

    values: tuple[float, ...]

    def at(self, s: Floats) -> Floats:
        """Return the values (n,), whatever the bands' s (n,)."""
        return np.array(self.values)

    def times(self, factor: float) -> Listed:
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
    """A part of the muscle: its bands and the one that stands for it in comparisons."""

    name: str
    bands: tuple[str, ...]
    represented_by: str


@dataclass(frozen=True)
class Sphere:
    """An interference sphere: bone that no band should enter, ground frame."""

    name: str
    centre: Point
    radius: float


@dataclass(frozen=True)
class Landmark:
    """A place on a bone that a laboratory can find on a subject."""

    name: str
    bone: str
    """scapula or humerus"""
    at: Point
    """In the bone's frame."""

    def __post_init__(self) -> None:
        """Check bone and place; ModelError says what would be right."""
        if self.bone not in BONES:
            raise ModelError(f'landmark {self.name}: {self.bone!r} given, one of {BONES} expected')
        place = np.array(self.at, dtype=np.float64)
        if place.shape != (3,):
            raise ModelError(f'landmark {self.name}: shape {place.shape} given, (3,) expected')
        object.__setattr__(self, 'at', tuple(place.tolist()))


@dataclass(frozen=True)
class Definition:
    """What a model file states, in its own units; the fields are those of the model file."""

    name: str
    source: str
    licence: str
    length: str
    """The unit of length, one of METRES."""
    angle: str
    """The unit of angles, one of RADIANS."""
    band_names: tuple[str, ...]
    s: Span | tuple[float, ...] | None
    heads: tuple[Head, ...]
    origin: Curves
    insertion: Curves
    sphere_frame: str | tuple[str, ...]
    """One of FRAMES, or one for each band."""
    sphere_centre: Curves
    sphere_radius: Curve
    ground_point: Point | None
    humeral_point: Point | None
    plane_angle: Curve
    reference_normal: Point
    interference_spheres: tuple[Sphere, ...] = ()
    landmarks: tuple[Landmark, ...] = ()
    range_of_motion: tuple[Interval, Interval, Interval] | None = None

    @cached_property
    def s_of_bands(self) -> Floats:
        """(n,) s of each band; zeros where none is stated, and none needed."""
        n = len(self.band_names)
        if isinstance(self.s, Span):
            return np.linspace(self.s.first, self.s.last, n)
        return np.zeros(n) if self.s is None else np.array(self.s)

    def curves(self) -> dict[str, Curve]:
        """Return what may vary over the bands, by its key in the file."""
        curves: dict[str, Curve] = {}
        for key, points in (
            ('origin', self.origin),
            ('insertion', self.insertion),
            ('sphere.centre', self.sphere_centre),
        ):
            curves.update(zip((f'{key}.{axis}' for axis in 'xyz'), points, strict=True))
        return {**curves, 'sphere.radius': self.sphere_radius, 'plane_angle': self.plane_angle}

    @cached_property
    def values(self) -> dict[str, Floats]:
        """The curves' values (n,) at the bands, in the file's units, by the key in the file."""
        return {key: curve.at(self.s_of_bands) for key, curve in self.curves().items()}

    @cached_property
    def evaluated(self) -> dict[str, Any]:
        """The fields of the BroadMuscle that this defines, by name, in m and rad."""
        metres, radians, values = METRES[self.length], RADIANS[self.angle], self.values

        def points(key: str) -> Floats:
            return np.column_stack([values[f'{key}.{axis}'] for axis in 'xyz']) * metres

        def point(given: Point | None) -> Floats | None:
            return None if given is None else np.array(given) * metres

        spheres = self.interference_spheres
        return {
            'name': self.name,
            'source': self.source,
            'licence': self.licence,
            'band_names': self.band_names,
            'heads': self.heads,
            'origins': points('origin'),
            'insertions': points('insertion'),
            'sphere_frame': self.sphere_frame,
            'sphere_centres': points('sphere.centre'),
            'sphere_radii': values['sphere.radius'] * metres,
            'ground_point': point(self.ground_point),
            'humeral_point': point(self.humeral_point),
            'plane_angles': values['plane_angle'] * radians,
            'reference_normal': unit(np.array(self.reference_normal)),
            'interference_names': tuple(sphere.name for sphere in spheres),
            'interference_centres': np.array([sphere.centre for sphere in spheres]).reshape(-1, 3)
            * metres,
            'interference_radii': np.array([sphere.radius for sphere in spheres]) * metres,
            'landmarks': tuple(
                Landmark(mark.name, mark.bone, scaled_by(mark.at, metres))
                for mark in self.landmarks
            ),
            'range_of_motion': self.range_of_motion
            and tuple((low * radians, high * radians) for low, high in self.range_of_motion),
        }


def frames_of(frame: str | tuple[str, ...], n: int) -> tuple[str, ...]:
    """Return each band's frame (n), where one may be stated for all."""
    return (frame,) * n if isinstance(frame, str) else frame


def scaled_by(point: Point, factor: float) -> Point:
    """Return a point times a factor."""
    x, y, z = point
    return x * factor, y * factor, z * factor


def unit(vector: Floats) -> Floats:
    """Return a vector (3,) at length 1; one that has it to rounding, or none, stays as it is."""
    size = float(np.linalg.norm(vector))
    return vector if abs(size - 1.0) < 1e-12 or size == 0.0 else vector / size


def in_metres(fields: dict[str, Any]) -> Definition:
    """Return the definition of a BroadMuscle's fields: explicit lists, in m and rad."""

    def columns(points: Floats) -> Any:
        return tuple(Listed(tuple(column)) for column in points.T.tolist())

    def listed(values: Floats | None) -> Any:
        return None if values is None else tuple(values.tolist())

    spheres = zip(
        fields['interference_names'],
        fields['interference_centres'].tolist(),
        fields['interference_radii'].tolist(),
        strict=True,
    )
    return Definition(
        name=fields['name'],
        source=fields['source'],
        licence=fields['licence'],
        length='m',
        angle='rad',
        band_names=fields['band_names'],
        s=None,
        heads=fields['heads'],
        origin=columns(fields['origins']),
        insertion=columns(fields['insertions']),
        sphere_frame=fields['sphere_frame'],
        sphere_centre=columns(fields['sphere_centres']),
        sphere_radius=Listed(listed(fields['sphere_radii'])),
        ground_point=listed(fields['ground_point']),
        humeral_point=listed(fields['humeral_point']),
        plane_angle=Listed(listed(fields['plane_angles'])),
        reference_normal=listed(fields['reference_normal']),
        interference_spheres=tuple(
            Sphere(name, (x, y, z), radius) for name, (x, y, z), radius in spheres
        ),
        landmarks=fields['landmarks'],
        range_of_motion=fields['range_of_motion'],
    )
