# SPDX-License-Identifier: Apache-2.0
"""A recording played: every message, byte by byte, in order."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from played_bags import COUNT, PLUGINS, Player, bytes_on, joint_states, notes, write_bag
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros_harness import Reader
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from linkedplane_ros.node.play import await_acknowledgement, time_message
from linkedplane_ros.recordings.bags.recording import Recording

START = 1_700_000_000_000_000_000  # ns since the epoch
STEP = 50_000_000  # ns


class Listener(Reader):
    """Keeps the bytes of every joint state, and the clock."""

    def __init__(self, *topics: str) -> None:
        """Subscribe the topics and the clock."""
        super().__init__('test_listener')
        self.heard: dict[str, list[bytes]] = {topic: [] for topic in topics}
        self.clock: list[int] = []
        for topic, heard in self.heard.items():
            self.keep(JointState, topic, heard.append, raw=True)
        self.keep(
            Clock,
            '/clock',
            lambda message: self.clock.append(message.clock.sec * 10**9 + message.clock.nanosec),
            qos_profile=QoSProfile(depth=5000, reliability=ReliabilityPolicy.BEST_EFFORT),
        )


@pytest.fixture
def listen(ros: None) -> Iterator[Callable[..., Listener]]:
    """Make listeners that are gone after the test."""
    made: list[Listener] = []

    def listener(*topics: str) -> Listener:
        made.append(Listener(*(topics or ('/joint_states',))))
        return made[-1]

    yield listener
    for node in made:
        node.destroy_node()


def test_no_subscriber_is_awaited_on_a_topic_without_messages(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / 'bag', joint_states('/recorded'), empty=['/joint_states'])
    assert Recording.from_bag(bag).topics == ('/recorded',)


def test_every_joint_state_arrives_byte_by_byte_in_order_and_nothing_else_does(
    listen: Callable[..., Listener], tmp_path: Path
) -> None:
    listener = listen(*(f'/{plugin}/{side}' for plugin in PLUGINS for side in ('left', 'right')))
    sent, players = [], []
    for plugin in PLUGINS:  # both at once
        messages = joint_states(f'/{plugin}/right') + joint_states(f'/{plugin}/left', 9) + notes()
        messages.sort(key=lambda message: message[1])
        sent += messages
        path = write_bag(tmp_path / plugin, messages, plugin)
        players.append((path, Player(path, '--rate', 20)))
    for path, player in players:
        assert listener.until(player.ended)
        assert player.result() == (
            0,
            f'{path}: {COUNT + 9} joint states on /{path.name}/left, /{path.name}/right, 1.0 s, '
            f'at 20 times its speed\n{COUNT + 9} joint states published\n',
            '',
        )
    assert listener.until(lambda: sum(map(len, listener.heard.values())) >= 2 * (COUNT + 9))
    assert listener.heard == {topic: bytes_on(sent, topic) for topic in listener.heard}
    assert '/notes' not in dict(listener.get_topic_names_and_types())
    assert listener.clock == []


@pytest.mark.parametrize('plugin', PLUGINS)
def test_a_bags_file_alone_is_read_as_the_bag(tmp_path: Path, plugin: str) -> None:
    messages = joint_states()
    folder = write_bag(tmp_path / 'bag', messages, plugin)
    [path] = (path for path in folder.iterdir() if path.suffix in ('.db3', '.mcap'))
    for recording in (Recording.from_bag(folder), Recording.from_bag(path)):
        assert recording.count == COUNT
        assert [(m.topic, m.time, m.data) for m in recording.messages()] == messages


@pytest.mark.parametrize('plugin', PLUGINS)
@pytest.mark.parametrize(('offset', 'skipped'), [(0, 0), (0.5, 10), (0.501, 11), (1.0, 20)])
def test_a_start_offset_skips_what_was_recorded_before_it(
    tmp_path: Path, plugin: str, offset: float, skipped: int
) -> None:
    messages = joint_states()
    recording = Recording.from_bag(write_bag(tmp_path / 'bag', messages, plugin))
    assert [m.data for m in recording.messages(offset)] == bytes_on(messages)[skipped:]


def test_a_start_offset_counts_from_the_first_message_of_any_kind(tmp_path: Path) -> None:
    early = ('/notes', START - 10 * STEP, notes(1)[0][2])
    messages = joint_states()
    recording = Recording.from_bag(write_bag(tmp_path / 'bag', [early, *messages]))
    assert recording.start == START - 10 * STEP
    assert [m.data for m in recording.messages(10.5e-9 * STEP)] == bytes_on(messages)[1:]


def test_from_an_offset_the_clock_tells_the_recorded_time_and_never_goes_back(
    listen: Callable[..., Listener], tmp_path: Path
) -> None:
    messages = joint_states()
    listener = listen()
    path = write_bag(tmp_path / 'bag', messages)
    player = Player(path, '--rate', 4, '--clock', 50, '--start-offset', 0.2)
    assert listener.until(player.ended)
    assert player.result()[0] == 0
    assert listener.until(lambda: len(listener.heard['/joint_states']) >= COUNT - 4)
    assert listener.heard['/joint_states'] == bytes_on(messages)[4:]
    assert len(listener.clock) > 1
    assert listener.clock == sorted(set(listener.clock))
    assert listener.clock[-1] <= START + (COUNT - 1) * STEP
    # 50 a second, while 4 s of the recording pass in one: 80 ms of it between two
    assert {(time - START - 4 * STEP) % 80_000_000 for time in listener.clock} == {0}


def test_a_loop_goes_round_until_it_is_interrupted(
    listen: Callable[..., Listener], tmp_path: Path
) -> None:
    messages = joint_states()
    listener = listen()
    player = Player(write_bag(tmp_path / 'bag', messages), '--rate', 20, '--loop')
    heard = listener.heard['/joint_states']
    assert listener.until(lambda: len(heard) > 2 * COUNT or player.ended())
    player.process.send_signal(signal.SIGINT)
    assert listener.until(player.ended)
    status, out, err = player.result()
    assert status == 130
    assert err == ''
    assert 'Traceback' not in out
    assert len(heard) > 2 * COUNT
    assert heard == (bytes_on(messages) * (1 + len(heard) // COUNT))[: len(heard)]


def test_waiting_for_a_subscriber_can_be_interrupted(ros: None, tmp_path: Path) -> None:
    player = Player(write_bag(tmp_path / 'bag', joint_states()))
    assert player.process.stdout is not None
    player.process.stdout.readline()  # by then it is about to wait
    player.process.send_signal(signal.SIGINT)
    status, _, err = player.result()
    assert status == 130
    assert 'Traceback' not in err


def test_without_a_subscriber_it_plays_all_the_same_and_says_so(ros: None, tmp_path: Path) -> None:
    path = write_bag(tmp_path / 'bag', joint_states())
    status, out, err = Player(path, '--rate', 20, '--wait', 0).result()
    assert status == 0
    assert out.endswith(f'{COUNT} joint states published\n')
    assert 'no subscriber after 0 s; playing anyway' in err


class Taken:
    """Stands in for a publisher whose subscriber takes everything in so many waits."""

    def __init__(self, waits: int) -> None:
        self.waits = waits

    def wait_for_all_acked(self, _: object) -> bool:
        self.waits -= 1
        return self.waits < 0


def test_the_player_stays_until_every_subscriber_has_taken_its_messages() -> None:
    publishers: list[Any] = [Taken(0), Taken(200), Taken(3)]
    assert await_acknowledgement(publishers, 60.0)
    assert [publisher.waits < 0 for publisher in publishers] == [True] * 3
    publishers = [Taken(10**9)]
    assert not await_acknowledgement(publishers, 0.0)


@pytest.mark.parametrize('nanoseconds', [0, 1, 999_999_999, START, START + 123_456_789])
def test_a_stamp_is_the_time_to_the_nanosecond(nanoseconds: int) -> None:
    made = time_message(nanoseconds)
    assert made.sec * 10**9 + made.nanosec == nanoseconds
    assert 0 <= made.nanosec < 10**9
