# SPDX-License-Identifier: Apache-2.0
"""What the options of `linkedplane fit` mean: the criterion, poses and plan that they state."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fits import simulated, write_data
from optional import requires

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle
from linkedplane_ros.commands import fit
from linkedplane_ros.commands.main import main
from linkedplane_ros.fit.criterion import Criterion
from linkedplane_ros.fit.data import read_data
from linkedplane_ros.fit.search.fitting import Plan

pytestmark = requires('pymoo')

DELTOID = BroadMuscle.load('deltoid')
DOCUMENT = (Path(__file__).parents[2] / 'doc' / 'how_to' / 'fitting.md').read_text(encoding='utf-8')
Stated = tuple[Criterion, Plan, Any, int]


@pytest.fixture
def stated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Stated]:
    """Return a call that gives what a command line states, up to the search."""
    data = write_data(tmp_path, simulated(DELTOID))

    def call(*options: str, measured: Path = data) -> Stated:
        caught: list[Any] = []

        def searched(*given: Any) -> Any:
            caught.extend(given)
            raise KeyboardInterrupt

        monkeypatch.setattr(fit, '_search', searched)
        task = ['fit', 'deltoid', str(measured), str(tmp_path / 'out.yaml'), *options]
        assert main(task) == 130
        criterion, plan, watch, jobs, _, _ = caught
        return criterion, plan, watch, jobs

    return call


def test_without_options_it_is_the_thesiss_criterion_at_the_poses_of_the_table(
    stated: Callable[..., Stated],
) -> None:
    criterion, plan, watch, jobs = stated()
    weights = criterion.weights
    kinds = weights.length, weights.arm, weights.interference, weights.order, weights.jumps
    assert kinds == (1.0, 1.0, 1.0, 0.0, 0.0)
    assert (weights.clearance, weights.arm_scale) == (0.0, 1.0)
    assert len(criterion.rotations) == criterion.measured == 24  # the hanging arm stands thrice
    assert len(criterion.space.parameters) == 26
    assert (plan, watch, jobs) == (Plan(), None, 1)


def test_weights_clearance_and_scale_of_moment_arms(stated: Callable[..., Stated]) -> None:
    options = '--weights length=2 arm=3 order=4 --clearance 1.5 --arm-scale 0.5'
    weights = stated(*options.split())[0].weights
    kinds = weights.length, weights.arm, weights.interference, weights.order, weights.jumps
    assert kinds == (2.0, 3.0, 1.0, 4.0, 0.0)
    assert (weights.clearance, weights.arm_scale) == (pytest.approx(1.5e-3), 0.5)  # m


def test_the_plan_and_the_jobs(stated: Callable[..., Stated]) -> None:
    options = '--particles 7 --generations 3 --rounds 2 --scatter 0.3 --polish 9 --seed 5 --jobs 2'
    _, plan, _, jobs = stated(*options.split(), '--tighten', '9', '4')
    assert plan == Plan(7, 3, 2, 0.3, 9, (pytest.approx(0.009), pytest.approx(0.004)), 5)
    assert jobs == 2


def test_over_the_range_faults_count_at_a_coarse_grid_and_a_fine_one_is_watched(
    stated: Callable[..., Stated],
) -> None:
    criterion, _, watch, _ = stated('--over', 'range')
    weights = criterion.weights
    assert (weights.interference, weights.order, weights.jumps) == (1.0, 1.0, 1.0)
    assert len(criterion.rotations) - criterion.measured == 5 * 3 * 3
    assert watch.shape == (17 * 13 * 13, 3, 3)


def test_what_is_free_and_how_far_it_may_go(stated: Callable[..., Stated]) -> None:
    options = '--free sphere.radius plane_angle --reach 10 0.1 --bound plane_angle=+-0.2'
    parameters = stated(*options.split())[0].space.parameters
    assert [len([p for p in parameters if p.unit == unit]) for unit in ('mm', 'rad')] == [5, 5]
    rooms = {parameter.unit: parameter.high - parameter.start for parameter in parameters}
    assert rooms == pytest.approx({'mm': 10.0, 'rad': 0.2})


def test_angles_are_scaled_and_stepped(stated: Callable[..., Stated]) -> None:
    criterion = stated('--angle-scale', '0.5', '--every', '20')[0]
    bends = np.degrees(np.arccos((np.trace(criterion.rotations, axis1=1, axis2=2) - 1.0) / 2.0))
    assert sorted(set(bends.round(6))) == [0.0, 20.0, 40.0]


def test_the_convention_says_what_three_angles_mean(
    tmp_path: Path, stated: Callable[..., Stated]
) -> None:
    convention = JOINT_CONVENTIONS['isb_yxy']
    names = ','.join(f'{each}_deg' for each in convention.coordinates)
    path = tmp_path / 'poses.csv'
    about = convention.coordinates[1]
    path.write_text(f'about,{names},band,moment_arm_mm\n{about},40,50,20,middle_1,9\n')
    criterion = stated('--convention', 'isb_yxy', measured=path)[0]
    expected = convention.rotation(np.radians((40.0, 50.0, 20.0)))
    np.testing.assert_allclose(criterion.rotations[0], expected, rtol=0.0, atol=1e-15)


def test_the_tables_of_the_document_are_read(tmp_path: Path) -> None:
    (text,) = re.findall(r'^```csv\n(.*?)^```', DOCUMENT, re.DOTALL | re.MULTILINE)
    path = tmp_path / 'data.csv'
    path.write_text(text)
    found = read_data(path, DELTOID)
    assert [round(math.degrees(row.angle)) for row in found.measurements] == [0, 30, 30]
    assert math.isnan(found.measurements[2].length)
