# SPDX-License-Identifier: Apache-2.0
"""`linkedplane study`: the thesis's case study done again, with a report."""

from __future__ import annotations

import argparse
from pathlib import Path

from .argument_types import add_muscle


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    # fmt: off
    add = parser.add_argument
    add('outdir', metavar='OUTDIR', help='the folder to write into: empty, or not there yet')
    add_muscle(parser)
    add('--half', action='store_true',
        help='halve the simulated moment arms, as the thesis does')
    add('--spheres', metavar='FILE', help='add the interference spheres of a .yaml file')
    add('--no-animation', action='store_true', help='leave out the GIF of flexion')
    add('--force', action='store_true', help='replace a study that OUTDIR holds')
    # fmt: on


def run(args: argparse.Namespace) -> None:
    """Do the thesis's case study again, with a report."""
    from ..study.experiments import HALF
    from ..study.report import REPORT, check_folder, write_study
    from ..study.subject import Subject

    folder = Path(args.outdir)
    check_folder(folder, args.force)
    subject = Subject.load(args.muscle, HALF if args.half else 1.0, args.spheres)
    write_study(subject, folder, args.force, animated=not args.no_animation)
    print(folder / REPORT)
