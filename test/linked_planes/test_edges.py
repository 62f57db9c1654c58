# SPDX-License-Identifier: Apache-2.0
"""Theta at the edge of a sphere: what its derivative is, and where it has only a one-sided one."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from random_muscles import (
    absurd_muscle,
    length_bounds,
    random_muscle,
    random_muscle_in_frames,
    wild_muscle,
)
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneError, LinkedPlaneSolver, WrapState
from linkedplane_ros.joints.conventions import THESIS_CONVENTION

FITTED = LinkedPlaneSolver(BroadMuscle.load('deltoid_ackland2008'))


def rotations_about(axes: Array, angle: float, rotation: Array) -> Array:
    """Return a rotation (3, 3) turned by an angle, rad, about each axis (k, 3)."""
    turned: Array = Rotation.from_rotvec(angle * axes).as_matrix() @ rotation
    return turned


def touching(solver: LinkedPlaneSolver, start: Array, end: Array) -> tuple[Array, Array]:
    """Return the neighbouring poses between which a band at an edge goes from CLEAR to MISSED."""
    assert (solver.solve(start).wrap[0], solver.solve(end).wrap[0]) == (
        WrapState.CLEAR,
        WrapState.MISSED,
    )
    way = Rotation.from_matrix(end @ start.T).as_rotvec()
    low, high = 0.0, 1.0
    while low < (middle := 0.5 * (low + high)) < high:
        pose = Rotation.from_rotvec(middle * way).as_matrix() @ start
        missed = solver.solve(pose).wrap[0] == WrapState.MISSED
        low, high = (low, middle) if missed else (middle, high)
    clear, missed = (Rotation.from_rotvec(x * way).as_matrix() @ start for x in (low, high))
    return clear, missed


def rim_poses() -> tuple[Array, Array]:
    """Return poses about the issue's one, at which theta rides the first band's sphere."""
    rng = np.random.default_rng(0)
    angles = np.radians(np.array((50.8, -43.6, 83.4)) + rng.uniform(-0.05, 0.05, (300, 3)))
    rotations = THESIS_CONVENTION.rotations_and_axes(angles)[0]
    wrap = FITTED.solve_batch(rotations).wrap[:, 0]
    return rotations[wrap == WrapState.CLEAR], rotations[wrap == WrapState.MISSED]


def test_where_a_line_touches_the_rim_the_derivative_is_that_of_the_clear_side() -> None:
    clear, missed = rim_poses()
    assert min(len(clear), len(missed)) > 20
    for start, end in zip(clear[:10], missed[:10], strict=True):
        pose, _ = touching(FITTED, start, end)
        state = FITTED.solve(pose)
        assert np.linalg.norm(state.moment_vectors, axis=1).max() < 0.1  # m; it was 1e14
        np.testing.assert_array_equal(state.one_sided, state.wrap == WrapState.WRAPPED)
        into = Rotation.from_matrix(start @ pose.T).as_rotvec()
        into *= 1e-7 / np.linalg.norm(into)
        beside = FITTED.solve(Rotation.from_rotvec(into).as_matrix() @ pose)
        slope = (beside.lengths - state.lengths) / 1e-7
        np.testing.assert_allclose(-state.moment_vectors @ (into / 1e-7), slope, atol=1e-5)
        assert not beside.one_sided.any()


def test_near_the_rim_moment_arms_are_the_lengths_slopes() -> None:
    for rotation in rim_poses()[0][:20]:
        state = FITTED.solve(rotation)
        near = [
            FITTED.solve_batch(rotations_about(np.eye(3), h, rotation)).lengths
            for h in (1e-7, -1e-7)
        ]
        slopes = (near[0] - near[1]).T / 2e-7
        np.testing.assert_allclose(state.moment_vectors, -slopes, atol=1e-5)


def doubled(muscle: BroadMuscle) -> BroadMuscle:
    """Return a muscle with a second band on each band: all edges are those of two."""
    angles = np.repeat(muscle.plane_angles, 2)
    angles[1::2] = 0.0
    return replace(
        muscle,
        band_names=tuple(f'{name}_{k}' for name in muscle.band_names for k in range(2)),
        heads=(),
        sphere_frame=tuple(np.repeat(muscle.sphere_frames, 2).tolist()),
        origins=np.repeat(muscle.origins, 2, axis=0),
        insertions=np.repeat(muscle.insertions, 2, axis=0),
        sphere_centres=np.repeat(muscle.sphere_centres, 2, axis=0),
        sphere_radii=np.repeat(muscle.sphere_radii, 2),
        plane_angles=angles,
    )


def test_bands_that_share_an_edge_are_held_at_it_together() -> None:
    for seed in range(60):
        muscle, rotations = random_muscle(seed)
        once = LinkedPlaneSolver(muscle).solve_batch(rotations)
        twice = LinkedPlaneSolver(doubled(muscle)).solve_batch(rotations)
        for field in ('lengths', 'moment_vectors'):
            want = np.repeat(getattr(once, field), 2, axis=1)
            np.testing.assert_allclose(getattr(twice, field), want, rtol=0.0, atol=1e-6)
        np.testing.assert_array_equal(twice.wrap, np.repeat(once.wrap, 2, axis=1))
        assert not (twice.one_sided & ~np.repeat(once.one_sided, 2, axis=1)).any()


def test_at_a_corner_of_two_edges_the_derivative_is_one_sided_and_marked() -> None:
    h, marked = 1e-7, 0  # rad
    for seed in range(60):
        muscle, rotations = random_muscle_in_frames(seed, 'ground')
        for rotation in rotations[:2]:
            corner = doubled(muscle)  # the second of two spheres moves with the humerus
            centres = corner.sphere_centres.copy()
            centres[1::2] = centres[1::2] @ rotation
            frames = ('ground', 'humerus') * len(muscle.band_names)
            corner = replace(corner, sphere_frame=frames, sphere_centres=centres)
            solver = LinkedPlaneSolver(corner)
            state = solver.solve(rotation)
            if not state.one_sided.any():
                continue
            marked += 1
            ends = [solver.solve_batch(rotations_about(np.eye(3), x, rotation)) for x in (h, -h)]
            ahead, behind = ((end.lengths - state.lengths) / h for end in ends)
            want = -state.moment_vectors.T
            off = np.minimum(abs(ahead - want), abs(-behind - want))
            smooth = [(end.wrap[:, ::2] == state.wrap[::2]).all(axis=1) for end in ends]
            # m: edges that meet at a small angle turn soon
            assert off[smooth[0] & smooth[1]].max(initial=0.0) < 2e-3
    assert marked > 10


@pytest.mark.parametrize('part', range(5))
def test_wild_muscles_have_real_lengths_and_finite_moments(part: int) -> None:
    # 0.5 deg here; make soak scans a million poses by 0.05 deg
    solved = 0
    for seed in range(10 * part, 10 * part + 10):
        muscle, rotations = wild_muscle(seed, 25)
        try:
            states = LinkedPlaneSolver(muscle).solve_batch(rotations)
        except LinkedPlaneError:
            continue  # a band has no plane at all
        solved += len(states)
        lines, longest = length_bounds(muscle, rotations)
        assert (states.lengths >= lines - 1e-15).all()
        assert (states.lengths <= longest + 1e-15).all()
        assert np.isfinite(states.moment_vectors).all()
        assert np.isfinite(states.theta).all()
    assert solved >= 150


ABSURD = (*range(120, 200), 956, 2303)  # of the last two, a plane turns by 1e-9 rad per number


def absurd_totals(seeds: tuple[int, ...]) -> Array:
    """Return the total length, m, of each pose of absurd muscles, in one row."""
    solved = [
        LinkedPlaneSolver(muscle).solve_batch(rotations)
        for muscle, rotations in (absurd_muscle(seed, 5) for seed in seeds)
    ]
    return np.concatenate([states.total_length for states in solved])


def test_absurd_muscles_have_real_lengths_and_finite_moments() -> None:
    for seed in ABSURD:
        muscle, rotations = absurd_muscle(seed, 20)
        states = LinkedPlaneSolver(muscle).solve_batch(rotations)
        lines = np.linalg.norm(states.insertions - states.origins, axis=2)
        _, longest = length_bounds(muscle, rotations)
        assert (states.lengths >= lines * (1.0 - 1e-12)).all(), seed
        assert (states.lengths <= longest * (1.0 + 1e-12)).all(), seed
        assert np.isfinite(states.moment_vectors).all()
        assert np.isfinite(states.theta).all()


def test_absurd_muscles_are_as_short_uncompiled(tmp_path: Path) -> None:
    code = (
        'import numpy, test_edges\n'
        f'numpy.save({str(tmp_path / "totals.npy")!r}, test_edges.absurd_totals({ABSURD[-22:]}))\n'
    )
    paths = os.pathsep.join(str(Path(__file__).parents[k]) for k in range(2))
    environment = {**os.environ, 'LINKEDPLANE_COMPILE': '0', 'PYTHONPATH': paths}
    subprocess.run([sys.executable, '-c', code], env=environment, check=True)
    # relative: theta's own rounding turns such a plane by up to 1e-8 rad
    totals = absurd_totals(ABSURD[-22:])
    np.testing.assert_allclose(np.load(tmp_path / 'totals.npy'), totals, rtol=1e-6)
