# SPDX-License-Identifier: Apache-2.0
"""A fit from beginning to end: rounds of a swarm and its polish, to be stopped and resumed."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ... import __version__
from ...muscle.writing import file_content
from ...types import Floats
from ..criterion import Criterion
from ..states import evaluate_poses
from .polish import polish
from .swarm import Swarm, scatter_particles


@dataclass(frozen=True)
class Plan:
    """How long and how widely to search."""

    particles: int = 50
    """At least 2."""
    generations: int = 150
    """Of each round."""
    rounds: int = 1
    """Of swarm and polish; each after the first starts at the best so far, half as wide as the
    last."""
    scatter: float = 1.0
    """How widely the first swarm is scattered about the start, as a share of the way to the
    bounds."""
    polish: int = 100
    """Steps of least squares of a polish; 0: no polish."""
    tighten: tuple[float, ...] = ()
    """m, how deep bands may be in the interference spheres: the first depth for the rounds, the
    others, then the criterion's own clearance, for a polish each. Bands that start inside bone and
    are led out of it end elsewhere than bands that have to stay outside from the start."""
    seed: int = 0
    """Of all random numbers."""


@dataclass(frozen=True)
class FitProgress:
    """How far a fit has come."""

    round: int
    """From 0."""
    generation: int
    """How many are done in this round."""
    best: float
    """mm^2, the least criterion so far."""


ADDED = 30  # watched poses that are added to the criterion at a time, at the most
POLISHES = 6  # of a stage, at the most
LAST_POLISHES = 20  # of the last stage


@dataclass
class Search:
    """All that a fit knows between two generations."""

    best: Floats
    """(p,) in the unit box."""
    value: float
    """mm^2, the criterion there."""
    round: int = 0
    swarm: Swarm | None = None
    """None before a round's first generation."""
    generation: int = 0
    """How many are done in this round."""
    polishes: int = 0
    """How many are done in this round or stage."""
    added: tuple[int, ...] = ()
    """The numbers of the watched poses that were added to the criterion at this stage."""
    best_of: tuple[tuple[float, Floats], ...] = ()
    """Of each stage that is done, the depth that was allowed, m, and the best (p,)."""

    def state(self) -> dict[str, Any]:
        """Return the search in types that JSON has."""
        return {
            'best': self.best.tolist(),
            'value': self.value,
            'round': self.round,
            'generation': self.generation,
            'polishes': self.polishes,
            'added': self.added,
            'best_of': [(depth, best.tolist()) for depth, best in self.best_of],
            'swarm': self.swarm and self.swarm.state(),
        }

    @staticmethod
    def from_state(state: dict[str, Any]) -> Search:
        """Return the search that had this state."""
        return Search(
            np.array(state['best']),
            state['value'],
            state['round'],
            state['swarm'] and Swarm.from_state(state['swarm']),
            state['generation'],
            state['polishes'],
            tuple(state['added']),
            tuple((depth, np.array(best)) for depth, best in state['best_of']),
        )


@dataclass(frozen=True, eq=False)
class FitResult:
    """What a fit has found."""

    best: Floats
    """(p,) the parameters, in the file's units."""
    value: float
    """mm^2, the criterion there, with all poses that were added to it."""
    best_of: tuple[tuple[float, Floats], ...]
    """Of each stage, the depth that was allowed, m, and the best parameters (p,)."""


Follow = Callable[[FitProgress, Search], None]


def fit(
    criterion: Criterion,
    plan: Plan,
    watch: Floats | None = None,
    state: dict[str, Any] | None = None,
    jobs: int = 1,
    follow: Follow = lambda progress, search: None,
) -> FitResult:
    """Return the parameters with the least criterion that a search finds.

    The same criterion, plan and machine give the same result, whatever `jobs` is, and whether or
    not the fit was stopped and resumed.

    Parameters
    ----------
    criterion
        What is minimised (thesis eq. 5.7).
    plan
        How long and how widely to search.
    watch
        (j, 3, 3) poses that the criterion does not have. Where the best muscle of a stage has
        penalties at some of them, the worst are added to the criterion and the stage is polished
        again: so few poses stand for many.
    state
        The `Search.state()` of a fit that was stopped, to resume it.
    jobs
        How many particles are computed at a time.
    follow
        Called with the progress and the search after every generation and polish.

    Raises
    ------
    LinkedPlaneError
        Where pymoo or SciPy is not installed.

    """
    with ThreadPoolExecutor(jobs) as threads:
        work = _Work(criterion, threads if jobs > 1 else None, watch, plan.tighten)
        if state is None:
            start = (criterion.space.start - work.low) / work.room
            search = Search(start, math.inf)
        else:
            search = Search.from_state(state)
        work.set_stage(search)
        while search.round < plan.rounds:
            _swarm(search, plan, work, follow)
            _polish(search, plan, work, follow)
            search.round, search.generation, search.swarm = search.round + 1, 0, None
            search.polishes = 0
            follow(FitProgress(search.round, 0, search.value), search)
        while len(search.best_of) < len(work.stages):
            if search.best_of:  # the first stage is that of the rounds
                if not search.polishes:
                    search.added = ()
                    work.set_stage(search)
                    work.add_worst_poses(search)
                _polish(search, plan, work, follow)
                search.polishes = 0
            depth = 0.0 - work.stages[len(search.best_of)]
            search.best_of += ((depth, search.best),)
            follow(FitProgress(search.round, 0, search.value), search)
        best_of = tuple((depth, work.low + work.room * best) for depth, best in search.best_of)
    return FitResult(best_of[-1][1], search.value, best_of)


class _Work:
    """The criterion of a stage over the unit box, and the poses to watch."""

    def __init__(
        self,
        criterion: Criterion,
        pool: ThreadPoolExecutor | None,
        watch: Floats | None,
        tighten: Sequence[float],
    ) -> None:
        self.criterion = self.first = criterion
        self.pool = pool
        self.watch = np.empty((0, 3, 3)) if watch is None else watch
        self.stages = (*(-depth for depth in tighten), criterion.weights.clearance)
        self.low = criterion.space.low
        self.room = criterion.space.high - self.low

    def set_stage(self, search: Search) -> None:
        """Take the criterion of a search's stage, with its added poses; update the value."""
        stage = min(len(search.best_of), len(self.stages) - 1)
        weights = replace(self.first.weights, clearance=self.stages[stage])
        poses = self.watch[list(search.added)]
        self.criterion = replace(self.first, weights=weights).with_poses(poses)
        search.value = self.value(search.best)

    def values(self, units: Floats) -> Floats:
        return self.criterion.values(self.low + self.room * units, self.pool)

    def value(self, unit: Floats) -> float:
        return self.criterion.value(self.low + self.room * unit)

    def residuals(self, unit: Floats) -> Floats | float:
        return self.criterion.residuals(self.low + self.room * unit)

    def add_worst_poses(self, search: Search) -> bool:
        """Add the watched poses with the largest penalties of the best muscle; False: none."""
        one = self.criterion
        muscle = one.space.flat_muscle(self.low + self.room * search.best)
        states = evaluate_poses(muscle, self.watch, one.spheres, 0, one.side)
        if isinstance(states, float) or not len(self.watch):
            return False
        each = np.sum([(part**2).sum(axis=1) for part in one.penalties(states)], axis=0)
        each[list(search.added)] = 0.0
        order = np.argsort(-each, kind='stable')[:ADDED]
        worst = tuple(int(k) for k in order if each[k] > 0.0)
        search.added += worst
        self.set_stage(search)
        return bool(worst)


def _swarm(search: Search, plan: Plan, work: _Work, follow: Follow) -> None:
    """Run the generations of a round that are left; the search keeps the best."""
    if search.swarm is None and plan.generations:
        seed = plan.seed, search.round
        width = plan.scatter * 0.5**search.round
        first = scatter_particles(search.best, plan.particles, width, seed)
        search.swarm = Swarm(first, int(np.random.default_rng((*seed, 1)).integers(2**31)))
    while search.swarm and search.generation < plan.generations:
        search.swarm.take_values(work.values(search.swarm.next_particles()))
        search.generation += 1
        place, value = search.swarm.best_particle
        if value < search.value:
            search.best, search.value = place, value
        follow(FitProgress(search.round, search.generation, search.value), search)


def _polish(search: Search, plan: Plan, work: _Work, follow: Follow) -> None:
    """Polish the best of a stage, and again with the worst of the watched poses added."""
    last = len(search.best_of) == len(work.stages) - 1
    most = (LAST_POLISHES if last else POLISHES) if plan.polish else 0
    while search.polishes < most:
        search.best = polish(work.residuals, search.best, plan.polish, work.pool)
        search.value = work.value(search.best)
        search.polishes = search.polishes + 1 if work.add_worst_poses(search) else most
        follow(FitProgress(search.round, search.generation, search.value), search)


def fit_fingerprint(criterion: Criterion, plan: Plan, watch: Floats | None = None) -> str:
    """Return a digest of all that a fit depends on: model, data, parameters, weights, plan."""
    space = criterion.space
    stated = {
        'version': __version__,
        'model': file_content(space.definition),
        'parameters': [asdict(parameter) for parameter in space.parameters],
        'weights': asdict(criterion.weights),
        'plan': asdict(plan),
    }
    digest = hashlib.sha256(json.dumps(stated, sort_keys=True).encode())
    watched = () if watch is None else (watch,)
    poses = criterion.rotations, criterion.spheres, *watched
    kinds = criterion.measured_lengths, criterion.measured_arms
    rows = (each for kind in kinds for each in (kind.places, kind.values, kind.roots, kind.axes))
    for array in (*poses, *rows):
        digest.update(array.tobytes())
    return digest.hexdigest()
