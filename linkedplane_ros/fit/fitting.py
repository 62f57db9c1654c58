"""A fit from beginning to end: rounds of a swarm and its polish, to be stopped and taken up."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from .. import __version__
from ..muscle.writing import file_content
from ..types import Floats
from .criterion import Criterion, posed
from .polish import polished
from .swarm import Swarm, scattered


@dataclass(frozen=True)
class Plan:
    """How long and how widely to search."""

    particles: int = 50
    generations: int = 150
    rounds: int = 1
    """Each after the first begins about the best place so far, in half the width of the last."""
    scatter: float = 1.0
    """How much of the way to the bounds the first swarm is scattered about the start."""
    polish: int = 100
    """Steps of least squares after each swarm; 0: none."""
    tighten: tuple[float, ...] = ()
    """How deep bands may be in the interference spheres, m: the first for the rounds, the others,
    then the criterion's own clearance, for a polish each. Those who have to go round a bone from
    the first find other ways than those who are shown out of it."""
    seed: int = 0


@dataclass(frozen=True)
class Progress:
    """How far a fit has come."""

    round: int
    generation: int
    best: float
    """The least criterion so far, mm^2."""


WATCHED = 30  # poses that are taken in at a time
PATIENCE = 6  # times that poses are taken in at a stage; at the last one
LAST = 20


@dataclass
class Search:
    """All that a fit knows between two generations."""

    best: Floats
    """(p,) in the unit box"""
    value: float
    round: int = 0
    swarm: Swarm | None = None
    """None before a round's first generation."""
    generation: int = 0
    """Done in this round."""
    polishes: int = 0
    """Done at this round or stage."""
    added: tuple[int, ...] = ()
    """Of the watched poses, those that the criterion has taken in at this stage."""
    best_of: tuple[tuple[float, Floats], ...] = ()
    """Of each stage that is done how deep bands were let in, m, and the best place (p,)."""

    def state(self) -> dict[str, Any]:
        """Return it as JSON can hold it."""
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
    def resumed(state: dict[str, Any]) -> Search:
        """Return the search that had this state."""
        return Search(
            np.array(state['best']),
            state['value'],
            state['round'],
            state['swarm'] and Swarm.resumed(state['swarm']),
            state['generation'],
            state['polishes'],
            tuple(state['added']),
            tuple((depth, np.array(best)) for depth, best in state['best_of']),
        )


@dataclass(frozen=True, eq=False)
class Found:
    """What a fit has found."""

    best: Floats
    """(p,) the parameters"""
    value: float
    """The criterion there, with all poses that it has taken in, mm^2."""
    best_of: tuple[tuple[float, Floats], ...]
    """How deep bands were let in at each stage, m, and the best parameters (p,) then."""


def fit(
    criterion: Criterion,
    plan: Plan,
    watch: Floats | None = None,
    state: dict[str, Any] | None = None,
    jobs: int = 1,
    tell: Callable[[Progress, Search], None] = lambda progress, search: None,
) -> Found:
    """Return the best parameters found.

    Where the best muscle of a stage does what none may do at poses to `watch` (k, 3, 3), the
    criterion takes in the worst of them and the stage is polished again: few poses that count stand
    for many. The same criterion, plan and machine give the same answer, whatever `jobs`, and also
    from the `state` of a Search that `tell`, called after every generation and polish, was given.
    """
    with ThreadPoolExecutor(jobs) as threads:
        work = _Work(criterion, threads if jobs > 1 else None, watch, plan.tighten)
        if state is None:
            start = (criterion.space.start - work.low) / work.room
            search = Search(start, math.inf)
        else:
            search = Search.resumed(state)
        work.at(search)
        while search.round < plan.rounds:
            _swarm(search, plan, work, tell)
            _polish(search, plan, work, tell)
            search.round, search.generation, search.swarm = search.round + 1, 0, None
            search.polishes = 0
            tell(Progress(search.round, 0, search.value), search)
        while len(search.best_of) < len(work.stages):
            if search.best_of:  # the first stage is that of the rounds
                if not search.polishes:
                    search.added = ()
                    work.at(search)
                    work.take_in(search)
                _polish(search, plan, work, tell)
                search.polishes = 0
            depth = 0.0 - work.stages[len(search.best_of)]
            search.best_of += ((depth, search.best),)
            tell(Progress(search.round, 0, search.value), search)
        best_of = tuple((depth, work.low + work.room * best) for depth, best in search.best_of)
    return Found(best_of[-1][1], search.value, best_of)


class _Work:
    """The criterion over the unit box, as a stage has it, and the poses that it has to watch."""

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

    def at(self, search: Search) -> None:
        """Take the criterion of a search's stage and poses; the search's value is that."""
        stage = min(len(search.best_of), len(self.stages) - 1)
        weights = replace(self.first.weights, clearance=self.stages[stage])
        poses = self.watch[list(search.added)]
        self.criterion = replace(self.first, weights=weights).also_at(poses)
        search.value = self.value(search.best)

    def values(self, units: Floats) -> Floats:
        return self.criterion.values(self.low + self.room * units, self.pool)

    def value(self, unit: Floats) -> float:
        return self.criterion.value(self.low + self.room * unit)

    def residuals(self, unit: Floats) -> Floats | float:
        return self.criterion.residuals(self.low + self.room * unit)

    def take_in(self, search: Search) -> bool:
        """Take in the watched poses with the worst faults of the best muscle; False: none."""
        one = self.criterion
        muscle = one.space.muscle(self.low + self.room * search.best)
        states = posed(muscle, self.watch, one.spheres, 0, one.side)
        if isinstance(states, float) or not len(self.watch):
            return False
        each = sum((part**2).sum(axis=1) for part in one.faults(states))
        each[list(search.added)] = 0.0
        order = np.argsort(-each, kind='stable')[:WATCHED]
        poses = tuple(int(k) for k in order if each[k] > 0.0)
        search.added += poses
        self.at(search)
        return bool(poses)


def _swarm(
    search: Search, plan: Plan, work: _Work, tell: Callable[[Progress, Search], None]
) -> None:
    """Run the generations of a round that are left; the search keeps the best."""
    if search.swarm is None and plan.generations:
        seed = plan.seed, search.round
        width = plan.scatter * 0.5**search.round
        first = scattered(search.best, plan.particles, width, seed)
        search.swarm = Swarm(first, int(np.random.default_rng((*seed, 1)).integers(2**31)))
    while search.swarm and search.generation < plan.generations:
        search.swarm.tell(work.values(search.swarm.ask()))
        search.generation += 1
        place, value = search.swarm.best
        if value < search.value:
            search.best, search.value = place, value
        tell(Progress(search.round, search.generation, search.value), search)


def _polish(
    search: Search, plan: Plan, work: _Work, tell: Callable[[Progress, Search], None]
) -> None:
    """Polish the best of a stage, and again with the worst of the watched poses taken in."""
    last = len(search.best_of) == len(work.stages) - 1
    most = (LAST if last else PATIENCE) if plan.polish else 0
    while search.polishes < most:
        search.best = polished(work.residuals, search.best, plan.polish, work.pool)
        search.value = work.value(search.best)
        search.polishes = search.polishes + 1 if work.take_in(search) else most
        tell(Progress(search.round, search.generation, search.value), search)


def fingerprint(criterion: Criterion, plan: Plan, watch: Floats | None = None) -> str:
    """Return a name for a fit: of its model, data, parameters, weights, poses and plan."""
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
    for array in (*poses, *criterion.of_length, *criterion.of_arm):
        digest.update(array.tobytes())
    return digest.hexdigest()
