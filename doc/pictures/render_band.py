# SPDX-License-Identifier: Apache-2.0
"""Draw the derivation's picture: one band in its plane, along its line, and its length.

Run it where linkedplane_ros[tools] is installed: `python doc/pictures/render_band.py [PNG]`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Arc

from linkedplane_ros.drawing.colours import HEAD_COLOURS
from linkedplane_ros.linked_planes.band import WRAPPED, obstacle_kind, wrap, wrap_state

BAND, SPHERE, BESIDE = HEAD_COLOURS[:3]
GREY = '0.45'

# a band of 0.16 m whose line runs through its sphere; m
D, A_LONG, RHO, R = 0.16, 0.070, 0.024, 0.045
BEHIND = np.radians(208.0)  # of the sphere's centre from n towards e: b < 0, the shorter side


def place(psi: float, rho: float) -> tuple[float, float]:
    """Return d, b (m) of a centre at rho (m) from the line, the plane turned by psi (rad)."""
    return rho * np.cos(BEHIND - psi), rho * np.sin(BEHIND - psi)


def tangents(rho: float) -> tuple[float, float]:
    """Return tP, tS, m."""
    off = rho * rho - R * R
    return float(np.sqrt(A_LONG**2 + off)), float(np.sqrt((D - A_LONG) ** 2 + off))


def length(psi: float, rho: float) -> float:
    """Return the band's length, m."""
    d, b = place(psi, rho)
    if wrap_state(obstacle_kind(D, A_LONG, rho * rho, R), R, d, b) != WRAPPED:
        return D
    tP, tS = tangents(rho)
    r, arc, *_ = wrap(D, A_LONG, tP, tS, R, d, b)
    return tP + r * arc + tS


def arrow(axes: Any, start: Any, along: Any, text: str, shift: Any = (0.0, 0.0)) -> None:
    """Draw a unit vector with its letter."""
    start, along = np.asarray(start), 0.024 * np.asarray(along)
    axes.annotate('', start + along, start, arrowprops={'arrowstyle': '-|>', 'color': 'k'})
    write(axes, text, start + 1.22 * along, shift, va='center', fontweight='bold')


def write(axes: Any, text: str, near: Any, shift: Any, **style: Any) -> None:
    """Write a text beside a point."""
    axes.text(*np.add(near, shift), text, ha='center', **style)


def dot(axes: Any, point: Any, text: str, shift: Any) -> None:
    """Draw a point with its letter."""
    axes.plot(*point, 'ko', markersize=4, zorder=5)
    write(axes, text, point, shift, va='center')


def span(axes: Any, start: Any, end: Any, text: str, shift: Any) -> None:
    """Draw a distance with its letter."""
    axes.annotate('', end, start, arrowprops={'arrowstyle': '<->', 'color': GREY, 'lw': 0.8})
    middle = 0.5 * (np.asarray(start) + end)
    write(axes, text, middle, shift, va='center', color=GREY)


def draw_plane(axes: Any) -> None:
    """Draw the band in its plane: u to the right, e up, n away from the reader."""
    d, b = place(0.0, RHO)
    tP, tS = tangents(RHO)
    r, arc, t1u, t1e, t2u, t2e = wrap(D, A_LONG, tP, tS, R, d, b)
    P, S, centre = np.zeros(2), np.array((D, 0.0)), np.array((A_LONG, b))
    t1, t2 = np.array((t1u, t1e)), np.array((t2u, t2e))
    Q, T = P + tP * t1, S - tS * t2
    axes.add_patch(plt.Circle(centre, r, facecolor=(*SPHERE, 0.12), edgecolor=SPHERE))
    start = np.arctan2(*(Q - centre)[::-1])
    turn = start - np.linspace(0.0, arc, 60)
    round_it = centre[:, None] + r * np.array((np.cos(turn), np.sin(turn)))
    axes.plot(*np.column_stack((P, Q)), *np.column_stack((T, S)), color=BAND, lw=2.5)
    axes.plot(*round_it, color=BAND, lw=2.5)
    axes.plot(*np.column_stack((P, S)), color=GREY, lw=1, ls='--')
    for point in (Q, T):
        axes.plot(*np.column_stack((centre, point)), color=GREY, lw=0.8)
    ends = np.degrees((start - arc, start))
    axes.add_patch(Arc(centre, 0.03, 0.03, theta1=ends[0], theta2=ends[1], color=GREY))
    write(axes, 'arc', centre, (0.004, 0.0195), color=GREY)
    write(axes, 'r', 0.5 * (centre + Q), (-0.005, 0.001), color=GREY)
    write(axes, '$t_P$', 0.5 * (P + Q), (-0.002, 0.005), color=BAND)
    write(axes, '$t_S$', 0.5 * (S + T), (0.003, 0.005), color=BAND)
    dot(axes, P, 'P', (-0.006, 0.0))
    dot(axes, S, 'S', (0.006, 0.0))
    dot(axes, Q, 'Q', (-0.004, 0.006))
    dot(axes, T, 'T', (0.004, 0.006))
    axes.plot(*centre, '+', color='k')
    span(axes, (0.0, -0.056), (A_LONG, -0.056), 'a', (0.0, -0.005))
    span(axes, (0.0, -0.07), (D, -0.07), 'D', (0.0, -0.005))
    span(axes, (A_LONG, 0.0), centre, 'b < 0', (-0.016, 0.0))
    arrow(axes, P, t1, '$t_1$', (0.006, -0.003))
    arrow(axes, S, t2, '$t_2$')
    arrow(axes, (-0.012, -0.045), (1, 0), 'u')
    arrow(axes, (-0.012, -0.045), (0, 1), 'e')
    axes.set(xlim=(-0.027, 0.187), ylim=(-0.08, 0.045), title='In the plane')


def draw_along(axes: Any) -> None:
    """Draw the same along the line, u towards the reader."""
    d, b = place(0.0, RHO)
    centre = np.array((d, b))
    axes.add_patch(plt.Circle(centre, R, facecolor=(*SPHERE, 0.12), edgecolor=SPHERE))
    axes.plot((0.0, 0.0), (-0.075, 0.075), color=BAND, lw=2.5)
    axes.text(0.003, 0.066, 'the plane, its side e up', color=BAND)
    axes.plot(*centre, '+', color='k')
    write(axes, 'C', centre, (-0.004, -0.006))
    write(axes, 'R', centre, (-0.011, -0.018), color=SPHERE)
    axes.plot(*np.column_stack((centre, centre + R * np.array((-0.45, -0.893)))), color=SPHERE)
    span(axes, (0.0, b), centre, 'd < 0', (0.003, -0.006))
    span(axes, (0.0, 0.0), (0.0, b), 'b < 0', (0.014, -0.001))
    axes.plot(0, 0, 'ko', markersize=5, zorder=5)
    axes.text(-0.003, 0.004, 'P, S', ha='right')
    arrow(axes, (0.0, 0.0), (1, 0), 'n')
    arrow(axes, (0.0, 0.0), (0, 1), 'e', (0.005, -0.003))
    axes.add_patch(Arc((0, 0), 0.09, 0.09, theta1=92, theta2=128, color='k'))
    axes.annotate('', (-0.029, 0.0345), (-0.0275, 0.0357), arrowprops={'arrowstyle': '-|>'})
    axes.text(-0.02, 0.047, '$\\psi$', ha='center')
    axes.set(xlim=(-0.075, 0.075), ylim=(-0.082, 0.082), title='Along the line, u to the reader')


def draw_length(axes: Any) -> None:
    """Draw the length over the turn of the plane: pierced, and beside the sphere."""
    turns = np.linspace(-180.0, 180.0, 1441)
    for rho, colour, text in (
        (RHO, BAND, 'PIERCED: the line runs through'),
        (1.25 * R, BESIDE, 'BESIDE: the line passes'),
    ):
        values = 1e3 * np.array([length(psi, rho) for psi in np.radians(turns)])
        jumps = np.abs(np.diff(values)) > 1.0
        values[1:][jumps] = np.nan
        axes.plot(turns, values, color=colour, label=text, lw=1.8)
    shortest = np.degrees(BEHIND) + 90.0 - 360.0
    axes.axvline(shortest, color=GREY, lw=0.8, ls=':')
    axes.text(shortest, 206, 'd = 0, b < 0', color=GREY, ha='center', backgroundcolor='w')
    for middle, height, text in (
        (shortest, 154, 'clear'),
        (shortest + 90.0, 154, 'missed'),
        (shortest - 87.0, 154, 'missed'),
        (shortest + 180.0, 190, 'wrapped'),
    ):
        axes.text(middle, height, text, color=BESIDE, ha='center')
    axes.set(
        xlabel='turn $\\psi$ of the plane (deg)',
        ylabel='length L (mm)',
        title='Length',
        xlim=(-180, 180),
        xticks=range(-180, 181, 90),
        ylim=(150, 278),
    )
    axes.legend(frameon=False, loc=(0.01, 0.83), fontsize=9)


def main(path: Path) -> None:
    """Write the picture."""
    plt.rcParams.update({'mathtext.fontset': 'dejavusans', 'font.size': 11})
    figure, (plane, along, lengths) = plt.subplots(
        1, 3, figsize=(15, 4.6), width_ratios=(1.45, 0.95, 1.0)
    )
    draw_plane(plane)
    draw_along(along)
    for axes in (plane, along):
        axes.set_aspect('equal')
        axes.set_axis_off()
    draw_length(lengths)
    figure.tight_layout()
    figure.savefig(path, dpi=100)


if __name__ == '__main__':
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name('band.png'))
