# SPDX-License-Identifier: Apache-2.0
"""The bundled examples of the format's variations: no anatomy, but muscles that work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reference
from ros_harness import ANSWERS, NodeProcess, Peer

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.muscle.file import bundled_models
from linkedplane_ros.muscle.parts import Listed, Polynomial
from linkedplane_ros.solver.range_check import check_model

THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
EXAMPLES = ('example_shared_sphere', 'example_humerus_spheres')
EXACT = 1e-12  # m: the node computes what the solver computes


def ways(muscle: BroadMuscle, count: int, steps: int) -> np.ndarray:
    """Return angles (count, steps, 3), rad, on straight ways through the range of motion."""
    low, high = np.array(muscle.range_of_motion).T
    start, end = np.random.default_rng(5).uniform(low, high, (2, count, 1, 3))
    return start + (end - start) * np.linspace(0.0, 1.0, steps)[:, np.newaxis]


def test_there_are_these() -> None:
    assert set(bundled_models()) == {
        'deltoid', 'deltoid_ackland2008', 'deltoid_girdle', *EXAMPLES
    }  # fmt: skip


@pytest.mark.parametrize('name', EXAMPLES)
def test_an_example_says_that_it_is_no_anatomy(name: str) -> None:
    muscle = BroadMuscle.load(name)
    assert muscle.name == name
    assert muscle.source == 'illustrative geometry, not anatomy'
    assert muscle.licence


def test_the_examples_show_the_variations() -> None:
    shared, on_humerus = (BroadMuscle.load(name).definition for name in EXAMPLES)
    assert shared.s is None
    assert shared.sphere_frame == 'ground'
    assert len(BroadMuscle.load(EXAMPLES[0]).bands_by_sphere()) == 1
    assert all(isinstance(curve, Listed) for curve in (*shared.origin, *shared.insertion))
    assert shared.plane_angle == Polynomial((40.0,))
    assert on_humerus.sphere_frame == 'humerus'
    assert len(BroadMuscle.load(EXAMPLES[1]).bands_by_sphere()) == 6
    assert isinstance(on_humerus.s, tuple)
    assert isinstance(on_humerus.origin[0], Polynomial)
    assert isinstance(on_humerus.plane_angle, Listed)
    assert (shared.length, on_humerus.length) == ('mm', 'cm')


@pytest.mark.parametrize('name', EXAMPLES)
def test_an_example_has_nothing_to_warn_of(name: str) -> None:
    assert check_model(BroadMuscle.load(name)).warnings == ()


@pytest.mark.parametrize('name', EXAMPLES)
def test_an_examples_bands_wrap_and_change_as_fast_as_a_shoulder_lets_them(name: str) -> None:
    muscle = BroadMuscle.load(name)
    angles = ways(muscle, 60, 200)
    rotations, _ = THESIS.rotations_and_axes(angles.reshape(-1, 3))
    states = LinkedPlaneSolver(muscle).solve_batch(rotations)
    wrapped = (states.wrap == WrapState.WRAPPED).mean(axis=0)
    assert (wrapped > 0.02).all()
    assert (states.wrap != WrapState.INSIDE).all()
    lengths = states.lengths.reshape(60, 200, -1)
    steps = np.linalg.norm(angles[:, 1] - angles[:, 0], axis=1)
    fastest = np.abs(np.diff(lengths, axis=1)).max(axis=(1, 2)) / steps
    assert fastest.max() < 0.1  # m/rad


@pytest.mark.parametrize('name', EXAMPLES)
def test_an_example_is_solved_as_the_literal_method_solves_it(name: str) -> None:
    muscle = BroadMuscle.load(name)
    solver = LinkedPlaneSolver(muscle)
    neutral = reference.neutral_theta(muscle)
    checked = 0
    for angles in ways(muscle, 4, 4).reshape(-1, 3):
        rotation = THESIS.rotation(angles)
        state = solver.solve(rotation)
        found = reference.moment_vectors(muscle, rotation, neutral)
        scan = reference.total_at(muscle, rotation, reference.circle(2000)).min()
        assert state.total_length <= scan + 1e-9  # m
        if found.smooth and found.error < 1e-9:
            np.testing.assert_allclose(state.moment_vectors, found.vectors, rtol=0.0, atol=1e-8)
            checked += 1
    assert checked >= 8


@pytest.mark.parametrize('name', EXAMPLES)
def test_an_example_runs_through_the_node(name: str, tmp_path: Path, ros: Any) -> None:
    muscle = BroadMuscle.load(name)
    solver, n = LinkedPlaneSolver(muscle), len(muscle.band_names)
    peer = Peer(name)
    poses = ways(muscle, 1, 12)[0].tolist()
    with NodeProcess(tmp_path / 'node.log', **{'muscle': name, 'markers.rate': 0.0}) as process:
        peer.connect(process)
        for k, pose in enumerate(poses):
            peer.send(THESIS.coordinates, pose, (0.1, -0.2, 0.3), nanoseconds=k)
            assert peer.answers(k + 1)
        assert peer.until(lambda: len(peer.got['markers']) > len(poses))  # a clearing one first
    peer.destroy_node()
    for k, pose in enumerate(poses):
        state = solver.solve(THESIS.rotation(pose))
        arms = state.moment_vectors @ THESIS.axes(pose)
        lengths, found_arms, bands, wrap, vectors, arm_states = (
            peer.got[topic][k] for topic in ANSWERS
        )
        assert tuple(bands.name) == muscle.band_names
        assert arm_states.name == [f'{b}/{c}' for b in bands.name for c in THESIS.coordinates]
        assert arm_states.position == found_arms.data
        np.testing.assert_allclose(lengths.data, state.lengths, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(np.reshape(found_arms.data, (n, 3)), arms, rtol=0.0, atol=EXACT)
        np.testing.assert_allclose(
            np.reshape(vectors.data, (n, 3)), state.moment_vectors, rtol=0.0, atol=EXACT
        )
        np.testing.assert_allclose(bands.velocity, -arms @ (0.1, -0.2, 0.3), atol=EXACT)
        assert list(wrap.data) == state.wrap.tolist()
        spheres = [m for m in peer.got['markers'][k + 1].markers if m.ns == 'obstacle_spheres']
        assert [m.id for m in spheres] == list(muscle.bands_by_sphere())
        for marker in spheres:
            place = marker.pose.position
            want = state.sphere_centres[marker.id]
            np.testing.assert_allclose((place.x, place.y, place.z), want, rtol=0.0, atol=EXACT)
