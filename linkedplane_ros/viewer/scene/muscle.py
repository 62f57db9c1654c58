# SPDX-License-Identifier: Apache-2.0
"""One muscle in the scene of the browser, updated from its drawables."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
import viser

from ...types import Bytes, Floats
from .camera import UNIT
from .geometry import Bodies, Drawable, Lines, Sheets

GREY = (128, 128, 128)
AXES = 0.09  # m that the axes reach from the glenohumeral centre
APART = (
    0.17  # m from the middle of the body to a glenohumeral centre, as in both_shoulders.launch.py
)
CROSS = 0.012  # m that the cross at the skeleton's root reaches from its middle
THIN = 0.0012  # m, of the axes and the cross
PIXELS = 1500.0  # a metre of line width: constant on the screen, at a third of the work
BEAD = 0.02  # m: smaller balls are drawn with few triangles
BALL, SMALL_BALL = (trimesh.creation.icosphere(subdivisions=k, radius=0.5) for k in (3, 1))
ROD = trimesh.creation.cylinder(radius=0.5, height=1.0, sections=32)


def light_scene(server: viser.ViserServer) -> None:
    """Light the scene from the front and above, without shadows."""
    scene = server.scene
    scene.set_up_direction('+z')
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_ambient('/light/all_round', intensity=1.1)
    for name, place, intensity in (('front', (1.0, 2.0, 2.0), 2.2), ('back', (-2, -2, 1), 1.0)):
        scene.add_light_directional(
            f'/light/{name}', position=np.array(place), intensity=intensity, cast_shadow=False
        )


class MuscleScene:
    """One muscle in the scene, named after the prefix of its topics."""

    def __init__(self, server: viser.ViserServer, prefix: str) -> None:
        """Add its frame."""
        self._scene = server.scene
        self._prefix = prefix
        self._place = self._scene.add_frame(prefix, show_axes=False)
        self._handles: dict[str, Any] = {}
        self._labels: list[Any] = []
        self._root: list[Any] = []
        self._side = ''
        self._away = np.zeros(3)

    def place_shoulder(self, side: str, muscles: int) -> None:
        """Move the muscle to the shoulder of a side, or to the middle if it is the only one."""
        away = APART if side == 'right' else -APART
        self._away = np.array((UNIT * away if muscles > 1 else 0.0, 0.0, 0.0))
        self.pose_ground(np.eye(3, 4))
        if side != self._side:
            self._side = side
            self._draw_axes(1.0 if side == 'right' else -1.0)

    def pose_ground(self, pose: Floats) -> None:
        """Move the muscle, with its ground bone, to a pose (3, 4), m, at its shoulder."""
        self._place.wxyz, self._place.position = self._as_placed(pose)

    def mark_root(self, name: str, pose: Floats | None) -> None:
        """Draw a cross where the root of the skeleton holds still, with its name; None: nowhere."""
        for part in self._root:
            part.remove()
        self._root = []
        if pose is None:
            return
        wxyz, position = self._as_placed(pose)
        arms = UNIT * CROSS * np.eye(3)
        path = f'{self._prefix}.root'  # beside all topics, whose names have no dots
        self._root = [
            self._scene.add_line_segments(
                path,
                np.stack((-arms, arms), axis=1),
                GREY,
                thickness=PIXELS * THIN,
                thickness_units='screen',
                wxyz=wxyz,
                position=position,
            ),
            self._scene.add_label(f'{path}/name', name),
        ]

    def _as_placed(self, pose: Floats) -> tuple[Floats, Floats]:
        """Return a pose (3, 4), m, at its shoulder as the library has it: w x y z and a point."""
        turn = viser.transforms.SO3.from_matrix(pose[:, :3])
        return turn.wxyz, self._away + UNIT * pose[:, 3]

    def _draw_axes(self, lateral: float) -> None:
        """Draw the axes of the scapula with their anatomical names."""
        for label in self._labels:
            label.remove()
        ends = {
            'lateral': (lateral * UNIT * AXES, 0.0, 0.0),
            'anterior': (0.0, UNIT * AXES, 0.0),
            'superior': (0.0, 0.0, UNIT * AXES),
        }
        pieces = np.array([((0.0, 0.0, 0.0), end) for end in ends.values()])
        name = f'{self._prefix}/axes'
        self._labels = [
            self._scene.add_line_segments(
                name, pieces, GREY, thickness=PIXELS * THIN, thickness_units='screen'
            ),
            *(
                self._scene.add_label(f'{name}/{text}', text, position=end)
                for text, end in ends.items()
            ),
        ]

    def show_axes(self, visible: bool) -> None:
        """Show or hide the axes and the mark of the root, with their names."""
        for label in (*self._labels, *self._root):
            label.visible = visible

    def draw(self, drawables: dict[str, Drawable]) -> None:
        """Draw these and hide everything else."""
        for name, each in drawables.items():
            if name not in self._handles:
                self._handles[name] = self._add(name, each)
            else:
                update_handle(self._handles[name], each)
        for name, handle in self._handles.items():
            handle.visible = name in drawables

    def _add(self, name: str, drawable: Drawable) -> Any:
        """Add a drawable to the scene; return the library's handle."""
        path = f'{self._prefix}/{name}'
        if isinstance(drawable, Lines):
            return self._scene.add_line_segments(
                path,
                UNIT * drawable.points,
                linear_rgb(drawable.colours),
                thickness=PIXELS * drawable.width,
                thickness_units='screen',
            )
        if isinstance(drawable, Bodies):
            ball = BALL if drawable.sizes.max() > BEAD else SMALL_BALL
            mesh = ROD if name.endswith('/rods') else ball
            return self._scene.add_batched_meshes_simple(
                path,
                mesh.vertices,
                mesh.faces,
                drawable.orientations,
                UNIT * drawable.positions,
                batched_scales=UNIT * drawable.sizes,
                batched_colors=linear_rgb(drawable.colours),
                opacity=opacity(drawable),
                lod='off',
                cast_shadow=False,
                receive_shadow=False,
            )
        return self._scene.add_mesh_simple(
            path,
            UNIT * drawable.points,
            np.arange(len(drawable.points)).reshape(-1, 3),
            color=drawable.colour,
            opacity=opacity(drawable),
            side='double',
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )


def linear_rgb(colours: Bytes) -> Bytes:
    """Return red, green and blue, 0..255, linear in light, as the library takes those of parts."""
    srgb = colours / 255.0
    light = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return np.rint(255.0 * light).astype(np.uint8)


def opacity(drawable: Bodies | Sheets) -> float | None:
    """Return the opacity of a drawable; None if it is opaque."""
    return drawable.opacity if drawable.opacity < 1.0 else None


def update_handle(handle: Any, drawable: Drawable) -> None:
    """Change a drawable of the scene; the library sends only what is different."""
    if isinstance(drawable, Lines):
        handle.points, handle.colors = UNIT * drawable.points, linear_rgb(drawable.colours)
        handle.thickness = PIXELS * drawable.width
    elif isinstance(drawable, Bodies):
        handle.batched_positions, handle.batched_wxyzs = (
            UNIT * drawable.positions,
            drawable.orientations,
        )
        handle.batched_scales = UNIT * drawable.sizes
        handle.batched_colors = linear_rgb(drawable.colours)
    else:
        handle.vertices = UNIT * drawable.points
        if len(handle.faces) != len(drawable.points) // 3:
            handle.faces = np.arange(len(drawable.points)).reshape(-1, 3)
