# SPDX-License-Identifier: Apache-2.0
"""What a model does over its range of motion: entries, order, fan, jumps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from fits import deepest, numbered_backwards

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.fit.states import pose_grid
from linkedplane_ros.fit.survey import STEPS, survey_range
from linkedplane_ros.solver.range_check import DEFAULT_RANGE

DELTOID = BroadMuscle.load('deltoid')


def with_spheres_moved(*by: float) -> BroadMuscle:
    """Return the deltoid with its obstacle spheres moved in their frames, m."""
    return replace(DELTOID, sphere_centres=DELTOID.sphere_centres + by)


def test_entries_are_counted_over_the_grid_and_random_poses() -> None:
    found = survey_range(DELTOID, random=50, lines=0)
    angles, rotations = pose_grid(DELTOID.range_of_motion or DEFAULT_RANGE, STEPS)
    states = LinkedPlaneSolver(DELTOID).solve_batch(rotations)
    assert len(found.angles) == len(angles) + 50 == 17 * 13 * 13 + 50
    entered = deepest(states)
    np.testing.assert_allclose(found.depths[: len(angles)], entered, rtol=0.0, atol=1e-9)
    assert found.entered == (found.depths >= 0.0).sum() > 1000
    low, high = np.array(DELTOID.range_of_motion).T
    assert ((found.angles >= low - 1e-9) & (found.angles <= high + 1e-9)).all()


def test_the_published_deltoid_does_not_jump_along_its_coordinates() -> None:
    assert survey_range(DELTOID, random=0, lines=0).jump < 1e-6  # m


def test_a_jump_is_found_as_large_as_it_is() -> None:
    muscle = with_spheres_moved(0.0, 0.0, 0.02)  # a sphere that its band's plane leaves
    jump = survey_range(muscle, random=0, lines=0).jump
    q = np.arange(math.radians(-40.0), math.radians(120.0), math.radians(0.02))
    steps = math.radians(0.02), 1.0, 1.0
    rotations = pose_grid([(q[0], q[-1]), (0.0, 0.0), (0.0, 0.0)], steps)[1]
    change = np.abs(np.diff(LinkedPlaneSolver(muscle).solve_batch(rotations).lengths, axis=0)).max()
    assert len(rotations) > 7000
    assert jump == pytest.approx(change, rel=0.1)  # near the edge moment arms change at once
    assert jump > 0.01


def test_bands_without_a_path_are_counted() -> None:
    muscle = with_spheres_moved(0.0, -0.04, 0.0)
    rotations = pose_grid(muscle.range_of_motion or DEFAULT_RANGE, STEPS)[1]
    inside = LinkedPlaneSolver(muscle).solve_batch(rotations).wrap == WrapState.INSIDE
    assert survey_range(muscle, random=0, lines=0).inside == inside.sum() > 100


def test_a_muscle_without_any_path_is_told_in_one_line() -> None:
    with pytest.raises(ValueError, match=r'^deltoid: a band has no path anywhere: an end lies'):
        survey_range(with_spheres_moved(-0.04, 0.0, 0.0))


def test_bands_may_be_numbered_backwards() -> None:
    still = ((0.0, 0.0),) * 3
    for muscle in (DELTOID, numbered_backwards()):
        found = survey_range(replace(muscle, range_of_motion=still), random=0, lines=0)
        assert found.disordered == 0
        assert found.gaps.min() > 5e-3  # m


def test_without_a_range_of_its_own_a_model_is_looked_at_in_the_deltoids() -> None:
    found = survey_range(replace(DELTOID, range_of_motion=None), random=0, lines=0)
    assert found.ranges == DEFAULT_RANGE
