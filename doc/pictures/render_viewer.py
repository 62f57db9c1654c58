# SPDX-License-Identifier: Apache-2.0
"""Take the pictures of the viewer from the viewer itself: four poses and an animation.

Both nodes, the viewer and a browser without a window are started here. Needs chromium and the
extras viewer and test.
"""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / 'bench'))

import numpy as np  # noqa: E402
from browser import WINDOW, Page, open_browser, wait_until  # noqa: E402
from PIL import Image  # noqa: E402

CONNECTED = '.tabler-icon-cloud-check'
DETAILS = ('obstacle spheres', 'interference spheres', 'band planes')
FRAMES, STEP = 48, 80  # of the animation, ms
SMALL = (720, 405)  # px
TOPICS = ['--topic', '/muscle_viewer/joint_states', '--topic', '/left/joint_states']
MODULE = [sys.executable, '-m']
LEFT = [
    *MODULE,
    'linkedplane_ros.node',
    '--ros-args',
    '-r',
    '__ns:=/left',
    '-p',
    'side:=left',
]


@contextmanager
def run_viewer() -> Iterator[str]:
    """Run the viewer and its node; give its address."""
    command = [*MODULE, 'linkedplane_ros.viewer', '--node', '--port', '0', *TOPICS]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    found = re.search(r'open (http\S+)', process.stdout.readline())
    assert found is not None
    try:
        yield found.group(1)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20.0)


def wait_for_rest(page: Page) -> bytes:
    """Wait until the page is connected and does not change any more; return its picture, a PNG."""
    before = b''

    def is_at_rest() -> bool:
        nonlocal before
        last, before = before, page.page.screenshot()
        return before == last and page.page.locator(CONNECTED).count() == 1

    # between two of the viewer's signs of life, which move the plots on
    if not wait_until(is_at_rest, wait=lambda _: page.page.wait_for_timeout(400.0)):
        raise TimeoutError('the page did not come to rest')
    return before


def wait_for_angles(page: Page, degrees: tuple[float, ...]) -> None:
    """Wait until the sliders stand there."""
    if not wait_until(lambda: np.allclose(np.degrees(page.slider_angles()), degrees, atol=0.1)):
        raise TimeoutError(f'the sliders did not come to {degrees}')


def save_still(page: Page, name: str) -> None:
    """Save the page as it is."""
    path = HERE / f'viewer_{name}.png'
    picture = Image.open(io.BytesIO(wait_for_rest(page))).convert('RGB')
    picture.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    print(path, path.stat().st_size)


def close_notice(page: Page) -> None:
    """Close the notice that this browser draws in software."""
    notice = page.page.locator('.mantine-Notification-closeButton')
    wait_until(lambda: notice.count() > 0, 20.0)
    if notice.count():
        notice.first.dispatch_event('click')


def take_stills(page: Page) -> None:
    """Take three poses, each with something else to be seen."""
    page.press_button('abduction 90')
    wait_for_angles(page, (0.0, 90.0, 0.0))
    page.press_button('neutral')
    wait_for_angles(page, (0.0, 0.0, 0.0))
    save_still(page, 'neutral')
    page.choose_option('time', 'coordinate')
    page.choose_option('head', 'moment arm')
    page.press_button('play a sweep')
    for low_and_high in (-39.0, 119.0, -39.0):
        wait_until(lambda end=low_and_high: (np.degrees(page.slider_angles()[0]) - end) * end > 0.0)
    page.press_button('flexion 80')
    wait_for_angles(page, (80.0, 0.0, 0.0))
    save_still(page, 'flexion')
    page.choose_option('moment arm', 'head')
    page.press_button('abduction 90')
    wait_for_angles(page, (0.0, 90.0, 0.0))
    page.open_tab('look')
    for label in DETAILS:
        page.toggle(label)
    page.open_tab('bands')
    save_still(page, 'abduction')
    page.open_tab('look')
    for label in DETAILS:
        page.toggle(label)


def take_animation(page: Page) -> None:
    """Raise the arm and lower it again, a slider's step at a time."""
    page.press_button('neutral')
    wait_for_angles(page, (0.0, 0.0, 0.0))
    page.open_tab('plots')
    page.choose_option('flexion', 'abduction')
    page.press_button('clear the plots')
    for first in ('1', '0'):  # a plot is there from its second point on
        page.type_number(1, first)
        wait_for_angles(page, (0.0, float(first), 0.0))
    frames: list[Any] = []
    for k in range(FRAMES):
        elevation = 55.0 * (1.0 - np.cos(2.0 * np.pi * k / FRAMES))
        page.type_number(1, f'{elevation:.1f}')
        wait_for_angles(page, (0.0, elevation, 0.0))
        picture = Image.open(io.BytesIO(wait_for_rest(page))).convert('RGB')
        frames.append(picture.resize(SMALL, Image.Resampling.LANCZOS))
    palette = frames[FRAMES // 2].quantize(256, Image.Quantize.MEDIANCUT, kmeans=2)
    small = [each.quantize(palette=palette, dither=Image.Dither.NONE) for each in frames]
    path = HERE / 'viewer.gif'
    small[0].save(path, save_all=True, append_images=small[1:], duration=STEP, loop=0)
    print(path, path.stat().st_size)


def take_both_shoulders(page: Page, chromium: Any, url: str) -> None:
    """Take both shoulders, in the dark."""
    left = subprocess.Popen(LEFT)
    try:
        page.open_tab('left deltoid')
        page.page.get_by_text('neutral', exact=True).last.click(force=True)
        wait_until(lambda: len(page.lines('/left/deltoid/bands/lines')) > 0)
        page.page.close()
        fresh = Page(chromium.new_page(viewport=WINDOW), url, 1.0)
        wait_until(lambda: len(fresh.lines('/left/deltoid/bands/lines')) > 0)
        close_notice(fresh)
        fresh.open_tab('look')
        fresh.toggle('dark')
        fresh.open_tab('plots')
        fresh.press_button('scaption 60')
        fresh.open_tab('left deltoid')
        with fresh.expect_change():
            fresh.page.get_by_text('abduction 90', exact=True).last.click(force=True)
        save_still(fresh, 'scaption')
    finally:
        left.send_signal(signal.SIGINT)
        left.wait(20.0)


def main() -> None:
    """Take all of them."""
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', str(os.getpid() % 100 + 1))
    with run_viewer() as url, open_browser(smooth=True) as chromium:
        page = Page(chromium.new_page(viewport=WINDOW), url, 1.0)
        page.press_button('neutral')  # nothing is shown before
        wait_until(lambda: len(page.lines()) > 0 and len(page.plots()) == 2)
        close_notice(page)
        take_stills(page)
        take_animation(page)
        take_both_shoulders(page, chromium, url)


if __name__ == '__main__':
    main()
