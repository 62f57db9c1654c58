# SPDX-License-Identifier: Apache-2.0
"""Draw the algorithm's picture: the fan of bands at three thetas, and its length over theta.

Run it where linkedplane_ros[tools] is installed: `python doc/pictures/render_theta.py [PNG]`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.drawing.colours import HEAD_COLOURS
from linkedplane_ros.linked_planes.chain import bands_at, energy, plane_at, state_at
from linkedplane_ros.linked_planes.path import band_path

SOLVER = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
HANGING = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
BANDS = bands_at(SOLVER._flat, HANGING)
LEAST = SOLVER.solve(np.eye(3)).theta
AWAY = np.radians(60.0)  # of the fans beside the shortest one


def polyline(band: Any, theta: float) -> np.ndarray:
    """Return a band's path at theta, (k, 3) m."""
    c, s = np.cos(theta), np.sin(theta)
    d, b, _, _ = plane_at(band.section, c, s)
    path = band_path(band, c, s, state_at(band.section, d, b, 0, -1))
    P, u, e = (np.array(each) for each in (path.P, path.u, path.e))
    if not path.wrapped:
        return np.array([P, P + path.D * u])
    start = np.arctan2(path.tP * path.t1e - path.b, path.tP * path.t1u - path.a)
    turn = start - np.linspace(0.0, path.arc, 24)
    x, y = path.a + path.r * np.cos(turn), path.b + path.r * np.sin(turn)
    return np.array([P, *(P + np.outer(x, u) + np.outer(y, e)), P + path.D * u])


def draw_fan(axes: Any, theta: float, title: str) -> None:
    """Draw the bands at theta, seen from the right front, and the plane of each as a triangle."""
    for band, name in zip(BANDS, SOLVER.muscle.band_names, strict=True):
        colour = HEAD_COLOURS[[h.name for h in SOLVER.muscle.heads].index(name.rpartition('_')[0])]
        points = polyline(band, theta)
        axes.plot(*points.T, color=colour, linewidth=2.2)
        n = np.cos(theta) * np.array(band.A) + np.sin(theta) * np.array(band.B)
        bulge = np.cross(band.u, n / np.linalg.norm(n))
        middle = 0.5 * (points[0] + points[-1]) + 0.045 * bulge
        axes.plot_trisurf(
            *np.array([points[0], middle, points[-1]]).T, color=colour, alpha=0.16, linewidth=0
        )
    axes.set(xlim=(-0.05, 0.1), ylim=(-0.05, 0.1), zlim=(-0.11, 0.06))
    axes.set_box_aspect((1.0, 1.0, 1.1), zoom=1.5)
    axes.view_init(elev=12, azim=25)
    axes.set_axis_off()
    axes.set_title(title, y=-0.06, fontsize=12)


def draw_length(axes: Any, thetas: tuple[float, ...]) -> None:
    """Draw the total length over the circle of theta, and mark these thetas."""
    circle = np.linspace(-np.pi, np.pi, 1441)
    total = np.array([energy(BANDS, theta, False, -1)[0] for theta in circle])
    total[1:][np.abs(np.diff(total)) > 2e-3] = np.nan  # a jump is no line
    axes.plot(np.degrees(circle), 1e3 * total, color='0.25', linewidth=1.6)
    for theta in thetas:
        length = 1e3 * energy(BANDS, theta, False, -1)[0]
        axes.plot(np.degrees(theta), length, 'o', color='C3' if theta == LEAST else '0.55')
        side = np.sign(theta - LEAST)
        axes.annotate(
            f'{length:.0f} mm',
            (np.degrees(theta), length),
            (10 * side, -5 * abs(side) + 9 * (side == 0)),
            textcoords='offset points',
            ha={-1.0: 'right', 0.0: 'center', 1.0: 'left'}[side],
        )
    axes.set(xlim=(-180, 180), xticks=range(-180, 181, 90), xlabel='theta (deg)',
             ylabel='length of all bands (mm)')  # fmt: skip
    axes.spines[['top', 'right']].set_visible(False)


def main(path: Path) -> None:
    """Write the picture."""
    plt.rcParams.update({'font.size': 11})
    thetas = LEAST - AWAY, LEAST, LEAST + AWAY
    figure = plt.figure(figsize=(14, 4.2))
    for place, theta in enumerate(thetas):
        axes = figure.add_axes((0.005 + 0.2 * place, 0.07, 0.21, 0.95), projection='3d')
        title = f'theta {np.degrees(theta):.0f}°'
        draw_fan(axes, theta, f'{title}: shortest' if theta == LEAST else title)
    draw_length(figure.add_axes((0.71, 0.15, 0.275, 0.8)), thetas)
    heads = [
        Line2D([], [], color=HEAD_COLOURS[i], linewidth=3, label=f'{head.name} head')
        for i, head in enumerate(SOLVER.muscle.heads)
    ]
    figure.legend(handles=heads, loc='upper center', bbox_to_anchor=(0.84, 0.99), frameon=False)
    figure.savefig(path, dpi=100)
    plt.close(figure)


if __name__ == '__main__':
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name('theta.png'))
