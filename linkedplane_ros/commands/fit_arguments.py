# SPDX-License-Identifier: Apache-2.0
"""What `linkedplane fit` takes."""

from __future__ import annotations

import argparse

from ..joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION
from .argument_types import (
    finite_number,
    non_negative_number,
    positive_count,
    positive_number,
    whole_number_from,
)

KINDS = ('length', 'arm', 'interference', 'order', 'jumps')


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
        default=THESIS_CONVENTION.name,
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
        type=weight_of_kind,
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


def weight_of_kind(text: str) -> tuple[str, float]:
    """Return a kind and its weight, for argparse."""
    kind, _, value = text.partition('=')
    try:
        number = non_negative_number(value)
    except argparse.ArgumentTypeError:
        kind = ''
    if kind not in KINDS:
        raise argparse.ArgumentTypeError(f'{text}: one of {", ".join(KINDS)}, = and a number >= 0')
    return kind, number
