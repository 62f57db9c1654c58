# SPDX-License-Identifier: Apache-2.0
"""No length jumps along a motion, and nothing depends on what was solved before."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import reference
from deltoid_poses import RANGES, rotations_in_range
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.linked_planes.compilation import COMPILED

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
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
    starts, ends = rotations_in_range(count, seed=6), rotations_in_range(count, seed=7)
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
    poses = rotations_in_range(1500, seed=9)
    np.save(tmp_path / 'poses.npy', poses)
    code = (
        'import numpy as np, linkedplane_ros as l\n'
        'from linkedplane_ros.linked_planes.compilation import COMPILED\n'
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
