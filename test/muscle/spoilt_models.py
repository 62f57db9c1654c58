# SPDX-License-Identifier: Apache-2.0
"""Models with something missing or wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

Content = dict[str, Any]
Write = Callable[[Any], Path]


def spoil(content: Content, key: str, value: Any) -> Content:
    """Put a value (... removes it) under a dotted key."""
    *outer, last = key.split('.')
    here = content
    for name in outer:
        here = here[name]
    if value is ...:
        del here[last]
    else:
        here[last] = value
    return content


REQUIRED = (
    'format', 'version', 'name', 'source', 'units', 'units.length', 'units.angle', 'bands',
    'bands.s.first', 'bands.s.last', 'bands.names', 'heads.middle.bands',
    'heads.middle.represented_by', 'origin', 'origin.x', 'insertion', 'insertion.z', 'sphere',
    'sphere.frame', 'sphere.centre', 'sphere.centre.y', 'sphere.radius', 'sphere.ground_point',
    'sphere.humeral_point', 'plane_angle', 'reference_normal',
    'interference_spheres.sphere_4.centre', 'interference_spheres.sphere_4.radius',
)  # fmt: skip


# the spoilt key, what stands there, what the message says of it
WRONG: list[tuple[str, Any, str]] = [
    ('bone', 1, 'unknown key'),
    ('sphere.radii', [1.0], 'unknown key'),
    ('interference_spheres.sphere_4.colour', 'red', 'unknown key'),
    ('format', 'urdf', 'linkedplane_ros/broad_muscle'),
    ('version', 3, '1 or 2 expected'),
    ('version', True, '1 or 2 expected'),
    ('bones', {'names': ['scapula', 'humerus']}, 'unknown key in version 1'),
    ('interference_spheres.sphere_4.bone', 'humerus', 'unknown key in version 1'),
    ('sphere.frame', 'clavicle', 'one of moving, ground, humerus'),
    ('version', '1', '1 or 2 expected'),
    ('version', None, '1 or 2 expected'),
    ('name', 3, 'text expected'),
    ('name', '', 'text expected'),
    ('source', None, 'text expected'),
    ('units.length', 'inch', 'm, cm, mm expected'),
    ('units.angle', 'turns', 'rad, deg expected'),
    ('units.length', 3, 'm, cm, mm expected'),
    ('units.length', None, 'm, cm, mm expected'),
    ('units.length', ['mm'], 'm, cm, mm expected'),
    ('units', 'mm', 'mapping'),
    ('bands.s.first', 'a', 'a number expected'),
    ('bands.s.first', True, 'a number expected'),
    ('bands.names', [], 'a list of names expected'),
    ('bands.names', 'all', 'a list of names expected'),
    ('bands.names', ['one', 2], 'a list of names expected'),
    ('bands.names', ['one', 'one'], 'twice'),
    ('heads.middle.represented_by', 'anterior_1', 'not one of the bands of the head'),
    ('heads.middle.bands', ['middle_1', 'nobody'], "'nobody' is not a band"),
    (
        'heads.middle.bands',
        ['middle_1', 'anterior_1'],
        "'anterior_1' is not a band, or is one of an",
    ),
    ('heads', {}, 'at least one head expected'),
    ('heads', {'one': {'bands': ['middle_1'], 'represented_by': 'middle_1'}}, 'no head has the ba'),
    ('heads', None, 'mapping'),
    ('heads.middle', [1], 'mapping'),
    ('origin', [1.0, 2.0, 3.0], 'mapping'),
    ('origin.x', [], 'a list of numbers expected'),
    ('origin.x', 'long', 'a number, a list of numbers'),
    ('origin.x', None, 'a number, a list of numbers'),
    ('origin.x', True, 'a number expected'),
    ('origin.x', [[1.0]], 'a number expected'),
    ('origin.x', {'list': [1.0, 2.0]}, 'a list of 9 numbers expected, a list of 2 given'),
    ('origin.x', {'lists': [1.0, 2.0]}, 'missing'),
    ('origin.x', {'list': [1.0] * 9, 'of': 'x'}, 'unknown key'),
    ('origin', {'list': [[1.0, 2.0, 3.0]]}, '9 points, one for each band, expected, a list of 1'),
    ('origin', {'list': 3.0}, 'a list of points, one for each band, expected, 3.0 given'),
    ('origin', {'list': [[1.0, 2.0]] * 9}, '3 numbers expected, a list of 2 given'),
    ('origin', {'list': [[1.0, 2.0, 3.0]] * 9, 'x': 1.0}, 'unknown key'),
    ('sphere.frame', 'sky', 'one of moving, ground, humerus expected'),
    ('sphere.frame', None, 'one of moving, ground, humerus expected'),
    ('sphere.frame', ['ground'], '9 frames, one for each band, expected, a list of 1 given'),
    ('sphere.frame', ['ground'] * 8 + ['sky'], "'sky' given, one of moving, ground, humerus"),
    ('bands.s', [0.1, 0.2], 'a list of 9 numbers expected, a list of 2 given'),
    ('bands.s', ..., 'missing; origin.x is a polynomial in s'),
    ('bands.s', 3.0, 'mapping'),
    ('licence', '', 'text expected'),
    ('landmarks', [1.0], 'mapping'),
    ('landmarks', {'acromion': {'bone': 'scapula'}}, 'missing'),
    ('landmarks', {'acromion': {'bone': 'wing', 'at': [1, 2, 3]}}, 'one of scapula, humerus'),
    ('landmarks', {'acromion': {'bone': 'scapula', 'at': [1, 2]}}, '3 numbers expected'),
    ('landmarks', {'joint_centre': {'bone': 'scapula', 'at': [1, 2, 3]}}, 'is the origin of both'),
    ('range_of_motion.flexion', [1.0, 0.5], 'the lowest, then the highest'),
    ('sphere.radius', [float('nan')], 'finite'),
    ('sphere.radius', [float('inf')], 'finite'),
    ('sphere.radius', ['1e-3'], "'1e-3' given; write 1.0e-3"),
    ('sphere.radius', ['-2.5E3'], "'-2.5E3' given; write 1.0e-3"),
    ('sphere.radius', [10**400], 'a finite number expected'),
    ('sphere.radius', [-1.0], 'a radius > 0 expected'),
    ('sphere.radius', [1.0, -0.5], 'a radius > 0 expected'),
    ('sphere.radius', [0.0], 'a radius > 0 expected'),
    ('sphere.radius', [9e-7], 'a radius of at least 1e-06 m expected'),
    ('sphere.ground_point', [1.0, 2.0], '3 numbers expected'),
    ('sphere.humeral_point', [1.0, 2.0, 3.0, 4.0], '3 numbers expected'),
    ('reference_normal', [0.0, 0.0, 0.0], 'zero'),
    ('reference_normal', [1.0, 0.0], '3 numbers expected'),
    ('reference_normal', 'up', '3 numbers expected'),
    ('interference_spheres.sphere_4.radius', -27.4, '> 0 expected'),
    ('interference_spheres.sphere_4.centre', [1.0], '3 numbers expected'),
    ('interference_spheres', [1.0], 'mapping'),
]
