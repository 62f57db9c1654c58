# SPDX-License-Identifier: Apache-2.0
"""A model at a subject's size: what scales, and how."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from random_muscles import random_muscle_in_frames
from varied_muscles import every_variation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, ModelError
from linkedplane_ros.muscle.parts import Listed, Polynomial
from linkedplane_ros.muscle.scaling import Scale

DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
POSES = np.array(
    [
        THESIS.rotation(angles)
        for angles in np.random.default_rng(12).uniform([-0.7, 0.0, -1.0], [2.0, 2.0, 1.0], (60, 3))
    ]
)
FACTORS = np.array((1.1, 0.9, 1.3))


def variations() -> dict[str, BroadMuscle]:
    """Return a muscle with its spheres in each frame."""
    return {'deltoid': DELTOID, 'all': BroadMuscle.from_definition(every_variation())} | {
        frame: random_muscle_in_frames(4, frame)[0]
        for frame in ('moving', 'ground', 'humerus', 'mixed')
    }


@pytest.mark.parametrize('factor', [0.3, 1.07, 2.0])
@pytest.mark.parametrize('name', variations())
def test_lengths_and_moment_arms_scale_with_the_muscle(name: str, factor: float) -> None:
    muscle = variations()[name]
    here, there = (LinkedPlaneSolver(m).solve_batch(POSES) for m in (muscle, muscle.scaled(factor)))
    np.testing.assert_array_equal(there.wrap, here.wrap)
    # m: rounding; lengths hang on theta by up to 0.1 m/rad
    np.testing.assert_allclose(there.lengths, factor * here.lengths, rtol=0.0, atol=1e-12)
    moments = factor * here.moment_vectors
    np.testing.assert_allclose(there.moment_vectors, moments, rtol=0.0, atol=1e-11)


def test_the_deltoids_moment_arms_scale_to_rounding() -> None:
    here, there = (LinkedPlaneSolver(m).solve_batch(POSES) for m in (DELTOID, DELTOID.scaled(1.1)))
    off = np.abs(there.moment_vectors - 1.1 * here.moment_vectors).max()
    assert off < 1e-12  # m


def test_an_even_scale_keeps_polynomials_units_and_the_plane_angles() -> None:
    scaled = DELTOID.scaled(1.1).definition
    assert scaled.length == 'mm'
    for key, curve in scaled.curves().items():
        assert isinstance(curve, Polynomial), key
    assert scaled.plane_angle == DELTOID.definition.plane_angle
    assert scaled.reference_normal == DELTOID.definition.reference_normal
    assert scaled.source == f'{DELTOID.source}; scaled by 1.1'


@pytest.mark.parametrize('scale', [1, 1.0, '1', (1.0, 1.0, 1.0), '1,1,1,1,1,1', Scale()])
def test_a_scale_of_one_changes_nothing(scale: Any) -> None:
    assert DELTOID.scaled(scale) == DELTOID


def test_points_scale_along_the_axes_of_their_bone() -> None:
    humerus = np.array((1.2, 1.0, 0.8))
    scaled = DELTOID.scaled((*FACTORS, *humerus))
    for field, factors in (
        ('origins', FACTORS),
        ('insertions', humerus),
        ('ground_point', FACTORS),
        ('humeral_point', humerus),
        ('interference_centres', FACTORS),
    ):
        want = getattr(DELTOID, field) * factors
        # m: the rounding of polynomials whose terms are a thousand times their sum
        np.testing.assert_allclose(getattr(scaled, field), want, rtol=0.0, atol=1e-14)
    factors_of = {'scapula': FACTORS, 'humerus': humerus}
    for mark, was in zip(scaled.landmarks, DELTOID.landmarks, strict=True):
        np.testing.assert_allclose(mark.at, was.at * factors_of[mark.bone], rtol=1e-14)
    assert scaled.range_of_motion == DELTOID.range_of_motion


@pytest.mark.parametrize('frame', ['ground', 'humerus'])
def test_a_sphere_on_a_bone_goes_along_and_stays_a_sphere(frame: str) -> None:
    muscle, _ = random_muscle_in_frames(4, frame)
    other = (1.0, 1.0, 1.0)
    scaled = muscle.scaled((*FACTORS, *other) if frame == 'ground' else (*other, *FACTORS))
    np.testing.assert_allclose(scaled.sphere_centres, muscle.sphere_centres * FACTORS, rtol=1e-14)
    mean = np.prod(FACTORS) ** (1.0 / 3.0)
    np.testing.assert_allclose(scaled.sphere_radii, muscle.sphere_radii * mean, rtol=1e-14)


def test_a_sphere_in_a_moving_frame_scales_by_the_mean_of_both_bones() -> None:
    scaled = DELTOID.scaled((*FACTORS, 1.2, 1.0, 0.8))
    mean = np.prod((*FACTORS, 1.2, 1.0, 0.8)) ** (1.0 / 6.0)
    np.testing.assert_allclose(scaled.sphere_centres, DELTOID.sphere_centres * mean, rtol=1e-14)
    np.testing.assert_allclose(scaled.sphere_radii, DELTOID.sphere_radii * mean, rtol=1e-14)
    assert isinstance(scaled.definition.sphere_radius, Polynomial)


def test_spheres_in_many_frames_each_scale_with_their_own() -> None:
    muscle = BroadMuscle.from_definition(every_variation())
    scaled = muscle.scaled(tuple(FACTORS))
    mean = np.prod(FACTORS) ** (1.0 / 3.0)
    for i, frame in enumerate(muscle.sphere_frames):
        want = muscle.sphere_centres[i] * (mean if frame == 'moving' else FACTORS)
        np.testing.assert_allclose(scaled.sphere_centres[i], want, rtol=1e-14)
    assert all(isinstance(curve, Listed) for curve in scaled.definition.sphere_centre)


def test_the_reference_plane_is_the_same_plane_of_the_scaled_muscle() -> None:
    normal, scaled = DELTOID.reference_normal, DELTOID.scaled(tuple(FACTORS)).reference_normal
    for within in np.cross(normal, np.eye(3)):
        assert scaled @ (within * FACTORS) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize('scale', ['1.07', '1.1,0.9,1.3', '1.1,0.9,1.3,1.2,1,0.8'])
@pytest.mark.parametrize('name', variations())
def test_a_scaled_muscle_is_saved_and_loaded_to_the_bit(
    name: str, scale: str, tmp_path: Path
) -> None:
    muscle = variations()[name].scaled(scale)
    muscle.to_yaml(tmp_path / 'scaled.yaml')
    loaded = BroadMuscle.load(tmp_path / 'scaled.yaml')
    assert loaded == muscle
    assert loaded.origins.tobytes() == muscle.origins.tobytes()


@pytest.mark.parametrize(
    ('scale', 'told'),
    [
        ('0', 'a factor > 0 expected'),
        (-1.0, 'a factor > 0 expected'),
        ('nan', 'a factor > 0 expected'),
        ('inf', 'a factor > 0 expected'),
        (0.19, '0.19 given, a factor > 0 expected, from 0.2 to 5'),
        ('5.01', '5.01 given, a factor > 0 expected, from 0.2 to 5'),
        ('1,1,1,1,1,1e9', '1e[+]09 given, a factor > 0 expected, from 0.2 to 5'),
        pytest.param(10**5000, '<16610 bits> given; one factor, 3', id='of many digits'),
        ('large', "'large' given; one factor, 3"),
        pytest.param('1' * 9999, 'inf given, a factor > 0 expected', id='of many ones'),
        (None, 'None given; one factor, 3'),
        (['a'], 'given; one factor, 3'),
        ([1.0, [1.0]], 'given; one factor, 3'),
        ([[1.0, 1.0, 1.0]], 'given; one factor, 3'),
        ('1,2', "'1,2' given; one factor, 3"),
        ((), 'one factor, 3'),
        ('', 'one factor, 3'),
        ('absent.yaml', 'absent.yaml: cannot be read: No such file'),
    ],
)
def test_what_is_no_scale_is_refused(scale: Any, told: str) -> None:
    with pytest.raises(ModelError, match=told):
        DELTOID.scaled(scale)


@pytest.mark.parametrize('factor', [0.2, '0.2', 5, 5.0])
def test_the_limits_of_a_scale_are_taken(factor: Any) -> None:
    np.testing.assert_allclose(DELTOID.scaled(factor).origins, float(factor) * DELTOID.origins)


@pytest.mark.parametrize('given', [(1.0, 1.0), 'abc', None, (1.0, 'a', 1.0), (1.0, 1.0, 9.0)])
def test_a_scale_made_in_python_has_three_factors_for_a_bone(given: Any) -> None:
    with pytest.raises(ModelError, match=r'^scale: '):
        Scale(scapula=given)
