# SPDX-License-Identifier: Apache-2.0
"""Time: the node answers by the stamps it is given, wherever they go."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from played_bags import Player, write_bag
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from ros_harness import ANSWERS, NodeProcess, Peer, together
from rosgraph_msgs.msg import Clock
from visualization_msgs.msg import Marker, MarkerArray

from linkedplane_ros.drawing.shapes import RateLimiter
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.recordings.bags.recording import Recording

NAMES = ('flexion', 'abduction', 'rotation')
BAG = Path(__file__).parents[2] / 'msg_examples' / 'arm_raise'
MS = 10**6  # ns


def shown_stamps(stamps: Sequence[float], rate: float = 30.0) -> list[float]:
    """Return which stamps, s, are let through; arrivals are 1 ms apart."""
    pace = RateLimiter(rate)
    return [stamp for k, stamp in enumerate(stamps) if pace.allows(stamp, 0.001 * k)]


def test_the_pace_is_that_of_the_stamps() -> None:
    stamps = [0.01 * k for k in range(101)]
    assert shown_stamps(stamps, 10.0) == pytest.approx([0.1 * k for k in range(11)])
    assert shown_stamps([100.0 * s for s in stamps], 10.0) == [100.0 * s for s in stamps]


def test_a_rate_of_zero_lets_everything_through() -> None:
    assert shown_stamps([1.0, 1.0, 1.0], 0.0) == [1.0, 1.0, 1.0]


def test_a_recording_played_backwards_keeps_the_pace() -> None:
    stamps = [0.01 * k for k in reversed(range(101))]
    assert shown_stamps(stamps, 10.0) == pytest.approx([0.1 * k for k in reversed(range(11))])


def test_a_jump_back_or_forwards_passes_at_once() -> None:
    assert shown_stamps([100.0, 100.001, 3.0, 3.001, 500.0, 500.001]) == [100.0, 3.0, 500.0]


def test_a_stamp_that_stands_still_is_let_through_by_its_arrival() -> None:
    assert len(shown_stamps([7.0] * 1000, 10.0)) == 10


def test_whatever_the_stamps_markers_never_stop() -> None:
    for stamps in (
        [0.02 * (k % 2) for k in range(3000)],
        [-1e9 + 0.02 * (k % 3) for k in range(9)],
    ):
        assert shown_stamps(stamps, 10.0)[0] == stamps[0]
    assert len(shown_stamps([0.3 * (k % 5) for k in range(500)], 10.0)) == 500


def stamps_of(peer: Peer, topic: str = 'band_states') -> list[int]:
    """Return the stamps of what has come, ns; of marker arrays that of their first marker."""
    headers = [m.markers[0].header if isinstance(m, MarkerArray) else m.header
               for m in peer.got[topic]]  # fmt: skip
    return [header.stamp.sec * 10**9 + header.stamp.nanosec for header in headers]


def test_a_recording_played_backwards_once_is_answered_message_by_message(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    stamps = [10**9 + 10 * MS * k for k in (*range(50), *reversed(range(50)))]
    for k, stamp in enumerate(stamps):
        peer.send(NAMES, (0.01 * k, 0.2, 0.1), nanoseconds=stamp)
    assert peer.answers(len(stamps))
    assert stamps_of(peer) == stamps
    assert peer.until(lambda: len(peer.got['markers']) > 20)
    drawn = stamps_of(peer, 'markers')
    assert min(drawn[15:]) < 10**9 + 100 * MS  # there and back
    gaps = [abs(b - a) for a, b in pairwise(drawn[1:])]
    assert max(gaps) <= 50 * MS


@pytest.mark.parametrize('clock', [False, True], ids=['stamps alone', 'with --clock and sim time'])
def test_a_looped_recording_is_answered_round_after_round(
    ros: None, tmp_path: Path, clock: bool
) -> None:
    parameters: dict[str, Any] = {'qos_overrides./joint_states.subscription.depth': 10000}
    if clock:
        parameters['use_sim_time'] = 'true'
    # slow enough for a node that gets little of a busy machine: a loop does not wait for it
    every_tenth = list(Recording.from_bag(BAG).messages())[::10]
    bag = write_bag(tmp_path / 'bag', [(m.topic, m.time, m.data) for m in every_tenth])
    first = len(every_tenth)  # messages a round
    peer = Peer(raw=True)  # to read so many markers as they come takes too long
    with NodeProcess(tmp_path / 'node.log', **parameters) as process:
        peer.connect(process)
        player = Player(bag, '--loop', '--rate', 3, *(['--clock', 100] if clock else []))
        try:
            assert peer.answers(3 * first + 1), peer.counts()
            assert peer.until(lambda: peer.diagnostics[-1].header.stamp.sec > 0)
        finally:
            player.process.send_signal(signal.SIGINT)
            player.result()
        told = peer.diagnostics[-1].header.stamp.sec
    peer.destroy_node()
    peer.got['markers'] = [deserialize_message(m, MarkerArray) for m in peer.got['markers']]
    stamps = stamps_of(peer)
    assert stamps[first : 2 * first] == stamps[:first]
    assert stamps[2 * first : 3 * first] == stamps[:first]
    assert stamps[:first] == sorted(stamps[:first])
    # markers in every round, whole, so that a viewer that has thrown them away has them again
    drawn = [a for a in peer.got['markers'] if a.markers[0].action != Marker.DELETEALL]
    # (those of interferences come and go)
    drawn = [[m for m in a.markers if m.ns != 'interferences'] for a in drawn]
    keys = [{(m.ns, m.id) for m in markers if m.action == Marker.ADD} for markers in drawn]
    assert all(k == keys[0] for k in keys)
    assert sum(b < a for a, b in pairwise(stamps_of(peer, 'markers'))) >= 2
    assert len(drawn) > 3 * 30
    if clock:  # the diagnostics carry the recording's time
        assert stamps[0] // 10**9 <= told <= stamps[first - 1] // 10**9 + 1


def test_a_paused_recording_goes_on_and_a_late_viewer_sees_where_it_stands(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    for k in range(5):
        peer.send(NAMES, (0.1, 0.2, 0.3), nanoseconds=10**9 + k * 100 * MS)
    assert peer.answers(5)
    late: list[MarkerArray] = []
    peer.create_subscription(MarkerArray, 'deltoid/markers', late.append, 10)
    assert peer.until(lambda: len(late) >= 1)
    stamp = late[-1].markers[0].header.stamp
    assert stamp.sec * 10**9 + stamp.nanosec == 10**9 + 400 * MS
    assert all(m.action == Marker.ADD for m in late[-1].markers if m.ns != 'interferences')
    peer.send(NAMES, (0.1, 0.2, 0.3), nanoseconds=2 * 10**9)
    assert peer.answers(6)
    assert stamps_of(peer)[-1] == 2 * 10**9


def test_a_viewer_that_comes_before_the_pause_is_one_sees_where_it_stands_too(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    peer.send(NAMES, (0.1, 0.2, 0.3), nanoseconds=10**9)
    assert peer.answers(1)
    late: list[MarkerArray] = []
    peer.create_subscription(MarkerArray, 'deltoid/markers', late.append, 10)
    node._report()  # once a second; at this moment more messages may still come
    assert peer.until(lambda: bool(late))
    assert late[-1].markers[0].header.stamp.sec == 1


def test_under_sim_time_the_node_works_before_and_after_the_clock_does_and_when_it_jumps(
    peer: Peer,
) -> None:
    made = MuscleStatePublisher(parameter_overrides=[Parameter('use_sim_time', value=True)])
    clock = peer.create_publisher(Clock, '/clock', 10)
    with together(peer, made):
        peer.connect()
        assert peer.until(lambda: clock.get_subscription_count() > 0)
        for k, now in enumerate((None, 100, 200, 50)):
            if now is not None:
                clock.publish(Clock(clock=Time(sec=now)))
                assert peer.until(lambda now=now: made.get_clock().now().nanoseconds == now * 10**9)
            peer.send(NAMES, (0.1, 0.2, 0.3), nanoseconds=(now or 0) * 10**9)
            assert peer.answers(k + 1)
        count = len(peer.diagnostics)
        assert peer.until(lambda: len(peer.diagnostics) > count + 1)
        assert peer.diagnostics[-1].header.stamp.sec == 50
    made.destroy_node()
    assert peer.counts() == dict.fromkeys(ANSWERS, 4)


def test_nothing_is_drawn_while_nobody_looks(ros: None) -> None:
    made, feeder = MuscleStatePublisher(), Peer(viewer=False)
    with together(feeder, made):
        feeder.connect()
        made._muscles[0]._markers = None  # to draw would fail
        for k in range(5):
            feeder.send(NAMES, (0.1, 0.2, 0.3), nanoseconds=k * 100 * MS)
        assert feeder.answers(5)
    feeder.destroy_node()
    made.destroy_node()
