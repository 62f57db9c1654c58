# SPDX-License-Identifier: Apache-2.0
"""`linkedplane info`: look at a model."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..muscle.broad_muscle import BroadMuscle
from .argument_types import add_scale


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    parser.add_argument(
        'muscle', nargs='?', default='deltoid', metavar='MUSCLE',
        help='a bundled model or a .yaml file (default: %(default)s)',
    )  # fmt: skip
    parser.add_argument(
        '--png', metavar='FILE', help='also draw it, hanging and raised, into a .png or .svg'
    )
    parser.add_argument(
        '--schema', action='store_true',
        help="print only the line that tells an editor a model file's format",
    )  # fmt: skip
    add_scale(parser)


def run(args: argparse.Namespace) -> None:
    """Print a muscle model."""
    from ..solver.report import model_report, schema_line

    if args.schema:
        print(schema_line())
        return
    muscle = BroadMuscle.load(args.muscle).scaled(args.scale)
    if args.png is not None:
        from ..drawing.picture import save_picture

        save_picture(muscle, Path(args.png))
    print(*model_report(muscle), sep='\n')
