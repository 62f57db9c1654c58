"""The scene in the browser: what is drawn of a muscle, kept in step with its markers."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
import viser

from ...types import Bytes
from .camera import UNIT
from .geometry import Bodies, Drawable, Lines, Sheets

GREY = (128, 128, 128)
AXES = 0.09  # m that the axes reach from the glenohumeral centre
APART = 0.17  # m from the middle of the body to a glenohumeral centre, as both_shoulders.launch.py
THIN = 0.0012  # m, of the axes
PIXELS = 1500.0  # of a metre of a line's width: as wide from near and far, a third of the work
BEAD = 0.02  # m: what is smaller is drawn with few triangles
BALL, SMALL_BALL = (trimesh.creation.icosphere(subdivisions=k, radius=0.5) for k in (3, 1))
ROD = trimesh.creation.cylinder(radius=0.5, height=1.0, sections=32)


def prepare(server: viser.ViserServer) -> None:
    """Light the scene from before and above, without shadows."""
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
    """One muscle in the scene, under the name of its topics' prefix."""

    def __init__(self, server: viser.ViserServer, prefix: str) -> None:
        """Make its place."""
        self._scene = server.scene
        self._prefix = prefix
        self._place = self._scene.add_frame(prefix, show_axes=False)
        self._handles: dict[str, Any] = {}
        self._labels: list[Any] = []
        self._side = ''

    def settle(self, side: str, muscles: int) -> None:
        """Stand where the shoulder of that side is, or in the middle if it is alone."""
        away = APART if side == 'right' else -APART
        self._place.position = (UNIT * away if muscles > 1 else 0.0, 0.0, 0.0)
        if side != self._side:
            self._side = side
            self._name_axes(1.0 if side == 'right' else -1.0)

    def _name_axes(self, lateral: float) -> None:
        """Draw the axes of the scapula with the names of anatomy."""
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

    def show_axes(self, shown: bool) -> None:
        """Show the axes and their names, or do not."""
        for label in self._labels:
            label.visible = shown

    def draw(self, drawables: dict[str, Drawable]) -> None:
        """Draw these and nothing else."""
        for name, each in drawables.items():
            if name not in self._handles:
                self._handles[name] = self._added(name, each)
            else:
                update(self._handles[name], each)
        for name, handle in self._handles.items():
            handle.visible = name in drawables

    def _added(self, name: str, drawable: Drawable) -> Any:
        """Add a thing to the scene."""
        path = f'{self._prefix}/{name}'
        if isinstance(drawable, Lines):
            return self._scene.add_line_segments(
                path,
                UNIT * drawable.points,
                linear(drawable.colours),
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
                drawable.turns,
                UNIT * drawable.positions,
                batched_scales=UNIT * drawable.sizes,
                batched_colors=linear(drawable.colours),
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


def linear(colours: Bytes) -> Bytes:
    """Return red, green and blue 0..255 as the library takes those of parts: linear in light."""
    shown = colours / 255.0
    light = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    return np.rint(255.0 * light).astype(np.uint8)


def opacity(drawable: Bodies | Sheets) -> float | None:
    """Return the opacity of what can be seen through; None of what cannot."""
    return drawable.opacity if drawable.opacity < 1.0 else None


def update(handle: Any, drawable: Drawable) -> None:
    """Change a thing of the scene; the library sends only what is different."""
    if isinstance(drawable, Lines):
        handle.points, handle.colors = UNIT * drawable.points, linear(drawable.colours)
        handle.thickness = PIXELS * drawable.width
    elif isinstance(drawable, Bodies):
        handle.batched_positions, handle.batched_wxyzs = UNIT * drawable.positions, drawable.turns
        handle.batched_scales = UNIT * drawable.sizes
        handle.batched_colors = linear(drawable.colours)
    else:
        handle.vertices = UNIT * drawable.points
        if len(handle.faces) != len(drawable.points) // 3:
            handle.faces = np.arange(len(drawable.points)).reshape(-1, 3)
