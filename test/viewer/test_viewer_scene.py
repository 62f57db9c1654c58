# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser: what is seen, in which colours, and kept as a picture."""

from __future__ import annotations

from urllib.parse import urlsplit

import numpy as np
import pytest
from browser import Page, wait_until
from ros_harness import NodeProcess
from viewer_stage import DRAWN, MISSING, Stage, all_lines_are_seen, state_at

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.drawing.bones import shaft_axis
from linkedplane_ros.drawing.colours import HEAD_COLOURS
from linkedplane_ros.viewer.panels.motions import end_poses
from linkedplane_ros.viewer.scene import colour_map

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
TABLET = {'width': 768, 'height': 1024}


def test_bands_take_the_colour_of_their_moment_arm(stage: Stage) -> None:
    page = stage.page
    page.press_button('scaption 60')
    page.choose_option('head', 'moment arm')
    state = state_at(end_poses(THESIS)['scaption 60'])
    arms = 1e3 * (state.moment_vectors @ THESIS.axes(end_poses(THESIS)['scaption 60']))[:, 0]
    assert wait_until(lambda: page.page.get_by_text('moment arm about flexion, mm').count() > 0)
    most = max(
        float(text.removeprefix('+'))
        for text in page.page.locator('span:text-matches("^[+][0-9]+$")').all_inner_texts()
    )
    counts = [len(path) - 1 for path in state.paths(16)]
    wanted = np.repeat(colour_map.map_colours(arms, most), counts, axis=0) / 255.0

    def painted() -> bool:
        light = page.colours()[:, 0]
        shown = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        # the library takes 256 steps of light: dark colours are coarse
        return len(shown) == len(wanted) and bool(np.abs(shown - wanted).max() < 0.05)

    assert wait_until(painted)
    page.choose_option('moment arm', 'head')


def test_all_of_the_muscle_is_in_the_picture_of_a_tablet_too_with_lateral_on_its_left(
    stage: Stage,
) -> None:
    tablet = stage.chromium.new_context(viewport=TABLET, has_touch=True).new_page()
    pages = [stage.page, Page(tablet, stage.viewer.url)]
    centre = np.zeros(3)
    for pose, angles in end_poses(THESIS).items():
        stage.page.press_button(pose)
        state = state_at(angles)
        arm = np.vstack((*state.paths(16), shaft_axis(DELTOID) @ state.rotation.T))
        for page in pages:
            assert stage.shows(state, page)
            assert wait_until(
                lambda page=page, arm=arm: bool(np.abs(page.project_points(arm)).max() < 0.95)
            )
            middle, lateral, superior = page.project_points(
                np.array((centre, (0.1, 0, 0), (0, 0, 0.1)))
            )
            assert lateral[0] < middle[0]
            assert superior[1] > middle[1]
        seen = stage.page.project_points(arm)
        assert np.ptp(seen, axis=0).max() > 0.5  # of 2: not lost in the picture
    tablet.close()


def heads_seen(picture: bytes) -> bool:
    """Return whether a PNG has the colour of each head; the library's tone adds up to 15 of 255."""
    import imageio.v3

    colours = imageio.v3.imread(picture)[..., :3].astype(int)
    heads = [tuple(round(255 * part) for part in colour) for colour in HEAD_COLOURS[:3]]
    return all((np.abs(colours - head).max(axis=2) < 18).sum() > 20 for head in heads)


def test_the_bands_are_seen_in_the_colours_of_their_heads(stage: Stage) -> None:
    stage.page.press_button('neutral')
    scene = {'x': 0, 'y': 0, 'width': 900, 'height': 720}  # beside the panel and its legend
    assert wait_until(lambda: heads_seen(stage.page.page.screenshot(clip=scene)))


def test_spheres_and_planes_are_there_on_demand(stage: Stage) -> None:
    page = stage.page
    names = ('obstacle_spheres/balls', 'interference_spheres/balls')

    def there(name: str) -> bool:
        return bool(
            page.page.evaluate(
                'name => window.__viserMutable.nodeRefFromName[name]?.visible ?? false', name
            )
        )

    page.open_tab('look')
    for name, label in zip(names, ('obstacle spheres', 'interference spheres'), strict=True):
        assert not there(f'/deltoid/{name}')
        page.toggle(label)
        assert wait_until(lambda name=name: there(f'/deltoid/{name}'))
        page.toggle(label)
    page.open_tab('plots')


def test_a_still_is_a_picture_of_the_scene(stage: Stage) -> None:
    stage.page.press_button('neutral')
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    stage.page.open_tab('save')
    with stage.page.page.expect_download() as download:
        stage.page.press_button('still (PNG)')
    path = stage.folder / download.value.suggested_filename
    download.value.save_as(path)
    assert path.suffix == '.png'
    assert heads_seen(path.read_bytes())
    stage.page.open_tab('plots')


def test_a_recording_opens_without_a_server(stage: Stage) -> None:
    stage.page.open_tab('save')
    stage.page.press_button('record')
    stage.page.press_button('abduction 90')
    state = state_at((0.0, np.radians(90.0), 0.0))
    assert stage.shows(state)
    with stage.page.page.expect_download() as download:
        stage.page.press_button('stop recording')
    path = stage.folder / download.value.suggested_filename
    download.value.save_as(path)
    alone = stage.chromium.new_context(offline=True).new_page()
    replay = Page(alone, path.as_uri())
    assert stage.shows(state, replay)
    assert replay.errors == []
    assert {urlsplit(url).scheme for url in replay.requests} <= {'file', 'data', 'blob'}
    alone.close()
    stage.page.open_tab('plots')


def test_a_second_shoulder_is_shown_beside_the_first(stage: Stage) -> None:
    left = NodeProcess(
        stage.folder / 'left.log', '-r', '__ns:=/left', side='left', **{'markers.rate': 0.0}
    )
    page = stage.page
    with left:
        assert wait_until(lambda: page.page.get_by_text('left deltoid', exact=True).count() > 0)
        page.open_tab('left deltoid')
        with page.expect_change():
            page.page.get_by_text('neutral', exact=True).last.click(force=True)
        assert wait_until(lambda: len(page.lines('/left/deltoid/bands/lines')) > 0)
        mirrored = LinkedPlaneSolver(DELTOID, 'left').solve(np.eye(3)).paths(16)
        wanted = np.concatenate([np.stack((p[:-1], p[1:]), axis=1) for p in mirrored])
        there = page.lines('/left/deltoid/bands/lines')
        np.testing.assert_allclose(there, wanted, rtol=0.0, atol=DRAWN)

        def as_one_stands_before_a_person() -> bool:
            """Their right arm is on the left."""
            right = page.project_points(page.lines().reshape(-1, 3))[:, 0]
            return bool(
                right.max() < page.project_points(there.reshape(-1, 3), '/left/deltoid')[:, 0].min()
            )

        assert wait_until(as_one_stands_before_a_person)
        assert wait_until(lambda: page.page.get_by_text('dashed: left deltoid').count() > 0)
        # both at rest, the newest of both every second
        assert wait_until(lambda: len(page.plots()) == 2 and len(page.plots()[0]) == 7)
        page.choose_option('time', 'coordinate')
        # the left arm has stayed: a point of its curves, the right one's before and behind
        assert wait_until(lambda: len(page.plots()) == 2 and len(page.plots()[0]) == 7)
        assert all_lines_are_seen(page)
