"""A still of the scene, and a recording that opens in a browser without this program."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

HEIGHT = 1080  # px of a still
LONGEST = 120.0  # s of a recording: what is longer belongs in a bag
RECORD, STOP = 'record', 'stop recording'


class Saving:
    """Buttons that save what a browser shows, through that browser."""

    def __init__(
        self, server: viser.ViserServer, gui: viser.GuiApi, dark: Callable[[], bool]
    ) -> None:
        """Add them to what is open of the GUI; `dark` tells whether the page is."""
        self._server = server
        self._dark = dark
        self._recording: Any = None
        self._begun = self._last = 0.0
        gui.add_markdown('Both come as downloads; a recording opens without a server.')
        still = gui.add_button('still (PNG)')
        self._record = gui.add_button(RECORD)
        still.on_click(self._still)
        self._record.on_click(self._switch)

    def _still(self, event: Any) -> None:
        import imageio.v3

        client = event.client
        if client is None:
            return
        camera = client.camera
        width = round(HEIGHT * camera.image_width / camera.image_height)
        picture = client.get_render(HEIGHT, width, transport_format='png', timeout=60.0)
        content = imageio.v3.imwrite('<bytes>', on_white(picture), extension='.png')
        client.send_file_download(name('png'), content, save_immediately=True)

    async def _switch(self, _: Any) -> None:
        if self._recording is None:
            self._begun = self._last = time.monotonic()
            self._recording = self._server.get_scene_serializer()
            self._record.label = STOP
        else:
            await self._finish()

    async def _finish(self) -> None:
        """Give the recording away; to pack it takes a while."""
        recording, self._recording = self._recording, None
        self._record.label = RECORD
        content = await asyncio.to_thread(recording.as_html, self._dark())
        self._server.send_file_download(name('html'), content.encode(), save_immediately=True)

    async def frame(self, now: float) -> None:
        """Tell the recording how long it was since the frame before."""
        if self._recording is None:
            return
        self._recording.insert_sleep(max(now - self._last, 0.0))
        self._last = now
        if now > self._begun + LONGEST:
            await self._finish()


def on_white(picture: Any) -> Any:
    """Return a picture (h, w, 4) with nothing to be seen through, (h, w, 3)."""
    alpha = picture[..., 3:] / 255.0
    return np.rint(alpha * picture[..., :3] + 255.0 * (1.0 - alpha)).astype(np.uint8)


def name(kind: str) -> str:
    """Return the name of a file of now."""
    return f'muscle_{time.strftime("%Y%m%d_%H%M%S")}.{kind}'
