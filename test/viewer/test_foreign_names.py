# SPDX-License-Identifier: Apache-2.0
"""Names and numbers from the network: shown as what they are, cut, and harmless."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from optional import requires
from rclpy.serialization import serialize_message
from ros_harness import Reader
from sensor_msgs.msg import JointState
from socket_browser import SocketBrowser
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, UInt8MultiArray
from viewer_stage import ViewerProcess
from visualization_msgs.msg import Marker, MarkerArray

from linkedplane_ros import LinkedPlaneError
from linkedplane_ros.viewer.names import LONGEST_NAME, distinct_names, html_name, short_name
from linkedplane_ros.viewer.newest import MuscleInfo, Values
from linkedplane_ros.viewer.panels.table import bands_table_html
from linkedplane_ros.viewer.scene.geometry import drawables
from linkedplane_ros.viewer.scene.wire import read_markers

SCRIPT = '<img src=x onerror=alert(1)>'
EVIL = (SCRIPT, '"><script>', 'a&b', "x' onload='y", 'long' * 5000, 'two\nlines\x1b[31m')


@pytest.mark.parametrize('name', EVIL, ids=lambda name: name[:10])
def test_a_name_is_one_short_line_and_no_html(name: str) -> None:
    assert len(short_name(name)) <= LONGEST_NAME
    assert short_name(name).isprintable()
    assert not set('<>"\'') & set(html_name(name))


def test_names_that_would_look_the_same_are_numbered() -> None:
    assert distinct_names(['a', 'b', 'c']) == ('a', 'b', 'c')
    assert len(set(distinct_names(['n' * 100] * 3))) == 3


def test_a_table_has_no_html_of_others_and_knows_no_more_states_than_there_are() -> None:
    coordinates = (SCRIPT, 'b', 'c')
    info = MuscleInfo.from_parameters(coordinates, (SCRIPT, 'x' * 9999), '/joint_states', {})
    text = bands_table_html(info, Values(wrap=np.array((9, 255), np.uint8)), 0, set())
    assert '<img' not in text
    assert '&lt;img' in text
    assert len(text) < 2000


def marker(**parts: Any) -> MarkerArray:
    made = Marker(**parts)
    made.pose.orientation.w = 1.0
    return MarkerArray(markers=[made])


@pytest.mark.parametrize('namespace', ['a/balls', 'a/b/c', '', '/', SCRIPT])
def test_a_namespace_is_one_part_of_a_path(namespace: str) -> None:
    message = marker(ns=namespace, type=Marker.SPHERE)
    [name] = drawables({('', 0): read_markers(serialize_message(message))[0]})
    assert name.count('/') == 1
    assert name.endswith('/balls')


def test_an_empty_list_is_not_drawn_and_numbers_have_to_be_finite() -> None:
    empty = read_markers(serialize_message(marker(type=Marker.SPHERE_LIST)))[0]
    assert drawables({('', 0): empty}) == {}
    wrong = marker(type=Marker.SPHERE)
    wrong.markers[0].scale.x = float('nan')
    with pytest.raises(LinkedPlaneError, match='finite'):
        read_markers(serialize_message(wrong))


class Impostor(Reader):
    """Publishes what has the topics of a muscle."""

    def __init__(self) -> None:
        super().__init__('impostor')
        self._arms = self.create_publisher(Float64MultiArray, '/evil/moment_arms', 10)
        self._lengths = self.create_publisher(Float64MultiArray, '/evil/band_lengths', 10)
        self._states = self.create_publisher(JointState, '/evil/band_states', 10)
        self._wrap = self.create_publisher(UInt8MultiArray, '/evil/wrap_states', 10)
        self._markers = self.create_publisher(MarkerArray, '/evil/markers', 10)
        self.is_met = lambda: self._arms.get_subscription_count() > 0

    def send(self, bands: list[str], coordinates: list[str], number: float) -> None:
        """Send a state of numbers that are all the same."""
        arms = Float64MultiArray(data=[number] * (3 * len(bands)))
        labels = f'band:{",".join(bands)}', f'coordinate:{",".join(coordinates)}'
        arms.layout.dim = [MultiArrayDimension(label=label) for label in labels]
        self._arms.publish(arms)
        self._wrap.publish(UInt8MultiArray(data=[200] * len(bands)))
        self._states.publish(JointState(name=bands, position=[number] * len(bands)))
        self._markers.publish(marker(ns=SCRIPT, type=Marker.SPHERE_LIST))


@pytest.fixture
def impostor(ros: None) -> Iterator[Impostor]:
    made = Impostor()
    yield made
    made.destroy_node()


@requires('viser')
def test_another_program_with_a_muscles_topics_is_shown_without_harm(
    tmp_path: Path, impostor: Impostor
) -> None:
    viewer = ViewerProcess(tmp_path / 'viewer.log')
    with viewer, SocketBrowser(viewer.url) as page:
        assert impostor.until(impostor.is_met)
        bad = float('nan')

        def shows_bands() -> bool:
            impostor.send(['a', 'b'], ['q', 'q', 'q'], 0.1)  # no three coordinates
            impostor.send([SCRIPT, 'x' * 500], [SCRIPT, 'two\nlines', 'c' * 500], bad)
            impostor.send([SCRIPT, 'x' * 500], [SCRIPT, 'two\nlines', 'c' * 500], 0.1)
            return any('&lt;img' in each for each in page.texts.values())

        assert page.until(shows_bands), viewer.text
        assert not any('<img' in each for each in page.texts.values())
        assert max(map(len, page.labels)) < 3 * LONGEST_NAME
        page.set_control('colour by', 'moment arm')
        assert page.shows('moment arm about &lt;img')
    assert 'Traceback' not in viewer.text
