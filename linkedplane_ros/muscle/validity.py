# SPDX-License-Identifier: Apache-2.0
"""What a broad muscle may be: a file and Python are refused here, for the same reasons."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..errors import FieldError, as_plain, describe_value
from ..types import Floats, Intervals, Point

if TYPE_CHECKING:
    from .broad_muscle import BroadMuscle
    from .parts import Head, Landmark

Item = TypeVar('Item')

JOINT_CENTRE = 'joint_centre'  # a landmark of both bones by itself
SHORTEST = 1e-9  # m, m^2: below, a line or a plane has no direction
LIMIT = (
    10.0  # m, rad: no animal has longer muscles, no angle needs two turns; beyond, a unit is wrong
)
LEAST_RADIUS = 1e-6  # m: less is a point, or vanishes where it is squared; a unit is wrong
PARALLEL = 1e-6  # sine of the smallest angle between a reference normal and the first band
UNPRINTABLE = (  # of Unicode's basic plane, as JSON Schema's regular expressions have it
    r'\x00-\x1f\x7f-\xa0\xad\u1680\u180e\u2000-\u200f\u2028-\u202f\u205f-\u206f\u3000'
    r'\ud800-\uf8ff\ufeff\ufff0-\uffff'
)
NAME = rf'^ *[^ {UNPRINTABLE}][^{UNPRINTABLE}]*$(?!\n)'
BAND_NAME = NAME.replace(UNPRINTABLE, f',{UNPRINTABLE}')


def check_topic_name(field: str, name: Any, owner: str = '') -> None:
    """Refuse a name that topics cannot begin with."""
    if not isinstance(name, str) or not re.fullmatch(r'[A-Za-z][A-Za-z0-9_]*', name):
        reason = f'{describe_value(name)} given; a letter, then letters, digits and _ expected'
        raise FieldError(field, reason, owner)


def require_choice(field: str, value: Any, choices: Iterable[str], owner: str = '') -> str:
    """Return a value that is one of the choices; FieldError for any other."""
    choices = tuple(choices)
    if not isinstance(value, str) or value not in choices:
        reason = f'{describe_value(value)} given, one of {", ".join(choices)} expected'
        raise FieldError(field, reason, owner)
    return value


def check_names(field: str, names: Sequence[str], owner: str = '') -> None:
    """Refuse names of bands with commas or line breaks, names that repeat, and an empty list."""
    if not names:
        raise FieldError(field, 'a list of names expected, an empty one given', owner)
    check_distinct(field, names, owner, BAND_NAME, 'a name without a comma')


def check_distinct(
    field: str,
    names: Iterable[str],
    owner: str = '',
    pattern: str = NAME,
    expected: str = 'a name',
) -> None:
    """Refuse names that repeat, and what is not a name: blank, or with what does not print."""
    names = list(names)
    wrong = [each for each in names if not isinstance(each, str) or not re.match(pattern, each)]
    if wrong:
        raise FieldError(field, f'{describe_value(wrong[0])} given; {expected} expected', owner)
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        reason = f'{describe_value(twice[0])} appears twice; different names expected'
        raise FieldError(field, reason, owner)


def require_items(field: str, values: Any, kind: type[Item]) -> tuple[Item, ...]:
    """Return a list's items, all of one kind; FieldError for anything else."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise FieldError(field, f'{describe_value(values)} given, a list expected')
    items = tuple(map(as_plain, values))
    wrong = [item for item in items if not isinstance(item, kind)]
    if wrong:
        name = 'name' if kind is str else kind.__name__
        raise FieldError(field, f'{describe_value(wrong[0])} given; a {name} expected')
    return items


def require_text(field: str, value: Any) -> str:
    """Return text without the blanks around it; FieldError for anything else, and for none."""
    if not isinstance(value, str) or not value.strip():
        raise FieldError(field, f'text expected, {describe_value(value)} given')
    return value.strip()


def require_array(field: str, value: Any, shape: tuple[int, ...], owner: str = '') -> Floats:
    """Return a copy as an array of finite numbers of this shape; FieldError for anything else."""
    try:
        if np.asarray(value).dtype.kind not in 'biuf':  # NumPy also reads text, and None as NaN
            raise TypeError
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        reason = f'{describe_value(value)} given, finite numbers of shape {shape} expected'
        raise FieldError(field, reason, owner) from None
    if array.shape != shape:
        raise FieldError(field, f'shape {array.shape} given, {shape} expected', owner)
    wrong = np.argwhere(~np.isfinite(array)).tolist()
    if wrong:
        where = f' at {wrong[0]}' if wrong[0] else ''
        number = array[tuple(wrong[0])]
        raise FieldError(field, f'{number} given{where}, a finite number expected', owner)
    return array


def check_size(field: str, values: Floats, unit: str) -> None:
    """Refuse coordinates and radii (m) and angles (rad) that are so large that a unit is wrong."""
    wrong = np.argwhere(np.abs(values) >= LIMIT).tolist()
    if wrong:
        where = f' at {wrong[0]}' if wrong[0] else ''
        given = f'{values[tuple(wrong[0])]:.6g} {unit} given{where}'
        raise FieldError(field, f'{given}, less than {LIMIT:g} {unit} expected; another unit?')


def require_point(field: str, value: Any, owner: str) -> Point:
    """Return three finite numbers; FieldError for anything else."""
    x, y, z = require_array(field, value, (3,), owner).tolist()
    return x, y, z


def require_intervals(field: str, value: Any, names: Sequence[str]) -> Intervals:
    """Return an interval for each name, rad; FieldError for anything else."""
    limits: list[list[float]] = require_array(field, value, (len(names), 2)).tolist()
    wrong = next((i for i, (low, high) in enumerate(limits) if low > high), None)
    if wrong is not None:
        given = '{:.6g} to {:.6g} rad given'.format(*limits[wrong])
        reason = f'{given}, the lowest, then the highest expected'
        raise FieldError(f'{field}.{names[wrong]}', reason)
    for name, interval in zip(names, limits, strict=True):
        check_size(f'{field}.{name}', np.array(interval), 'rad')
    return tuple((low, high) for low, high in limits)


def check_heads(heads: Sequence[Head], bands: Sequence[str]) -> None:
    """Refuse heads that do not have every band once."""
    check_distinct('heads', [head.name for head in heads])
    left = dict.fromkeys(bands)
    for head in heads:
        for band in head.bands:
            if band not in left:
                reason = f'{describe_value(band)} is not a band, or is one of another head'
                raise FieldError(f'heads.{head.name}.bands', reason)
            del left[band]
    if left:
        raise FieldError('heads', f'no head has the band {describe_value(next(iter(left)))}')


def check_landmarks(landmarks: Sequence[Landmark]) -> None:
    """Refuse names that repeat or that every model has, and places far away."""
    names = [landmark.name for landmark in landmarks]
    check_distinct('landmarks', names)
    for landmark in landmarks:
        check_size(f'landmarks.{landmark.name}.at', np.array(landmark.at), 'm')
    if JOINT_CENTRE in names:
        reason = 'is the origin of both bones in every model; another name expected'
        raise FieldError(f'landmarks.{JOINT_CENTRE}', reason)


def check_geometry(muscle: BroadMuscle) -> None:
    """Refuse what has no geometry: a radius that is not positive, a band without a plane."""
    names, origins = muscle.band_names, muscle.origins
    if not np.linalg.norm(muscle.reference_normal) > 0.0:
        raise FieldError('reference_normal', 'a vector of some length expected, zero given')
    spheres = [f'sphere {name}' for name in muscle.interference_names]
    check_radii('sphere_radii', muscle.sphere_radii, [f'band {name}' for name in names])
    check_radii('interference_radii', muscle.interference_radii, spheres)
    lines = muscle.insertions - origins
    sizes = np.linalg.norm(lines, axis=1)
    short = np.flatnonzero(sizes <= SHORTEST)
    if short.size:
        reason = f'band {names[short[0]]} ends where it begins (arm at the side)'
        raise FieldError('insertions', reason)
    if np.linalg.norm(np.cross(muscle.reference_normal, lines[0] / sizes[0])) < PARALLEL:
        reason = f'parallel to the first band, {names[0]} (arm at the side): its plane is undefined'
        raise FieldError('reference_normal', reason)
    if muscle.ground_point is not None and muscle.humeral_point is not None:
        check_moving_frames(muscle, np.cross(muscle.humeral_point - origins,
                                             muscle.ground_point - origins))  # fmt: skip


def check_radii(field: str, radii: Floats, owners: Sequence[str]) -> None:
    """Refuse radii (k,), m, that are not above zero, or next to nothing; each has an owner."""
    wrong = np.flatnonzero(radii < LEAST_RADIUS)
    if wrong.size:
        radius = radii[wrong[0]]
        least = f'of at least {LEAST_RADIUS:g} m expected; another unit?'
        reason = f'a radius {"> 0 expected" if radius <= 0.0 else least}'
        raise FieldError(field, f'{radius:.6g} m for {owners[wrong[0]]}, {reason}')


def check_moving_frames(muscle: BroadMuscle, across: Floats) -> None:
    """Refuse SC in line with HM and a band's origin; `across` (n, 3) is normal to these, m^2."""
    moving = np.array(muscle.sphere_frames) == 'moving'
    flat = np.flatnonzero(moving & (np.linalg.norm(across, axis=1) <= SHORTEST))
    if flat.size:
        reason = (
            f'in line with humeral_point and the origin of band {muscle.band_names[flat[0]]}: '
            "the sphere's frame is undefined"
        )
        raise FieldError('ground_point', reason)
