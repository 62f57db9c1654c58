"""Where browsers look from: at one shoulder or at both, from so far that their picture holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...types import Floats

if TYPE_CHECKING:
    import viser


FOV = 0.6  # rad, upright
# The library draws an empty picture 1 unit before each camera. Where a unit is smaller than the
# nearest that is seen, it costs nothing: without a graphics card, a third of the time of a frame.
UNIT = 10.0  # units of the scene in a metre
NEAR, FAR = 0.105, 20.0  # m
MOVED = 1e-4  # m: farther away than that, somebody has moved the camera


@dataclass(frozen=True)
class View:
    """What a camera looks at, and where it stands to have all end poses in its picture."""

    place: tuple[float, float, float]
    """m; x to the right of the body, y to its front, z up."""
    at: tuple[float, float, float]
    """m; the middle of the picture."""
    aspect: float
    """Width by height of the narrowest picture that the place suits."""

    def place_for(self, aspect: float) -> Floats:
        """Return where to stand (3,), m: farther away for a picture that is narrower."""
        at = np.array(self.at)
        return np.asarray(at + max(1.0, self.aspect / aspect) * (self.place - at))


def view(sides: Sequence[str]) -> View:
    """Return the view of one shoulder from its front and side, or of several from the front."""
    if len(sides) > 1:
        return View((0.0, 0.95, 0.2), (0.0, 0.02, -0.07), 1.45)
    lateral = -1.0 if 'left' in sides else 1.0
    return View((lateral * 0.455, 0.485, 0.13), (lateral * 0.03, 0.025, -0.065), 1.05)


class Cameras:
    """The cameras of all browsers. One that a person has moved stays where it is."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Look at a right shoulder, for the time being."""
        self._server = server
        self._view = view(())
        self._placed: dict[int, Floats] = {}
        initial = server.initial_camera
        initial.up = np.array((0.0, 0.0, 1.0))
        initial.fov, initial.near, initial.far = FOV, UNIT * NEAR, UNIT * FAR
        self._begin()
        server.on_client_connect(self._welcome)
        server.on_client_disconnect(self._forget)

    def _begin(self) -> None:
        """Tell browsers to come where to stand at first."""
        initial = self._server.initial_camera
        initial.look_at = UNIT * np.array(self._view.at)
        initial.position = UNIT * np.array(self._view.place)

    def look(self, chosen: View) -> None:
        """Let all browsers look at something else; nothing changes if it is not something else."""
        if chosen == self._view:
            return
        self._view = chosen
        self._begin()
        for client in self._server.get_clients().values():
            self._aim(client.camera)

    async def _welcome(self, client: viser.ClientHandle) -> None:
        self._placed[client.client_id] = np.array(self._view.place)
        client.camera.on_update(self._fit)

    async def _forget(self, client: viser.ClientHandle) -> None:
        self._placed.pop(client.client_id, None)

    async def _fit(self, camera: viser.CameraHandle) -> None:
        """Step back or nearer when the picture has become another, and nobody moved the camera."""
        placed = self._placed[camera.client.client_id]
        wanted = self._view.place_for(aspect(camera))
        if np.allclose(camera.position / UNIT, placed, atol=MOVED) and not np.allclose(
            wanted, placed
        ):
            self._aim(camera)

    def _aim(self, camera: viser.CameraHandle) -> None:
        place = self._view.place_for(aspect(camera))
        self._placed[camera.client.client_id] = place
        camera.position = UNIT * place
        camera.look_at = UNIT * np.array(self._view.at)


def aspect(camera: viser.CameraHandle) -> float:
    """Return the width by the height of what a browser draws."""
    return max(camera.image_width, 1) / max(camera.image_height, 1)
