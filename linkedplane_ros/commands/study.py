"""`linkedplane study`: the thesis's case study done again, with a report."""

from __future__ import annotations

import argparse
from pathlib import Path


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    parser.add_argument('outdir', metavar='OUTDIR', help='a folder that is empty or not there')
    parser.add_argument('--muscle', default='deltoid', help='a bundled model or a .yaml file')
    parser.add_argument('--half', action='store_true',
                        help='halve simulated moment arms, as the thesis does')  # fmt: skip
    parser.add_argument('--spheres', metavar='FILE',
                        help='a .yaml file with further interference spheres')  # fmt: skip
    parser.add_argument('--no-animation', action='store_true', help='leave out the GIF of flexion')
    parser.add_argument('--force', action='store_true', help='replace a study that stands there')


def run(args: argparse.Namespace) -> None:
    """Do the thesis's case study again, with a report."""
    from ..study.experiments import HALF
    from ..study.report import REPORT, refuse, write
    from ..study.subject import Subject

    folder = Path(args.outdir)
    refuse(folder, args.force)
    subject = Subject.load(args.muscle, HALF if args.half else 1.0, args.spheres)
    write(subject, folder, args.force, animated=not args.no_animation)
    print(folder / REPORT)
