# SPDX-License-Identifier: Apache-2.0
"""The deltoid that was fitted to measured moment arms: what its report and its page say of it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from optional import requires

import linkedplane_ros
from linkedplane_ros import BroadMuscle
from linkedplane_ros.fit.criterion import Criterion, Weights
from linkedplane_ros.fit.data import read_data
from linkedplane_ros.fit.parameters import build_space
from linkedplane_ros.fit.search.fitting import Plan, fit
from linkedplane_ros.fit.states import FitStates
from linkedplane_ros.fit.survey import Survey, survey_range

PACKAGE = Path(linkedplane_ros.__file__).parent
LITERATURE = PACKAGE / 'literature'
REPORT = (PACKAGE / 'models' / 'deltoid_ackland2008.md').read_text(encoding='utf-8')
PAGE = PACKAGE.parent / 'doc' / 'explanation' / 'what_to_rely_on.md'
PUBLISHED = BroadMuscle.load('deltoid')
FITTED = BroadMuscle.load('deltoid_ackland2008')
TWO_THIRDS = 2.0 / 3.0  # of an angle to the thorax is glenohumeral


def criterion(muscle: BroadMuscle, scale: float = TWO_THIRDS) -> Criterion:
    """Return the criterion for only the measured moment arms, to 110 deg by tens."""
    data = read_data(LITERATURE / 'ackland2008_deltoid_fit.csv', muscle, angle_scale=scale)
    weights = Weights(length=0.0, interference=0.0)
    return Criterion.from_data(muscle, build_space(muscle.definition), data, weights)


def mean_off(one: Criterion, x: np.ndarray) -> float:
    """Return the mean deviation of the moment arms, mm."""
    states = one.states(x)
    assert isinstance(states, FitStates)
    return float(np.abs(one.deviations(states)[1]).mean())


@pytest.fixture(scope='module')
def over() -> Survey:
    """Return what it does at a grid, at random poses and on lines that no fit has looked at."""
    return survey_range(FITTED, random=5000, lines=100, seed=1)


def test_it_enters_no_bone_over_its_range_of_motion(over: Survey) -> None:
    assert over.entered == 0
    assert FITTED.interference_names == PUBLISHED.interference_names
    np.testing.assert_array_equal(FITTED.interference_centres, PUBLISHED.interference_centres)
    np.testing.assert_array_equal(FITTED.interference_radii, PUBLISHED.interference_radii)
    assert FITTED.range_of_motion == PUBLISHED.range_of_motion


def test_its_bands_keep_their_order_and_fan(over: Survey) -> None:
    assert over.disordered == 0
    assert over.parted == 0


def test_its_bands_have_paths_and_lengths_that_do_not_jump(over: Survey) -> None:
    assert over.inside == 0
    assert over.jump < 1e-5  # m: what moment arms do not explain of a step of 0.25 deg


def test_its_attachments_are_the_published_ones() -> None:
    np.testing.assert_array_equal(FITTED.origins, PUBLISHED.origins)
    np.testing.assert_array_equal(FITTED.insertions, PUBLISHED.insertions)


def test_the_documents_say_how_far_it_is_from_what_was_measured() -> None:
    means = {}
    for scale in (1.0, TWO_THIRDS):
        for muscle in (PUBLISHED, FITTED):
            one = criterion(muscle, scale)
            means[muscle.name, scale] = mean_off(one, one.space.start)
    before, after = (means[muscle.name, TWO_THIRDS] for muscle in (PUBLISHED, FITTED))
    assert after < before
    assert re.search(rf'\| \*\*all\*\* \| 66 \| [\d.]+ \| {after:.2f} \|', REPORT)
    lines = PAGE.read_text(encoding='utf-8').splitlines()
    for muscle in (PUBLISHED, FITTED):
        row = next(line for line in lines if line.startswith(f'| `{muscle.name}` |'))
        cells = f'{means[muscle.name, TWO_THIRDS]:.1f} mm', f'{means[muscle.name, 1.0]:.1f} mm'
        assert all(cell in row for cell in cells)


@requires('pymoo')
def test_free_to_enter_bone_it_comes_far_nearer_to_what_was_measured() -> None:
    one = criterion(PUBLISHED)
    found = fit(one, Plan(particles=50, generations=30, polish=60, seed=1))
    assert mean_off(one, one.space.start) > 7.5  # mm
    assert mean_off(one, found.best) < 5.0  # mm
