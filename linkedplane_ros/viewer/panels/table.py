# SPDX-License-Identifier: Apache-2.0
"""The table of the bands: length, moment arm, wrap state, interference."""

from __future__ import annotations

from ..names import html_name
from ..newest import MuscleInfo, Values

STATES = dict(enumerate(('wrapped', 'clear', 'missed', 'inside')))  # WrapState, 0 to 3
CELL = 'style="padding:0 0.4em;text-align:right"'


def bands_table_html(
    info: MuscleInfo, newest: Values, coordinate: int, interfering: set[int]
) -> str:
    """Return the bands as an HTML table, in mm, with the arms about a coordinate, by its number."""
    head = ('band', 'length', f'arm: {html_name(info.coordinates[coordinate])}', '', '')
    rows = [''.join(f'<th {CELL}>{each}</th>' for each in head)]
    for i, band in enumerate(info.bands):
        cells = [html_name(band), '', '', '', '']
        if newest.lengths is not None and i < len(newest.lengths):
            cells[1] = f'{1e3 * newest.lengths[i]:.1f}'
        if newest.arms is not None and i < len(newest.arms) and coordinate < newest.arms.shape[1]:
            cells[2] = f'{1e3 * newest.arms[i, coordinate]:.1f}'
        if newest.wrap is not None and i < len(newest.wrap):
            cells[3] = STATES.get(int(newest.wrap[i]), '')
        if i in interfering:
            cells[4] = '<b style="color:rgb(219,20,61)">interferes</b>'
        rows.append(''.join(f'<td {CELL}>{each}</td>' for each in cells))
    body = ''.join(f'<tr>{row}</tr>' for row in rows)
    return f'<table style="font-size:0.75em;padding:0.5em">{body}</table><small>&emsp;in mm</small>'
