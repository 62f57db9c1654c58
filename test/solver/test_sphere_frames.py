# SPDX-License-Identifier: Apache-2.0
"""Obstacle spheres that move with the ground, the humerus or their band's own frame (thesis ch. 4).

There they may be fixed to the ground or to the moving bones, or have a motion of their own.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import reference
from random_muscles import LEAST, SAME, random_muscle_in_frames
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.linked_planes.compilation import COMPILED

FRAMES = ('moving', 'ground', 'humerus')
DELTOID = BroadMuscle.load('deltoid')


@pytest.mark.parametrize('frame', ['ground', 'humerus', 'mixed'])
def test_a_muscle_is_as_short_as_the_best_of_a_scan(frame: str) -> None:
    wrapped = 0
    for seed in range(25):
        muscle, rotations = random_muscle_in_frames(seed, frame)
        batch = LinkedPlaneSolver(muscle).solve_batch(rotations)
        scan = reference.total_at(muscle, rotations[:, np.newaxis], reference.circle(720))
        assert (batch.total_length <= scan.min(axis=1) + LEAST).all()
        # theta may stand at the edge of a sphere, where the length jumps: either side will do
        around = batch.theta + np.array([[-1e-9], [0.0], [1e-9]])  # rad
        off = np.abs(reference.lengths_at(muscle, rotations, around) - batch.lengths)
        assert (off.min(axis=0) < 1e-8).all()  # m: 1e-9 rad at no more than 0.1 m/rad
        assert (np.median(off.min(axis=0)) < SAME).all()
        wrapped += int((batch.wrap == WrapState.WRAPPED).sum())
    assert wrapped > 50


@pytest.mark.parametrize('frame', [*FRAMES, 'mixed'])
def test_moment_vectors_are_the_lengths_slopes_the_linked_term_included(frame: str) -> None:
    # Richardson's central differences; where two steps differ there is a kink, or too sharp a bend
    told = wrapped = linked = 0
    for seed in range(60):
        muscle, rotations = random_muscle_in_frames(seed, frame)
        solver = LinkedPlaneSolver(muscle)
        batch = solver.solve_batch(rotations)
        coarse, fine = slopes(solver, rotations, 2e-3), slopes(solver, rotations, 1e-3)
        smooth = np.abs(fine - coarse).max(axis=(1, 2)) < 3e-9
        off = np.abs(batch.moment_vectors + fine).max(axis=(1, 2))[smooth]
        assert off.max(initial=0.0) <= 1e-8  # m
        told += int(smooth.sum())
        wraps = (batch.wrap[smooth] == WrapState.WRAPPED).sum(axis=1)
        wrapped += int(wraps.sum())
        linked += int((wraps > 1).sum())
    assert told > 120
    assert wrapped > 120
    assert linked > 25  # theta weighs one band against another


def slopes(solver: LinkedPlaneSolver, poses: Array, h: float) -> Array:
    """Return dL/domega (m, n, 3) by solving anew at turns of h and h / 2 (rad); error of h^4."""
    steps = h * np.array((-1.0, -0.5, 0.5, 1.0))
    turns = Rotation.from_rotvec(np.einsum('h,ij->hij', steps, np.eye(3)).reshape(-1, 3))
    near = solver.solve_batch((turns.as_matrix()[:, np.newaxis] @ poses).reshape(-1, 3, 3))
    L = near.lengths.reshape(4, 3, len(poses), -1)
    return np.moveaxis((8.0 * (L[2] - L[1]) - (L[3] - L[0])) / (6.0 * h), 0, -1)


def test_a_sphere_stands_where_its_frame_has_it() -> None:
    muscle, rotations = random_muscle_in_frames(3, 'mixed')
    assert len(muscle.band_names) >= 3
    for rotation in rotations:
        centres = LinkedPlaneSolver(muscle).solve(rotation).sphere_centres
        given = muscle.sphere_centres
        np.testing.assert_allclose(centres[0], given[0], rtol=0.0, atol=1e-15)
        np.testing.assert_allclose(centres[2], rotation @ given[2], rtol=0.0, atol=1e-15)
        literal = reference.sphere_centres(muscle, rotation)
        np.testing.assert_allclose(centres, literal, rtol=0.0, atol=1e-14)


def test_moving_frames_that_stand_still_are_the_grounds() -> None:
    # HM at the centre of the joint: no pose moves it
    still = replace(DELTOID, humeral_point=np.zeros(3))
    centres = LinkedPlaneSolver(still).solve(np.eye(3)).sphere_centres
    ground = replace(still, sphere_frame='ground', sphere_centres=centres)
    poses = Rotation.random(200, np.random.default_rng(1)).as_matrix()
    one, other = (LinkedPlaneSolver(muscle).solve_batch(poses) for muscle in (still, ground))
    np.testing.assert_array_equal(one.wrap, other.wrap)
    # m: the rounding of the centres
    np.testing.assert_allclose(one.lengths, other.lengths, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(one.moment_vectors, other.moment_vectors, rtol=0.0, atol=1e-9)


def test_seen_from_the_humerus_a_sphere_on_it_stands_on_the_ground() -> None:
    # run from their insertions to their origins the bands are as long; the sense of phi turns about
    for seed in range(10):
        muscle, rotations = random_muscle_in_frames(seed, 'humerus')
        seen = replace(
            muscle,
            origins=muscle.insertions,
            insertions=muscle.origins,
            sphere_frame='ground',
            plane_angles=-muscle.plane_angles,
        )
        here, there = LinkedPlaneSolver(muscle), LinkedPlaneSolver(seen)
        for rotation in rotations:
            one, other = here.solve(rotation), there.solve(rotation.T)
            np.testing.assert_allclose(other.lengths, one.lengths, rtol=0.0, atol=1e-9)
            moments = -other.moment_vectors @ rotation.T
            np.testing.assert_allclose(moments, one.moment_vectors, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize('frame', ['ground', 'humerus', 'mixed'])
def test_the_left_shoulder_is_the_muscle_mirrored_by_hand(frame: str) -> None:
    for seed in range(6):
        muscle, rotations = random_muscle_in_frames(seed, frame)
        left, mirrored = (
            LinkedPlaneSolver(muscle, 'left'),
            LinkedPlaneSolver(reference.mirrored(muscle)),
        )
        for rotation in rotations:
            one = left.solve(rotation)
            other = mirrored.solve(reference.mirrored_rotation(rotation))
            np.testing.assert_allclose(one.lengths, other.lengths, rtol=0.0, atol=1e-9)
            np.testing.assert_allclose(one.moment_vectors, other.moment_vectors, atol=1e-6)
            np.testing.assert_allclose(one.sphere_centres, other.sphere_centres, atol=1e-14)


def test_a_bands_path_lies_on_its_sphere_in_any_frame() -> None:
    for frame in ('ground', 'humerus', 'mixed'):
        for seed in range(5):
            muscle, rotations = random_muscle_in_frames(seed, frame)
            for state in LinkedPlaneSolver(muscle).solve_batch(rotations):
                for i in np.flatnonzero(state.wrap == WrapState.WRAPPED):
                    away = state.paths()[i][1:-1] - state.sphere_centres[i]
                    radii = np.linalg.norm(away, axis=1)
                    np.testing.assert_allclose(radii, muscle.sphere_radii[i], rtol=0.0, atol=1e-12)


@pytest.mark.skipif(not COMPILED, reason='numba is not installed or LINKEDPLANE_COMPILE is 0')
def test_compiled_and_uncompiled_agree(tmp_path: Path) -> None:
    poses = Rotation.random(30, np.random.default_rng(2)).as_matrix()
    muscles = [
        random_muscle_in_frames(seed, frame)[0] for frame in (*FRAMES, 'mixed') for seed in (3, 4)
    ]
    files = [tmp_path / f'{k}.yaml' for k in range(len(muscles))]
    for muscle, file in zip(muscles, files, strict=True):
        muscle.to_yaml(file)
    np.save(tmp_path / 'poses.npy', poses)
    code = (
        'import sys, numpy as np, linkedplane_ros as l\n'
        'from linkedplane_ros.linked_planes.compilation import COMPILED\n'
        'assert not COMPILED\n'
        'poses = np.load(sys.argv[1])\n'
        'for file in sys.argv[2:]:\n'
        '    s = l.LinkedPlaneSolver(l.BroadMuscle.load(file)).solve_batch(poses)\n'
        '    np.save(file, s.lengths)\n'
    )
    environment = {**os.environ, 'LINKEDPLANE_COMPILE': '0'}
    command = [sys.executable, '-c', code, str(tmp_path / 'poses.npy'), *map(str, files)]
    subprocess.run(command, env=environment, check=True)
    for muscle, file in zip(muscles, files, strict=True):
        compiled = LinkedPlaneSolver(muscle).solve_batch(poses)
        uncompiled = np.load(f'{file}.npy')
        np.testing.assert_allclose(compiled.lengths, uncompiled, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize('frame', FRAMES)
def test_a_band_without_a_plane_is_told_of_its_sphere_only_where_that_has_a_part(
    frame: str,
) -> None:
    # turned half about, the humerus has the insertion at the origin
    muscle = replace(
        DELTOID,
        insertions=-DELTOID.origins,
        sphere_frame=frame,
        sphere_centres=np.tile([0.3, 0.0, 0.0], (9, 1)),
        sphere_radii=np.full(9, 0.01),
    )
    half = reference.unit(DELTOID.origins[4])
    turn = Rotation.from_rotvec(np.pi * np.cross(half, reference.unit(np.cross(half, [0, 0, 1.0]))))
    with pytest.raises(ValueError, match='band middle_2 has no plane at this pose') as caught:
        LinkedPlaneSolver(muscle).solve(turn.as_matrix())
    assert ('HM lies in line' in str(caught.value)) == (frame == 'moving')
