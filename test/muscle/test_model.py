# SPDX-License-Identifier: Apache-2.0
"""The model file: the published deltoid, number by number."""

from typing import Any

import numpy as np
import pytest
from reference import Array
from spoilt_models import Content, Write, spoil

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver

PRINTED = 1e-6  # mm: the last printed digit, rounded

# Table 6.2.1, mm. Erratum 2: at s = 0.662 the table prints 39.002657 and -24.278081.
ORIGINS = [
    (-30.364671, 29.960188, 50.400338),
    (-10.635975, 19.135245, 46.662769),
    (5.177352, 4.035993, 39.755528),
    (10.080286, -15.407628, 33.140352),
    (2.689311, -32.151317, 28.428708),
    (-14.557902, -40.244315, 25.776385),
    (-37.192806, -39.002657, 24.278081),
    (-60.506285, -33.147806, 22.361996),
    (-81.338976, -28.910651, 18.184419),
]
# Table 6.2.2, mm. Erratum 3: the z column is shifted at s = 0.569 (prints -96.184484) and 0.662
# (prints -96.717775).
INSERTIONS = [
    (27.612714, 18.917582, -98.235863),
    (29.151882, 14.704815, -98.006792),
    (30.461534, 10.438491, -97.535801),
    (31.511408, 6.133919, -96.970483),
    (32.271238, 1.80640, -96.458430),
    (32.710763, -2.528731, -96.147233),
    (32.799717, -6.856190, -96.184484),
    (32.507837, -11.160659, -96.717775),
    (31.804860, -15.426829, -97.894699),
]


def largest_gap(found_m: Array, printed_mm: Any) -> float:
    return float(np.abs(found_m * 1e3 - np.array(printed_mm)).max())


def test_the_deltoids_origins_are_those_of_table_6_2_1() -> None:
    # mm; the table was made with unrounded coefficients
    assert largest_gap(BroadMuscle.load('deltoid').origins, ORIGINS) < 1e-4


def test_the_deltoids_insertions_are_those_of_table_6_2_2() -> None:
    assert largest_gap(BroadMuscle.load('deltoid').insertions, INSERTIONS) < 1e-4


def test_the_deltoid_is_in_metres_and_its_normal_a_unit_vector() -> None:
    muscle = BroadMuscle.load('deltoid')
    np.testing.assert_allclose(muscle.ground_point, [-0.0955, 0.1354, 0.034], atol=1e-15)
    np.testing.assert_allclose(muscle.humeral_point, [0.0, 0.0, -0.02963], atol=1e-15)
    normal = np.array([-0.83, 0.29, -0.47])
    np.testing.assert_allclose(muscle.reference_normal, normal / np.linalg.norm(normal), atol=1e-15)
    # radius and phi over s = 0.10 .. 0.85: 36 to 14 mm and 0.48 to 0.16 rad, highest power first
    s = np.linspace(0.10, 0.85, 9)
    radius = [-14.833320, -16.211523, 2.679743, -9.323871, 37.294653]
    phi = [-0.471239, -0.515373, -0.366520, 0.072008, 0.444474]
    for found, coefficients, unit in (
        (muscle.sphere_radii, radius, 1e-3),
        (muscle.plane_angles, phi, 1.0),
    ):
        expected = sum(c * s ** (4 - k) for k, c in enumerate(coefficients))
        np.testing.assert_allclose(found, expected * unit, atol=1e-12)


def test_the_deltoids_heads_are_those_the_thesis_compares() -> None:
    muscle = BroadMuscle.load('deltoid')
    represented = {head.name: head.represented_by for head in muscle.heads}
    order = [muscle.band_names.index(represented[name]) for name in ('anterior', 'middle')]
    assert order == [1, 3]
    assert muscle.band_names.index(represented['posterior']) == 7
    assert muscle.find_head('posterior_3') == 'posterior'


def test_the_deltoids_interference_spheres_are_those_of_table_5_1() -> None:
    muscle = BroadMuscle.load('deltoid')
    centres = [(-0.20, 3.00, -1.00), (-13.50, -12.00, 20.40), (-35.70, 3.00, -10.00)]
    assert largest_gap(muscle.interference_centres, centres) < PRINTED
    assert largest_gap(muscle.interference_radii, [27.40, 24.30, 23.90]) < PRINTED


def test_a_file_gives_the_same_muscle_as_the_bundled_one(content: Content, write: Write) -> None:
    mine, bundled = BroadMuscle.load(write(content)), BroadMuscle.load('deltoid')
    assert mine.origins.tobytes() == bundled.origins.tobytes()
    assert BroadMuscle.load(str(write(content))).band_names == bundled.band_names


def test_units_of_a_file_are_converted(content: Content, write: Write) -> None:
    content['units'] = {'length': 'cm', 'angle': 'deg'}
    muscle, bundled = BroadMuscle.load(write(content)), BroadMuscle.load('deltoid')
    np.testing.assert_allclose(muscle.origins, bundled.origins * 10.0, rtol=1e-14)
    np.testing.assert_allclose(muscle.sphere_radii, bundled.sphere_radii * 10.0, rtol=1e-14)
    np.testing.assert_allclose(muscle.plane_angles, np.radians(bundled.plane_angles), rtol=1e-14)


def test_a_file_without_interference_spheres_has_none(content: Content, write: Write) -> None:
    muscle = BroadMuscle.load(write(spoil(content, 'interference_spheres', ...)))
    assert muscle.interference_centres.shape == (0, 3)
    assert muscle.interference_names == ()


@pytest.mark.parametrize('count', [1, 2, 40])
def test_a_file_may_name_any_number_of_bands(count: int, content: Content, write: Write) -> None:
    names = [f'band_{i}' for i in range(count)]
    content['bands']['names'] = names
    content['heads'] = {'all': {'bands': names, 'represented_by': names[0]}}
    muscle = BroadMuscle.load(write(content))
    assert muscle.origins.shape == (count, 3)
    assert LinkedPlaneSolver(muscle).solve(np.eye(3)).lengths.shape == (count,)
