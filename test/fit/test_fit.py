# SPDX-License-Identifier: Apache-2.0
"""Fits from beginning to end: what they find, that they repeat themselves, and can be stopped."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fits import HEADS, simulated, ten_percent_off
from optional import requires
from random_muscles import random_poses

from linkedplane_ros import BroadMuscle
from linkedplane_ros.errors import LinkedPlaneError
from linkedplane_ros.fit.criterion import Criterion, Weights
from linkedplane_ros.fit.parameters import Bound, build_space
from linkedplane_ros.fit.search.checkpoint import Checkpoint
from linkedplane_ros.fit.search.fitting import FitProgress, Plan, Search, fit, fit_fingerprint
from linkedplane_ros.fit.search.polish import polish
from linkedplane_ros.fit.search.swarm import Swarm, scatter_particles
from linkedplane_ros.fit.states import FitStates

pytestmark = requires('pymoo')
DELTOID = BroadMuscle.load('deltoid')
QUICK = Plan(particles=8, generations=4, rounds=2, polish=4, seed=3)
POLISH = Plan(generations=0, polish=300)  # from where the model stands
FREE = ['sphere.radius', 'plane_angle', 'humeral_point']


def recovery(start: BroadMuscle, parts: tuple[str, ...] = HEADS) -> Criterion:
    """Return the criterion for what the deltoid has simulated, over all 26 parameters."""
    parameters = build_space(start.definition)
    return Criterion.from_data(
        start, parameters, simulated(DELTOID, parts), Weights(interference=0.0)
    )


def quick(weights: Weights | None = None) -> Criterion:
    """Return a criterion that 10 % of the way off is quickly searched: 3 heads, 26 poses."""
    start = ten_percent_off(0)
    weights = weights or Weights(interference=0.0)
    return Criterion.from_data(
        start, build_space(start.definition, FREE), simulated(DELTOID), weights
    )


def states_of(
    criterion: Criterion, plan: Plan, watch: Any = None
) -> tuple[Any, float, list[dict[str, Any]]]:
    """Return the answer, its criterion, and the states of the search, as a file would hold them."""
    states: list[dict[str, Any]] = []

    def follow(_: FitProgress, search: Search) -> None:
        states.append(json.loads(json.dumps(search.state())))

    found = fit(criterion, plan, watch, follow=follow)
    return found.best, found.value, states


@pytest.mark.parametrize('seed', range(3))
def test_it_recovers_the_published_deltoid_from_10_percent_off(seed: int) -> None:
    criterion = recovery(ten_percent_off(seed))
    assert criterion.value(criterion.space.start) > 50.0  # mm^2
    x = fit(criterion, POLISH).best
    states = criterion.states(x)
    assert isinstance(states, FitStates)
    lengths, arms = (np.abs(off).mean() for off in criterion.deviations(states))
    assert lengths < 0.01  # mm; 0.1 is asked for
    assert arms < 0.02  # mm; 0.2 is asked for


def test_the_swarm_and_its_polish_recover_it_too() -> None:
    criterion = recovery(ten_percent_off(0))
    found = fit(criterion, Plan(particles=30, generations=15, polish=100))
    states = criterion.states(found.best)
    assert isinstance(states, FitStates)
    assert max(np.abs(off).mean() for off in criterion.deviations(states)) < 0.1  # mm
    assert found.value < 1e-2 * criterion.value(criterion.space.start)


def test_with_every_band_measured_the_coefficients_themselves_come_back() -> None:
    # three heads cannot tell the curves between them
    criterion = recovery(ten_percent_off(1), DELTOID.band_names)
    x = fit(criterion, POLISH).best
    for place, value in criterion.space.coefficients(x).items():
        assert value == pytest.approx(DELTOID.coefficients[place], rel=1e-5, abs=1e-6), place


def test_the_same_seed_gives_the_same_answer_whatever_the_jobs() -> None:
    found, again = fit(quick(), QUICK), fit(quick(), QUICK, jobs=2)
    np.testing.assert_array_equal(again.best, found.best)
    assert again.value == found.value
    assert fit(quick(), replace(QUICK, seed=4)).value != found.value


def test_a_fit_that_was_stopped_goes_on_as_if_it_had_not_been() -> None:
    weights = Weights(interference=0.01, order=0.01)
    watch = random_poses(10, 0)
    plan = replace(QUICK, tighten=(0.02, 0.01))
    x, value, states = states_of(quick(weights), plan, watch)
    # generations, polishes of the rounds, of later stages
    assert {(s['round'], s['polishes'] > 0, len(s['best_of'])) for s in states} >= {
        (0, False, 0), (0, True, 0), (1, False, 0), (1, True, 0), (2, True, 1), (2, True, 2)
    }  # fmt: skip
    assert states[-1]['added']
    for state in states[::2]:
        again = fit(quick(weights), plan, watch, state=state)
        np.testing.assert_array_equal(again.best, x)
        assert again.value == value


def test_the_best_never_gets_worse() -> None:
    _, value, states = states_of(quick(), QUICK)
    values = [state['value'] for state in states]
    assert values == sorted(values, reverse=True)
    assert value == values[-1] < quick().value(quick().space.start)


def test_poses_that_are_watched_count_once_the_muscle_fails_there() -> None:
    weights = Weights(interference=0.01)
    watch, short = random_poses(30, 1), Plan(particles=8, generations=2, polish=2)
    _, _, states = states_of(quick(weights), short, watch)
    added = states[-1]['added']
    assert states[0]['added'] == []
    assert len(set(added)) == len(added) > 0
    # they are those with the worst faults, of the muscle that was best then
    found = fit(quick(weights), short, watch)
    counted = quick(weights).with_poses(watch[added]).value(found.best)
    assert counted == pytest.approx(found.value, rel=1e-12)
    assert quick(weights).value(found.best) < found.value


def test_bands_are_let_into_the_spheres_less_and_less() -> None:
    weights = Weights(clearance=1e-3)
    plan = replace(QUICK, rounds=1, tighten=(0.03, 0.01))
    found = fit(quick(weights), plan, random_poses(10, 0))
    assert [depth for depth, _ in found.best_of] == [0.03, 0.01, -1e-3]
    np.testing.assert_array_equal(found.best_of[-1][1], found.best)
    deepest = []
    for _, best in found.best_of:
        states = quick(weights).states(best)
        assert isinstance(states, FitStates)
        deepest.append(states.depths.max())
    assert deepest == sorted(deepest, reverse=True)


def test_the_answer_keeps_to_the_bounds() -> None:
    start = ten_percent_off(0)
    bounds = [Bound.from_text('sphere.radius=+-1')]
    parameters = build_space(start.definition, ['sphere.radius'], bounds)
    criterion = Criterion.from_data(
        start, parameters, simulated(DELTOID), Weights(interference=0.0)
    )
    x = fit(criterion, QUICK).best
    assert (parameters.low <= x).all()
    assert (x <= parameters.high).all()
    assert np.minimum(x - parameters.low, parameters.high - x).min() < 1e-3  # it wants farther


def test_a_polish_never_ends_worse_than_it_began() -> None:
    criterion = quick()
    low, room = criterion.space.low, criterion.space.high - criterion.space.low

    def residuals(unit: Any) -> Any:
        return criterion.residuals(low + room * unit)

    for start in scatter_particles(np.full(len(low), 0.5), 4, 0.3, (1,)):
        end = polish(residuals, start, 5)
        before, after = residuals(start), residuals(end)
        if isinstance(before, float):
            np.testing.assert_array_equal(end, start)
        else:
            assert after @ after <= before @ before


def test_a_swarm_is_its_state() -> None:
    def valley(places: Any) -> Any:
        return ((places - 0.3) ** 2).sum(axis=1)

    swarm = Swarm(scatter_particles(np.full(4, 0.9), 6, 1.0, (0,)), seed=1)
    for _ in range(3):
        swarm.take_values(valley(swarm.next_particles()))
    other = Swarm.from_state(json.loads(json.dumps(swarm.state())))
    for _ in range(5):
        asked = swarm.next_particles(), other.next_particles()
        np.testing.assert_array_equal(*asked)
        for one, places in zip((swarm, other), asked, strict=True):
            one.take_values(valley(places))
    assert swarm.best_particle[1] == other.best_particle[1]


# Checkpoints


def checkpoint(path: Any, plan: Plan = QUICK) -> Checkpoint:
    return Checkpoint(path, fit_fingerprint(quick(), plan))


def test_a_checkpoint_gives_the_state_back_to_the_bit(tmp_path: Any) -> None:
    _, _, states = states_of(quick(), QUICK)
    file = checkpoint(tmp_path / 'a.checkpoint')
    file.write(states[2])
    assert checkpoint(tmp_path / 'a.checkpoint').read() == states[2]
    file.remove()
    assert not list(tmp_path.iterdir())


def test_a_checkpoint_of_another_fit_is_refused(tmp_path: Any) -> None:
    file = tmp_path / 'a.checkpoint'
    checkpoint(file).write({})
    with pytest.raises(ValueError, match=r'^\S+a\.checkpoint: of another fit: .*$'):
        checkpoint(file, Plan(8, 4, 2, 4, seed=9)).read()


@pytest.mark.parametrize('text', ['', '{}', '[1]', '{"format": "x"}', '[' * 10**6, '\xff'])
def test_what_is_no_checkpoint_is_told_in_one_line(tmp_path: Any, text: str) -> None:
    file = tmp_path / 'a.checkpoint'
    file.write_text(text, encoding='latin-1')
    with pytest.raises(ValueError, match=r'^\S+a\.checkpoint: not a checkpoint of a fit, or cut$'):
        checkpoint(file).read()


def test_a_flipped_digit_of_a_checkpoint_is_noticed(tmp_path: Any) -> None:
    file = tmp_path / 'a.checkpoint'
    checkpoint(file).write({'values': [0.125]})
    file.write_text(file.read_text().replace('0.125', '0.135'))
    with pytest.raises(ValueError, match=r'^\S+a\.checkpoint: damaged; --force'):
        checkpoint(file).read()


@pytest.mark.parametrize('name', ['a.checkpoint', '.a.checkpoint.part'])
def test_a_checkpoint_is_not_written_through_a_link(tmp_path: Any, name: str) -> None:
    precious = tmp_path / 'precious'
    precious.mkdir()
    (precious / 'a.checkpoint').write_text('precious')
    link = tmp_path / name
    link.symlink_to(precious / 'a.checkpoint' if name == 'a.checkpoint' else precious)
    with suppress(LinkedPlaneError):
        checkpoint(tmp_path / 'a.checkpoint').write({})
    assert (precious / 'a.checkpoint').read_text() == 'precious'
    assert [each.name for each in precious.iterdir()] == ['a.checkpoint']


def test_a_checkpoint_that_is_not_there_is_told_in_one_line(tmp_path: Any) -> None:
    with pytest.raises(ValueError, match=r'^\S+ cannot be read: No such file or directory$'):
        checkpoint(tmp_path / 'a.checkpoint').read()
    with pytest.raises(ValueError, match=r'^\S+ cannot be written: No such file or directory$'):
        checkpoint(tmp_path / 'nowhere' / 'a.checkpoint').write({})
