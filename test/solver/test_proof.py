"""What others would want to see before they trust the solver."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.linked_planes.compiled import COMPILED

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
RANGES = np.radians(((-40, 120), (0, 120), (-60, 60)))  # flexion, abduction, rotation


def rotations(count: int, seed: int) -> Array:
    """Return random poses of the range of motion."""
    angles = np.random.default_rng(seed).uniform(*RANGES.T, (count, 3))
    return np.array([THESIS.rotation(each) for each in angles])


def least_of_scan(poses: Array) -> Array:
    """Return the least total over the circle of theta in steps of 0.1 deg, literally."""
    return reference.total_at(DELTOID, poses[:, np.newaxis], reference.circle(3600)).min(axis=1)


def test_no_theta_of_a_fine_scan_is_better_over_2000_poses() -> None:
    # 0.1 deg over the whole circle, literally; a twentieth of a degree off the minimum E is higher
    # by 1e-5 m at most, so the scan also tells that the solver's total is not too short
    poses = rotations(2000, seed=3)
    totals = SOLVER.solve_batch(poses).total_length
    with ThreadPoolExecutor(2) as pool:
        scan = np.concatenate(list(pool.map(least_of_scan, np.split(poses, 40))))
    assert (totals - scan).max() <= 1e-9
    assert (scan - totals).max() <= 1e-5


def test_moment_vectors_are_the_slopes_of_the_solve_over_500_poses() -> None:
    # Richardson's central differences at two steps; where the two differ there is a kink, or a bend
    # too sharp for them, and they tell nothing
    poses = rotations(500, seed=4)
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


@pytest.mark.parametrize('engine', ['mujoco', 'opensim'])
def test_a_band_alone_is_that_of_another_engine(engine: str) -> None:
    pytest.importorskip(engine, reason=f'{engine} is not installed: no rival to compare with')
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


unit_quaternions = st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(
    lambda q: np.linalg.norm(q) > 0.1
)
in_range = st.tuples(*(st.floats(*span) for span in RANGES))
few = settings(deadline=None, max_examples=60, derandomize=True)


def turned(muscle: BroadMuscle, Q: Array) -> BroadMuscle:
    """Return the muscle with both frames turned about the glenohumeral centre."""
    return replace(
        muscle,
        origins=muscle.origins @ Q.T,
        insertions=muscle.insertions @ Q.T,
        ground_point=Q @ muscle.ground_point,
        humeral_point=Q @ muscle.humeral_point,
        reference_normal=Q @ muscle.reference_normal,
    )


@few
@given(q=unit_quaternions, angles=in_range)
def test_a_rigid_motion_of_everything_turns_the_moments_and_keeps_the_rest(
    q: list[float], angles: tuple[float, ...]
) -> None:
    Q = Rotation.from_quat(q).as_matrix()
    R = THESIS.rotation(angles)
    here, there = SOLVER.solve(R), LinkedPlaneSolver(turned(DELTOID, Q)).solve(Q @ R @ Q.T)
    # m, rad: rounding; lengths depend on theta by up to 0.03 m/rad
    np.testing.assert_allclose(there.lengths, here.lengths, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(
        there.moment_vectors, here.moment_vectors @ Q.T, rtol=0.0, atol=1e-10
    )


@few
@given(scale=st.floats(1e-3, 1e3), angles=in_range)
def test_lengths_and_moments_scale_with_the_muscle(scale: float, angles: tuple[float, ...]) -> None:
    # 1000: the same muscle in mm
    larger = replace(
        DELTOID,
        origins=DELTOID.origins * scale,
        insertions=DELTOID.insertions * scale,
        sphere_centres=DELTOID.sphere_centres * scale,
        sphere_radii=DELTOID.sphere_radii * scale,
        ground_point=DELTOID.ground_point * scale,
        humeral_point=DELTOID.humeral_point * scale,
    )
    R = THESIS.rotation(angles)
    here, there = SOLVER.solve(R), LinkedPlaneSolver(larger).solve(R)
    np.testing.assert_allclose(there.lengths / scale, here.lengths, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(
        there.moment_vectors / scale, here.moment_vectors, rtol=0.0, atol=1e-10
    )


@few
@given(first=st.floats(-3, 3), angles=in_range)
def test_the_first_bands_own_angle_is_taken_up_by_theta(
    first: float, angles: tuple[float, ...]
) -> None:
    phi = DELTOID.plane_angles.copy()
    phi[0] += first
    R = THESIS.rotation(angles)
    there = LinkedPlaneSolver(replace(DELTOID, plane_angles=phi)).solve(R)
    np.testing.assert_array_equal(there.lengths, SOLVER.solve(R).lengths)


@few
@given(turn=st.floats(-1, 1), angles=in_range)
def test_a_turned_reference_normal_gives_another_theta_and_the_same_lengths(
    turn: float, angles: tuple[float, ...]
) -> None:
    axis = np.cross(DELTOID.reference_normal, (0.0, 0.0, 1.0))
    Q = Rotation.from_rotvec(turn * axis / np.linalg.norm(axis)).as_matrix()
    other = LinkedPlaneSolver(replace(DELTOID, reference_normal=Q @ DELTOID.reference_normal))
    R = THESIS.rotation(angles)
    np.testing.assert_allclose(other.solve(R).lengths, SOLVER.solve(R).lengths, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        other.solve(R).moment_vectors, SOLVER.solve(R).moment_vectors, rtol=0, atol=1e-10
    )


STEP = np.radians(0.1)
FASTEST = 0.08  # m: hardly a moment arm is longer, so where a length changes faster one looks


def single_axes() -> list[Array]:
    """Return the sweeps along each of the thesis's coordinates from the arm at the side."""
    sweeps = []
    for axis, (low, high) in enumerate(RANGES):
        angles = np.zeros((round((high - low) / STEP) + 1, 3))
        angles[:, axis] = np.linspace(low, high, len(angles))
        sweeps.append(np.array([THESIS.rotation(each) for each in angles]))
    return sweeps


def great_arcs(count: int) -> list[Array]:
    """Return sweeps straight from one random pose of the range of motion to another."""
    starts, ends = rotations(count, seed=6), rotations(count, seed=7)
    sweeps = []
    for start, end in zip(starts, ends, strict=True):
        way = Rotation.from_matrix(end @ start.T).as_rotvec()
        parts = np.linspace(0.0, 1.0, int(np.linalg.norm(way) / STEP) + 2)[:, np.newaxis]
        sweeps.append(Rotation.from_rotvec(parts * way).as_matrix() @ start)
    return sweeps


def jump(sweep: Array, k: int, field: str) -> tuple[Array, ...]:
    """Return the two poses, as near as may be, between which a field jumps from k to k + 1."""
    start, end = sweep[k], sweep[k + 1]
    for _ in range(20):
        parts = Rotation.from_matrix(end @ start.T).as_rotvec() * np.linspace(0, 1, 9)[:, None]
        poses = Rotation.from_rotvec(parts).as_matrix() @ start
        values = getattr(SOLVER.solve_batch(poses), field).reshape(9, -1)
        steps = np.abs(np.diff(values, axis=0)).max(axis=1)
        if steps.max() < 0.5 * np.abs(values[-1] - values[0]).max():
            return ()
        start, end = poses[steps.argmax()], poses[steps.argmax() + 1]
    return start, end


def at_an_edge(pose: Array) -> bool:
    """Return whether theta keeps a band just outside its sphere, where the total would jump."""
    around = SOLVER.solve(pose).theta + np.array((-1e-7, 1e-7))
    states = reference.states_at(DELTOID, pose, around)
    return bool((states[0] != states[1]).any())


def check_sweep(sweep: Array) -> int:
    """Nothing jumps without a reason along a sweep; return how often a length jumped with one."""
    states = SOLVER.solve_batch(sweep)
    for values in (states.theta, states.lengths, states.moment_vectors):
        assert np.isfinite(values).all()
    leaps = np.abs(np.diff(states.lengths, axis=0)).max(axis=1) > FASTEST * STEP
    found = [k for k in np.flatnonzero(leaps) if jump(sweep, k, 'lengths')]
    for k in found:
        band = np.abs(states.lengths[k + 1] - states.lengths[k]).argmax()
        assert (states.wrap[k : k + 2, band] == WrapState.MISSED).any()
    # a moment changes its sign through zero, or where a band comes onto its sphere or leaves it, or
    # where theta comes to the edge of a sphere that a band misses and stays there
    before, after = states.moment_vectors[:-1], states.moment_vectors[1:]
    flips = (before * after < 0.0) & (np.abs(before - after) > FASTEST * STEP)
    for k in np.flatnonzero(flips.any(axis=(1, 2))):
        if (states.wrap[k] == states.wrap[k + 1]).all():
            beside = jump(sweep, k, 'moment_vectors')
            assert not beside or any(at_an_edge(pose) for pose in beside)
    return len(found)


def test_no_length_jumps_over_sweeps_along_single_axes() -> None:
    assert [check_sweep(sweep) for sweep in single_axes()] == [0, 0, 0]


def test_no_length_jumps_over_200_great_arcs() -> None:
    assert sum(check_sweep(sweep) for sweep in great_arcs(200 if COMPILED else 20)) == 0


def recorded(shared: Path) -> Array:
    """Return all poses of the recordings."""
    poses = []
    for name, convention in (('abduction', 'opensim_tsm'), ('flexion', 'opensim_tsm'),
                             ('daily_motion', 'isb_yxy')):  # fmt: skip
        table = np.loadtxt(
            shared / 'recordings' / f'{name}.csv', delimiter=',', skiprows=1, usecols=(1, 2, 3)
        )
        poses += [JOINT_CONVENTIONS[convention].rotation(angles) for angles in table]
    return np.array(poses)


def test_shuffled_and_ordered_replays_of_the_recordings_agree_to_the_bit(shared: Path) -> None:
    poses = recorded(shared)
    order = np.random.default_rng(8).permutation(len(poses))
    ordered, shuffled = SOLVER.solve_batch(poses), SOLVER.solve_batch(poses[order])
    alone = [SOLVER.solve(poses[k]) for k in order[:500]]
    for name in ('theta', 'lengths', 'moment_vectors', 'wrap'):
        there = getattr(ordered, name)
        assert getattr(shuffled, name).tobytes() == there[order].tobytes()
        single = np.array([getattr(state, name) for state in alone], dtype=there.dtype)
        assert single.tobytes() == there[order[:500]].tobytes()


@pytest.mark.skipif(not COMPILED, reason='numba is not installed or LINKEDPLANE_COMPILE is 0')
def test_compiled_and_uncompiled_agree(tmp_path: Path) -> None:
    poses = rotations(1500, seed=9)
    np.save(tmp_path / 'poses.npy', poses)
    code = (
        'import numpy as np, linkedplane_ros as l\n'
        'from linkedplane_ros.linked_planes.compiled import COMPILED\n'
        'assert not COMPILED\n'
        f'poses = np.load({str(tmp_path / "poses.npy")!r})\n'
        "s = l.LinkedPlaneSolver(l.BroadMuscle.load('deltoid')).solve_batch(poses)\n"
        f'np.savez({str(tmp_path / "states.npz")!r}, theta=s.theta, lengths=s.lengths,'
        ' moment_vectors=s.moment_vectors, wrap=s.wrap)\n'
    )
    environment = {**os.environ, 'LINKEDPLANE_COMPILE': '0'}
    subprocess.run([sys.executable, '-c', code], env=environment, check=True)
    compiled, uncompiled = SOLVER.solve_batch(poses), np.load(tmp_path / 'states.npz')
    for name in ('lengths', 'moment_vectors'):
        np.testing.assert_allclose(getattr(compiled, name), uncompiled[name], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(compiled.wrap, uncompiled['wrap'])
