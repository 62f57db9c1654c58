# SPDX-License-Identifier: Apache-2.0
"""A model as its file states it: polynomials stay polynomials, and lengths in the file's unit.

A file and its definition say the same, to the bit. What the solver works with, arrays in m and rad,
is evaluated here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import FieldError
from ..types import Floats, Interval, Point
from .bones import BALL_JOINT, Bones
from .parts import (
    METRES,
    RADIANS,
    Curve,
    Curves,
    Head,
    InterferenceSphere,
    Landmark,
    Listed,
    Polynomial,
    Span,
    multiply_point,
    whole_head,
)
from .validity import check_names, require_array, require_choice


@dataclass(frozen=True)
class Definition:
    """What a model file states of a muscle of n bands, in the file's units.

    The fields are the keys of the file (keys.py), which say what they mean.

    Raises
    ------
    ModelError
        Where the parts do not suit each other: a list that is not as long as there are bands, a
        polynomial without s, a moving frame without its points. Whether the numbers make a muscle
        is checked where that is made, by `BroadMuscle.from_definition`.

    """

    name: str
    source: str
    licence: str
    """Empty where none is stated."""
    length: str
    """The unit of length, one of METRES."""
    angle: str
    """The unit of angles, one of RADIANS."""
    band_names: tuple[str, ...]
    """(n)"""
    s: Span | tuple[float, ...] | None
    """Of the first and the last band, or (n); None where there are no polynomials."""
    heads: tuple[Head, ...]
    origin: Curves
    """x, y and z, each in the frame of its bone: the ground, if `bones` does not say otherwise."""
    insertion: Curves
    """x, y and z, each in the frame of its bone: the humerus, as above."""
    sphere_frame: str | tuple[str, ...]
    """One of `bones.frames`, or (n) one for each band."""
    sphere_centre: Curves
    """x, y and z, each in its `sphere_frame`."""
    sphere_radius: Curve
    ground_point: Point | None
    """SC, ground frame; None without a moving frame."""
    humeral_point: Point | None
    """HM, humerus frame; None without a moving frame."""
    plane_angle: Curve
    """phi"""
    reference_normal: Point
    """N, ground frame, of any length."""
    interference_spheres: tuple[InterferenceSphere, ...] = ()
    landmarks: tuple[Landmark, ...] = ()
    range_of_motion: tuple[Interval, Interval, Interval] | None = None
    bones: Bones = BALL_JOINT

    def __post_init__(self) -> None:
        """Check units, frames, s and the lengths of lists; FieldError names the file's key."""
        require_choice('units.length', self.length, METRES)
        require_choice('units.angle', self.angle, RADIANS)
        check_names('bands.names', self.band_names)
        object.__setattr__(self, 'heads', self.heads or (whole_head(self.name, self.band_names),))
        n = len(self.band_names)
        if isinstance(self.s, Span):
            require_array('bands.s', (self.s.first, self.s.last), (2,))
        elif self.s is not None:
            check_count('bands.s', len(self.s), n)
            require_array('bands.s', self.s, (n,))
        self.bones.check_count(n)
        check_bones(self.bones, self.landmarks, 'landmarks')
        check_bones(self.bones, self.interference_spheres, 'interference_spheres')
        self._check_frame()
        self._check_curves()

    @property
    def version(self) -> int:
        """The version of the format that its file has: the first that can say all."""
        standing = all(each.bone == self.bones.ground for each in self.interference_spheres)
        return 1 if standing and self.bones == BALL_JOINT else 2

    def _check_frame(self) -> None:
        """Refuse SC and HM without a moving frame, and such a frame without them."""
        n = len(self.band_names)
        frame = require_frame('sphere.frame', self.sphere_frame, n, self.bones.frames)
        frames = expand_frame(frame, n)
        points = {
            'sphere.ground_point': self.ground_point,
            'sphere.humeral_point': self.humeral_point,
        }
        moving = 'moving' in frames
        wrong = [key for key, point in points.items() if (point is not None) is not moving]
        if wrong and moving:
            raise FieldError(wrong[0], 'missing')
        if wrong:
            given = ', '.join(dict.fromkeys(frames))
            raise FieldError(wrong[0], f'is for moving frames; given here: {given}')

    def _check_curves(self) -> None:
        """Refuse lists that are not as long as the muscle has bands, and polynomials without s."""
        n = len(self.band_names)
        wrong = [each for each in self._lists() if each[1] != n]
        if wrong:
            key, count, what = wrong[0]
            check_count(key, count, n, what)
        varying = [
            key
            for key, curve in self.curves().items()
            if isinstance(curve, Polynomial) and len(curve.coefficients) > 1
        ]
        if varying and self.s is None:
            raise FieldError('bands.s', f'missing; {varying[0]} is a polynomial in s')

    def _lists(self) -> Iterator[tuple[str, int, str]]:
        """Yield the key of each list, how many it has, and of what."""
        for key, points in self.points().items():
            counts = {len(axis.values) if isinstance(axis, Listed) else -1 for axis in points}
            if len(counts) == 1 and -1 not in counts:
                yield key, counts.pop(), 'points, one for each band,'
        for key, curve in self.curves().items():
            if isinstance(curve, Listed):
                yield key, len(curve.values), 'numbers'

    @cached_property
    def s_of_bands(self) -> Floats:
        """(n,) s of each band; zeros where none is stated, and none needed."""
        n = len(self.band_names)
        if isinstance(self.s, Span):
            with np.errstate(all='ignore'):  # what is not finite is refused
                return np.linspace(self.s.first, self.s.last, n)
        return np.zeros(n) if self.s is None else np.array(self.s)

    def points(self) -> dict[str, Curves]:
        """Return the points that may vary over the bands, by their keys in the file."""
        return {
            'origin': self.origin,
            'insertion': self.insertion,
            'sphere.centre': self.sphere_centre,
        }

    def curves(self) -> dict[str, Curve]:
        """Return what may vary over the bands, by its key in the file."""
        curves = {
            f'{key}.{axis}': curve
            for key, points in self.points().items()
            for axis, curve in zip('xyz', points, strict=True)
        }
        return {**curves, 'sphere.radius': self.sphere_radius, 'plane_angle': self.plane_angle}

    @cached_property
    def values(self) -> dict[str, Floats]:
        """The curves' values (n,) at the bands, in the file's units, by the key in the file."""
        return {key: curve.evaluate(self.s_of_bands) for key, curve in self.curves().items()}

    @cached_property
    def muscle_fields(self) -> dict[str, Any]:
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
            'reference_normal': unit_vector(np.array(self.reference_normal)),
            'interference_names': tuple(sphere.name for sphere in spheres),
            'interference_centres': np.array([sphere.centre for sphere in spheres]).reshape(-1, 3)
            * metres,
            'interference_radii': np.array([sphere.radius for sphere in spheres]) * metres,
            'interference_bones': tuple(sphere.bone for sphere in spheres)
            if any(sphere.bone != self.bones.ground for sphere in spheres)
            else (),
            'landmarks': tuple(
                Landmark(mark.name, mark.bone, multiply_point(mark.at, (metres,) * 3))
                for mark in self.landmarks
            ),
            'range_of_motion': self.range_of_motion
            and tuple((low * radians, high * radians) for low, high in self.range_of_motion),
            'bones': self.bones,
        }


def check_count(key: str, count: int, n: int, what: str = 'numbers') -> None:
    """Refuse a list that does not have something for each of n bands."""
    if count != n:
        raise FieldError(key, f'a list of {n} {what} expected, a list of {count} given')


def check_bones(
    bones: Bones, parts: Iterable[Landmark] | Iterable[InterferenceSphere], key: str
) -> None:
    """Refuse landmarks, or interference spheres, on a bone that is not there."""
    for each in parts:
        bones.require(f'{key}.{each.name}.bone', each.bone)


def require_frame(field: str, value: Any, n: int, known: tuple[str, ...]) -> str | tuple[str, ...]:
    """Return what spheres move with, one of the known for all or n of them; or FieldError."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        return require_choice(field, value, known)
    frames = tuple(value)
    check_count(field, len(frames), n, 'frames, one for each band,')
    return tuple(require_choice(f'{field}[{i}]', each, known) for i, each in enumerate(frames))


def expand_frame(frame: str | tuple[str, ...], n: int) -> tuple[str, ...]:
    """Return a frame for each of n bands, where one may be stated for all."""
    return (frame,) * n if isinstance(frame, str) else frame


def unit_vector(vector: Floats) -> Floats:
    """Return a vector (3,) at length 1; of length 1 to rounding, or of length 0, as it is."""
    largest = float(np.abs(vector).max())
    if largest == 0.0:
        return vector
    if not 1e-150 < largest < 1e150:  # the squares vanish or overflow
        vector = vector / largest
    size = float(np.linalg.norm(vector))
    return vector if abs(size - 1.0) < 1e-12 else vector / size


def define_in_metres(fields: dict[str, Any]) -> Definition:
    """Return the definition of a BroadMuscle's fields: lists, in m and rad."""

    def curves(points: Floats) -> Any:
        return tuple(Listed(tuple(column)) for column in points.T.tolist())

    def numbers(values: Floats | None) -> Any:
        return None if values is None else tuple(values.tolist())

    names = fields['interference_names']
    spheres = zip(
        names,
        fields['interference_centres'].tolist(),
        fields['interference_radii'].tolist(),
        fields['interference_bones'] or (fields['bones'].ground,) * len(names),
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
        origin=curves(fields['origins']),
        insertion=curves(fields['insertions']),
        sphere_frame=fields['sphere_frame'],
        sphere_centre=curves(fields['sphere_centres']),
        sphere_radius=Listed(numbers(fields['sphere_radii'])),
        ground_point=numbers(fields['ground_point']),
        humeral_point=numbers(fields['humeral_point']),
        plane_angle=Listed(numbers(fields['plane_angles'])),
        reference_normal=numbers(fields['reference_normal']),
        interference_spheres=tuple(
            InterferenceSphere(name, (x, y, z), radius, bone)
            for name, (x, y, z), radius, bone in spheres
        ),
        landmarks=fields['landmarks'],
        range_of_motion=fields['range_of_motion'],
        bones=fields['bones'],
    )
