# SPDX-License-Identifier: Apache-2.0
"""The places of a model file whose numbers a fit may change, and the patterns that choose them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np

from ..errors import LinkedPlaneError
from ..muscle.definition import Definition
from ..muscle.parts import Curve, Listed, Polynomial

THESIS = ('sphere.centre', 'sphere.radius', 'plane_angle', 'humeral_point')
"""What the thesis fitted: 25 coefficients and the distance of HM (ch. 5)."""
DISTANCE = 'humeral_point'
"""The distance of HM from the joint's centre, along its own direction."""


def free_numbers(definition: Definition) -> dict[str, float]:
    """Return every number that can be free, by its place; of HM only its distance."""
    numbers: dict[str, float] = {}
    names = place_names(definition)
    for key, curve in definition.curves().items():
        numbers.update(zip(names[key], curve_numbers(curve), strict=True))
    given = {'reference_normal': definition.reference_normal}
    if definition.ground_point is not None and definition.humeral_point is not None:
        given['sphere.ground_point'] = definition.ground_point
        numbers[DISTANCE] = float(np.linalg.norm(definition.humeral_point))
    for key, point in given.items():
        numbers.update({f'{key}[{axis}]': value for axis, value in enumerate(point)})
    return numbers


def matches_place(pattern: str, place: str) -> bool:
    """Return whether a pattern matches a place, or the beginning of it up to a . or [."""
    place = f'sphere.{place}' if place == DISTANCE != pattern else place
    starts = [place, *(place[: found.start()] for found in re.finditer(r'[.\[]', place))]
    escaped = pattern.replace('[', '[[]')  # an index, not a set of characters
    return any(fnmatchcase(start, escaped) for start in starts)


def choose_places(definition: Definition, patterns: Sequence[str]) -> list[str]:
    """Return the places that patterns match, in the file's order.

    Raises
    ------
    LinkedPlaneError
        For a pattern that matches no place.

    """
    known = free_numbers(definition)
    wrong = [each for each in patterns if not any(matches_place(each, place) for place in known)]
    if wrong:
        heads = dict.fromkeys(re.split(r'\[|\.list', place)[0] for place in known)
        raise LinkedPlaneError(
            f'free: {wrong[0]!r} matches nothing of {definition.name}; it has {", ".join(heads)}'
        )
    return [place for place in known if any(matches_place(pattern, place) for pattern in patterns)]


def place_names(definition: Definition) -> dict[str, list[str]]:
    """Return the places of each curve's numbers, as `BroadMuscle.coefficients` names them."""
    curves = definition.curves()
    names = {}
    for key, curve in curves.items():
        count = len(curve_numbers(curve))
        point, _, axis = key.rpartition('.')
        if isinstance(curve, Polynomial):
            names[key] = [key] if count == 1 else [f'{key}[{i}]' for i in range(count)]
        elif axis in 'xyz' and all(isinstance(curves[f'{point}.{a}'], Listed) for a in 'xyz'):
            names[key] = [f'{point}.list[{i}][{"xyz".index(axis)}]' for i in range(count)]
        else:
            names[key] = [f'{key}.list[{i}]' for i in range(count)]
    return names


def curve_numbers(curve: Curve) -> tuple[float, ...]:
    """Return the numbers that state a curve: its coefficients, or its values."""
    return curve.coefficients if isinstance(curve, Polynomial) else curve.values
