# SPDX-License-Identifier: Apache-2.0
"""What a fit may change: places of the model file, chosen by patterns, within bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference import Array

from linkedplane_ros import BroadMuscle
from linkedplane_ros.fit.parameters import Bound, build_space
from linkedplane_ros.fit.places import choose_places, free_numbers
from linkedplane_ros.fit.space import Space, pack_definition
from linkedplane_ros.muscle.definition import Definition
from linkedplane_ros.muscle.parts import Head

DELTOID = BroadMuscle.load('deltoid').definition
LISTED = BroadMuscle(**DELTOID.muscle_fields).definition  # the same muscle as lists
ROUNDING = 1e-12  # of numbers up to 3e4, as those of the origin


def somewhere(found: Space, seed: int = 0) -> Array:
    return np.random.default_rng(seed).uniform(found.low, found.high)


def rebuilt(definition: Definition, found: Space, x: Array) -> Definition:
    return (
        BroadMuscle.from_definition(definition).with_coefficients(found.coefficients(x)).definition
    )


@pytest.mark.parametrize(
    'free',
    [
        ['sphere.centre', 'sphere.radius', 'plane_angle', 'humeral_point'],
        ['sphere.radius[0]', 'plane_angle[4]', 'origin.y', 'insertion.x[1]'],
        ['sphere.*', 'reference_normal', 'humeral_point'],
    ],
)
@pytest.mark.parametrize('definition', [DELTOID, LISTED], ids=['curves', 'lists'])
def test_the_kernels_muscle_is_that_of_the_written_coefficients(
    definition: Definition, free: list[str]
) -> None:
    if definition is LISTED:
        free = [pattern.split('[')[0].removesuffix('.y').removesuffix('.x') for pattern in free]
    found = build_space(definition, free)
    x = somewhere(found)
    model = rebuilt(definition, found, x)
    np.testing.assert_allclose(
        found.flat_muscle(x), pack_definition(model), rtol=0.0, atol=ROUNDING
    )
    same = rebuilt(definition, found, found.start)
    for place, value in BroadMuscle.from_definition(same).coefficients.items():
        expected = BroadMuscle.from_definition(definition).coefficients[place]
        assert value == pytest.approx(expected, rel=1e-9, abs=1e-9), place


def test_every_place_is_one_of_the_models_coefficients() -> None:
    for definition in (DELTOID, LISTED):
        known = BroadMuscle.from_definition(definition).coefficients
        mine = set(free_numbers(definition)) - {'humeral_point'}
        hm = {f'sphere.humeral_point[{axis}]' for axis in range(3)}
        assert mine | hm == set(known)


def test_the_thesis_fits_26_numbers() -> None:
    found = build_space(DELTOID)
    assert len(found.parameters) == 26
    assert found.parameters[-1].start == pytest.approx(29.63)  # mm, HM (ch. 5)


def test_a_pattern_is_a_place_or_its_beginning() -> None:
    assert choose_places(DELTOID, ['sphere.radius']) == [f'sphere.radius[{k}]' for k in range(5)]
    assert choose_places(DELTOID, ['sphere.radius[1]', '*.z[0]']) == [
        'origin.z[0]', 'insertion.z[0]', 'sphere.centre.z[0]', 'sphere.radius[1]',
    ]  # fmt: skip
    with pytest.raises(ValueError, match=r"free: 'sphere.rad' matches nothing of deltoid; it has "):
        choose_places(DELTOID, ['sphere.rad'])


def test_a_whole_curve_is_sought_by_its_values_along_s() -> None:
    found = build_space(DELTOID, ['sphere.radius'], [Bound.from_text('sphere.radius=10:40')])
    assert [parameter.name for parameter in found.parameters] == [
        f'sphere.radius(s={s})' for s in ('0.10', '0.21', '0.47', '0.74', '0.85')
    ]
    x = somewhere(found)
    model = rebuilt(DELTOID, found, x)
    assert model.sphere_radius.evaluate(np.array([0.10, 0.85])) == pytest.approx(x[[0, -1]])


def test_without_a_bound_no_value_at_a_band_moves_farther_than_the_reach() -> None:
    found = build_space(DELTOID, ['sphere.radius[0]', 'plane_angle[2]'], reach=(0.005, 0.5))
    for corner in (found.low, found.high):
        model = rebuilt(DELTOID, found, corner)
        radius = model.values['sphere.radius'] - DELTOID.values['sphere.radius']
        angle = model.values['plane_angle'] - DELTOID.values['plane_angle']
        assert np.abs(radius).max() == pytest.approx(5.0)  # mm
        assert np.abs(angle).max() == pytest.approx(0.5)  # rad


def test_bounds_are_absolute_or_about_the_start() -> None:
    bounds = [
        Bound.from_text(text)
        for text in ('sphere.*=+-2', 'sphere.radius=10:80', 'plane_angle=+-10%')
    ]
    found = build_space(DELTOID, ['sphere.centre.x', 'sphere.radius', 'plane_angle'], bounds)
    by_name = {parameter.name: parameter for parameter in found.parameters}
    centre = by_name['sphere.centre.x(s=0.10)']
    assert (centre.low, centre.high) == pytest.approx((centre.start - 2.0, centre.start + 2.0))
    radius = by_name['sphere.radius(s=0.85)']
    assert (radius.low, radius.high) == (10.0, 80.0)
    assert (
        found.start[found.parameters.index(radius)]
        == radius.start
        == pytest.approx(13.61, abs=0.01)
    )
    angle = by_name['plane_angle(s=0.10)']
    largest = np.abs(DELTOID.values['plane_angle']).max()
    assert angle.high - angle.start == pytest.approx(0.1 * largest)


@pytest.mark.parametrize(
    'text',
    [
        'sphere.radius',
        'a=1',
        'a=2:1',
        '=1:2',
        'a=+-0',
        'a=+-x%',
        'a=',
        'a=1:inf',
        'a=+-nan',
        'a=1:2:3',
    ],
)
def test_a_bound_that_is_none_is_told_in_one_line(text: str) -> None:
    with pytest.raises(ValueError, match=r'^bound .*: PATTERN=LOW:HIGH, .* expected$'):
        Bound.from_text(text)


def test_a_bound_of_what_is_not_free_is_a_fault() -> None:
    with pytest.raises(
        ValueError, match=r"^bound: 'origin' matches nothing that is free: sphere.centre"
    ):
        build_space(DELTOID, ['sphere'], [Bound.from_text('origin=+-1')])


def test_a_curve_that_is_free_as_a_whole_is_bounded_as_a_whole() -> None:
    bound = Bound.from_text('sphere.radius[4]=37:38')
    with pytest.raises(ValueError, match=r"'sphere.radius\[4\]' matches nothing .* sphere.radius$"):
        build_space(DELTOID, ['sphere.radius'], [bound])
    (alone,) = build_space(DELTOID, ['sphere.radius[4]'], [bound]).parameters
    assert (alone.low, alone.high) == (37.0, 38.0)


@pytest.mark.parametrize(
    ('free', 'bound', 'said'),
    [
        ('plane_angle[4]', '1:2', r'plane_angle\[4\] starts at 0.444474, outside 1 to 2'),
        ('sphere.radius', '20:22', r'sphere.radius starts at 36.37.*, outside 20 to 22'),
        ('sphere.radius', '0:0.5', r'no room for sphere.radius about 36.37'),
    ],
)
def test_a_bound_that_leaves_the_start_out_is_a_fault(free: str, bound: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        build_space(DELTOID, [free], [Bound.from_text(f'{free}={bound}')])


@pytest.mark.parametrize(
    ('free', 'bound'),
    [
        ('sphere.radius', '0:10000'),
        ('origin.x', '+-1e9'),
        ('plane_angle', '-20:20'),
        ('sphere.ground_point', '-1e5:1e5'),
        ('humeral_point', '1:1e4'),
    ],
)
def test_a_bound_beyond_what_a_model_may_have_is_a_fault(free: str, bound: str) -> None:
    with pytest.raises(ValueError, match=r'less than 1.* expected: the limit of a model'):
        build_space(DELTOID, [free], [Bound.from_text(f'{free}={bound}')])


def test_hm_belongs_to_the_sphere() -> None:
    for pattern in ('humeral_point', 'sphere.humeral_point'):
        assert choose_places(DELTOID, [pattern]) == ['humeral_point']
    assert build_space(DELTOID, ['sphere']).parameters[-1].name == 'humeral_point'


def test_curves_of_more_coefficients_than_bands_are_sought_by_them() -> None:
    one = replace(
        DELTOID,
        band_names=DELTOID.band_names[:1],
        s=(0.1,),
        heads=(Head('anterior', DELTOID.band_names[:1], DELTOID.band_names[0]),),
    )
    found = build_space(one, ['sphere.radius'])
    assert [parameter.name for parameter in found.parameters] == [
        f'sphere.radius[{k}]' for k in range(5)
    ]
    again = rebuilt(one, found, found.start).values['sphere.radius']
    assert again == pytest.approx(DELTOID.values['sphere.radius'][:1])
