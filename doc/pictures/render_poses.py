# SPDX-License-Identifier: Apache-2.0
"""Draw the first picture: the deltoid at four poses, from the markers that RViz gets.

Run it where linkedplane_ros[all] is installed: `python doc/pictures/render_poses.py [PNG]`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from linkedplane_ros.node import environment

environment.prepare()

import matplotlib  # noqa: E402

matplotlib.use('Agg')

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from builtin_interfaces.msg import Time  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from visualization_msgs.msg import Marker  # noqa: E402

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver  # noqa: E402
from linkedplane_ros.drawing.colours import HEAD_COLOURS  # noqa: E402
from linkedplane_ros.node.markers import MuscleMarkers  # noqa: E402

POSES = {  # angles, deg; where the joint and the title stand across the picture, of 1
    'abduction 90°': ((0, 90, 0), 0.27, 0.24),
    'arm at the side': ((0, 0, 0), 0.4, 0.4),
    'abduction 45°, internal rotation 45°': ((0, 45, 45), 0.6, 0.59),
    'flexion 80°': ((80, 0, 0), 0.73, 0.8),
}
REACH = 0.19  # m, what is seen to each side of the glenohumeral centre
NAMESPACES = ('bones', 'attachments', 'bands')  # the obstacle spheres would hide the muscle


def rotation_of(marker: Marker) -> np.ndarray:
    """Return the (3, 3) rotation of a marker's orientation."""
    q = marker.pose.orientation
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
    )


def surface(marker: Marker) -> list[np.ndarray]:
    """Return the grid of a sphere's or cylinder's surface."""
    around = np.linspace(0, 2 * np.pi, 33)
    if marker.type == Marker.SPHERE:
        down = np.linspace(0, np.pi, 17)[:, None]
        unit = (
            np.sin(down) * np.cos(around),
            np.sin(down) * np.sin(around),
            np.cos(down) + 0 * around,
        )
    else:
        height = np.array([[-1.0], [1.0]])
        unit = np.cos(around) + 0 * height, np.sin(around) + 0 * height, height + 0 * around
    size = 0.5 * np.array((marker.scale.x, marker.scale.y, marker.scale.z))
    centre = np.array((marker.pose.position.x, marker.pose.position.y, marker.pose.position.z))
    points = np.stack(unit, axis=-1) * size @ rotation_of(marker).T + centre
    return [points[..., axis] for axis in range(3)]


def draw(axes: Any, marker: Marker) -> None:
    """Draw one marker."""
    colour = (marker.color.r, marker.color.g, marker.color.b, marker.color.a)
    points = np.array([(p.x, p.y, p.z) for p in marker.points]).reshape(-1, 3).T
    if marker.type == Marker.LINE_STRIP:
        axes.plot(*points, color=colour, linewidth=900 * marker.scale.x, zorder=10)  # over bones
    elif marker.type == Marker.SPHERE_LIST:
        colours = [(c.r, c.g, c.b, c.a) for c in marker.colors]
        axes.scatter(*points, c=colours, s=14, depthshade=False)
    else:
        axes.plot_surface(*surface(marker), color=colour[:3], alpha=0.35, linewidth=0)


def main(path: Path) -> None:
    """Write the picture."""
    solver = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
    markers = MuscleMarkers(solver.muscle, 'scapula', 32)
    convention = JOINT_CONVENTIONS['flexion_abduction_rotation']
    figure = plt.figure(figsize=(14, 4.9))
    for title, (degrees, place, below) in POSES.items():
        axes: Any = figure.add_axes((place - 0.5, -0.37, 1.0, 2.1), projection='3d')
        state = solver.solve(convention.rotation(np.radians(degrees)))
        for marker in markers.update(state, Time()).markers:
            if marker.ns in NAMESPACES:
                draw(axes, marker)
        axes.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), zlim=(-REACH, REACH))
        axes.set_box_aspect((1.0, 1.0, 1.0), zoom=0.82)
        axes.view_init(elev=16, azim=30)
        axes.set_proj_type('persp', focal_length=0.6)
        axes.set_axis_off()
        axes.patch.set_visible(False)
        figure.text(below, 0.02, title, ha='center', va='bottom', fontsize=13)
    heads = [
        Line2D([], [], color=HEAD_COLOURS[i], linewidth=3, label=f'{head.name} head')
        for i, head in enumerate(solver.muscle.heads)
    ]
    figure.legend(handles=heads, loc='upper left', frameon=False)
    figure.savefig(path, dpi=100)


if __name__ == '__main__':
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name('poses.png'))
