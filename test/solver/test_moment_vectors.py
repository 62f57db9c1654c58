# SPDX-License-Identifier: Apache-2.0
"""Moment vectors are the slopes of the lengths, and moment arms their parts about the joints."""

import numpy as np
import pytest
import reference
from deltoid_poses import BATCH, POSES, literal_moments
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState

DELTOID = BroadMuscle.load('deltoid')
RIGHT = LinkedPlaneSolver(DELTOID)
NEUTRAL = RIGHT.solve(np.eye(3)).theta
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


@pytest.fixture(scope='module')
def literal() -> list[reference.Moments]:
    """The reference's moment vectors at POSES."""
    return literal_moments(DELTOID, POSES, NEUTRAL)


def test_moment_vectors_are_differences_of_the_literal_method(
    literal: list[reference.Moments],
) -> None:
    checked = mixed = missed = straight = 0
    for state, found in zip(BATCH, literal, strict=True):
        if not found.smooth or found.error > 1e-9:
            continue  # a kink within the differences
        np.testing.assert_allclose(state.moment_vectors, found.vectors, rtol=0.0, atol=1e-8)
        checked += 1
        kinds = set(state.wrap.tolist())
        mixed += len(kinds) == 3
        missed += (state.wrap == WrapState.MISSED).sum() >= 3
        straight += WrapState.WRAPPED not in kinds
    assert checked >= 60
    assert mixed >= 5  # wrapped, clear and missed bands at once
    assert missed >= 5
    assert straight >= 2


def test_moment_vectors_near_a_kink_are_still_close(literal: list[reference.Moments]) -> None:
    for state, found in zip(BATCH, literal, strict=True):
        # m: within the stencil of 8e-3 rad the second derivative, some 0.05 m, may jump
        np.testing.assert_allclose(state.moment_vectors, found.vectors, rtol=0.0, atol=1e-4)


def test_the_sum_over_the_bands_needs_no_linked_term() -> None:
    # dE/dtheta = 0, so at a fixed theta the whole muscle's moments are the same
    h = 1e-3  # rad
    for state, rotation in zip(BATCH, POSES, strict=True):
        slopes = []
        for axis in np.eye(3):
            turned = [
                Rotation.from_rotvec(k * h * axis).as_matrix() @ rotation for k in (-2, -1, 1, 2)
            ]
            found = reference.chain(DELTOID, np.array(turned), state.theta)
            states = np.stack([one.state for one in found])
            if (states != state.wrap[:, np.newaxis]).any():
                break
            E = sum(one.length for one in found)
            slopes.append(E @ np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h))
        else:
            total = state.moment_vectors.sum(axis=0)
            np.testing.assert_allclose(total, np.negative(slopes), rtol=0.0, atol=1e-8)


def test_a_straight_band_pulls_along_its_line() -> None:
    for state in BATCH:
        straight = state.wrap != WrapState.WRAPPED
        pull = reference.unit(DELTOID.origins - state.insertions)
        moment = np.cross(state.insertions, pull)
        np.testing.assert_allclose(
            state.moment_vectors[straight], moment[straight], rtol=0.0, atol=1e-15
        )


def test_moment_vectors_foretell_the_lengths_along_a_motion() -> None:
    # the integral of -v.omega over a flexion is the change of length (Simpson's rule, 161 poses)
    sweep = np.radians(np.linspace(0.0, 80.0, 161))
    states = RIGHT.solve_batch([THESIS.rotation([f, 0.0, 0.0]) for f in sweep])
    rates = -states.moment_vectors[:, :, 0]
    weights = np.array([1.0, *[4.0, 2.0] * 79, 4.0, 1.0]) * (sweep[1] - sweep[0]) / 3.0
    change = states.lengths[-1] - states.lengths[0]
    np.testing.assert_allclose(weights @ rates, change, rtol=0.0, atol=1e-5)  # m: kinks


@pytest.mark.parametrize('name', list(JOINT_CONVENTIONS))
def test_moment_arms_are_the_lengths_slopes_over_the_coordinates(name: str) -> None:
    convention = JOINT_CONVENTIONS[name]
    h = 1e-4  # rad
    for angles in np.random.default_rng(6).uniform([-1, 0.2, -1], [1, 1.2, 1], (10, 3)):
        state = RIGHT.solve(convention.rotation(angles))
        arms = state.moment_vectors @ convention.axes(angles)
        for j, step in enumerate(h * np.eye(3)):
            ends = RIGHT.solve_batch([convention.rotation(angles + k * step) for k in (1, -1)])
            if (ends.wrap != state.wrap).any():
                continue
            slope = (ends.lengths[0] - ends.lengths[1]) / (2.0 * h)
            np.testing.assert_allclose(arms[:, j], -slope, rtol=0.0, atol=1e-6)  # m: h^2, kinks
