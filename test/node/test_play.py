"""A recording played: every message, byte by byte, in order; or a line that says why not."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import monotonic

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from linkedplane_ros.commands.main import main
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.node.play import stamp
from linkedplane_ros.recordings.bags import Recording

START = 1_700_000_000_000_000_000  # ns since the epoch
STEP = 50_000_000  # ns
COUNT = 21
PATIENCE = 60.0  # s: the longest that anything is waited for; nothing is asserted about time
PLUGINS = {'sqlite3': StoragePlugin.SQLITE3, 'mcap': StoragePlugin.MCAP}
TYPES = get_typestore(Stores.ROS2_JAZZY)
Sent = tuple[str, int, bytes]


def joint_states(topic: str = '/joint_states', count: int = COUNT) -> list[Sent]:
    """Return (topic, time, CDR) of joint states of many sizes, none like another."""
    made = []
    for k in range(count):
        names = ['flexion', 'abduction', 'rotation', 'elbow'][: 1 + k % 4]
        message = JointState(name=names, position=[0.01 * k + i for i in range(len(names))])
        message.velocity = [0.1] * len(names) if k % 2 else []
        message.header.frame_id = 'x' * (k % 5)
        message.header.stamp.sec = k
        made.append((topic, START + k * STEP, bytes(serialize_message(message))))
    return made


def texts(count: int = 3) -> list[Sent]:
    """Return (topic, time, CDR) of messages that are not joint states."""
    return [
        ('/notes', START + k * STEP + 1, bytes(serialize_message(String(data=f'note {k}'))))
        for k in range(count)
    ]


def bag(folder: Path, messages: Sequence[Sent], plugin: str = 'mcap') -> Path:
    """Write a recording."""
    with Writer(folder, version=9, storage_plugin=PLUGINS[plugin]) as writer:
        connections = {}
        for topic, time, data in messages:
            if topic not in connections:
                kind = 'std_msgs/msg/String' if topic == '/notes' else 'sensor_msgs/msg/JointState'
                connections[topic] = writer.add_connection(topic, kind, typestore=TYPES)
            writer.write(connections[topic], time, data)
    return folder


class Listener(Node):
    """Keeps the bytes of every joint state, and the clock."""

    def __init__(self, *topics: str) -> None:
        """Subscribe the topics and the clock."""
        super().__init__('test_listener')
        self.heard: dict[str, list[bytes]] = {topic: [] for topic in topics}
        self.clock: list[int] = []
        for topic, heard in self.heard.items():
            self.create_subscription(
                JointState, topic, heard.append, QoSProfile(depth=5000), raw=True
            )
        self.create_subscription(
            Clock,
            '/clock',
            lambda message: self.clock.append(message.clock.sec * 10**9 + message.clock.nanosec),
            QoSProfile(depth=5000, reliability=ReliabilityPolicy.BEST_EFFORT),
        )
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)

    def until(self, condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
        """Read messages until the condition holds; return whether it did in time."""
        deadline = monotonic() + seconds
        while not condition():
            if monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=0.02)
        return True


class Player:
    """`linkedplane play` in a process of its own."""

    def __init__(self, *arguments: object) -> None:
        """Start it."""
        command = [sys.executable, '-m', 'linkedplane_ros.commands', 'play', *map(str, arguments)]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def ended(self) -> bool:
        """Whether it has come to its end."""
        return self.process.poll() is not None

    def result(self) -> tuple[int, str, str]:
        """Wait for its end; return its status, what it printed, and its stderr."""
        out, err = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, out, err


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


def data(messages: Sequence[Sent], topic: str = '/joint_states') -> list[bytes]:
    """Return the bytes of the messages on a topic."""
    return [message[2] for message in messages if message[0] == topic]


def test_every_joint_state_arrives_byte_by_byte_in_order_and_nothing_else_does(
    listen: Callable[..., Listener], tmp_path: Path
) -> None:
    listener = listen(*(f'/{plugin}/{side}' for plugin in PLUGINS for side in ('left', 'right')))
    sent, players = [], []
    for plugin in PLUGINS:  # both at once
        messages = joint_states(f'/{plugin}/right') + joint_states(f'/{plugin}/left', 9) + texts()
        messages.sort(key=lambda message: message[1])
        sent += messages
        path = bag(tmp_path / plugin, messages, plugin)
        players.append((path, Player(path, '--rate', 20)))
    for path, player in players:
        assert listener.until(player.ended)
        assert player.result() == (
            0,
            f'{path}: {COUNT + 9} joint states on /{path.name}/left, /{path.name}/right, 1.0 s, '
            f'at 20 times its speed\n{COUNT + 9} joint states published\n',
            '',
        )
    listener.until(lambda: sum(map(len, listener.heard.values())) >= 2 * (COUNT + 9))
    assert listener.heard == {topic: data(sent, topic) for topic in listener.heard}
    assert '/notes' not in dict(listener.get_topic_names_and_types())
    assert listener.clock == []


@pytest.mark.parametrize('plugin', PLUGINS)
def test_a_bags_file_alone_is_read_as_the_bag(tmp_path: Path, plugin: str) -> None:
    messages = joint_states()
    folder = bag(tmp_path / 'bag', messages, plugin)
    [path] = (path for path in folder.iterdir() if path.suffix in ('.db3', '.mcap'))
    for recording in (Recording.open(folder), Recording.open(path)):
        assert recording.count == COUNT
        assert [(m.topic, m.time, m.data) for m in recording.messages()] == messages


@pytest.mark.parametrize('plugin', PLUGINS)
@pytest.mark.parametrize(('offset', 'skipped'), [(0, 0), (0.5, 10), (0.501, 11), (1.0, 20)])
def test_a_start_offset_skips_what_was_recorded_before_it(
    tmp_path: Path, plugin: str, offset: float, skipped: int
) -> None:
    messages = joint_states()
    recording = Recording.open(bag(tmp_path / 'bag', messages, plugin))
    assert [m.data for m in recording.messages(offset)] == data(messages)[skipped:]


def test_a_start_offset_counts_from_the_first_message_of_any_kind(tmp_path: Path) -> None:
    early = ('/notes', START - 10 * STEP, texts(1)[0][2])
    messages = joint_states()
    recording = Recording.open(bag(tmp_path / 'bag', [early, *messages]))
    assert recording.start == START - 10 * STEP
    assert [m.data for m in recording.messages(10.5e-9 * STEP)] == data(messages)[1:]


def test_from_an_offset_the_clock_tells_the_recorded_time_and_never_goes_back(
    listen: Callable[..., Listener], tmp_path: Path
) -> None:
    messages = joint_states()
    listener = listen()
    path = bag(tmp_path / 'bag', messages)
    player = Player(path, '--rate', 4, '--clock', 50, '--start-offset', 0.2)
    assert listener.until(player.ended)
    assert player.result()[0] == 0
    assert listener.until(lambda: len(listener.heard['/joint_states']) >= COUNT - 4)
    assert listener.heard['/joint_states'] == data(messages)[4:]
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
    player = Player(bag(tmp_path / 'bag', messages), '--rate', 20, '--loop')
    heard = listener.heard['/joint_states']
    assert listener.until(lambda: len(heard) > 2 * COUNT or player.ended())
    player.process.send_signal(signal.SIGINT)
    assert listener.until(player.ended)
    status, out, err = player.result()
    assert status == 130
    assert err == ''
    assert 'Traceback' not in out
    assert len(heard) > 2 * COUNT
    assert heard == (data(messages) * (1 + len(heard) // COUNT))[: len(heard)]


def test_waiting_for_a_subscriber_can_be_interrupted(ros: None, tmp_path: Path) -> None:
    player = Player(bag(tmp_path / 'bag', joint_states()))
    assert player.process.stdout is not None
    player.process.stdout.readline()  # by then it is about to wait
    player.process.send_signal(signal.SIGINT)
    status, _, err = player.result()
    assert status == 130
    assert 'Traceback' not in err


def test_without_a_subscriber_it_plays_all_the_same_and_says_so(ros: None, tmp_path: Path) -> None:
    path = bag(tmp_path / 'bag', joint_states())
    status, out, err = Player(path, '--rate', 20, '--wait', 0).result()
    assert status == 0
    assert out.endswith(f'{COUNT} joint states published\n')
    assert 'no subscriber after 0 s; playing all the same' in err


def nothing(path: Path) -> Path:
    return path


def a_text(path: Path) -> Path:
    path.write_text('not a bag at all')
    return path


def an_empty_file(path: Path) -> Path:
    path.touch()
    return path


def an_empty_folder(path: Path) -> Path:
    path.mkdir()
    return path


def a_folder_of_rubbish(path: Path) -> Path:
    path.mkdir()
    (path / 'metadata.yaml').write_text('rosbag2_bagfile_information: [1, 2]')
    return path


def a_bag_without_its_file(path: Path) -> Path:
    bag(path, joint_states())
    next(path.glob('*.mcap')).unlink()
    return path


def of_other_things(path: Path) -> Path:
    return bag(path, texts())


def of_nothing(path: Path) -> Path:
    return bag(path, [])


def cut_short(path: Path) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])


def a_truncated_mcap(path: Path) -> Path:
    bag(path, joint_states(count=2000))
    cut_short(next(path.glob('*.mcap')))
    return path


def a_truncated_mcap_alone(path: Path) -> Path:
    return next(a_truncated_mcap(path).glob('*.mcap'))


def a_truncated_sqlite3(path: Path) -> Path:
    bag(path, joint_states(count=2000), 'sqlite3')
    cut_short(next(path.glob('*.db3')))
    return path


def a_sqlite3_with_a_hole(path: Path) -> Path:
    bag(path, joint_states(count=2000), 'sqlite3')
    make_a_hole(next(path.glob('*.db3')))
    return path


def an_mcap_with_a_hole(path: Path) -> Path:
    bag(path, joint_states(count=2000))
    make_a_hole(next(path.glob('*.mcap')))
    return path


def make_a_hole(path: Path) -> None:
    content = bytearray(path.read_bytes())
    third = len(content) // 3
    content[third : 2 * third] = b'\xff' * third
    path.write_bytes(content)


FAULTY = [
    (nothing, 'bag', 'no such file or folder'),
    (nothing, 'bag.mcap', 'no such file or folder'),
    (a_text, 'notes.txt', 'not a readable rosbag2'),
    (a_text, 'notes.mcap', 'not a readable rosbag2'),
    (a_text, 'notes.db3', 'not a readable rosbag2'),
    (a_text, 'old.bag', 'a ROS 1 bag; convert it with rosbags-convert first'),
    (an_empty_file, 'empty.mcap', 'not a readable rosbag2'),
    (an_empty_file, 'empty.db3', 'not a readable rosbag2'),
    (an_empty_folder, 'empty', 'not a readable rosbag2'),
    (a_folder_of_rubbish, 'rubbish', 'not a readable rosbag2'),
    (a_bag_without_its_file, 'bag', 'not a readable rosbag2'),
    (of_other_things, 'bag', 'no sensor_msgs/msg/JointState in it, but std_msgs/msg/String'),
    (of_nothing, 'bag', 'no sensor_msgs/msg/JointState in it, but nothing'),
    (a_truncated_mcap, 'bag', 'not a readable rosbag2'),
    (a_truncated_mcap_alone, 'bag', 'not a readable rosbag2'),
    (a_truncated_sqlite3, 'bag', 'not a readable rosbag2'),
]


@pytest.mark.parametrize(
    ('make', 'name', 'reason'), FAULTY, ids=[f'{make.__name__}-{name}' for make, name, _ in FAULTY]
)
def test_what_is_no_recording_of_joint_states_is_refused_in_one_line(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    make: Callable[[Path], Path],
    name: str,
    reason: str,
) -> None:
    path = make(tmp_path / name)
    with pytest.raises(RecordingError, match=reason):
        Recording.open(path)
    assert main(['play', str(path)]) == 1
    out, err = capsys.readouterr()
    assert out == ''
    assert err.count('\n') == 1
    assert err.startswith(f'linkedplane: {path}: {reason}')


@pytest.mark.parametrize('make', [a_sqlite3_with_a_hole, an_mcap_with_a_hole])
def test_damage_that_is_met_on_the_way_ends_it_in_one_line(
    ros: None, tmp_path: Path, make: Callable[[Path], Path]
) -> None:
    path = make(tmp_path / 'bag')
    status, out, err = Player(path, '--wait', 0, '--rate', 1000).result()
    lines = [line for line in err.splitlines() if 'no subscriber after' not in line]
    assert status == 1
    assert len(lines) == 1, err
    assert lines[0].startswith(f'linkedplane: {path}: ')
    assert 'published' not in out


def test_a_start_offset_beyond_the_end_is_refused_in_one_line(tmp_path: Path) -> None:
    path = bag(tmp_path / 'bag', joint_states())
    status, out, err = Player(path, '--start-offset', 1.5).result()
    assert (status, out) == (1, '')
    assert err == 'linkedplane: --start-offset: 1.5 s given, the recording lasts 1.0 s\n'


@pytest.mark.parametrize('nanoseconds', [0, 1, 999_999_999, START, START + 123_456_789])
def test_a_stamp_is_the_time_to_the_nanosecond(nanoseconds: int) -> None:
    made = stamp(nanoseconds)
    assert made.sec * 10**9 + made.nanosec == nanoseconds
    assert 0 <= made.nanosec < 10**9
