# SPDX-License-Identifier: Apache-2.0
"""Slider to drawn path: the viewer and its node, in a real browser without a window.

A slider is held and moved, again and again, after a rest: the time from the pointer's move, as the
browser stamps it, until the pixels of the first frame with another path can be read back. With
and without smoothed edges, which cost a browser without a graphics card several times as much.
Prints JSON: s, or why there is none.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from typing import Any

import numpy as np
from browser import CHROMIUM, LINES, WINDOW, Page, open_browser, wait_until

COUNT = 60
WARMING = 10  # before them: shaders and the page are compiled with the first frames
PAUSES = np.random.default_rng(0).uniform(600.0, 1800.0, WARMING + COUNT)  # ms of rest
PIXELS = 1.0  # drawn for each of the page's
PLACES = (20.0, 60.0)  # deg, in turn
WATCH = f"""() => {{
  const find = {LINES}, name = '/deltoid/bands/lines';
  const node = () => window.__viserMutable.nodeRefFromName[name];
  const before = find(name);
  let done = false;  // a hook of an earlier move is still there
  window.taken = null;
  addEventListener('pointermove', event => {{
    const hook = () => node().traverse(each => {{
      each.onAfterRender = (renderer, scene, camera, geometry) => {{
        if (done || geometry === before || !geometry.attributes.instanceStart) return;
        done = true;
        queueMicrotask(() => {{
          renderer.getContext().readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
          window.taken = performance.now() - event.timeStamp;
        }});
      }};
    }});
    const tick = () => {{
      hook();
      if (!done) requestAnimationFrame(tick);
    }};
    tick();
  }}, {{capture: true, once: true}});
}}"""

DRAWN_BY = """() => {
  const canvas = window.__viserMutable.canvas, gl = canvas.getContext('webgl2');
  const name = gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL;
  const found = gl.getParameter(name);
  const software = ['llvmpipe', 'SwiftShader'].find(each => found.includes(each));
  return [software ? `software (${software})` : found, gl.getParameter(gl.SAMPLES),
    `${canvas.width} x ${canvas.height}`];
}"""


def measure_times(page: Page) -> list[float]:
    """Return the times of all moves, s."""
    page.hover_slider(0, PLACES[1])
    page.page.mouse.down()
    found = []
    for k in range(WARMING + COUNT):
        page.page.wait_for_timeout(PAUSES[k])
        page.page.evaluate(WATCH)
        page.hover_slider(0, PLACES[k % 2])
        page.page.wait_for_function('typeof window.taken === "number"')
        found.append(1e-3 * page.page.evaluate('window.taken'))
    return found[WARMING:]


def measure(smooth: bool) -> dict[str, Any]:
    """Return median, 95th percentile and worst, s, and what was drawn by what."""
    command = [sys.executable, '-m', 'linkedplane_ros.viewer', '--node', '--port', '0']
    viewer = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert viewer.stdout is not None
        found = re.search(r'open (http\S+)', viewer.stdout.readline())
        if not found:
            raise RuntimeError('the viewer did not start')
        with open_browser(smooth) as chromium:
            page = Page(chromium.new_page(viewport=WINDOW), found.group(1), PIXELS)
            page.press_button('neutral')  # nothing is shown before
            if not wait_until(lambda: len(page.lines()) > 0, 300.0):
                raise RuntimeError('the viewer shows no muscle')
            taken = measure_times(page)
            drawn_by, samples, pixels = page.page.evaluate(DRAWN_BY)
    finally:
        viewer.send_signal(signal.SIGINT)
        viewer.wait(10.0)
    median, p95, worst = np.quantile(taken, (0.5, 0.95, 1.0)).tolist()
    return {
        'median': median,
        'p95': p95,
        'worst': worst,
        'count': COUNT,
        'pixels': pixels,
        'samples': samples,
        'drawn by': drawn_by,
    }


def main() -> None:
    """Measure and print."""
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', str(os.getpid() % 100 + 1))
    if CHROMIUM is None:
        print(json.dumps('left out: chromium is not installed'))
        return
    try:
        print(json.dumps([measure(smooth) for smooth in (False, True)]))
    except ImportError as error:
        print(json.dumps(f'left out: {error}'))


if __name__ == '__main__':
    main()
