# SPDX-License-Identifier: Apache-2.0
"""Saving the scene: a still, and a recording that opens in a browser without this program."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from ..scene.camera import aspect_ratio

HEIGHT = 1080  # px of a still
LONGEST = 120.0  # s of a recording; record a bag for more
RECORD, STOP = 'record', 'stop recording'


class Saving:
    """Buttons that save what a browser shows, as downloads of that browser."""

    def __init__(
        self, server: viser.ViserServer, gui: viser.GuiApi, dark: Callable[[], bool]
    ) -> None:
        """Add them to the open part of the GUI; `dark()` returns whether the page is dark."""
        self._server = server
        self._dark = dark
        self._recording: Any = None
        self._begun = self._last = 0.0
        gui.add_markdown('Both are downloads; a recording opens without a server.')
        still = gui.add_button('still (PNG)')
        self._record = gui.add_button(RECORD)
        still.on_click(self._on_still)
        self._record.on_click(self._on_record)

    def _on_still(self, event: Any) -> None:
        import imageio.v3

        client = event.client
        if client is None:
            return
        camera = client.camera
        width = round(HEIGHT * aspect_ratio(camera))
        picture = client.get_render(HEIGHT, width, transport_format='png', timeout=60.0)
        content = imageio.v3.imwrite('<bytes>', flatten_on_white(picture), extension='.png')
        client.send_file_download(file_name('png'), content, save_immediately=True)

    async def _on_record(self, _: Any) -> None:
        if self._recording is None:
            self._begun = self._last = time.monotonic()
            self._recording = self._server.get_scene_serializer()
            self._record.label = STOP
        else:
            await self._finish_recording()

    async def _finish_recording(self) -> None:
        """Send the recording; packing takes a while."""
        recording, self._recording = self._recording, None
        self._record.label = RECORD
        content = await asyncio.to_thread(recording.as_html, self._dark())
        self._server.send_file_download(file_name('html'), content.encode(), save_immediately=True)

    async def record_frame(self, now: float) -> None:
        """Record the time since the last frame, if a recording is under way."""
        if self._recording is None:
            return
        self._recording.insert_sleep(max(now - self._last, 0.0))
        self._last = now
        if now > self._begun + LONGEST:
            await self._finish_recording()


def flatten_on_white(picture: Any) -> Any:
    """Return a picture (h, w, 4) on a white ground, (h, w, 3)."""
    alpha = picture[..., 3:] / 255.0
    return np.rint(alpha * picture[..., :3] + 255.0 * (1.0 - alpha)).astype(np.uint8)


def file_name(kind: str) -> str:
    """Return a file name with the time of day."""
    return f'muscle_{time.strftime("%Y%m%d_%H%M%S")}.{kind}'
