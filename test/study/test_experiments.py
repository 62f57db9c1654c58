# SPDX-License-Identifier: Apache-2.0
"""The thesis's experiments, done again: poses, lengths, moment arms both ways, attachments."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.joints.rotations import rotation_about
from linkedplane_ros.study import attachments
from linkedplane_ros.study.experiments import (
    HALF,
    MOTIONS,
    AxisMotion,
    Experiment,
    cubic_arms,
    simulate_motion,
    simulate_motions,
)
from linkedplane_ros.study.literature import HEADS, published_curves

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
AGREES = 1e-8  # m: the thesis's tables and its polynomials, but for errata 1 to 3
ROUNDED = 1e-9  # m: rounding of the solver's and these sums
MODEL = Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml'


@pytest.fixture(scope='module')
def experiments() -> dict[str, Experiment]:
    """Return the thesis's three experiments."""
    return {each.motion.name: each for each in simulate_motions(DELTOID)}


# The motions


def test_the_poses_are_those_of_the_thesis(experiments: dict[str, Experiment]) -> None:
    degrees = {name: np.degrees(each.angles) for name, each in experiments.items()}
    for name, last in (('flexion', 80), ('abduction', 90), ('scaption', 60)):
        np.testing.assert_allclose(degrees[name], np.arange(0, last + 1, 10), atol=1e-12)
    assert sum(map(len, degrees.values())) == 26


def test_flexion_and_abduction_are_the_coordinates_of_the_thesis(
    experiments: dict[str, Experiment],
) -> None:
    for column, name in enumerate(('flexion', 'abduction')):
        one = experiments[name]
        for angle, state in zip(one.angles.tolist(), one.states, strict=True):
            angles = np.zeros(3)
            angles[column] = angle
            np.testing.assert_allclose(state.rotation, THESIS.rotation(angles), atol=1e-15)


@pytest.mark.parametrize(
    ('name', 'towards'),
    [
        ('flexion', (0.0, 1.0)),
        ('abduction', (1.0, 0.0)),
        ('scaption', (math.sqrt(0.75), 0.5)),  # 30 deg before lateral
    ],
)
def test_the_arm_goes_where_the_motion_says(name: str, towards: tuple[float, float]) -> None:
    (motion,) = (each for each in MOTIONS if each.name == name)
    hand = rotation_about(np.array(motion.axis), math.radians(60.0)) @ (0.0, 0.0, -1.0)
    level = math.sin(math.radians(60.0))
    np.testing.assert_allclose(hand[:2], level * np.array(towards), atol=1e-15)  # lateral, anterior
    assert hand[2] == pytest.approx(-0.5, abs=1e-15)


def test_a_motion_turned_about_the_vertical_goes_into_the_turned_plane() -> None:
    abduction = MOTIONS[1]
    # forwards is a positive turn about the vertical: x lateral to y anterior
    assert abduction.rotate(math.radians(30.0)).axis == pytest.approx(MOTIONS[2].axis, abs=1e-15)


# Moment arms


def test_exact_moment_arms_are_the_slopes_of_the_lengths() -> None:
    # central differences of 0.01 deg: off by 1e-7 m at most where there is no kink
    step = math.radians(0.01)
    for motion in MOTIONS:
        middle = motion.angles()[1:-1] + math.radians(3.0)  # beside the tabled poses
        one = simulate_motion(SOLVER, motion, middle)
        before, after = (
            simulate_motion(SOLVER, motion, middle + by).lengths for by in (-step, step)
        )
        np.testing.assert_allclose(one.arms, (before - after) / (2.0 * step), atol=2e-6)


def test_a_cubic_through_a_cubic_gives_its_slope() -> None:
    q = np.linspace(0.0, 1.5, 10)
    lengths = np.column_stack((0.15 - 0.02 * q + 0.01 * q**3, 0.1 + 0.03 * q**2))
    wanted = np.column_stack((0.02 - 0.03 * q**2, -0.06 * q))
    np.testing.assert_allclose(cubic_arms(q, lengths), wanted, atol=1e-14)


def test_a_cubic_needs_four_poses() -> None:
    with pytest.raises(ValueError, match='3 poses; more than 3 expected'):
        cubic_arms(np.arange(3.0), np.zeros((3, 1)))


def test_the_cubic_is_near_the_exact_moment_arms_but_not_the_same(
    experiments: dict[str, Experiment],
) -> None:
    # mm: what the thesis's way of differentiating does to its curves
    off = np.concatenate(
        [np.abs(each.cubic_arms - each.arms).ravel() for each in experiments.values()]
    )
    assert 1e3 * off.mean() == pytest.approx(0.37, abs=0.005)
    assert 1e3 * off.max() == pytest.approx(3.46, abs=0.005)


def test_the_half_scaling_halves_moment_arms_and_no_lengths() -> None:
    whole, half = (simulate_motion(SOLVER, MOTIONS[0], scale=scale) for scale in (1.0, HALF))
    np.testing.assert_array_equal(half.arms, 0.5 * whole.arms)
    np.testing.assert_allclose(half.cubic_arms, 0.5 * whole.cubic_arms, rtol=1e-15)
    np.testing.assert_array_equal(half.lengths, whole.lengths)
    assert (whole.scale, half.scale) == (1.0, 0.5)


def test_the_posterior_arm_is_negative_in_early_abduction_and_then_rises(
    experiments: dict[str, Experiment],
) -> None:
    # as the thesis describes its own curve (ch. 7)
    one = experiments['abduction']
    arm = one.arms[:, one.column('posterior')]
    assert arm[0] < -0.02
    assert (np.diff(arm) > 0.0).all()
    assert arm[-1] > 0.02


# Against other tables of the same


def test_the_experiments_give_the_models_own_column_of_the_literature() -> None:
    # LP: means of the heads' three bands; mm to one digit (arms) and two (lengths)
    for quantity, rounding in (('moment_arm_mm', 0.5e-4), ('length_mm', 0.5e-5)):
        for (head, name), curve in published_curves(quantity)['LP'].items():
            (motion,) = (each for each in MOTIONS if each.name == name)
            one = simulate_motion(SOLVER, motion, curve.angles)
            values = one.arms if quantity == 'moment_arm_mm' else one.lengths
            k = HEADS.index(head)
            mean = values[:, 3 * k : 3 * k + 3].mean(axis=1)
            np.testing.assert_allclose(mean, curve.values, rtol=0.0, atol=rounding + ROUNDED)


@pytest.mark.parametrize('table', ['6.2.1', '6.2.2'])
def test_the_positions_are_the_printed_ones_but_for_the_errata(table: str) -> None:
    rows = attachments.compare_positions(DELTOID, table)
    assert tuple(row.band for row in rows) == DELTOID.band_names
    for row in rows:
        assert row.printed.s == pytest.approx(row.s, abs=0.000501)  # three decimals are printed
        assert (row.deviation > AGREES) == bool(row.printed.erratum), row
    assert sum(bool(row.printed.erratum) for row in rows) == {'6.2.1': 1, '6.2.2': 2}[table]


def test_erratum_2_is_a_matter_of_two_signs() -> None:
    (row,) = (
        each for each in attachments.compare_positions(DELTOID, '6.2.1') if each.printed.erratum
    )
    x, y, z = row.printed.point
    assert row.point == pytest.approx((x, -y, -z), abs=AGREES)


def test_erratum_3_is_a_column_shifted_by_a_row() -> None:
    rows = attachments.compare_positions(DELTOID, '6.2.2')
    for k in (5, 6):
        assert rows[k].printed.point[2] == pytest.approx(rows[k + 1].point[2], abs=1e-8)
        assert rows[k].printed.point[:2] == pytest.approx(rows[k].point[:2], abs=1e-8)


def test_the_whole_span_holds_the_bands_and_reaches_beyond_them() -> None:
    span = attachments.span_attachments(DELTOID)
    assert (span.s[0], span.s[-1]) == (0.0, 1.0)
    ours = attachments.band_attachments(DELTOID)
    np.testing.assert_array_equal(ours.origins, DELTOID.origins)
    np.testing.assert_array_equal(ours.insertions, DELTOID.insertions)


def test_the_span_of_any_other_muscle_is_that_of_its_bands(tmp_path: Path) -> None:
    path = tmp_path / 'mine.yaml'
    path.write_text(MODEL.read_text().replace('first: 0.10', 'first: 0.12'))
    muscle = BroadMuscle.load(path)
    assert not attachments.is_published(muscle)
    assert attachments.is_published(DELTOID)
    span = attachments.span_attachments(muscle)
    assert (span.s[0], span.s[-1]) == (0.12, 0.85)


def test_a_motion_may_have_any_step() -> None:
    assert (
        len(AxisMotion('flexion', (1.0, 0.0, 0.0), math.radians(80.0)).angles(math.radians(1)))
        == 81
    )
