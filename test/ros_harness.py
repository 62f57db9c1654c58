# SPDX-License-Identifier: Apache-2.0
"""A node in a process of its own or in this one, and a peer that feeds it and reads its topics.

A test starts the node by `with NodeProcess(...)` and `peer.connect(process)`, or by
`with running(peer, ...)`, and waits for what it claims by `peer.until(...)`: never by a sleep,
never less than PATIENCE. That something does not happen is seen from what happens after it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from unhurried import PATIENCE

from linkedplane_ros.node.messages import message_class
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.topics import OUTPUTS

TOPICS = {topic.name: message_class(topic.type) for topic in OUTPUTS}
DEEP = QoSProfile(depth=20000)
TURN = 100  # messages: some take longer to read than the next one takes to come
ANSWERS = tuple(topic for topic in TOPICS if topic != 'markers')


LEFT: list[subprocess.Popen[bytes]] = []  # started by the test that runs
READERS: list[Reader] = []  # made by the test that runs


def hear_hangup() -> None:
    """Let a child end when its terminal does, also where the tests run under nohup."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def end_what_is_left() -> None:
    """End every process that a test has started and not stopped, and every reader it has made."""
    for process in LEFT:
        if process.poll() is None:
            process.kill()
            process.wait()
    LEFT.clear()
    for reader in list(READERS):
        reader.destroy_node()


class NodeProcess:
    """The muscle node as users run it, with parameters; its stderr is kept."""

    def __init__(self, log: Path, *arguments: str, **parameters: Any) -> None:
        """Start it; what it writes goes to the log.

        Its subscription is reliable, so that a message sent to it is not lost while it matches.
        """
        parameters.setdefault('qos_overrides./joint_states.subscription.reliability', 'reliable')
        given = [part for item in parameters.items() for part in ('-p', '{}:={}'.format(*item))]
        command = [sys.executable, '-m', 'linkedplane_ros.node', '--ros-args']
        command += [*arguments, *given]
        self.log = log
        compiled = {key: v for key, v in os.environ.items() if key != 'LINKEDPLANE_COMPILE'}
        with log.open('wb') as out:
            # what is open for children is the lock of the ROS domain
            self.process = subprocess.Popen(
                command,
                stdout=out,
                stderr=out,
                env=compiled,
                close_fds=False,
                preexec_fn=hear_hangup,
            )
        LEFT.append(self.process)

    def stop(self, how: signal.Signals = signal.SIGINT) -> int:
        """End it and return its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(PATIENCE)

    def outlive_test(self) -> None:
        """Live on when the test ends; who keeps it stops it."""
        LEFT.remove(self.process)

    def __enter__(self) -> NodeProcess:
        """Run."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """End it, whatever has happened; if all was well, so is its end."""
        status = self.stop()
        if kind is None:
            assert status == 0, self.text
            assert 'Traceback' not in self.text

    @property
    def text(self) -> str:
        """All that it has written."""
        return self.log.read_text()


class ReleasingExecutor(SingleThreadedExecutor):
    """Holds nothing between two waits, so that what is destroyed then is gone.

    rclpy 7.1 may stop in the middle of a wait, with the handles of all nodes in use; what is
    destroyed meanwhile stays in the graph, for ever if nobody waits again.
    """

    def release(self) -> None:
        """End the wait that was stopped; what was ready and not yet taken is found again."""
        self._cb_iter = None


class Reader(Node):
    """Keeps what comes on its topics; all waiting of a test is `until` something has come."""

    def __init__(self, name: str, context: Any = None) -> None:
        """Work in an executor of its own, whose turns are those of `until`."""
        super().__init__(name, context=context)
        self.executor_of_its_own = ReleasingExecutor(context=context)
        self.executor_of_its_own.add_node(self)
        self.readers: list[Subscription] = []
        READERS.append(self)

    def destroy_node(self) -> None:
        """Leave the graph, if that has not been done."""
        if self in READERS:
            READERS.remove(self)
            super().destroy_node()

    def keep(self, kind: Any, topic: str, kept: Callable[[Any], None], **how: Any) -> None:
        """Subscribe a topic, reliable and deep enough to lose nothing."""
        how.setdefault('qos_profile', DEEP)
        self.readers.append(self.create_subscription(kind, topic, kept, **how))

    def until(self, condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
        """Read messages until the condition holds; return whether it did in time."""
        deadline = time.monotonic() + seconds
        try:
            while not condition():
                if time.monotonic() > deadline:
                    return False
                self.executor_of_its_own.spin_once(timeout_sec=0.02)
                self._take_the_rest()
            return True
        finally:
            self.executor_of_its_own.release()

    def _take_the_rest(self) -> None:
        """Read what has come: an executor reads one message a turn, too slow for a stream."""
        for reader in self.readers:
            for _ in range(TURN):
                taken = reader.handle.take_message(reader.msg_type, reader.raw)
                if taken is None:
                    break
                reader.callback(taken[0])


class Peer(Reader):
    """Publishes joint states and keeps every message that the muscle node publishes."""

    def __init__(
        self,
        prefix: str = 'deltoid',
        context: Any = None,
        raw: bool = False,
        topic: str = 'joint_states',
        viewer: bool = True,
    ) -> None:
        """Subscribe everything; markers unread (bytes) if `raw`.

        A peer that is no viewer leaves the markers alone.
        """
        super().__init__('test_peer', context)
        self.got: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
        self.diagnostics: list[DiagnosticArray] = []
        self.publisher = self.create_publisher(JointState, topic, DEEP)
        for name, kind in TOPICS.items():
            if viewer or name != 'markers':
                unread = raw and name == 'markers'
                self.keep(kind, f'{prefix}/{name}', self.got[name].append, raw=unread)
        # the last: who knows it knows the others
        self.keep(DiagnosticArray, '/diagnostics', self.diagnostics.append)

    def connect(self, node: NodeProcess | None = None) -> None:
        """Wait until the node and this peer have found each other, both ways.

        Between nodes of one process both ways are one step. A node in a process of its own is known
        here before it knows this peer; that it does, its first diagnostics tell.
        """

        def found() -> bool:
            if node is not None and node.process.poll() is not None:
                raise AssertionError(f'the node ended: {node.text}')
            return (
                self.publisher.get_subscription_count() > 0
                and all(reader.get_publisher_count() for reader in self.readers)
                and (node is None or bool(self.diagnostics))
            )

        assert self.until(found), self.describe_matches(node)

    def describe_matches(self, node: NodeProcess | None) -> str:
        """Return who is matched with whom, for a test that has waited in vain."""
        counts = {reader.topic_name: reader.get_publisher_count() for reader in self.readers}
        return (
            f'{self.publisher.get_subscription_count()} subscribers of joint states; publishers: '
            f'{counts}; {len(self.diagnostics)} diagnostics; nodes: {self.get_node_names()}; '
            f'the node wrote: {node.text if node else "nothing"}'
        )

    def send(
        self,
        names: Sequence[str],
        positions: Sequence[float],
        velocities: Sequence[float] = (),
        nanoseconds: int = 0,
    ) -> JointState:
        """Publish one joint state."""
        message = JointState(name=list(names), position=list(positions), velocity=list(velocities))
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(nanoseconds, 10**9)
        self.publisher.publish(message)
        return message

    def answers(self, count: int, seconds: float = PATIENCE) -> bool:
        """Wait for so many answers on every topic; return whether they came."""
        return self.until(lambda: all(len(self.got[topic]) >= count for topic in ANSWERS), seconds)

    def counts(self) -> dict[str, int]:
        """How many answers have come on each topic."""
        return {topic: len(self.got[topic]) for topic in ANSWERS}

    def values(self) -> dict[str, str]:
        """The newest diagnostics of the muscle node; waits for the first."""
        assert self.until(lambda: bool(self.diagnostics)), 'no diagnostics'
        return {item.key: item.value for item in self.diagnostics[-1].status[0].values}


@contextmanager
def together(peer: Peer, *nodes: Node) -> Iterator[None]:
    """Let nodes of this process work together with a peer."""
    for node in nodes:
        peer.executor_of_its_own.add_node(node)
    try:
        yield
    finally:
        for node in nodes:
            peer.executor_of_its_own.remove_node(node)


@contextmanager
def running(*readers: Peer, **parameters: Any) -> Iterator[MuscleStatePublisher]:
    """Run the node in this process with parameters, connected with its readers."""
    node = MuscleStatePublisher(
        parameter_overrides=[Parameter(name, value=value) for name, value in parameters.items()]
    )
    try:
        with together(readers[0], node):
            for reader in readers:
                reader.connect()
            yield node
    finally:
        node.destroy_node()


@contextmanager
def reader_of(muscle: str, peer: Peer) -> Iterator[Peer]:
    """Read a muscle while its peer works."""
    made = Peer(muscle)
    made.executor_of_its_own = peer.executor_of_its_own
    try:
        with together(peer, made):
            yield made
    finally:
        made.destroy_node()


def muscles_published(node: MuscleStatePublisher) -> set[str]:
    """Return the muscles whose topics a node has; ROS learns of a change some time later."""
    found = node.get_publisher_names_and_types_by_node(node.get_name(), node.get_namespace())
    return {topic.split('/')[1] for topic, _ in found if topic.endswith('/moment_arms')}
