# SPDX-License-Identifier: Apache-2.0
"""What others want to see before they trust the solver: least totals, slopes, other engines."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import reference
from deltoid_poses import RANGES, rotations_in_range
from optional import requires
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def least_of_scan(poses: Array) -> Array:
    """Return the least total over the circle of theta in steps of 0.1 deg, literally."""
    return reference.total_at(DELTOID, poses[:, np.newaxis], reference.circle(3600)).min(axis=1)


def test_no_theta_of_a_fine_scan_is_better_over_2000_poses() -> None:
    # 0.1 deg over the whole circle, literally; a twentieth of a degree off the minimum E is higher
    # by 1e-5 m at most, so the scan also tells that the solver's total is not too short
    poses = rotations_in_range(2000, seed=3)
    totals = SOLVER.solve_batch(poses).total_length
    with ThreadPoolExecutor(2) as pool:
        scan = np.concatenate(list(pool.map(least_of_scan, np.split(poses, 40))))
    assert (totals - scan).max() <= 1e-9
    assert (scan - totals).max() <= 1e-5


def test_moment_vectors_are_the_slopes_of_the_solve_over_500_poses() -> None:
    # Richardson's central differences at two steps; where the two differ there is a kink, or a bend
    # too sharp for them, and they tell nothing
    poses = rotations_in_range(500, seed=4)
    state = SOLVER.solve_batch(poses)
    coarse, fine = slopes(poses, 2e-3), slopes(poses, 1e-3)
    told = np.abs(fine - coarse).max(axis=(1, 2)) < 3e-9
    off = np.abs(state.moment_vectors + fine).max(axis=(1, 2))
    assert told.sum() > 450
    assert off[told].max() <= 1e-8


def slopes(poses: Array, h: float) -> Array:
    """Return dL/domega (m, n, 3) by solving anew at turns of h and h / 2 (rad); error of h^4."""
    steps = h * np.array((-1.0, -0.5, 0.5, 1.0))
    turns = Rotation.from_rotvec(np.einsum('h,ij->hij', steps, np.eye(3)).reshape(-1, 3))
    near = SOLVER.solve_batch((turns.as_matrix()[:, np.newaxis] @ poses).reshape(-1, 3, 3))
    L = near.lengths.reshape(4, 3, len(poses), -1)
    return np.moveaxis((8.0 * (L[2] - L[1]) - (L[3] - L[0])) / (6.0 * h), 0, -1)


@cache
def standing_bands() -> tuple[list[LinkedPlaneSolver], tuple[Array, Array, Array, Array]]:
    """Return each band as a muscle of its own, its sphere fixed to the ground; and their numbers.

    With HM at the glenohumeral centre the moving frames stand still; one band's plane is free.
    """
    ones = [
        LinkedPlaneSolver(
            replace(
                DELTOID,
                band_names=(name,),
                heads=(),
                origins=DELTOID.origins[i : i + 1],
                insertions=DELTOID.insertions[i : i + 1],
                sphere_centres=DELTOID.sphere_centres[i : i + 1],
                sphere_radii=DELTOID.sphere_radii[i : i + 1],
                plane_angles=DELTOID.plane_angles[i : i + 1],
                humeral_point=np.zeros(3),
            )
        )
        for i, name in enumerate(DELTOID.band_names)
    ]
    centres = np.concatenate([one.solve(np.eye(3)).sphere_centres for one in ones])
    return ones, (DELTOID.origins, DELTOID.insertions, centres, DELTOID.sphere_radii)


@pytest.mark.parametrize(
    'engine', [pytest.param(name, marks=requires(name)) for name in ('mujoco', 'opensim')]
)
def test_a_band_alone_is_that_of_another_engine(engine: str) -> None:
    import rivals

    ones, numbers = standing_bands()
    rival: Any = rivals.MujocoBands if engine == 'mujoco' else rivals.OpenSimBands
    other = rival(*numbers)
    wrapped = 0
    for angles in np.random.default_rng(5).uniform(*RANGES.T, (40, 3)):
        rotation = THESIS.rotation(angles)
        states = [one.solve(rotation) for one in ones]
        wrapped += sum(int(state.wrap[0] == WrapState.WRAPPED) for state in states)
        lengths = np.concatenate([state.lengths for state in states])
        moments = np.concatenate([state.moment_vectors for state in states])
        if engine == 'mujoco':
            their_lengths, their_moments = other.solve(rotation)
        else:
            their_lengths, their_moments = other.solve(angles)
            moments = moments @ THESIS.axes(angles)
        # m: two closed forms of the same path
        np.testing.assert_allclose(lengths, their_lengths, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(moments, their_moments, rtol=0.0, atol=1e-9)
    assert wrapped > 30
