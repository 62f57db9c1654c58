# SPDX-License-Identifier: Apache-2.0
"""Writing a model file, to be read back to the bit; and its numbers by their places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import yaml

from ..errors import ModelError
from .definition import Definition
from .keys import FORMAT, known_keys
from .parts import COORDINATES, Curve, Curves, Listed, Span
from .yaml_mapping import YamlMapping

GEOMETRY = ('origin', 'insertion', 'sphere', 'plane_angle', 'reference_normal')


def yaml_text(definition: Definition) -> str:
    """Return the text of a definition's file, which is read back to the bit."""
    text = yaml.safe_dump(
        file_content(definition),
        sort_keys=False,
        default_flow_style=None,
        width=100,
        allow_unicode=True,
    )
    return str(text)


def file_content(definition: Definition) -> dict[str, Any]:
    """Return a definition as the mapping that its file holds."""
    sphere: dict[str, Any] = {
        'frame': _plain(definition.sphere_frame),
        'centre': _points_content(definition.sphere_centre),
        'radius': _curve_content(definition.sphere_radius),
    }
    for key in ('ground_point', 'humeral_point'):
        if getattr(definition, key) is not None:
            sphere[key] = _plain(getattr(definition, key))
    bands: dict[str, Any] = {'names': _plain(definition.band_names)}
    if isinstance(definition.s, Span):
        bands['s'] = {'first': definition.s.first, 'last': definition.s.last}
    elif definition.s is not None:
        bands['s'] = _plain(definition.s)
    model: dict[str, Any] = {
        'format': FORMAT,
        'version': definition.version,
        'name': definition.name,
        'source': definition.source,
        'licence': definition.licence,
        'units': {'length': definition.length, 'angle': definition.angle},
        'bands': bands,
        'heads': {
            head.name: {'bands': _plain(head.bands), 'represented_by': head.represented_by}
            for head in definition.heads
        },
        'bones': definition.version > 1
        and {key: _plain(value) for key, value in vars(definition.bones).items()},
        'origin': _points_content(definition.origin),
        'insertion': _points_content(definition.insertion),
        'sphere': sphere,
        'plane_angle': _curve_content(definition.plane_angle),
        'reference_normal': _plain(definition.reference_normal),
        'interference_spheres': {
            each.name: {'centre': _plain(each.centre), 'radius': each.radius, 'bone': each.bone}
            if definition.version > 1
            else {'centre': _plain(each.centre), 'radius': each.radius}
            for each in definition.interference_spheres
        },
        'landmarks': {
            each.name: {'bone': each.bone, 'at': _plain(each.at)} for each in definition.landmarks
        },
        'range_of_motion': definition.range_of_motion
        and {
            coordinate: list(limits)
            for coordinate, limits in zip(COORDINATES, definition.range_of_motion, strict=True)
        },
    }
    needed, _ = known_keys('')
    return {key: value for key, value in model.items() if value or key in needed}


def _plain(value: str | tuple[Any, ...]) -> str | list[Any]:
    return value if isinstance(value, str) else list(value)


def _curve_content(curve: Curve) -> Any:
    if isinstance(curve, Listed):
        return {'list': list(curve.values)}
    common = len(curve.coefficients) == 1
    return curve.coefficients[0] if common else list(curve.coefficients)


def _points_content(curves: Curves) -> dict[str, Any]:
    x, y, z = curves
    if isinstance(x, Listed) and isinstance(y, Listed) and isinstance(z, Listed):
        return {'list': [list(row) for row in zip(x.values, y.values, z.values, strict=True)]}
    return {axis: _curve_content(curve) for axis, curve in zip('xyz', curves, strict=True)}


def coefficients(definition: Definition) -> dict[str, float]:
    """Return every number of the geometry by its place in the file, as `sphere.centre.x[0]`."""
    stated = file_content(definition)
    return dict(item for key in GEOMETRY for item in _numbers(key, stated[key]))


def replace_coefficients(definition: Definition, values: Mapping[str, float]) -> YamlMapping:
    """Return a definition's content with other numbers in these places; ModelError for others."""
    stated = file_content(definition)
    known = coefficients(definition)
    for place, value in values.items():
        if place not in known:
            raise ModelError(f'{definition.name}: {place}: no such number; see coefficients')
        *steps, last = _steps(place)
        here: Any = stated
        for step in steps:
            here = here[step]
        here[last] = float(value)
    return YamlMapping(definition.name, '', stated)


def _numbers(place: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, float):
        yield place, value
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(f'{place}.{key}', inner)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _numbers(f'{place}[{i}]', inner)


def _steps(place: str) -> list[str | int]:
    """Return the keys and indices that lead to a place."""
    steps: list[str | int] = []
    for part in place.split('.'):
        key, *indices = part.replace(']', '').split('[')
        steps += [key, *map(int, indices)]
    return steps
