"""The ROS side of the viewer: finds the muscles' topics, keeps their newest state, moves arms."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from threading import Event
from typing import Any

import numpy as np
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters
from rclpy._rclpy_pybind11 import NodeNameNonExistentError, RCLError
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_parameter_events
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, UInt8MultiArray
from visualization_msgs.msg import MarkerArray

from ..joints.joint_state import JointMemory, Rejected
from ..processing.topics import FLOAT_ARRAY, MARKERS, read_label
from ..recordings.bags import JOINT_STATE
from ..types import Floats
from .newest import MARKERS_KEPT, Facts, Newest

FRAME = 1.0 / 60.0  # s: no screen needs to be told more often
GATHER, GATHERINGS = 0.001, 12  # s between looks for the rest of an answer, and how many of them
ANSWER = 8  # messages: more are a stream that is quicker than its markers
LOOK = 0.5  # s between looks at what is there
POSES_KEPT = 64  # joint states, to find the pose that an answer belongs to
ASKED = ('muscle', 'side', 'joint_convention', 'joint_names', 'joint_signs', 'joint_offsets')


def latest(depth: int = 1) -> QoSProfile:
    """Return the quality of service of a reader that wants what is newest, of any publisher."""
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)


def muscles_among(topics: list[tuple[str, list[str]]]) -> list[str]:
    """Return the prefixes (`/deltoid`) of the muscles that topics and their types tell of."""
    kinds = dict(topics)
    prefixes = [topic.removesuffix('/markers') for topic in kinds if topic.endswith('/markers')]
    return sorted(
        prefix
        for prefix in prefixes
        if MARKERS.type in kinds[f'{prefix}/markers']
        and FLOAT_ARRAY in kinds.get(f'{prefix}/band_lengths', ())
    )


class MuscleReader:
    """Reads one muscle's topics into its newest state, and publishes joint states for it."""

    def __init__(self, node: Node, prefix: str, fresh: Event) -> None:
        """Subscribe its topics (`/deltoid/...`)."""
        self.newest = Newest(fresh)
        self.publisher: Publisher | None = None
        self.taken = 0
        self._pending: dict[str, Any] = {}
        self._states: JointState | None = None
        self._markers: list[bytes] = []
        self._node = node
        self._prefix = prefix
        self._labels: tuple[tuple[str, ...], tuple[str, ...]] | None = None
        self._parameters: dict[str, Any] = {}
        self._memory: JointMemory | None = None
        self._poses: OrderedDict[tuple[int, int], Floats] = OrderedDict()
        self._joints: Any = None
        self._source = ''
        self._client: Any = None
        self._answer: Any = None
        for kind, topic, callback in (
            (Float64MultiArray, 'moment_arms', self._take_arms),
            (JointState, 'band_states', self._take_states),
            (UInt8MultiArray, 'wrap_states', self._take_wrap),
        ):
            self._subscribe(kind, f'{prefix}/{topic}', callback, latest())
        self._subscribe(
            MarkerArray,
            f'{prefix}/markers',
            self._markers.append,
            QoSProfile(depth=MARKERS_KEPT),
            raw=True,
        )

    def _subscribe(
        self,
        kind: Any,
        topic: str,
        callback: Callable[[Any], None],
        profile: QoSProfile,
        **how: Any,
    ) -> Any:
        def take(message: Any) -> None:
            self.taken += 1
            callback(message)

        return self._node.create_subscription(kind, topic, take, profile, **how)

    def _take_arms(self, message: Float64MultiArray) -> None:
        names = [read_label(dim.label)[1] for dim in message.layout.dim]
        if len(names) != 2 or len(names[1]) != 3 or len(message.data) != 3 * len(names[0]):
            return
        if (names[1], names[0]) != self._labels:
            self._labels = names[1], names[0]
            self._answer = None  # the node has changed: ask it again
            self._tell()
        self._pending['arms'] = np.array(message.data).reshape(-1, 3)

    def _take_states(self, message: JointState) -> None:
        self._states = message

    def _take_wrap(self, message: UInt8MultiArray) -> None:
        self._pending['wrap'] = np.array(message.data, np.uint8)

    def _take_joints(self, message: JointState) -> None:
        if self._memory is None:
            return
        with suppress(Rejected):
            angles, _, _ = self._memory.take(message.name, message.position, message.velocity)
            self._poses[message.header.stamp.sec, message.header.stamp.nanosec] = np.array(angles)
            self._pending['angles'] = np.array(angles)
        while len(self._poses) > POSES_KEPT:
            self._poses.popitem(last=False)

    @property
    def waiting(self) -> bool:
        """Whether something of an answer has come that is not handed over."""
        return self._states is not None or 'arms' in self._pending or self.complete

    @property
    def complete(self) -> bool:
        """Whether the markers have come, the last of an answer."""
        return bool(self._markers)

    def hand_over(self) -> None:
        """Hand over what has come since the last time, all at once: it belongs together."""
        messages = self._markers.copy()
        self._markers.clear()
        if self._states is not None:
            stamp = self._states.header.stamp
            self._pending['lengths'] = np.array(self._states.position)
            pose = self._poses.get((stamp.sec, stamp.nanosec))
            self._states = None
            self.newest.put_answer(messages, pose, **self._pending)
            self._pending = {}
        elif messages:
            self.newest.put(messages)

    def _tell(self) -> None:
        """Let it be known what the muscle is, as far as that is known."""
        if self._joints is None or not (self._labels or self._parameters):
            return
        labels = self._labels or ((), ())
        facts = Facts.told(*labels, self._joints.topic_name, self._parameters)
        if self._memory is None or self._memory.joints != facts.joints:
            self._memory = JointMemory(facts.joints)
        self.newest.put_facts(facts)

    def look(self) -> None:
        """See whether its node is there, what it is and where it takes its joint states from."""
        publishers = self._node.get_publishers_info_by_topic(f'{self._prefix}/markers')
        others = self._joints.get_publisher_count() - 1 if self._joints else 0
        self.newest.put(present=bool(publishers), rivals=max(others, 0))
        if not publishers:
            self._answer = None  # what comes back may be another
            return
        with suppress(StopIteration, NodeNameNonExistentError):  # its name comes later than it
            found = next(each for each in publishers if each.node_namespace.startswith('/'))
            name, namespace = found.node_name, found.node_namespace.rstrip('/')
            self._meet(f'{namespace}/{name}', self._joint_topic(name, namespace))
        if self._answer is None and self._client is not None and self._client.service_is_ready():
            self._answer = self._client.call_async(GetParameters.Request(names=list(ASKED)))
            self._answer.add_done_callback(self._learn)

    def _joint_topic(self, name: str, namespace: str) -> str:
        """Return the topic that a node takes its joint states from."""
        taken = self._node.get_subscriber_names_and_types_by_node(name, namespace or '/')
        topics = sorted(topic for topic, kinds in taken if JOINT_STATE in kinds)
        return topics[0] if topics else f'{namespace}/joint_states'

    def _meet(self, source: str, topic: str) -> None:
        """Connect with a node: its parameters and the topic of its joint states."""
        if source == self._source and self._joints.topic_name == topic:
            return
        for old, destroy in (
            (self._joints, self._node.destroy_subscription),
            (self.publisher, self._node.destroy_publisher),
            (self._client, self._node.destroy_client),
        ):
            if old is not None:
                destroy(old)
        self.publisher = self._node.create_publisher(JointState, topic, QoSProfile(depth=10))
        self._joints = self._subscribe(JointState, topic, self._take_joints, latest(4))
        self._client = self._node.create_client(GetParameters, f'{source}/get_parameters')
        self._source, self._answer = source, None
        self._tell()

    def _learn(self, answer: Any) -> None:
        """Take the node's parameters in."""
        values = [parameter_value_to_python(value) for value in answer.result().values]
        self._parameters = {
            name: value for name, value in zip(ASKED, values, strict=False) if value is not None
        }
        self._tell()

    def changed(self, event: ParameterEvent) -> None:
        """Ask the node again if it is the one whose parameters have changed."""
        if event.node == self._source:
            self._answer = None


class ViewerNode(Node):
    """Reads every muscle that it finds."""

    def __init__(self, **kwargs: Any) -> None:
        """Look out for muscles from now on."""
        super().__init__('muscle_viewer', **kwargs)
        self.fresh = Event()
        self.readers: dict[str, MuscleReader] = {}
        self.create_timer(LOOK, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.create_subscription(
            ParameterEvent, '/parameter_events', self._changed, qos_profile_parameter_events
        )
        self._look()

    def _look(self) -> None:
        for prefix in muscles_among(self.get_topic_names_and_types()):
            if prefix not in self.readers:
                reader = MuscleReader(self, prefix, self.fresh)
                self.readers = {**self.readers, prefix: reader}
        for reader in self.readers.values():
            reader.look()

    def _changed(self, event: ParameterEvent) -> None:
        for reader in self.readers.values():
            reader.changed(event)

    def move(self, prefix: str, facts: Facts, angles: Floats, speeds: Floats) -> None:
        """Publish a muscle's angles (3,), rad, and speeds (3,), rad/s, as joint states."""
        publisher = self.readers[prefix].publisher
        if publisher is None:
            return
        joints = facts.joints
        signs = np.array(joints.signs)
        message = JointState(
            name=list(joints.names),
            position=(signs * (angles - joints.offsets)).tolist(),
            velocity=(signs * speeds).tolist(),
        )
        message.header.stamp = self.get_clock().now().to_msg()
        with suppress(InvalidHandle):  # the reader is about to make another
            publisher.publish(message)

    def spin(self, going: Callable[[], bool]) -> None:
        """Read messages as long as it is going: once a frame, the newest, whatever the rate.

        The readers' queues are short, so what is not read in time is never read, and this thread
        is as idle at 1 kHz as at 60 Hz.
        """
        try:
            executor = SingleThreadedExecutor(context=self.context)
            executor.add_node(self)
            while going():
                executor.spin_once(timeout_sec=0.1)
                if any(reader.waiting for reader in self.readers.values()):
                    begun = time.monotonic()
                    self._gather(executor)
                    time.sleep(max(begun + FRAME - time.monotonic(), 0.0))
            executor.shutdown()
        except (ExternalShutdownException, RCLError):  # the end, at an inconvenient moment
            if self.context.ok():
                raise

    def _gather(self, executor: SingleThreadedExecutor) -> None:
        """Take all that there is of an answer; wait a little for the markers, its last."""
        readers = self.readers.values()
        enough = self._taken + ANSWER * len(readers)
        for _ in range(GATHERINGS):
            time.sleep(GATHER)
            before = -1
            while before != (before := self._taken):
                executor.spin_once(timeout_sec=0.0)
            whole = all(reader.complete or not reader.waiting for reader in readers)
            if whole or self._taken > enough:
                break
        for reader in readers:
            reader.hand_over()

    @property
    def _taken(self) -> int:
        return sum(reader.taken for reader in self.readers.values())
