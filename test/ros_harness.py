# SPDX-License-Identifier: Apache-2.0
"""A node in a process of its own, and a peer that feeds it and reads its topics."""

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
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from linkedplane_ros.node.messages import message_class
from linkedplane_ros.node.topics import OUTPUTS

TOPICS = {topic.name: message_class(topic.type) for topic in OUTPUTS}
ANSWERS = tuple(topic for topic in TOPICS if topic != 'markers')
PATIENCE = 60.0  # s: the longest that anything is waited for; nothing is asserted about time


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
            self.process = subprocess.Popen(command, stdout=out, stderr=out, env=compiled)

    def stop(self, how: signal.Signals = signal.SIGINT) -> int:
        """End it and return its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(PATIENCE)

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


class Peer(Node):
    """Publishes joint states and keeps every message that the muscle node publishes."""

    def __init__(
        self,
        prefix: str = 'deltoid',
        context: Any = None,
        raw: bool = False,
        topic: str = 'joint_states',
        viewer: bool = True,
    ) -> None:
        """Subscribe everything, deep enough to lose nothing; markers unread (bytes) if `raw`.

        A peer that is no viewer leaves the markers alone.
        """
        super().__init__('test_peer', context=context)
        qos = QoSProfile(depth=20000)
        self.got: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
        self.diagnostics: list[DiagnosticArray] = []
        self.publisher = self.create_publisher(JointState, topic, qos)
        self.readers = [
            self.create_subscription(
                kind,
                f'{prefix}/{topic}',
                self.got[topic].append,
                qos,
                raw=raw and topic == 'markers',
            )
            for topic, kind in TOPICS.items()
            if viewer or topic != 'markers'
        ]
        self.executor_of_its_own = SingleThreadedExecutor(context=context)
        self.executor_of_its_own.add_node(self)
        self.create_subscription(DiagnosticArray, '/diagnostics', self.diagnostics.append, qos)

    def until(self, condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
        """Read messages until the condition holds; return whether it did in time."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.executor_of_its_own.spin_once(timeout_sec=0.02)
        return True

    def connect(self, node: NodeProcess | None = None) -> None:
        """Wait until the node has found this peer, both ways."""

        def found() -> bool:
            if node is not None and node.process.poll() is not None:
                raise AssertionError(f'the node ended: {node.text}')
            return self.publisher.get_subscription_count() > 0 and all(
                reader.get_publisher_count() for reader in self.readers
            )

        assert self.until(found), node.text if node else 'no node'
        # that the node has found the readers, too, its first diagnostics tell
        assert self.until(lambda: bool(self.diagnostics)), 'no diagnostics'

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
        """The newest diagnostics of the muscle node."""
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
