# SPDX-License-Identifier: Apache-2.0
"""`linkedplane fit`: chosen coefficients of a model, fitted to measurements."""

from __future__ import annotations

import argparse
import math
import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import LinkedPlaneError
from ..files import claim_output
from ..muscle.broad_muscle import BroadMuscle
from ..muscle.validity import check_topic_name
from ..solver.range_check import DEFAULT_RANGE
from .fit_arguments import add_arguments
from .progress import ProgressBar

if TYPE_CHECKING:
    from ..fit.criterion import Criterion
    from ..fit.measurements import Data
    from ..fit.report import FinishedFit
    from ..fit.search.checkpoint import Checkpoint
    from ..fit.search.fitting import FitProgress, FitResult, Plan, Search
    from ..fit.survey import Survey

__all__ = ['add_arguments', 'run']

COARSE = (40.0, 60.0, 60.0)  # deg, flexion, abduction, rotation: poses that count from the start


def run(args: argparse.Namespace) -> None:
    """Fit chosen coefficients of a model to measured lengths and moment arms."""
    from ..fit.files import Files
    from ..fit.search.checkpoint import Checkpoint
    from ..fit.search.fitting import Plan, fit_fingerprint
    from ..fit.search.swarm import require_libraries
    from ..fit.survey import survey_range

    require_libraries()
    files = Files(Path(args.out), bool(args.tighten))
    muscle = BroadMuscle.load(args.model)
    name = args.name or files.model.stem
    check_topic_name('name', name, args.out)
    _check_depths(args, muscle)
    criterion, watch, data = _build_criterion(args, muscle)
    if isinstance(criterion.states(criterion.space.start), float):
        raise LinkedPlaneError(
            f'{args.model}: a band has no path anywhere: an end lies in its sphere'
        )
    before = survey_range(muscle)
    plan = Plan(
        args.particles,
        args.generations,
        args.rounds,
        args.scatter,
        args.polish,
        tuple(1e-3 * depth for depth in args.tighten),
        args.seed,
    )
    checkpoint = Checkpoint(files.checkpoint, fit_fingerprint(criterion, plan, watch))
    files.check_overwriting(Path(args.data), args.force or args.resume)
    with claim_output(files.model, LinkedPlaneError):
        state = _read_state(args, checkpoint)
        result = _search(criterion, plan, watch, args.jobs, checkpoint, state)
        outcome = _describe_outcome(args, name, (muscle, before), data, criterion, result)
        files.write_outcome(outcome)
        checkpoint.remove()
    _print_summary(outcome)
    print(*files.results, sep='\n')


def _check_depths(args: argparse.Namespace, muscle: BroadMuscle) -> None:
    """Refuse depths to tighten by that do not get smaller, and any without spheres."""
    depths = [*args.tighten, -args.clearance]
    if args.tighten and not muscle.interference_names:
        raise LinkedPlaneError(f'tighten: {muscle.name} has no interference spheres')
    if args.tighten and depths != sorted(set(depths), reverse=True):
        raise LinkedPlaneError(
            f'tighten: {" ".join(f"{depth:g}" for depth in args.tighten)}, then clearance '
            f'{args.clearance:g}; each smaller than the one before expected'
        )


def _build_criterion(
    args: argparse.Namespace, muscle: BroadMuscle
) -> tuple[Criterion, np.ndarray | None, Data]:
    """Return the criterion, the poses to watch and the data that the arguments state."""
    from ..fit.criterion import Criterion, Weights
    from ..fit.data import read_data
    from ..fit.parameters import Bound, build_space
    from ..fit.places import THESIS, free_numbers, matches_place
    from ..fit.states import pose_grid
    from ..fit.survey import STEPS

    step = None if args.every is None else math.radians(args.every)
    data = read_data(args.data, muscle, args.convention, args.angle_scale, step)
    bounds = [Bound.from_text(text) for text in args.bound]
    mm, rad = args.reach
    known = free_numbers(muscle.definition)
    free = args.free or [
        each for each in THESIS if any(matches_place(each, place) for place in known)
    ]
    parameters = build_space(muscle.definition, free, bounds, (1e-3 * mm, rad))
    over = args.over == 'range'
    given = {'order': float(over), 'jumps': float(over), **dict(args.weights)}
    weights = Weights(clearance=1e-3 * args.clearance, arm_scale=args.arm_scale, **given)
    if not over:
        return Criterion.from_data(muscle, parameters, data, weights), None, data
    ranges = muscle.range_of_motion or DEFAULT_RANGE
    coarse = pose_grid(ranges, [math.radians(step) for step in COARSE])[1]
    watch = pose_grid(ranges, STEPS)[1]
    return Criterion.from_data(muscle, parameters, data, weights, coarse), watch, data


def _describe_outcome(
    args: argparse.Namespace,
    name: str,
    before: tuple[BroadMuscle, Survey],
    data: Data,
    criterion: Criterion,
    result: FitResult,
) -> FinishedFit:
    """Return what a fit has done, with surveys of the range of motion."""
    from ..fit.report import FinishedFit, Stage
    from ..fit.survey import survey_range

    muscle, survey_before = before

    def build_fitted(x: np.ndarray) -> BroadMuscle:
        places = criterion.space.coefficients(x)
        rounded = {place: float(f'{value:.12g}') for place, value in places.items()}
        definition = muscle.with_coefficients(rounded).definition
        source = f'{muscle.source}; fitted to {data.path.name} ({data.reading})'
        return BroadMuscle.from_definition(replace(definition, name=name, source=source))

    stages = tuple(
        Stage(depth, best, survey_range(build_fitted(best))) for depth, best in result.best_of
    )
    words = [word for word in args.words if word not in ('--resume', '--force')]
    command = 'linkedplane ' + shlex.join(words)
    start = criterion.space.start
    return FinishedFit(
        command, data, criterion, muscle, build_fitted(result.best), start, survey_before, stages
    )


def _read_state(args: argparse.Namespace, checkpoint: Checkpoint) -> dict[str, Any] | None:
    """Return the state to resume from, if any; refuse to overwrite that of another fit."""
    if args.resume:
        return checkpoint.read()
    if not args.force and checkpoint.path.exists():
        raise LinkedPlaneError(
            f'{checkpoint.path}: a fit was stopped here; --resume continues it, '
            '--force starts again'
        )
    return None


def _search(
    criterion: Criterion,
    plan: Plan,
    watch: np.ndarray | None,
    jobs: int,
    checkpoint: Checkpoint,
    state: dict[str, Any] | None,
) -> FitResult:
    """Return what the fit finds; show its progress, and keep its state on disk."""
    from ..fit.search.fitting import fit

    total = plan.rounds * plan.generations
    with ProgressBar(total) as bar:

        def follow(progress: FitProgress, search: Search) -> None:
            checkpoint.write_if_due(search)
            completed = progress.round * plan.generations + progress.generation
            bar.update(
                completed,
                f'round {min(progress.round + 1, plan.rounds)}: {completed} of {total} '
                f'generations, best {progress.best:,.2f} mm²',
            )

        try:
            return fit(criterion, plan, watch, state, jobs, follow)
        except KeyboardInterrupt:
            if checkpoint.written:
                print(f'linkedplane: stopped; {checkpoint.path} is there for --resume',
                      file=sys.stderr)  # fmt: skip
            raise


def _print_summary(outcome: FinishedFit) -> None:
    """Print what the fit has done."""
    from ..fit.report import mean_deviation, names_at_bounds

    criterion = outcome.criterion
    bound = names_at_bounds(criterion, outcome.end)
    values = [criterion.value(x) for x in (outcome.start, outcome.end)]
    print(
        f'{len(outcome.start)} parameters, {len(outcome.data.measurements)} rows '
        f'({outcome.data.reading}): criterion {values[0]:,.2f} -> {values[1]:,.2f} mm²'
    )
    before, after = outcome.deviations(outcome.start), outcome.deviations(outcome.end)
    for kind in after:
        if after[kind]:
            means = mean_deviation(before[kind]), mean_deviation(after[kind])
            print(f'{kind}: mean deviation {means[0]:.3f} -> {means[1]:.3f} mm')
    survey = outcome.stages[-1].survey
    print(
        f'over the range of motion, {len(survey.angles)} poses: {survey.entered} bands enter a '
        f'sphere, {survey.disordered} are not behind the one before, {survey.parted} farther from '
        f'it than at their origins, {survey.inside} have no path; largest jump of a length '
        f'{1e3 * survey.jump:.2f} mm'
    )
    print(f'{len(bound)} parameters at a bound' + (f': {", ".join(bound)}' if bound else ''))
