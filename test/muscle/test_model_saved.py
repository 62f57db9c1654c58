# SPDX-License-Identifier: Apache-2.0
"""A model keeps what its file states: load(save(m)) == m, and polynomials stay polynomials."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from reference import Array
from varied_muscles import MUSCLES, every_variation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, ModelError
from linkedplane_ros.muscle.file import bundled_models
from linkedplane_ros.muscle.parts import Head, Landmark, Polynomial, Span

DELTOID = BroadMuscle.load('deltoid')


def save_and_load(muscle: BroadMuscle, folder: Path) -> BroadMuscle:
    """Return a muscle saved and loaded."""
    path = folder / 'saved.yaml'
    muscle.to_yaml(path)
    return BroadMuscle.load(path)


def assert_same_to_the_bit(one: BroadMuscle, other: BroadMuscle) -> None:
    for each in fields(BroadMuscle):
        here, there = getattr(one, each.name), getattr(other, each.name)
        if isinstance(here, np.ndarray):
            assert here.tobytes() == there.tobytes(), each.name
        elif each.name != 'stated':
            assert here == there, each.name
    assert one == other
    assert hash(one) == hash(other)
    assert one.definition == other.definition


@pytest.mark.parametrize('case', MUSCLES)
def test_a_saved_muscle_is_loaded_to_the_bit(case: str, tmp_path: Path) -> None:
    muscle = MUSCLES[case]()
    assert_same_to_the_bit(muscle, save_and_load(muscle, tmp_path))


finite = st.floats(-8.9, 8.9, allow_subnormal=True)  # m, rad: within the limits


@settings(deadline=None, max_examples=60, derandomize=True)
@given(columns=st.lists(st.tuples(*[finite] * 6), min_size=1, max_size=4), angle=finite)
def test_any_numbers_are_saved_to_the_bit(
    columns: list[tuple[float, ...]], angle: float, tmp_path_factory: pytest.TempPathFactory
) -> None:
    values: Array = np.array(columns)
    n = len(values)
    muscle = replace(
        DELTOID,
        band_names=tuple(f'band_{i}' for i in range(n)),
        heads=(),
        origins=values[:, :3],
        insertions=values[:, :3] + (0.01, 0.02, -1.0),
        sphere_frame='humerus',
        sphere_centres=values[:, 3:],
        sphere_radii=np.abs(values[:, 5]) + 1e-3,
        plane_angles=np.full(n, angle),
    )
    assert_same_to_the_bit(muscle, save_and_load(muscle, tmp_path_factory.mktemp('saved')))


def test_polynomials_and_units_are_written_as_they_were(tmp_path: Path) -> None:
    DELTOID.to_yaml(tmp_path / 'saved.yaml')
    saved = yaml.safe_load((tmp_path / 'saved.yaml').read_text())
    stated = yaml.safe_load(bundled_models()['deltoid'])
    assert saved == stated
    assert DELTOID.definition.s == Span(0.1, 0.85)
    assert DELTOID.definition.length == 'mm'


def test_a_muscle_changed_in_python_is_written_as_lists_in_metres(tmp_path: Path) -> None:
    changed = replace(DELTOID, sphere_radii=DELTOID.sphere_radii * 1.1)
    assert changed != DELTOID
    assert changed.definition.length == 'm'
    path = tmp_path / 'saved.yaml'
    changed.to_yaml(path)
    assert yaml.safe_load(path.read_text())['sphere']['radius'] == {
        'list': changed.sphere_radii.tolist()
    }
    state, want = (LinkedPlaneSolver(m).solve(np.eye(3)) for m in (BroadMuscle.load(path), changed))
    assert state.lengths.tobytes() == want.lengths.tobytes()


def test_a_change_that_changes_nothing_keeps_the_polynomials() -> None:
    same = replace(DELTOID, origins=DELTOID.origins.copy())
    assert same == DELTOID
    assert same.definition is DELTOID.definition


def test_a_changed_coefficient_changes_its_bands() -> None:
    radius = DELTOID.definition.sphere_radius
    assert isinstance(radius, Polynomial)
    larger = Polynomial((*radius.coefficients[:-1], radius.coefficients[-1] + 2.0))
    muscle = BroadMuscle.from_definition(replace(DELTOID.definition, sphere_radius=larger))
    # m: two of the file's millimetres
    np.testing.assert_allclose(muscle.sphere_radii, DELTOID.sphere_radii + 2e-3, atol=1e-15)
    np.testing.assert_array_equal(muscle.origins, DELTOID.origins)


def test_a_number_is_changed_by_its_place() -> None:
    muscle = DELTOID.with_coefficients({'sphere.radius[4]': 39.294653, 'plane_angle[0]': 0.0})
    np.testing.assert_allclose(muscle.sphere_radii, DELTOID.sphere_radii + 2e-3, atol=1e-15)
    assert muscle.definition.plane_angle.coefficients[0] == 0.0
    places = BroadMuscle.from_definition(every_variation()).coefficients
    for place, value in (
        ('sphere.radius', 2.5),
        ('sphere.centre.x', 9.0),
        ('sphere.centre.y[1]', -0.1),
        ('sphere.humeral_point[2]', -29.63),
        ('plane_angle.list[8]', 11.3),
        ('insertion.list[8][1]', 100 * DELTOID.insertions[8, 1]),
        ('reference_normal[0]', -0.83),
    ):
        assert places[place] == value
    for each in (DELTOID, BroadMuscle.from_definition(every_variation())):
        assert each.with_coefficients(each.coefficients) == each


@pytest.mark.parametrize(
    ('values', 'told'),
    [
        ({'sphere.radius[5]': 1.0}, r'deltoid: sphere.radius\[5\]: no such number'),
        ({'name': 1.0}, 'deltoid: name: no such number'),
        ({'sphere.radius[4]': -100.0}, 'deltoid: sphere.radius: .* a radius > 0 expected'),
        ({'plane_angle[1]': np.nan}, r'deltoid: plane_angle\[1\]: a finite number expected'),
    ],
)
def test_a_change_that_is_no_good_is_refused(values: dict, told: str) -> None:
    with pytest.raises(ModelError, match=told):
        DELTOID.with_coefficients(values)


@pytest.mark.parametrize(
    'change',
    [
        {'name': 'other'},
        {'source': 'elsewhere'},
        {'licence': 'none'},
        {'sphere_frame': 'ground'},
        {'origins': DELTOID.origins + 1e-16},
        {'range_of_motion': None},
        {'landmarks': (Landmark('tip', 'scapula', (0.0, 0.0, 0.1)),)},
        {'heads': (Head('all', DELTOID.band_names, 'middle_1'),)},
    ],
)
def test_muscles_that_differ_in_anything_are_not_equal(change: dict) -> None:
    assert replace(DELTOID, **change) != DELTOID
    assert BroadMuscle.load('deltoid') == DELTOID != 'deltoid'


def test_a_muscle_without_heads_is_its_own_only_head() -> None:
    muscle = replace(DELTOID, heads=())
    assert muscle.heads == (Head('deltoid', DELTOID.band_names, 'middle_2'),)
    assert muscle.find_head('anterior_1') == 'deltoid'


def test_a_muscle_is_made_of_what_it_takes_and_no_more(tmp_path: Path) -> None:
    muscle = BroadMuscle(
        name='thread',
        source='a thought',
        band_names=np.array(['only']),
        origins=[[0, 0.03, 0.04]],
        insertions=[[0.02, 0, -0.09]],
        sphere_frame='ground',
        sphere_centres=[[0, 0, 0]],
        sphere_radii=[0.02],
        plane_angles=[0],
        reference_normal=[2, 0, 0],
        range_of_motion=np.zeros((3, 2)),
        landmarks=(Landmark('tip', 'scapula', np.array((0.0, 0.0, 0.1))),),
    )
    assert muscle.reference_normal.tolist() == [1.0, 0.0, 0.0]
    assert_same_to_the_bit(muscle, save_and_load(muscle, tmp_path))
    assert LinkedPlaneSolver(muscle).solve(np.eye(3)).lengths.shape == (1,)


def test_the_arrays_of_a_muscle_cannot_be_written_to() -> None:
    with pytest.raises(ValueError, match='read-only'):
        DELTOID.origins[0, 0] = 1.0


def test_what_would_be_read_otherwise_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / 'saved.yaml'
    names = tuple(f' {name}' for name in DELTOID.band_names)
    with pytest.raises(ModelError, match=r'heads\.deltoid\.represented_by') as caught:
        replace(DELTOID, band_names=names, heads=()).to_yaml(path)
    assert str(caught.value).startswith(str(path))
    assert not path.exists()


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r'cannot be written: No such file'):
        DELTOID.to_yaml(tmp_path / 'absent' / 'saved.yaml')
    with pytest.raises(ModelError, match=r'a model file ends in \.yaml'):
        DELTOID.to_yaml(tmp_path / 'saved.json')
