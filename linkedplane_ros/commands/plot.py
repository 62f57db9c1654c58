# SPDX-License-Identifier: Apache-2.0
"""`linkedplane plot`: figures of a processed recording."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the command takes."""
    # fmt: off
    add = parser.add_argument
    add('output', metavar='OUTPUT',
        help='what `linkedplane process` has written: a bag, .csv or .parquet')
    add('--png', dest='kinds', action='append_const', const='png',
        help='draw PNG files (the default)')
    add('--svg', dest='kinds', action='append_const', const='svg', help='draw SVG files')
    add('--out', metavar='NAME', help="the beginning of the files' names (default: OUTPUT's name)")
    # fmt: on


def run(args: argparse.Namespace) -> None:
    """Draw a processed recording: lengths, moment arms and wrap states."""
    from ..drawing.plot import save_figures
    from ..processing.inputs import plain_name
    from ..processing.reading import read_processed

    source = Path(args.output) if Path(args.output).name else Path(args.output).resolve()
    out = Path(args.out) if args.out else source.with_name(plain_name(source))
    processed = read_processed(source)
    for kind in args.kinds or ['png']:
        for path in save_figures(processed, out, kind):
            print(path)
