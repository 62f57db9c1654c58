# SPDX-License-Identifier: Apache-2.0
"""A real browser, without a window, that looks at the viewer: for the tests and the bench."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes.util import find_library
from pathlib import Path
from typing import Any

import numpy as np

UNIT = 10.0  # units of the viewer's scene in a metre
PATIENCE = 300.0  # s: the longest wait for anything
CHROMIUM = shutil.which('chromium')
# drawn in software: slow, but the same everywhere; Mesa, if installed, takes half the time
MESA = ['--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist']
SWIFTSHADER = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']
DRIVERS = Path('/usr/lib').glob('*/dri/swrast_dri.so')
DRAWING = MESA if find_library('EGL_mesa') and any(DRIVERS) else SWIFTSHADER
SOFTWARE = {'EGL_PLATFORM': 'surfaceless', 'LIBGL_ALWAYS_SOFTWARE': '1'}
# the rest of the page is faster without the emulated graphics card
PLAIN = ['--disable-gpu-rasterization', '--disable-gpu-compositing']
# what Chromium does with slow cards: edges are not smoothed
ROUGH = ['--disable_chromium_framebuffer_multisample']
ALONE = ['--no-sandbox', '--disable-background-networking', '--disable-component-update']
CHANGE = b'GuiUpdate'  # in what the page sends when a control of its panel has changed
WINDOW = {'width': 1280, 'height': 720}
LINES = """name => {
  const node = window.__viserMutable?.nodeRefFromName[name];
  let found = null;
  node?.traverse(each => { found ??= each.geometry?.attributes.instanceStart ? each : null; });
  return found?.geometry ?? null;
}"""
PLOTS = """() => Object.values(window.__viserTestpoints?.uplots ?? {})
  .map(each => Array.from(each.chart.data, column => Array.from(column)))"""

MATRICES = """name => {
  const {camera, nodeRefFromName} = window.__viserMutable;
  const used = [camera.projectionMatrix, camera.matrixWorldInverse,
    nodeRefFromName[name].matrixWorld];
  return used.map(each => each.elements);
}"""
RANGES = """() => Object.values(window.__viserTestpoints?.uplots ?? {})
  .map(({chart: {scales: {x, y}}}) => [x.min, x.max, y.min, y.max])"""


class Page:
    """A page of the browser at the viewer."""

    def __init__(self, page: Any, url: str, dpr: float = 0.3) -> None:
        """Load it; `dpr` pixels are drawn for one of the page, few for speed."""
        self.page = page
        self.errors: list[str] = []
        self._changes = 0
        self.requests: list[str] = []
        page.on('pageerror', lambda error: self.errors.append(str(error)))
        page.on('console', self._on_console)
        page.on('request', lambda request: self.requests.append(request.url))
        page.on('websocket', self._on_websocket)
        page.set_default_timeout(1e3 * PATIENCE)
        page.goto(f'{url}&fixedDpr={dpr}' if url.startswith('http') else url)

    def _on_console(self, message: Any) -> None:
        if message.type == 'error':
            self.errors.append(message.text)

    def _on_websocket(self, socket: Any) -> None:
        self.requests.append(socket.url)
        socket.on('framesent', self._on_frame_sent)

    def _on_frame_sent(self, frame: str | bytes) -> None:
        self._changes += isinstance(frame, bytes) and CHANGE in frame

    def lines(self, name: str = '/deltoid/bands/lines') -> np.ndarray:
        """Return the lines of a name in the scene: (m, 2, 3), m; empty if there are none."""
        script = f'name => Array.from(({LINES})(name)?.attributes.instanceStart.data.array ?? [])'
        return np.array(self.page.evaluate(script, name)).reshape(-1, 2, 3) / UNIT

    def colours(self, name: str = '/deltoid/bands/lines') -> np.ndarray:
        """Return the colours of the lines' ends, (m, 2, 3) in 0..1, linear in light."""
        script = f'name => Array.from(({LINES})(name).attributes.instanceColorStart.data.array)'
        return np.array(self.page.evaluate(script, name)).reshape(-1, 2, 3)

    def project_points(self, points: np.ndarray, name: str = '/deltoid') -> np.ndarray:
        """Return where points (k, 3), m, of a frame are seen: (k, 2), -1..1 to the right and up."""
        project, view, place = (
            np.array(each).reshape(4, 4).T for each in self.page.evaluate(MATRICES, name)
        )
        seen = np.column_stack((UNIT * points, np.ones(len(points)))) @ (project @ view @ place).T
        return np.asarray(seen[:, :2] / seen[:, 3:])

    def plots(self) -> list[np.ndarray]:
        """Return the columns of each visible plot, x first."""
        return [np.array(columns, dtype=float) for columns in self.page.evaluate(PLOTS)]

    def plot_ranges(self) -> np.ndarray:
        """Return the ends of the axes of each plot: of x, then of y (k, 4)."""
        return np.array(self.page.evaluate(RANGES), dtype=float).reshape(-1, 4)

    def frame_count(self) -> int:
        """Return how often the scene was drawn."""
        return int(self.page.evaluate('window.__viserTestpoints.rendererInfo.render.frame'))

    @contextmanager
    def expect_change(self) -> Iterator[None]:
        """Wait until the change made here is sent: the library keeps only the last one of 50 ms."""
        before = self._changes
        yield
        if not wait_until(lambda: self._changes > before, wait=self.page.wait_for_timeout):
            raise TimeoutError('nothing was sent')

    def press_button(self, text: str) -> None:
        """Press a button, even while it moves on a slow machine."""
        with self.expect_change():
            self.open_tab(text)

    def open_tab(self, text: str) -> None:
        """Press a tab, which changes only what this page shows."""
        self.page.get_by_text(text, exact=True).first.click(force=True)

    def toggle(self, label: str) -> None:
        """Press the checkbox beside a label."""
        row = self.page.get_by_text(label, exact=True).first
        with self.expect_change():
            row.locator('xpath=following::input[@type="checkbox"][1]').dispatch_event('click')

    def choose_option(self, chosen: str, other: str) -> None:
        """Choose something else where something is chosen; a list out of sight would not open."""
        box = self.page.locator(f'input[value="{chosen}"]').first
        box.scroll_into_view_if_needed()
        box.dispatch_event('click')
        with self.expect_change():
            self.page.get_by_role('option', name=other, exact=True).dispatch_event('click')

    def hover_slider(self, slider: int, degrees: float) -> None:
        """Move the pointer to about so many degrees on the track of a slider."""
        thumb = self.page.locator('[role=slider]').nth(slider)
        low, high = (float(thumb.get_attribute(f'aria-value{end}')) for end in ('min', 'max'))
        track = self.page.locator('.mantine-Slider-track').nth(slider).bounding_box()
        part = (degrees - low) / (high - low)
        middle = track['y'] + 0.5 * track['height']
        self.page.mouse.move(track['x'] + part * track['width'], middle)

    def move_slider(self, slider: int, degrees: float) -> None:
        """Move a slider: press its track at about so many degrees."""
        self.hover_slider(slider, degrees)
        with self.expect_change():
            self.page.mouse.down()
            self.page.mouse.up()

    def type_number(self, slider: int, number: str) -> None:
        """Type a number into the box beside a slider."""
        box = self.page.locator('.mantine-NumberInput-root input').nth(slider)
        with self.expect_change():
            box.fill(number)
        box.blur()

    def slider_angles(self) -> np.ndarray:
        """Return the angles of the sliders, rad."""
        thumbs = self.page.locator('[role=slider]').all()
        return np.radians([float(thumb.get_attribute('aria-valuenow')) for thumb in thumbs[:3]])


@contextmanager
def open_browser(smooth: bool = False) -> Iterator[Any]:
    """Run the browser; edges are `smooth` by multisampling, which is slow in software."""
    from playwright.sync_api import sync_playwright

    arguments = [*DRAWING, *PLAIN, *([] if smooth else ROUGH), *ALONE]
    environment = {**os.environ, **SOFTWARE}
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM, args=arguments, env=environment, timeout=1e3 * PATIENCE
        )
        yield chromium
        chromium.close()


def wait_until(
    condition: Callable[[], bool],
    seconds: float = PATIENCE,
    wait: Callable[[float], None] = lambda milliseconds: time.sleep(1e-3 * milliseconds),
) -> bool:
    """Wait until a condition holds; return whether it did in time."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        wait(50.0)
    return True
