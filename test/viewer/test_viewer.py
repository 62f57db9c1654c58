# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser: the arm is moved, and the scene and the plots follow."""

from __future__ import annotations

import signal
import time

import numpy as np
import pytest
from browser import wait_until
from ros_harness import Peer, together
from viewer_stage import MISSING, Stage, all_lines_are_seen, state_at

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle
from linkedplane_ros.viewer.panels.motions import end_poses

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
HEADS = (1, 3, 7)


def test_a_slider_moves_the_arm_and_the_scene_is_the_solvers_path(stage: Stage) -> None:
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    stage.page.move_slider(0, 40.0)
    stage.page.move_slider(1, 20.0)
    angles = stage.page.slider_angles()
    # a track is some 120 pixels long: 1.3 deg a pixel
    np.testing.assert_allclose(np.degrees(angles), (40.0, 20.0, 0.0), atol=2.7)
    assert stage.shows(state_at(angles))


def test_a_number_beyond_the_range_is_taken_as_its_end(stage: Stage) -> None:
    stage.page.press_button('neutral')
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    stage.page.type_number(1, '999')
    assert stage.shows(state_at((0.0, DELTOID.range_of_motion[1][1], 0.0)))
    assert 'not used' not in stage.node.text  # 999 deg would have been refused
    stage.page.type_number(1, '30')
    assert stage.shows(state_at((0.0, np.radians(30.0), 0.0)))


def test_the_plots_grow_by_the_lengths_and_arms_of_the_heads(stage: Stage) -> None:
    page = stage.page
    assert wait_until(lambda: len(page.plots()) == 2)
    before = page.plots()[0][0, -1]  # s
    page.move_slider(0, 30.0)
    angles = page.slider_angles()
    state = state_at(angles)
    lengths = 1e3 * state.lengths[list(HEADS)]
    arms = 1e3 * (state.moment_vectors @ THESIS.axes(angles))[list(HEADS), 0]

    def newest() -> bool:
        rows = [columns[1:, -1] for columns in page.plots()]
        # mm; the same numbers, but for the rounding of another product
        return np.allclose(rows[0], lengths, atol=1e-9) and np.allclose(rows[1], arms, atol=1e-9)

    assert wait_until(newest)
    assert page.plots()[0][0, -1] > before
    assert all_lines_are_seen(page)


def test_a_button_takes_the_arm_to_an_end_pose_of_the_case_study(stage: Stage) -> None:
    stage.page.press_button('scaption 60')
    assert stage.shows(state_at(end_poses(THESIS)['scaption 60']))
    # sliders are shown to a tenth of a degree
    assert wait_until(
        lambda: np.allclose(
            stage.page.slider_angles(), end_poses(THESIS)['scaption 60'], atol=np.radians(0.06)
        )
    )


def test_the_sliders_follow_a_stream_when_they_are_told_to(stage: Stage, peer: Peer) -> None:
    with together(peer):
        assert peer.until(lambda: peer.publisher.get_subscription_count() > 1)
        stage.page.toggle('follow the stream')
        angles = (0.5, 0.25, -0.3)

        def followed() -> bool:
            peer.send(THESIS.coordinates, angles, nanoseconds=time.time_ns())
            return bool(np.allclose(stage.page.slider_angles(), angles, atol=np.radians(0.06)))

        assert wait_until(followed)
        assert stage.shows(state_at(angles))
    stage.page.toggle('follow the stream')


def test_a_stream_of_1_khz_is_drawn_at_the_screens_rate_and_its_end_is_what_is_shown(
    stage: Stage, peer: Peer
) -> None:
    # the node and the viewer
    assert peer.until(lambda: peer.publisher.get_subscription_count() > 1)
    stage.page.toggle('follow the stream')
    count, start = 2000, time.monotonic()
    before = stage.page.frame_count()
    for k in range(count):
        time.sleep(max(0.0, start + k / 1000 - time.monotonic()))
        angles = (0.8 * np.sin(0.003 * k), 0.5, 0.001 * (k % 300))
        peer.send(THESIS.coordinates, angles, nanoseconds=time.time_ns())
    frames = stage.page.frame_count() - before
    assert frames < 100 * (time.monotonic() - start)  # a screen's 60 Hz, with room
    assert stage.shows(state_at(angles))
    assert wait_until(lambda: stage.page.frame_count() > before)
    stage.page.toggle('follow the stream')


def test_a_second_browser_and_one_that_comes_back_see_the_same(stage: Stage) -> None:
    stage.page.press_button('flexion 80')
    state = state_at((np.radians(80.0), 0.0, 0.0))
    second = stage.open(dpr=0.1)
    assert stage.shows(state, second)
    assert stage.shows(state)
    second.page.reload()
    assert stage.shows(state, second)
    second.press_button('neutral')
    assert stage.shows(state_at((0.0, 0.0, 0.0)))
    assert second.errors == []
    second.page.close()


def test_a_node_that_dies_and_comes_back_is_moved_again(stage: Stage) -> None:
    stage.node.stop(signal.SIGKILL)
    assert wait_until(lambda: stage.page.page.get_by_text('the node does not answer').count() > 0)
    stage.start_node(stage.folder / 'again.log')
    stage.page.move_slider(1, 20.0)
    assert stage.shows(state_at(stage.page.slider_angles()))
    assert wait_until(lambda: stage.page.page.get_by_text('the node does not answer').count() == 0)
