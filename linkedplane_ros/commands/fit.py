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

from ..joints.conventions import JOINT_CONVENTIONS
from ..muscle.broad_muscle import BroadMuscle
from ..muscle.validity import check_topic_name
from ..solver.check import DEFAULT_RANGE
from .progress import ProgressBar
from .values import (
    finite_number,
    non_negative_number,
    positive_count,
    positive_number,
    whole_number_from,
)

if TYPE_CHECKING:
    from ..fit.checkpoint import Checkpoint
    from ..fit.criterion import Criterion
    from ..fit.data import Data
    from ..fit.files import Files
    from ..fit.fitting import Found, Plan, Progress, Search
    from ..fit.over_range import OverRange
    from ..fit.report import Outcome

KINDS = ('length', 'arm', 'interference', 'order', 'jumps')
COARSE = (40.0, 60.0, 60.0)  # deg, flexion, abduction, rotation: poses that count from the first


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    add = parser.add_argument
    add('model', metavar='MODEL', help='where to start: a bundled model or a .yaml file')
    add('data', metavar='DATA.csv', help='measured lengths and moment arms (doc/how_to/fitting.md)')
    add('out', metavar='OUT.yaml', help='the fitted model; its report is written beside it')
    what = parser.add_argument_group('what is fitted')
    add = what.add_argument
    add(
        '--free',
        nargs='+',
        metavar='PATTERN',
        help='which coefficients, by their places in the model file; * stands for anything '
        '(default: those that the thesis fitted)',
    )
    add(
        '--bound',
        nargs='+',
        metavar='BOUND',
        default=[],
        help='how far they may go: PATTERN=LOW:HIGH, PATTERN=+-SIZE or PATTERN=+-PERCENT%%, in the '
        "model file's units",
    )
    add(
        '--reach',
        nargs=2,
        type=positive_number,
        metavar=('MM', 'RAD'),
        default=(30.0, 0.5),
        help='how far anything without a bound may go from its start (default: 30 0.5)',
    )
    add(
        '--convention',
        choices=tuple(JOINT_CONVENTIONS),
        default='flexion_abduction_rotation',
        help='what three angles in the data mean (default: %(default)s)',
    )
    add(
        '--angle-scale',
        type=positive_number,
        default=1.0,
        metavar='F',
        help="multiply the angles of the data's motions, e.g. by 0.6667 for angles against the "
        'thorax (default: %(default)s)',
    )
    add(
        '--every',
        type=positive_number,
        metavar='DEG',
        help="take the data's curves at multiples of this angle, deg (default: at its own angles)",
    )
    add(
        '--arm-scale',
        type=positive_number,
        default=1.0,
        metavar='F',
        help='multiply modelled moment arms; the thesis takes 0.5 (default: %(default)s)',
    )
    add(
        '--weights',
        nargs='+',
        type=weight,
        metavar='KIND=WEIGHT',
        default=[],
        help=f'what each kind of deviation counts; kinds: {", ".join(KINDS)} (default: length=1 '
        'arm=1 interference=1, others 0)',
    )
    add(
        '--over',
        choices=('data', 'range'),
        default='data',
        help="where interference, order and jumps count: at the data's poses, or over the model's "
        'whole range of motion, with order=1 jumps=1 (default: %(default)s)',
    )
    add(
        '--clearance',
        type=finite_number,
        default=0.0,
        metavar='MM',
        help='keep paths so far off the interference spheres, mm; negative: let them in so far '
        '(default: %(default)s)',
    )
    add(
        '--tighten',
        nargs='+',
        type=positive_number,
        default=[],
        metavar='MM',
        help='first let bands so deep into the spheres, mm: the first depth for the swarm, the '
        'others, then --clearance, for a polish each (default: none)',
    )
    how = parser.add_argument_group('how')
    add = how.add_argument
    add(
        '--particles',
        type=whole_number_from(2),
        default=50,
        metavar='N',
        help='particles of the swarm (default: %(default)s)',
    )
    add(
        '--generations',
        type=whole_number_from(0),
        default=150,
        metavar='N',
        help='generations of each round (default: %(default)s)',
    )
    add(
        '--rounds',
        type=positive_count,
        default=1,
        metavar='N',
        help='rounds of swarm and polish, each half as wide as the last (default: %(default)s)',
    )
    add(
        '--scatter',
        type=positive_number,
        default=1.0,
        metavar='SHARE',
        help='where the first particles are, as a share of the way to the bounds '
        '(default: %(default)s)',
    )
    add(
        '--polish',
        type=whole_number_from(0),
        default=100,
        metavar='N',
        help='steps of least squares of a polish; with --over range a stage has up to 6, the last '
        'one up to 20 (default: %(default)s)',
    )
    add(
        '--seed',
        type=whole_number_from(0),
        default=0,
        metavar='N',
        help='seed of all random numbers (default: %(default)s)',
    )
    add(
        '--jobs',
        type=positive_count,
        default=1,
        metavar='N',
        help='particles computed at a time (default: %(default)s); the result is the same',
    )
    add('--resume', action='store_true', help='continue a fit that was stopped')
    add('--force', action='store_true', help='replace an output that exists')
    add('--name', help="the fitted model's name (default: OUT's, without .yaml)")


def run(args: argparse.Namespace) -> None:
    """Fit chosen coefficients of a model to measured lengths and moment arms."""
    from ..fit.checkpoint import Checkpoint
    from ..fit.files import Files
    from ..fit.fitting import Plan, fingerprint
    from ..fit.over_range import over_range
    from ..fit.swarm import needed

    needed()
    files = Files(Path(args.out), bool(args.tighten))
    muscle = BroadMuscle.load(args.model)
    name = args.name or files.model.stem
    check_topic_name('name', name, args.out)
    _check_depths(args, muscle)
    criterion, watch, data = _stated(args, muscle)
    if isinstance(criterion.states(criterion.space.start), float):
        raise ValueError(f'{args.model}: a band has no path anywhere: an end lies in its sphere')
    before = over_range(muscle)
    plan = Plan(
        args.particles,
        args.generations,
        args.rounds,
        args.scatter,
        args.polish,
        tuple(1e-3 * depth for depth in args.tighten),
        args.seed,
    )
    checkpoint = Checkpoint(files.checkpoint, fingerprint(criterion, plan, watch))
    state = _begun(args, files, checkpoint)
    found = _searched(criterion, plan, watch, args.jobs, checkpoint, state)
    outcome = _outcome(args, name, (muscle, before), data, criterion, found)
    files.write(outcome)
    checkpoint.remove()
    _tell(outcome)
    print(*files.results, sep='\n')


def _check_depths(args: argparse.Namespace, muscle: BroadMuscle) -> None:
    """ValueError where depths to tighten by cannot be."""
    depths = [*args.tighten, -args.clearance]
    if args.tighten and not muscle.interference_names:
        raise ValueError(f'tighten: {muscle.name} has no interference spheres')
    if args.tighten and depths != sorted(set(depths), reverse=True):
        raise ValueError(
            f'tighten: {" ".join(f"{depth:g}" for depth in args.tighten)}, then clearance '
            f'{args.clearance:g}; ever smaller depths expected'
        )


def _stated(
    args: argparse.Namespace, muscle: BroadMuscle
) -> tuple[Criterion, np.ndarray | None, Data]:
    """Return the criterion, the poses to watch and the data that the arguments state."""
    from ..fit.criterion import Criterion, Weights, grid
    from ..fit.data import read
    from ..fit.over_range import STEPS
    from ..fit.parameters import THESIS, Bound, matches, places, space

    step = None if args.every is None else math.radians(args.every)
    data = read(args.data, muscle, args.convention, args.angle_scale, step)
    bounds = [Bound.of(text) for text in args.bound]
    mm, rad = args.reach
    known = places(muscle.definition)
    free = args.free or [each for each in THESIS if any(matches(each, place) for place in known)]
    parameters = space(muscle.definition, free, bounds, (1e-3 * mm, rad))
    over = args.over == 'range'
    given = {'order': float(over), 'jumps': float(over), **dict(args.weights)}
    weights = Weights(clearance=1e-3 * args.clearance, arm_scale=args.arm_scale, **given)
    if not over:
        return Criterion.of(muscle, parameters, data, weights), None, data
    ranges = muscle.range_of_motion or DEFAULT_RANGE
    coarse = grid(ranges, [math.radians(step) for step in COARSE])[1]
    watch = grid(ranges, STEPS)[1]
    return Criterion.of(muscle, parameters, data, weights, coarse), watch, data


def _outcome(
    args: argparse.Namespace,
    name: str,
    before: tuple[BroadMuscle, OverRange],
    data: Data,
    criterion: Criterion,
    found: Found,
) -> Outcome:
    """Return what a fit has made, and what it does over the range of motion."""
    from ..fit.over_range import over_range
    from ..fit.report import Outcome, Stage

    muscle, over_before = before

    def fitted(x: np.ndarray) -> BroadMuscle:
        places = criterion.space.coefficients(x)
        made = muscle.with_coefficients({place: float(f'{v:.12g}') for place, v in places.items()})
        source = f'{muscle.source}; fitted to {data.path.name} ({data.reading})'
        return BroadMuscle.from_definition(replace(made.definition, name=name, source=source))

    stages = tuple(Stage(depth, best, over_range(fitted(best))) for depth, best in found.best_of)
    words = [word for word in args.words if word not in ('--resume', '--force')]
    command = 'linkedplane ' + shlex.join(words)
    start = criterion.space.start
    return Outcome(command, data, criterion, muscle, fitted(found.best), start, over_before, stages)


def _begun(args: argparse.Namespace, files: Files, checkpoint: Checkpoint) -> dict[str, Any] | None:
    """Return the state to go on from, if any; ValueError for a file that would be lost."""
    files.check(Path(args.data), args.force or args.resume)
    if args.resume:
        return checkpoint.read()
    if not args.force and checkpoint.path.exists():
        raise ValueError(
            f'{checkpoint.path}: a fit was stopped here; --resume goes on, --force begins anew'
        )
    return None


def _searched(
    criterion: Criterion,
    plan: Plan,
    watch: np.ndarray | None,
    jobs: int,
    checkpoint: Checkpoint,
    state: dict[str, Any] | None,
) -> Found:
    """Return what the fit finds; tells how far it is, and keeps its state on disk."""
    from ..fit.fitting import fit

    total = plan.rounds * plan.generations
    with ProgressBar(total) as bar:

        def follow(progress: Progress, search: Search) -> None:
            checkpoint.offer(search)
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


def _tell(outcome: Outcome) -> None:
    """Print what has become of the fit."""
    from ..fit.report import at_bounds, mean

    one = outcome.criterion
    bound = at_bounds(one, outcome.found)
    values = [one.value(x) for x in (outcome.start, outcome.found)]
    print(
        f'{len(outcome.start)} parameters, {len(outcome.data.measurements)} rows '
        f'({outcome.data.reading}): criterion {values[0]:,.2f} -> {values[1]:,.2f} mm²'
    )
    before, after = outcome.deviations(outcome.start), outcome.deviations(outcome.found)
    for kind in after:
        if after[kind]:
            print(f'{kind}: mean deviation {mean(before[kind]):.3f} -> {mean(after[kind]):.3f} mm')
    over = outcome.stages[-1].over
    print(
        f'over the range of motion, {len(over.angles)} poses: {over.entered} bands enter a sphere, '
        f'{over.disordered} are not behind the one before, {over.parted} farther from it than at '
        f'their origins, {over.inside} have no path; largest '
        f'jump of a length {1e3 * over.jump:.2f} mm'
    )
    print(f'{len(bound)} parameters at a bound' + (f': {", ".join(bound)}' if bound else ''))


def weight(text: str) -> tuple[str, float]:
    """Return a kind and its weight, for argparse."""
    kind, _, value = text.partition('=')
    try:
        number = non_negative_number(value)
    except argparse.ArgumentTypeError:
        kind = ''
    if kind not in KINDS:
        raise argparse.ArgumentTypeError(f'{text}: one of {", ".join(KINDS)}, = and a number >= 0')
    return kind, number
