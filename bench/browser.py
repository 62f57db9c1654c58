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
PATIENCE = 60.0  # s: the longest that anything is waited for
CHROMIUM = shutil.which('chromium')
# drawn in software: slow, but the same everywhere; Mesa, where it is, takes half the time
MESA = ['--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist']
SWIFTSHADER = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']
DRIVERS = Path('/usr/lib').glob('*/dri/swrast_dri.so')
DRAWING = MESA if find_library('EGL_mesa') and any(DRIVERS) else SWIFTSHADER
SOFTWARE = {'EGL_PLATFORM': 'surfaceless', 'LIBGL_ALWAYS_SOFTWARE': '1'}
# the rest of the page is quicker without what stands in for a graphics card
PLAIN = ['--disable-gpu-rasterization', '--disable-gpu-compositing']
# Chromium's own way with cards that are slow at it: edges are not smoothed
ROUGH = ['--disable_chromium_framebuffer_multisample']
ALONE = ['--no-sandbox', '--disable-background-networking', '--disable-component-update']
TOLD = b'GuiUpdate'  # in what the page sends when something on its panel has changed
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
REACHES = """() => Object.values(window.__viserTestpoints?.uplots ?? {})
  .map(({chart: {scales: {x, y}}}) => [x.min, x.max, y.min, y.max])"""


class Page:
    """A page of the browser at the viewer."""

    def __init__(self, page: Any, url: str, dpr: float = 0.3) -> None:
        """Load it; so many pixels are drawn for one of the page's, few to be quick."""
        self.page = page
        self.errors: list[str] = []
        self._told = 0
        self.requests: list[str] = []
        page.on('pageerror', lambda error: self.errors.append(str(error)))
        page.on('console', self._said)
        page.on('request', lambda request: self.requests.append(request.url))
        page.on('websocket', self._connected)
        page.set_default_timeout(1e3 * PATIENCE)
        page.goto(f'{url}/?fixedDpr={dpr}' if url.startswith('http') else url)

    def _said(self, message: Any) -> None:
        if message.type == 'error':
            self.errors.append(message.text)

    def _connected(self, socket: Any) -> None:
        self.requests.append(socket.url)
        socket.on('framesent', self._sent)

    def _sent(self, frame: str | bytes) -> None:
        self._told += isinstance(frame, bytes) and TOLD in frame

    def lines(self, name: str = '/deltoid/bands/lines') -> np.ndarray:
        """Return what the scene holds of lines: (m, 2, 3), m; none where they are not there."""
        script = f'name => Array.from(({LINES})(name)?.attributes.instanceStart.data.array ?? [])'
        return np.array(self.page.evaluate(script, name)).reshape(-1, 2, 3) / UNIT

    def colours(self, name: str = '/deltoid/bands/lines') -> np.ndarray:
        """Return the colours of the lines' ends, (m, 2, 3) in 0..1, linear in light."""
        script = f'name => Array.from(({LINES})(name).attributes.instanceColorStart.data.array)'
        return np.array(self.page.evaluate(script, name)).reshape(-1, 2, 3)

    def places(self, points: np.ndarray, name: str = '/deltoid') -> np.ndarray:
        """Return where points (k, 3), m, of a frame are seen: (k, 2), -1..1 from the left, up."""
        project, see, put = (
            np.array(each).reshape(4, 4).T for each in self.page.evaluate(MATRICES, name)
        )
        seen = np.column_stack((UNIT * points, np.ones(len(points)))) @ (project @ see @ put).T
        return np.asarray(seen[:, :2] / seen[:, 3:])

    def plots(self) -> list[np.ndarray]:
        """Return the columns of each plot that is to be seen, x first."""
        return [np.array(columns, dtype=float) for columns in self.page.evaluate(PLOTS)]

    def reaches(self) -> np.ndarray:
        """Return from where to where each plot reaches: across, then up (k, 4)."""
        return np.array(self.page.evaluate(REACHES), dtype=float).reshape(-1, 4)

    def frames(self) -> int:
        """Return how often the scene was drawn."""
        return int(self.page.evaluate('window.__viserTestpoints.rendererInfo.render.frame'))

    @contextmanager
    def telling(self) -> Iterator[None]:
        """Wait until what is done here is sent: the library keeps but the last change of 50 ms."""
        before = self._told
        yield
        if not until(lambda: self._told > before, wait=self.page.wait_for_timeout):
            raise TimeoutError('nothing was sent')

    def press(self, text: str) -> None:
        """Press a button; a slow machine is not asked to hold still for it."""
        with self.telling():
            self.turn_to(text)

    def turn_to(self, text: str) -> None:
        """Press what bears a text and changes nothing but what this page shows: a tab."""
        self.page.get_by_text(text, exact=True).first.click(force=True)

    def tick(self, label: str) -> None:
        """Press the checkbox beside a label."""
        row = self.page.get_by_text(label, exact=True).first
        with self.telling():
            row.locator('xpath=following::input[@type="checkbox"][1]').dispatch_event('click')

    def choose(self, chosen: str, other: str) -> None:
        """Choose something else where something is chosen; a list out of sight would not open."""
        box = self.page.locator(f'input[value="{chosen}"]').first
        box.scroll_into_view_if_needed()
        box.dispatch_event('click')
        with self.telling():
            self.page.get_by_role('option', name=other, exact=True).dispatch_event('click')

    def reach(self, slider: int, degrees: float) -> None:
        """Take the pointer where about so many degrees are on a slider's track."""
        thumb = self.page.locator('[role=slider]').nth(slider)
        low, high = (float(thumb.get_attribute(f'aria-value{end}')) for end in ('min', 'max'))
        track = self.page.locator('.mantine-Slider-track').nth(slider).bounding_box()
        part = (degrees - low) / (high - low)
        middle = track['y'] + 0.5 * track['height']
        self.page.mouse.move(track['x'] + part * track['width'], middle)

    def slide(self, slider: int, degrees: float) -> None:
        """Move a slider: press its track where about so many degrees are."""
        self.reach(slider, degrees)
        with self.telling():
            self.page.mouse.down()
            self.page.mouse.up()

    def type(self, slider: int, number: str) -> None:
        """Type a number beside a slider, and leave it at that."""
        box = self.page.locator('.mantine-NumberInput-root input').nth(slider)
        with self.telling():
            box.fill(number)
        box.blur()

    def angles(self) -> np.ndarray:
        """Return where the sliders stand, rad."""
        thumbs = self.page.locator('[role=slider]').all()
        return np.radians([float(thumb.get_attribute('aria-valuenow')) for thumb in thumbs[:3]])


@contextmanager
def browser(smooth: bool = False) -> Iterator[Any]:
    """Run the browser; edges are `smooth` by multisampling, which is slow in software."""
    from playwright.sync_api import sync_playwright

    arguments = [*DRAWING, *PLAIN, *([] if smooth else ROUGH), *ALONE]
    environment = {**os.environ, **SOFTWARE}
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=CHROMIUM, args=arguments, env=environment)
        yield made
        made.close()


def until(
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
