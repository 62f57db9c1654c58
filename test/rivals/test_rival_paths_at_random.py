# SPDX-License-Identifier: Apache-2.0
"""What holds for the path of every rival: random bands at random poses."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from random_bands import MODELS, Model, length_slopes, random_models, random_rotations, turned_model
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.linked_planes.compilation import COMPILED
from linkedplane_ros.rivals import (
    Bands,
    CappedCylinder,
    Cylinder,
    DoubleCylinder,
    PathModel,
    PathState,
    Sphere,
    Straight,
    ViaPoints,
)

STILL = np.eye(3)
every_model = pytest.mark.parametrize('kind', MODELS, ids=lambda kind: kind.__name__)


@every_model
def test_moment_vectors_are_the_slopes_of_the_length(kind: Model) -> None:
    # Richardson's central differences at two steps; where they differ there is a kink or a jump
    bands = Bands(random_models(kind, 400))
    R = random_rotations(1)[0]
    coarse, fine = length_slopes(bands, R, 2e-4), length_slopes(bands, R, 1e-4)
    told = np.abs(coarse - fine).max(axis=1) < 1e-9
    state = bands.solve(R)
    off = np.abs(state.moment_vectors + fine).max(axis=1)
    assert told.mean() > 0.97
    assert off[told].max() < 1e-9  # m/rad: the differences' own error is 1e-16 m / 1e-4 rad, h^4
    for contacts in {Straight: (0,), ViaPoints: (0,), DoubleCylinder: (0, 1, 2, 3)}.get(
        kind, (0, 1)
    ):
        assert (told & (state.contacts == contacts)).sum() > 5


@every_model
def test_the_drawn_path_is_as_long_as_the_band_and_bends_nowhere(kind: Model) -> None:
    state = Bands(random_models(kind, 200)).solve(random_rotations(1)[0])
    for i, path in enumerate(state.paths(200)):
        parts = np.diff(path, axis=0)
        long = np.linalg.norm(parts, axis=1)
        # m: the polygon of an arc of up to 0.04 m and a turn of pi, in 200 parts
        assert long.sum() == pytest.approx(state.lengths[i], abs=3e-6)
        if kind is ViaPoints or state.contacts[i] == 0:
            continue
        parts, long = parts[long > 1e-6], long[long > 1e-6]
        unit = parts / long[:, np.newaxis]
        # rad: an arc of pi in 200 parts, and shorter parts beside it
        assert np.linalg.norm(np.diff(unit, axis=0), axis=1).max() < 0.04


def bands_below(state: PathState, model: PathModel, R: Array) -> float:
    """Return how deep a path runs in its single obstacle, m; on its surface 0."""
    path = state.path(60)
    centre, axis = np.array(model.centre), np.array(getattr(model, 'axis', (0, 0, 0)))
    bone = R if model.bone == 'humerus' else STILL
    points = np.linspace(path[:-1], path[1:], 9).reshape(-1, 3) - bone @ centre
    if not isinstance(model, Sphere):
        w = bone @ axis / np.linalg.norm(axis)
        height = points @ w
        if isinstance(model, CappedCylinder):
            height = np.minimum(height, 0.0)
        points = points - height[:, np.newaxis] * w
    return float(model.radius - np.linalg.norm(points, axis=1).min())


@pytest.mark.parametrize('kind', [Sphere, Cylinder, CappedCylinder])
def test_a_path_keeps_out_of_its_obstacle(kind: Model) -> None:
    R = random_rotations(1)[0]
    seen = 0
    for model in random_models(kind, 300):
        state = model.solve(R)
        if state.wrap in (WrapState.WRAPPED, WrapState.CLEAR):
            seen += state.wrap == WrapState.WRAPPED
            # m: the chord of an arc of up to 0.04 m and pi, in 60 parts, lies 1.4e-5 below it
            assert bands_below(state, model, R) < 1.5e-5
    assert seen > 10


@every_model
def test_a_turn_of_everything_turns_the_moments_and_keeps_the_rest(kind: Model) -> None:
    R, Q = random_rotations(2)
    models = random_models(kind, 300)
    here = Bands(models).solve(R)
    there = Bands([turned_model(model, Q) for model in models]).solve(Q @ R @ Q.T)
    same = here.wrap == there.wrap  # but where rounding decides
    assert same.sum() >= 299
    # m: rounding; a crossing or a second contact is found by a search, so a little more
    np.testing.assert_allclose(here.lengths[same], there.lengths[same], rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        (here.moment_vectors @ Q.T)[same], there.moment_vectors[same], rtol=0, atol=1e-10
    )


@pytest.mark.parametrize('kind', [Straight, Sphere, Cylinder])
def test_seen_from_the_other_bone_a_band_is_the_same(kind: Model) -> None:
    R = random_rotations(1)[0]
    other = {'scapula': 'humerus', 'humerus': 'scapula'}
    for model in random_models(kind, 100):
        swapped = {'origin': model.insertion, 'insertion': model.origin}
        if kind is not Straight:
            swapped['bone'] = other[model.bone]
        if kind is Cylinder:
            swapped['axis'] = tuple(-x for x in model.axis)
        here, there = model.solve(R), replace(model, **swapped).solve(R.T)
        assert here.wrap == there.wrap
        assert here.length == pytest.approx(there.length, abs=1e-15)  # m: rounding
        moment = -R @ there.moment_vector
        np.testing.assert_allclose(here.moment_vector, moment, rtol=0, atol=1e-14)


@every_model
def test_a_path_depends_on_its_pose_alone(kind: Model) -> None:
    """To the bit: alone or in a batch, whatever came before, whichever way the band flipped."""
    bands = Bands(random_models(kind, 30))
    poses = np.concatenate((random_rotations(300), sweep_over_the_top()))
    order = np.random.default_rng(3).permutation(len(poses))
    ordered, shuffled = bands.solve_batch(poses), bands.solve_batch(poses[order])
    for name in ('lengths', 'moment_vectors', 'wrap', 'contacts'):
        there = getattr(ordered, name)
        assert getattr(shuffled, name).tobytes() == there[order].tobytes()
        single = np.array([getattr(bands.solve(poses[k]), name) for k in order[:50]], there.dtype)
        assert single.tobytes() == there[order[:50]].tobytes()
    assert np.isfinite(ordered.lengths).all()
    assert np.isfinite(ordered.moment_vectors).all()


def sweep_over_the_top() -> Array:
    return Rotation.from_rotvec(np.linspace(0, np.pi, 100)[:, np.newaxis] * (1.0, 0, 0)).as_matrix()


def test_a_band_that_flips_flips_at_the_same_pose_on_the_way_back() -> None:
    """A sphere's band changes sides where its line passes the centre, and has no memory of it."""
    band = Bands([Sphere((0, 0.1, 0), (0, -0.1, -0.001), (0, 0, 0), 0.03, 'scapula')])
    there = sweep_over_the_top()[:30]
    tilted = Rotation.from_rotvec((-0.3, 0, 0)).as_matrix() @ there
    forth, back = band.solve_batch(tilted), band.solve_batch(tilted[::-1])
    np.testing.assert_array_equal(forth.moment_vectors, back.moment_vectors[::-1])
    assert len(np.unique(np.sign(forth.moment_vectors[:, 0, 0]))) == 2
    assert np.abs(np.diff(forth.lengths, axis=0)).max() < 0.0011  # m: 0.03 m times a step of 2 deg


@pytest.mark.skipif(not COMPILED, reason='numba is not installed or LINKEDPLANE_COMPILE is 0')
def test_compiled_and_uncompiled_rivals_agree(tmp_path: Path) -> None:
    code = (
        'import numpy as np\n'
        'from random_bands import MODELS, random_models, random_rotations\n'
        'from linkedplane_ros.rivals import Bands\n'
        'found = {}\n'
        'for kind in MODELS:\n'
        '    state = Bands(random_models(kind, 100, seed=7)).solve_batch(random_rotations(2))\n'
        '    found[kind.__name__] = state.lengths\n'
        '    found[kind.__name__ + "_"] = state.moment_vectors\n'
        f'np.savez({str(tmp_path / "states.npz")!r}, **found)\n'
    )
    here = str(Path(__file__).parent)
    environment = {
        **os.environ,
        'LINKEDPLANE_COMPILE': '0',
        'PYTHONPATH': os.pathsep.join((here, *sys.path[1:])),
    }
    subprocess.run([sys.executable, '-c', code], env=environment, check=True)
    uncompiled = np.load(tmp_path / 'states.npz')
    for kind in MODELS:
        state = Bands(random_models(kind, 100, seed=7)).solve_batch(random_rotations(2))
        near = np.abs(state.lengths - uncompiled[kind.__name__]) < 1e-12  # m: rounding
        assert near.mean() > 0.99  # two cylinders in each other may settle by a hair
        off = np.abs(state.moment_vectors - uncompiled[kind.__name__ + '_'])[near]
        assert off.max() < 1e-9  # m: what a contact found to 1e-12 of the radius leaves


@pytest.mark.skipif(not COMPILED, reason='numba is not installed or LINKEDPLANE_COMPILE is 0')
def test_the_rivals_make_no_kernel_of_the_solver_compile_anew() -> None:
    code = (
        'import {}\n'
        'from linkedplane_ros import BroadMuscle, LinkedPlaneSolver\n'
        'from linkedplane_ros.solver.kernels import solve_poses\n'
        'LinkedPlaneSolver(BroadMuscle.load("deltoid"))\n'
        'print(sum(solve_poses.stats.cache_hits.values()))'
    )
    LinkedPlaneSolver(BroadMuscle.load('deltoid'))  # from now on the cache has the kernels
    for first in ('linkedplane_ros.solver.kernels', 'linkedplane_ros.rivals'):
        run = subprocess.run(
            [sys.executable, '-c', code.format(first)], capture_output=True, text=True
        )
        assert run.stdout == '1\n', run.stderr
