# SPDX-License-Identifier: Apache-2.0
"""Python refuses what the reader of a file refuses, and names field, value and what is expected."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from linkedplane_ros import BroadMuscle, Head, Landmark, ModelError
from linkedplane_ros.errors import FieldError
from linkedplane_ros.muscle.parts import InterferenceSphere, Listed, Polynomial, Span

DELTOID = BroadMuscle.load('deltoid')
NAMES = DELTOID.band_names
ANTERIOR, MIDDLE, POSTERIOR = DELTOID.heads
LIMITS = DELTOID.range_of_motion


def spoilt(field: str, index: Any, value: float) -> dict[str, Any]:
    """Return a field of the deltoid with one number replaced."""
    array = getattr(DELTOID, field).copy()
    array[index] = value
    return {field: array}


# What is changed, where the message begins, what it says
WRONG: list[tuple[dict[str, Any], str, str]] = [
    ({'name': 3}, 'name: ', '3 given; a letter, then letters, digits and _ expected'),
    ({'name': ''}, 'name: ', "'' given; a letter"),
    ({'name': 'two words'}, 'name: ', "'two words' given; a letter"),
    ({'name': '/deltoid'}, 'name: ', "'/deltoid' given; a letter"),
    ({'name': '2nd'}, 'name: ', "'2nd' given; a letter"),
    ({'source': None}, 'source: ', 'text expected, None given'),
    ({'source': ' '}, 'source: ', "text expected, ' ' given"),
    ({'licence': 3}, 'licence: ', 'text expected, 3 given'),
    ({'band_names': ()}, 'band_names: ', 'a list of names expected, an empty one given'),
    ({'band_names': ('one', 'one')}, 'band_names: ', "'one' appears twice"),
    ({'band_names': ('a', '')}, 'band_names: ', "'' given; a name without a comma expected"),
    ({'band_names': ('a,b',)}, 'band_names: ', "'a,b' given; a name without a comma expected"),
    ({'band_names': ('a\n',)}, 'band_names: ', "'a\\n' given; a name without a comma expected"),
    ({'heads': (ANTERIOR, MIDDLE)}, 'heads: ', "no head has the band 'posterior_1'"),
    ({'heads': (ANTERIOR, *DELTOID.heads)}, 'heads: ', "'anterior' appears twice"),
    (
        {'heads': (Head('all', ('nobody',), 'nobody'),)},
        'heads.all.bands: ',
        "'nobody' is not a band, or is one of another head",
    ),
    (
        {'heads': (ANTERIOR, MIDDLE, replace(POSTERIOR, bands=NAMES[5:], represented_by=NAMES[6]))},
        'heads.posterior.bands: ',
        "'middle_3' is not a band, or is one of another head",
    ),
    ({'origins': 'long'}, 'origins: ', "'long' given, finite numbers of shape (9, 3) expected"),
    ({'origins': None}, 'origins: ', 'None given, finite numbers of shape (9, 3) expected'),
    ({'origins': [[1.0, 2.0, 3.0]]}, 'origins: ', 'shape (1, 3) given, (9, 3) expected'),
    ({'origins': [[1.0, 2.0]] * 9}, 'origins: ', 'shape (9, 2) given, (9, 3) expected'),
    ({'origins': [[1.0, 2.0], [3.0]]}, 'origins: ', 'finite numbers of shape (9, 3) expected'),
    (spoilt('origins', (2, 1), np.nan), 'origins: ', 'nan given at [2, 1], a finite number'),
    (spoilt('insertions', (8, 2), -np.inf), 'insertions: ', '-inf given at [8, 2], a finite'),
    (spoilt('sphere_centres', (0, 0), np.nan), 'sphere_centres: ', 'nan given at [0, 0]'),
    (spoilt('plane_angles', 1, np.nan), 'plane_angles: ', 'nan given at [1]'),
    ({'plane_angles': 0.1}, 'plane_angles: ', 'shape () given, (9,) expected'),
    ({'insertions': DELTOID.origins}, 'insertions: ', 'band anterior_1 ends where it begins'),
    ({'sphere_frame': 'sky'}, 'sphere_frame: ', "'sky' given, one of moving, ground, humerus"),
    ({'sphere_frame': None}, 'sphere_frame: ', 'None given, one of moving, ground, humerus'),
    ({'sphere_frame': ('ground',)}, 'sphere_frame: ', '9 frames, one for each band, expected'),
    ({'sphere_frame': ['ground'] * 8 + ['sky']}, 'sphere_frame[8]: ', "'sky' given, one of mov"),
    ({'sphere_radii': -DELTOID.sphere_radii}, 'sphere_radii: ', 'm for band anterior_1, a radius'),
    (spoilt('sphere_radii', 4, 0.0), 'sphere_radii: ', '0 m for band middle_2, a radius > 0'),
    (spoilt('sphere_radii', 4, 9e-7), 'sphere_radii: ', 'middle_2, a radius of at least 1e-06 m'),
    (spoilt('sphere_radii', 4, np.nan), 'sphere_radii: ', 'nan given at [4], a finite number'),
    ({'sphere_radii': [10**400] * 9}, 'sphere_radii: ', 'finite numbers of shape (9,) expected'),
    ({'ground_point': None}, 'ground_point: ', 'None given, finite numbers of shape (3,)'),
    ({'ground_point': [1.0, 2.0]}, 'ground_point: ', 'shape (2,) given, (3,) expected'),
    ({'ground_point': DELTOID.humeral_point}, 'ground_point: ', 'in line with humeral_point'),
    ({'humeral_point': [0.0, 0.0, np.inf]}, 'humeral_point: ', 'inf given at [2], a finite'),
    ({'reference_normal': np.zeros(3)}, 'reference_normal: ', 'some length expected, zero given'),
    ({'reference_normal': [1.0, 0.0]}, 'reference_normal: ', 'shape (2,) given, (3,) expected'),
    ({'reference_normal': 'up'}, 'reference_normal: ', "'up' given, finite numbers of shape (3,)"),
    (
        {'reference_normal': DELTOID.insertions[0] - DELTOID.origins[0]},
        'reference_normal: ',
        'parallel to the first band, anterior_1',
    ),
    (
        {'interference_radii': [0.0274, -0.0243, 0.0239]},
        'interference_radii: ',
        f'-0.0243 m for sphere {DELTOID.interference_names[1]}, a radius > 0 expected',
    ),
    ({'interference_radii': [0.03]}, 'interference_radii: ', 'shape (1,) given, (3,) expected'),
    ({'interference_centres': np.full((3, 3), np.nan)}, 'interference_centres: ', 'nan given at'),
    ({'interference_names': ('a', 'b', 'a')}, 'interference_names: ', "'a' appears twice"),
    ({'range_of_motion': ((0.0, 1.0),)}, 'range_of_motion: ', 'shape (1, 2) given, (3, 2)'),
    (
        {'range_of_motion': (LIMITS[0], (1.0, 0.5), LIMITS[2])},
        'range_of_motion.abduction: ',
        '1 to 0.5 rad given, the lowest, then the highest expected',
    ),
    (
        {'range_of_motion': (LIMITS[0], (0.0, np.nan), LIMITS[2])},
        'range_of_motion: ',
        'nan given at [1, 1], a finite number expected',
    ),
    (
        {'landmarks': (Landmark('joint_centre', 'scapula', (0.0, 0.0, 0.0)),)},
        'landmarks.joint_centre: ',
        'is the origin of both bones',
    ),
    (
        {'landmarks': (Landmark('tip', 'scapula', (0.0, 0.0, 0.1)),) * 2},
        'landmarks: ',
        "'tip' appears twice",
    ),
]  # fmt: skip


@pytest.mark.parametrize(
    ('change', 'start'),
    [
        ({'heads': ('anterior',)}, "heads: 'anterior' given; a Head expected"),
        ({'landmarks': 5}, 'landmarks: 5 given, a list expected'),
        ({'band_names': None}, 'band_names: None given, a list expected'),
        ({'band_names': list(range(9))}, 'band_names: 0 given; a name expected'),
        ({'interference_names': 'abc'}, "interference_names: 'abc' given, a list expected"),
        ({'sphere_radii': ['0.1'] * 9}, 'sphere_radii: '),
        ({'origins': DELTOID.origins + 0j}, 'origins: [[(-0.0'),
        ({'heads': np.zeros(1)}, 'heads: 0.0 given; a Head expected'),
        ({'stated': 5}, 'stated: 5 given, a Definition expected'),
    ],
)
def test_a_field_of_another_kind_is_named(change: dict[str, Any], start: str) -> None:
    with pytest.raises(ModelError) as caught:
        replace(DELTOID, **change)
    assert str(caught.value).startswith(start)
    assert '\n' not in str(caught.value)


def test_a_head_is_found_for_bands_alone() -> None:
    assert DELTOID.find_head('middle_1') == 'middle'
    with pytest.raises(ModelError, match="band 'biceps' given, one of anterior_1"):
        DELTOID.find_head('biceps')


@pytest.mark.parametrize(('change', 'start', 'reason'), WRONG)
def test_a_field_that_cannot_be_is_named_with_its_value_and_what_is_expected(
    change: dict[str, Any], start: str, reason: str
) -> None:
    with pytest.raises(ModelError) as caught:
        replace(DELTOID, **change)
    message = str(caught.value)
    assert message.startswith(start)
    assert reason in message
    assert '\n' not in message


def test_a_muscle_made_anew_is_checked_as_one_that_is_changed() -> None:
    fields = DELTOID.definition.muscle_fields
    assert BroadMuscle(**fields) == replace(DELTOID, stated=None)
    with pytest.raises(ModelError, match=r'sphere_radii: -0\.03\d* m for band anterior_1'):
        BroadMuscle(**{**fields, 'sphere_radii': -fields['sphere_radii']})


@pytest.mark.parametrize(
    ('make', 'told'),
    [
        (
            lambda: Head('middle', ('a', 'b'), 'c'),
            "head middle: represented_by: 'c' is not one of the bands of the head",
        ),
        (lambda: Head('middle', (), 'c'), 'head middle: bands: a list of names expected'),
        (lambda: Head('middle', ('a', 'a'), 'a'), "head middle: bands: 'a' appears twice"),
        (
            lambda: replace(DELTOID, landmarks=(Landmark('tip', 'wing', (0.0, 0.0, 0.0)),)),
            "landmarks.tip.bone: 'wing' given, one of scapula, humerus expected",
        ),
        (
            lambda: Landmark('tip', 'scapula', (0.0, 0.0)),
            r'landmark tip: at: shape \(2,\) given, \(3,\) expected',
        ),
        (
            lambda: Landmark('tip', 'scapula', (0.0, np.nan, 0.0)),
            r'landmark tip: at: nan given at \[1\], a finite number expected',
        ),
        (
            lambda: InterferenceSphere('ball', (0.0, 0.0, 0.0), np.inf),
            'interference sphere ball: radius: inf given, a finite number expected',
        ),
    ],
)
def test_a_part_that_cannot_be_is_named(make: Any, told: str) -> None:
    with pytest.raises(ModelError, match=told):
        make()


@pytest.mark.parametrize(
    ('change', 'told'),
    [
        ({'length': 'inch'}, "units.length: 'inch' given, one of m, cm, mm expected"),
        ({'angle': 'turns'}, "units.angle: 'turns' given, one of rad, deg expected"),
        ({'s': None}, 'bands.s: missing; origin.x is a polynomial in s'),
        ({'s': (0.1, 0.2)}, 'bands.s: a list of 9 numbers expected, a list of 2 given'),
        ({'s': Span(0.0, np.nan)}, r'bands.s: nan given at \[1\], a finite number expected'),
        ({'sphere_radius': Listed((1.0,))}, 'sphere.radius: a list of 9 numbers expected, a list'),
        ({'origin': (Listed((1.0,)),) * 3}, 'origin: a list of 9 points, one for each band, exp'),
        ({'sphere_frame': 'ground'}, 'sphere.ground_point: is for moving frames; given here: gr'),
        ({'ground_point': None}, 'sphere.ground_point: missing'),
        ({'band_names': NAMES[:1] * 9}, "bands.names: 'anterior_1' appears twice"),
    ],
)
def test_a_definition_that_cannot_be_is_refused_by_the_keys_of_its_file(
    change: dict[str, Any], told: str
) -> None:
    with pytest.raises(ModelError, match=told):
        replace(DELTOID.definition, **change)


def test_a_polynomial_that_overflows_is_refused() -> None:
    huge = replace(DELTOID.definition, sphere_radius=Polynomial((1e308, 1e308, 1e308)))
    with pytest.raises(ModelError, match=r'sphere_radii: inf given at \[\d\], a finite number'):
        BroadMuscle.from_definition(huge)


def test_a_field_error_crosses_processes() -> None:
    error = FieldError('radius', '-1 given, > 0 expected', 'interference sphere ball')
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
    assert str(error) == 'interference sphere ball: radius: -1 given, > 0 expected'


@pytest.mark.parametrize(
    ('field', 'value', 'given'),
    [
        ('origins', DELTOID.origins + 10.0, 'm given at'),
        ('insertions', DELTOID.insertions - 1e9, r'm given at \[0, 0\]'),
        ('sphere_centres', DELTOID.sphere_centres * 1e3, 'm given at'),
        ('sphere_radii', np.full(9, 10.0), r'10 m given at \[0\]'),
        ('ground_point', (0.0, 11.0, 0.0), r'11 m given at \[1\]'),
        ('humeral_point', (0.0, 0.0, -10.0), r'-10 m given at \[2\]'),
        ('interference_centres', np.full((3, 3), 1e6), '1e[+]06 m given'),
        ('interference_radii', np.full(3, 1e6), '1e[+]06 m given'),
        ('plane_angles', np.full(9, -10.0), '-10 rad given'),
        ('range_of_motion', ((0.0, 90.0), (0.0, 1.0), (0.0, 1.0)), r'90 rad given at \[1\]'),
        ('landmarks', (Landmark('tip', 'scapula', (0.0, 10.0, 0.0)),), '10 m given'),
    ],
)
def test_numbers_of_ten_metres_or_radians_are_refused(field: str, value: Any, given: str) -> None:
    expected = rf'^{field}.*: .*{given}.*, less than 10 (m|rad) expected; another unit\?$'
    with pytest.raises(ModelError, match=expected):
        replace(DELTOID, **{field: value})
