# SPDX-License-Identifier: Apache-2.0
"""Where browsers look from: at one shoulder or at both, far enough away to see all of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...types import Floats, Point

if TYPE_CHECKING:
    import viser


FOV = 0.6  # rad, upright
# The library draws an empty picture 1 unit before each camera. Nearer than the nearest that is
# seen, it costs nothing; otherwise, without a graphics card, a third of the time of a frame.
UNIT = 10.0  # units of the scene in a metre
NEAR, FAR = 0.105, 20.0  # m
MOVED = 1e-4  # m: a camera farther from its place has been moved by a person


@dataclass(frozen=True)
class View:
    """What a camera looks at, and from where it sees all end poses."""

    position: Point
    """m; x to the right of the body, y to its front, z up."""
    target: Point
    """m; the middle of the picture."""
    aspect: float
    """Width by height of the narrowest picture that the position suits."""

    def position_for(self, aspect: float) -> Floats:
        """Return the position (3,), m: farther away for a narrower picture."""
        target = np.array(self.target)
        return np.asarray(target + max(1.0, self.aspect / aspect) * (self.position - target))


def choose_view(sides: Sequence[str]) -> View:
    """Return the view of one shoulder from the front and the side, or of several from the front."""
    if len(sides) > 1:
        return View((0.0, 0.95, 0.2), (0.0, 0.02, -0.07), 1.45)
    lateral = -1.0 if 'left' in sides else 1.0
    return View((lateral * 0.455, 0.485, 0.13), (lateral * 0.03, 0.025, -0.065), 1.05)


class Cameras:
    """The cameras of all browsers; one that a person has moved stays where it is."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Look at a right shoulder until `set_view` is called."""
        self._server = server
        self._view = choose_view(())
        self._placed: dict[int, Floats] = {}
        initial = server.initial_camera
        initial.up = np.array((0.0, 0.0, 1.0))
        initial.fov, initial.near, initial.far = FOV, UNIT * NEAR, UNIT * FAR
        self._set_initial()
        server.on_client_connect(self._on_connect)
        server.on_client_disconnect(self._on_disconnect)

    def _set_initial(self) -> None:
        """Set where the camera of a new browser stands."""
        initial = self._server.initial_camera
        initial.look_at = UNIT * np.array(self._view.target)
        initial.position = UNIT * np.array(self._view.position)

    def set_view(self, view: View) -> None:
        """Let all browsers have a view; nothing changes if they have it already."""
        if view == self._view:
            return
        self._view = view
        self._set_initial()
        for client in self._server.get_clients().values():
            self._aim(client.camera)

    async def _on_connect(self, client: viser.ClientHandle) -> None:
        self._placed[client.client_id] = np.array(self._view.position)
        client.camera.on_update(self._on_update)

    async def _on_disconnect(self, client: viser.ClientHandle) -> None:
        self._placed.pop(client.client_id, None)

    async def _on_update(self, camera: viser.CameraHandle) -> None:
        """Adjust the distance to a window of another shape, unless a person moved the camera."""
        placed = self._placed[camera.client.client_id]
        wanted = self._view.position_for(aspect_ratio(camera))
        if np.allclose(camera.position / UNIT, placed, atol=MOVED) and not np.allclose(
            wanted, placed
        ):
            self._aim(camera)

    def _aim(self, camera: viser.CameraHandle) -> None:
        position = self._view.position_for(aspect_ratio(camera))
        self._placed[camera.client.client_id] = position
        camera.position = UNIT * position
        camera.look_at = UNIT * np.array(self._view.target)


def aspect_ratio(camera: viser.CameraHandle) -> float:
    """Return the width by the height of what a browser draws."""
    return max(camera.image_width, 1) / max(camera.image_height, 1)
