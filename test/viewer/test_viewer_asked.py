# SPDX-License-Identifier: Apache-2.0
"""The viewer moves an arm only when a person asks it to, and only where nobody else does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from optional import requires
from ros_harness import Peer, Reader
from sensor_msgs.msg import JointState
from socket_browser import SocketBrowser
from viewer_stage import ViewerProcess

pytestmark = requires('viser')
OWN, COMMON = '/muscle_viewer/joint_states', '/joint_states'
SLIDER = 'flexion (deg)'
SILENCE = 2.0  # s: an arm at rest has a joint state every second


class Listener(Reader):
    """Hears all joint states of a topic."""

    def __init__(self, *topics: str) -> None:
        super().__init__('listener')
        self.heard: list[JointState] = []
        for topic in topics:
            self.keep(JointState, topic, self.heard.append)

    def hears_more(self, seconds: float = 60.0) -> bool:
        """Wait for one more joint state."""
        before = len(self.heard)
        return self.until(lambda: len(self.heard) > before, seconds)

    def falls_silent(self) -> bool:
        """Return whether nothing more comes, once what was under way has come."""
        return any(not self.hears_more(SILENCE) for _ in range(100))

    def hears_flexion(self, degrees: float) -> bool:
        """Wait for a joint state at an angle."""
        return self.until(
            lambda: (
                bool(self.heard) and abs(np.degrees(self.heard[-1].position[0]) - degrees) < 0.1
            ),
            60.0,
        )


@pytest.fixture
def listener(ros: None) -> Iterator[Listener]:
    made = Listener(OWN, COMMON)
    yield made
    made.destroy_node()


@contextmanager
def look_on(folder: Path, *arguments: str) -> Iterator[tuple[ViewerProcess, SocketBrowser]]:
    """Run the viewer with its node and a browser that looks on."""
    viewer = ViewerProcess(folder / 'viewer.log', '--node', *arguments)
    with viewer, SocketBrowser(viewer.url) as page:
        yield viewer, page


def publishers(listener: Listener, topic: str) -> int:
    return len(listener.get_publishers_info_by_topic(topic))


def test_nothing_is_published_before_a_person_moves_a_control_and_then_on_a_topic_of_its_own(
    tmp_path: Path, listener: Listener
) -> None:
    with look_on(tmp_path) as (viewer, page):
        assert page.shows('nothing moves this arm yet')
        assert not listener.hears_more(4.0)  # it began after 1.5 s
        assert (publishers(listener, OWN), publishers(listener, COMMON)) == (0, 0)
        page.set_control(SLIDER, 30.0)
        assert listener.hears_flexion(30.0)
        assert publishers(listener, COMMON) == 0
        assert 'another publisher' not in viewer.text


def test_a_node_that_listens_elsewhere_is_shown_and_not_moved(
    tmp_path: Path, listener: Listener, peer: Peer
) -> None:
    remapped = ('--ros-args', '-r', f'joint_states:={COMMON}')
    with look_on(tmp_path, *remapped) as (_, page):
        assert page.shows('start the viewer with --topic /joint_states')
        page.set_control(SLIDER, 30.0)
        page.set_control('go to', 'flexion 80')
        page.set_control('play a sweep', True)
        assert not listener.hears_more(SILENCE)
        assert peer.until(lambda: peer.publisher.get_subscription_count() > 2)
        peer.send(('flexion', 'abduction', 'rotation'), (0.5, 0.0, 0.0))
        assert listener.hears_flexion(math.degrees(0.5))


def test_the_common_topic_is_a_choice(tmp_path: Path, listener: Listener) -> None:
    with look_on(tmp_path, '--topic', 'joint_states') as (_, page):
        page.set_control(SLIDER, 30.0)
        assert listener.hears_flexion(30.0)
        assert publishers(listener, OWN) == 0


def test_a_sweep_ends_with_the_last_browser_that_looks_on(
    tmp_path: Path, listener: Listener
) -> None:
    with ViewerProcess(tmp_path / 'viewer.log', '--node') as viewer:
        with SocketBrowser(viewer.url):
            with SocketBrowser(viewer.url) as second:
                second.set_control('play a sweep', True)
                assert listener.until(lambda: len(listener.heard) > 50)
            assert listener.until(lambda: len(listener.heard) > 200)  # the first looks on
        assert listener.until(lambda: publishers(listener, OWN) == 0)
        assert listener.falls_silent()
        with SocketBrowser(viewer.url) as again:
            assert again.until(lambda: bool(again.texts))
            assert not listener.hears_more(SILENCE)  # a page that comes back moves nothing
            again.set_control(SLIDER, 10.0)
            assert listener.hears_flexion(10.0)


@pytest.mark.parametrize('control', [(SLIDER, 20.0), ('play a sweep', True)], ids=str)
def test_it_stops_at_once_with_a_line_when_another_publisher_comes(
    control: tuple[str, object], tmp_path: Path, listener: Listener
) -> None:
    with look_on(tmp_path) as (viewer, page):
        page.set_control(*control)
        assert listener.hears_more()
        rival = Reader('robot_driver')
        publisher = rival.create_publisher(JointState, OWN, 10)
        assert page.shows('another publisher of /muscle_viewer/joint_states is there')
        assert listener.falls_silent()
        page.set_control(SLIDER, 40.0)
        page.set_control('go to', 'neutral')
        page.set_control('follow the stream', False)
        assert not listener.hears_more(SILENCE)
        assert publishers(listener, OWN) == 1
        [line] = [each for each in viewer.text.splitlines() if 'another publisher' in each]
        assert page.shows('is there (/robot_driver)')
        assert '--take' in line
        rival.destroy_publisher(publisher)
        rival.destroy_node()
        assert listener.until(lambda: publishers(listener, OWN) == 0)
        assert not listener.hears_more(SILENCE)  # nor does it go on by itself
        page.set_control('follow the stream', False)
        assert page.waits_for(SLIDER)
        page.set_control(SLIDER, 50.0)
        assert listener.hears_flexion(50.0)


def test_it_does_not_begin_beside_another_publisher_unless_it_is_told_to_take_the_arm(
    tmp_path: Path, listener: Listener
) -> None:
    rival = Reader('robot_driver')
    rival.create_publisher(JointState, COMMON, 10)
    common = ('--topic', COMMON)
    with look_on(tmp_path, *common) as (_, page):
        page.set_control(SLIDER, 20.0)
        assert page.shows('another publisher of /joint_states is there')
        assert not listener.hears_more(SILENCE)
    with look_on(tmp_path, *common, '--take') as (_, page):
        page.set_control(SLIDER, 20.0)
        assert listener.hears_flexion(20.0)
    rival.destroy_node()


def test_two_viewers_do_not_move_one_arm(tmp_path: Path, listener: Listener) -> None:
    second = ViewerProcess(tmp_path / 'second.log')
    with look_on(tmp_path) as (_, page), second, SocketBrowser(second.url) as other:
        page.set_control(SLIDER, 20.0)
        assert listener.hears_flexion(20.0)
        assert other.shows('is there (/muscle_viewer)')
        other.set_control(SLIDER, 90.0)
        listener.hears_more(SILENCE)
        assert not any(each.position[0] > 1.0 for each in listener.heard)


def test_what_is_not_finite_or_beyond_a_range_is_refused_from_a_socket_too(
    tmp_path: Path, listener: Listener
) -> None:
    with look_on(tmp_path) as (viewer, page):
        page.set_control(SLIDER, 30.0)
        assert listener.hears_flexion(30.0)
        for value in (math.nan, math.inf, 'nan', 1e9, -500, None, True, [1.0]):
            page.set_control(SLIDER, value)
        page.set_control('go to', 'nowhere')
        page.set_control('colour by', 'nothing')
        page.set_control('coordinate', '<b>')
        page.send(b'\xc1')
        page.send({'type': 'ShareUrlRequest'})
        page.set_control('abduction (deg)', 20.0)
        assert listener.until(lambda: bool(listener.heard[-1].position[1] > 0.1))
        positions = np.array([each.position for each in listener.heard])
        assert np.isfinite(positions).all()
        assert positions[:, 0].max() <= np.radians(30.1)
        assert 'a number from' in viewer.text
        assert 'Traceback' not in viewer.text
