"""A real browser, without a window, that looks at the viewer: for the tests and the bench."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

PATIENCE = 60.0  # s: the longest that anything is waited for
CHROMIUM = shutil.which('chromium')
# drawn in software: slow, but the same everywhere
DRAWING = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']
# the rest of the page is quicker without what stands in for a graphics card
DRAWING += ['--disable-gpu-rasterization', '--disable-gpu-compositing']
ALONE = ['--no-sandbox', '--disable-background-networking', '--disable-component-update']
HELD_BACK = 100.0  # ms: the library holds a change back for 50 ms; another one then undoes it
WINDOW = {'width': 1280, 'height': 720}
LINES = """name => {
  const node = window.__viserMutable?.nodeRefFromName[name];
  let found = null;
  node?.traverse(each => { found ??= each.geometry?.attributes.instanceStart ? each : null; });
  return found?.geometry ?? null;
}"""
PLOTS = """() => Object.values(window.__viserTestpoints?.uplots ?? {})
  .map(each => Array.from(each.chart.data, column => Array.from(column)))"""


class Page:
    """A page of the browser at the viewer."""

    def __init__(self, page: Any, url: str, dpr: float = 0.3) -> None:
        """Load it; so many pixels are drawn for one of the page's, few to be quick."""
        self.page = page
        self.errors: list[str] = []
        self.requests: list[str] = []
        page.on('pageerror', lambda error: self.errors.append(str(error)))
        page.on('console', self._said)
        page.on('request', lambda request: self.requests.append(request.url))
        page.on('websocket', lambda socket: self.requests.append(socket.url))
        page.set_default_timeout(1e3 * PATIENCE)
        page.goto(f'{url}/?fixedDpr={dpr}' if url.startswith('http') else url)

    def _said(self, message: Any) -> None:
        if message.type == 'error':
            self.errors.append(message.text)

    def lines(self, name: str = '/deltoid/bands/lines') -> np.ndarray:
        """Return what the scene holds of lines: (m, 2, 3), m; none where they are not there."""
        script = f'name => Array.from(({LINES})(name)?.attributes.instanceStart.data.array ?? [])'
        return np.array(self.page.evaluate(script, name)).reshape(-1, 2, 3)

    def colours(self, name: str = '/deltoid/bands/lines') -> np.ndarray:
        """Return the colours of the lines' ends, (m, 2, 3) in 0..1, linear in light."""
        script = f'name => Array.from(({LINES})(name).attributes.instanceColorStart.data.array)'
        return np.array(self.page.evaluate(script, name)).reshape(-1, 2, 3)

    def plots(self) -> list[np.ndarray]:
        """Return the columns of each plot that is to be seen, x first."""
        return [np.array(columns, dtype=float) for columns in self.page.evaluate(PLOTS)]

    def frames(self) -> int:
        """Return how often the scene was drawn."""
        return int(self.page.evaluate('window.__viserTestpoints.rendererInfo.render.frame'))

    def press(self, text: str) -> None:
        """Press what bears a text; a slow machine is not asked to hold still for it."""
        self.page.get_by_text(text, exact=True).first.click(force=True)
        self.page.wait_for_timeout(HELD_BACK)

    def tick(self, label: str) -> None:
        """Press the checkbox beside a label."""
        row = self.page.get_by_text(label, exact=True).first
        row.locator('xpath=following::input[@type="checkbox"][1]').dispatch_event('click')
        self.page.wait_for_timeout(HELD_BACK)

    def choose(self, chosen: str, other: str) -> None:
        """Choose something else where something is chosen."""
        self.page.locator(f'input[value="{chosen}"]').first.dispatch_event('click')
        self.page.get_by_role('option', name=other, exact=True).dispatch_event('click')
        self.page.wait_for_timeout(HELD_BACK)

    def slide(self, slider: int, degrees: float) -> None:
        """Move a slider: press its track where about so many degrees are."""
        thumb = self.page.locator('[role=slider]').nth(slider)
        low, high = (float(thumb.get_attribute(f'aria-value{end}')) for end in ('min', 'max'))
        track = self.page.locator('.mantine-Slider-track').nth(slider).bounding_box()
        part = (degrees - low) / (high - low)
        middle = track['y'] + 0.5 * track['height']
        self.page.mouse.click(track['x'] + part * track['width'], middle)
        pixel = (high - low) / track['width']
        until(lambda: abs(float(thumb.get_attribute('aria-valuenow')) - degrees) < 2.0 * pixel)
        self.page.wait_for_timeout(HELD_BACK)

    def angles(self) -> np.ndarray:
        """Return where the sliders stand, rad."""
        thumbs = self.page.locator('[role=slider]').all()
        return np.radians([float(thumb.get_attribute('aria-valuenow')) for thumb in thumbs[:3]])


@contextmanager
def browser() -> Iterator[Any]:
    """Run the browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=CHROMIUM, args=[*DRAWING, *ALONE])
        yield made
        made.close()


def until(condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
    """Wait until a condition holds; return whether it did in time."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True
