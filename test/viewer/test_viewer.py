"""The viewer as a person meets it: in a real browser, over the loopback device, beside the node."""

from __future__ import annotations

import importlib.util
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from browser import CHROMIUM, WINDOW, Page, browser, until
from ros_harness import NodeProcess, Peer, together

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, MuscleState
from linkedplane_ros.drawing.bones import shaft_axis
from linkedplane_ros.drawing.colours import HEAD_COLOURS
from linkedplane_ros.viewer.panels.motions import poses
from linkedplane_ros.viewer.scene import colour_map

MISSING = next(
    (f'{what} is not installed: {cure}' for what, there, cure in (
        ('chromium', CHROMIUM, 'apt-get install chromium'),
        ('playwright', importlib.util.find_spec('playwright'), 'pip install playwright'),
        ('viser', importlib.util.find_spec('viser'), "pip install 'linkedplane_ros[viewer]'"),
    ) if not there),
    '',
)  # fmt: skip
pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]

DELTOID = BroadMuscle.load('deltoid')
SOLVER = LinkedPlaneSolver(DELTOID)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
DRAWN = 1e-7  # m: coordinates below 0.25 m in single precision
HEADS = (1, 3, 7)
TABLET = {'width': 768, 'height': 1024}


class ViewerProcess(NodeProcess):
    """The viewer as users run it; its output is kept."""

    def __init__(self, log: Path, *arguments: str) -> None:
        """Start it on a port that is free, and wait until it says where it listens."""
        self.log = log
        command = [sys.executable, '-m', 'linkedplane_ros.viewer', '--port', '0', *arguments]
        with log.open('wb') as out:
            self.process = subprocess.Popen(command, stdout=out, stderr=out)
        assert until(lambda: 'open http' in self.text or self.process.poll() is not None)
        found = re.search(r'open (http\S+)', self.text)
        assert found, self.text
        self.url = found.group(1)


class Stage:
    """The node, the viewer and a page of the browser."""

    def __init__(self, folder: Path, chromium: Any) -> None:
        self.folder = folder
        self.chromium = chromium
        self.node = NodeProcess(folder / 'node.log', **{'markers.rate': 0.0})
        self.viewer = ViewerProcess(folder / 'viewer.log')
        self.page = self.open()
        assert until(lambda: len(self.page.lines()) > 0), self.viewer.text

    def open(self, dpr: float = 0.3) -> Page:
        return Page(self.chromium.new_page(viewport=WINDOW), self.viewer.url, dpr)

    def shows(self, state: MuscleState, page: Page | None = None) -> bool:
        """Wait until the scene of a page is that of a state; return whether it was."""
        paths = [np.stack((path[:-1], path[1:]), axis=1) for path in state.paths(16)]
        wanted = np.concatenate(paths)

        def equal() -> bool:
            drawn = (page or self.page).lines()
            return drawn.shape == wanted.shape and bool(np.abs(drawn - wanted).max() < DRAWN)

        return until(equal)


@pytest.fixture(scope='module')
def stage(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stage]:
    """Run all of it once, for all tests of this file.

    At the end the page must have had no error, and asked for nothing beyond this machine.
    """
    folder = tmp_path_factory.mktemp('viewer')
    with browser() as chromium:
        made = Stage(folder, chromium)
        yield made
        assert made.page.errors == []
        hosts = {urlsplit(url).hostname for url in made.page.requests}
        assert '127.0.0.1' in hosts
        assert hosts <= {'127.0.0.1', None}  # None: a blob of the page's own
        assert made.viewer.stop() == 0, made.viewer.text
        assert made.node.stop() == 0
    assert 'Traceback' not in made.viewer.text


def state_at(angles: Any) -> MuscleState:
    return SOLVER.solve(THESIS.rotation(angles))


def test_a_slider_moves_the_arm_and_the_scene_is_the_solvers_path(stage: Stage) -> None:
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    stage.page.slide(0, 40.0)
    stage.page.slide(1, 20.0)
    angles = stage.page.angles()
    # a track is some 120 pixels long: 1.3 deg a pixel
    np.testing.assert_allclose(np.degrees(angles), (40.0, 20.0, 0.0), atol=2.7)
    assert stage.shows(state_at(angles))


def test_a_number_beyond_the_range_is_taken_as_its_end(stage: Stage) -> None:
    stage.page.press('neutral')
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    stage.page.type(1, '999')
    assert stage.shows(state_at((0.0, DELTOID.range_of_motion[1][1], 0.0)))
    assert 'not used' not in stage.node.text  # 999 deg would have been refused
    stage.page.type(1, '30')
    assert stage.shows(state_at((0.0, np.radians(30.0), 0.0)))


def test_the_plots_grow_by_the_lengths_and_arms_of_the_heads(stage: Stage) -> None:
    page = stage.page
    assert until(lambda: len(page.plots()) == 2)
    before = page.plots()[0][0, -1]  # s
    page.slide(0, 30.0)
    angles = page.angles()
    state = state_at(angles)
    lengths = 1e3 * state.lengths[list(HEADS)]
    arms = 1e3 * (state.moment_vectors @ THESIS.axes(angles))[list(HEADS), 0]

    def newest() -> bool:
        rows = [columns[1:, -1] for columns in page.plots()]
        # mm; the same numbers, but for the rounding of another product
        return np.allclose(rows[0], lengths, atol=1e-9) and np.allclose(rows[1], arms, atol=1e-9)

    assert until(newest)
    assert page.plots()[0][0, -1] > before
    assert all_lines_are_seen(page)


def all_lines_are_seen(page: Page) -> bool:
    """Return whether the plots come to have room for all that is in them."""

    def room() -> bool:
        found = zip(page.plots(), page.reaches(), strict=True)
        return all(
            (first, last) == (columns[0][0], columns[0][-1])
            and low < np.nanmin(columns[1:])
            and np.nanmax(columns[1:]) < high
            for columns, (first, last, low, high) in found
        )

    return until(room)


def test_a_button_takes_the_arm_to_an_end_pose_of_the_case_study(stage: Stage) -> None:
    stage.page.press('scaption 60')
    assert stage.shows(state_at(poses(THESIS)['scaption 60']))
    # sliders are shown to a tenth of a degree
    assert until(
        lambda: np.allclose(
            stage.page.angles(), poses(THESIS)['scaption 60'], atol=np.radians(0.06)
        )
    )


def test_bands_take_the_colour_of_their_moment_arm(stage: Stage) -> None:
    page = stage.page
    page.press('scaption 60')
    page.choose('head', 'moment arm')
    state = state_at(poses(THESIS)['scaption 60'])
    arms = 1e3 * (state.moment_vectors @ THESIS.axes(poses(THESIS)['scaption 60']))[:, 0]
    assert until(lambda: page.page.get_by_text('moment arm about flexion, mm').count() > 0)
    most = max(
        float(text.removeprefix('+'))
        for text in page.page.locator('span:text-matches("^[+][0-9]+$")').all_inner_texts()
    )
    counts = [len(path) - 1 for path in state.paths(16)]
    wanted = np.repeat(colour_map.colours(arms, most), counts, axis=0) / 255.0

    def painted() -> bool:
        light = page.colours()[:, 0]
        shown = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        # the library takes 256 steps of light: dark colours are coarse
        return len(shown) == len(wanted) and bool(np.abs(shown - wanted).max() < 0.05)

    assert until(painted)
    page.choose('moment arm', 'head')


def test_all_of_the_muscle_is_in_the_picture_of_a_tablet_too_with_lateral_on_its_left(
    stage: Stage,
) -> None:
    tablet = stage.chromium.new_context(viewport=TABLET, has_touch=True).new_page()
    pages = [stage.page, Page(tablet, stage.viewer.url)]
    centre = np.zeros(3)
    for pose, angles in poses(THESIS).items():
        stage.page.press(pose)
        state = state_at(angles)
        arm = np.vstack((*state.paths(16), shaft_axis(DELTOID) @ state.rotation.T))
        for page in pages:
            assert stage.shows(state, page)
            assert until(lambda page=page, arm=arm: bool(np.abs(page.places(arm)).max() < 0.95))
            middle, lateral, superior = page.places(np.array((centre, (0.1, 0, 0), (0, 0, 0.1))))
            assert lateral[0] < middle[0]
            assert superior[1] > middle[1]
        assert np.ptp(stage.page.places(arm), axis=0).max() > 0.5  # of 2: not lost in the picture
    tablet.close()


def heads_seen(picture: bytes) -> bool:
    """Return whether a PNG has the colour of each head; the library's tone adds up to 15 of 255."""
    import imageio.v3

    colours = imageio.v3.imread(picture)[..., :3].astype(int)
    heads = [tuple(round(255 * part) for part in colour) for colour in HEAD_COLOURS[:3]]
    return all((np.abs(colours - head).max(axis=2) < 18).sum() > 20 for head in heads)


def test_the_bands_are_seen_in_the_colours_of_their_heads(stage: Stage) -> None:
    stage.page.press('neutral')
    scene = {'x': 0, 'y': 0, 'width': 900, 'height': 720}  # beside the panel and its legend
    assert until(lambda: heads_seen(stage.page.page.screenshot(clip=scene)))


def test_spheres_and_planes_are_there_on_demand(stage: Stage) -> None:
    page = stage.page
    names = ('obstacle_spheres/balls', 'interference_spheres/balls')

    def there(name: str) -> bool:
        return bool(
            page.page.evaluate(
                'name => window.__viserMutable.nodeRefFromName[name]?.visible ?? false', name
            )
        )

    page.turn_to('look')
    for name, label in zip(names, ('obstacle spheres', 'interference spheres'), strict=True):
        assert not there(f'/deltoid/{name}')
        page.tick(label)
        assert until(lambda name=name: there(f'/deltoid/{name}'))
        page.tick(label)
    page.turn_to('plots')


def test_the_sliders_follow_a_stream_when_they_are_told_to(stage: Stage, peer: Peer) -> None:
    with together(peer):
        assert peer.until(lambda: peer.publisher.get_subscription_count() > 1)
        stage.page.tick('follow the stream')
        angles = (0.5, 0.25, -0.3)

        def followed() -> bool:
            peer.send(THESIS.coordinates, angles, nanoseconds=time.time_ns())
            return bool(np.allclose(stage.page.angles(), angles, atol=np.radians(0.06)))

        assert until(followed)
        assert stage.shows(state_at(angles))
    stage.page.tick('follow the stream')


def test_a_stream_of_1_khz_is_drawn_at_the_screens_rate_and_its_end_is_what_is_shown(
    stage: Stage, peer: Peer
) -> None:
    # the node and the viewer
    assert peer.until(lambda: peer.publisher.get_subscription_count() > 1)
    stage.page.tick('follow the stream')
    before = stage.page.frames()
    count, start = 2000, time.monotonic()
    for k in range(count):
        time.sleep(max(0.0, start + k / 1000 - time.monotonic()))
        angles = (0.8 * np.sin(0.003 * k), 0.5, 0.001 * (k % 300))
        peer.send(THESIS.coordinates, angles, nanoseconds=time.time_ns())
    assert stage.page.frames() - before < count / 4
    assert stage.shows(state_at(angles))
    assert until(lambda: stage.page.frames() > before)
    stage.page.tick('follow the stream')


def test_a_second_browser_and_one_that_comes_back_see_the_same(stage: Stage) -> None:
    stage.page.press('flexion 80')
    state = state_at((np.radians(80.0), 0.0, 0.0))
    second = stage.open(dpr=0.1)
    assert stage.shows(state, second)
    assert stage.shows(state)
    second.page.reload()
    assert stage.shows(state, second)
    second.press('neutral')
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    assert second.errors == []
    second.page.close()


def test_a_node_that_dies_and_comes_back_is_moved_again(stage: Stage) -> None:
    stage.node.stop(signal.SIGKILL)
    assert until(lambda: stage.page.page.get_by_text('the node does not answer').count() > 0)
    stage.node = NodeProcess(stage.folder / 'again.log', **{'markers.rate': 0.0})
    stage.page.slide(1, 20.0)
    assert stage.shows(state_at(stage.page.angles()))
    assert until(lambda: stage.page.page.get_by_text('the node does not answer').count() == 0)


def test_a_still_is_a_picture_of_the_scene(stage: Stage) -> None:
    stage.page.press('neutral')
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    stage.page.turn_to('save')
    with stage.page.page.expect_download() as download:
        stage.page.press('still (PNG)')
    path = stage.folder / download.value.suggested_filename
    download.value.save_as(path)
    assert path.suffix == '.png'
    assert heads_seen(path.read_bytes())
    stage.page.turn_to('plots')


def test_a_recording_opens_without_a_server(stage: Stage) -> None:
    stage.page.turn_to('save')
    stage.page.press('record')
    stage.page.press('abduction 90')
    state = state_at((0.0, np.radians(90.0), 0.0))
    assert stage.shows(state)
    with stage.page.page.expect_download() as download:
        stage.page.press('stop recording')
    path = stage.folder / download.value.suggested_filename
    download.value.save_as(path)
    alone = stage.chromium.new_context(offline=True).new_page()
    replay = Page(alone, path.as_uri())
    assert stage.shows(state, replay)
    assert replay.errors == []
    assert {urlsplit(url).scheme for url in replay.requests} <= {'file', 'data', 'blob'}
    alone.close()
    stage.page.turn_to('plots')


def test_a_second_shoulder_is_shown_beside_the_first(stage: Stage) -> None:
    left = NodeProcess(
        stage.folder / 'left.log', '-r', '__ns:=/left', side='left', **{'markers.rate': 0.0}
    )
    page = stage.page
    with left:
        assert until(lambda: len(page.lines('/left/deltoid/bands/lines')) > 0)
        mirrored = LinkedPlaneSolver(DELTOID, 'left').solve(np.eye(3)).paths(16)
        wanted = np.concatenate([np.stack((p[:-1], p[1:]), axis=1) for p in mirrored])
        there = page.lines('/left/deltoid/bands/lines')
        np.testing.assert_allclose(there, wanted, rtol=0.0, atol=DRAWN)

        def as_one_stands_before_a_person() -> bool:
            """Their right arm is on the left."""
            right = page.places(page.lines().reshape(-1, 3))[:, 0]
            return bool(
                right.max() < page.places(there.reshape(-1, 3), '/left/deltoid')[:, 0].min()
            )

        assert until(as_one_stands_before_a_person)
        assert until(lambda: page.page.get_by_text('dashed: left deltoid').count() > 0)
        page.choose('time', 'coordinate')
        # the left arm has not been moved: a point of its curves, the right one's before and behind
        assert until(lambda: len(page.plots()) == 2 and len(page.plots()[0]) == 7)
        assert all_lines_are_seen(page)
