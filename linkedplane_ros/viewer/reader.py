# SPDX-License-Identifier: Apache-2.0
"""Reads the topics of one muscle: its states, its markers, and what its node is."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from threading import Event
from typing import Any

import numpy as np
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters
from rclpy._rclpy_pybind11 import NodeNameNonExistentError
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, UInt8MultiArray
from visualization_msgs.msg import MarkerArray

from ..errors import escape_controls
from ..node.parameters import NAMES
from ..processing.topics import read_label
from ..recordings.bags.topics import JOINT_STATE
from ..types import Floats
from .heard import HeardJoints
from .mover import ArmMover
from .newest import MARKERS_KEPT, MuscleInfo, NewestState

MOST_BANDS = 1000  # a label with more names is not one of a muscle
POSES_KEPT = 64  # joint states, to find the pose of an answer
MOST_COORDINATES = 100


def best_effort_profile(depth: int = 1) -> QoSProfile:
    """Return the quality of service of a reader of the newest messages of any publisher."""
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)


class MuscleReader:
    """Reads the topics of one muscle into its newest state."""

    def __init__(self, node: Node, prefix: str, fresh: Event, mover: ArmMover) -> None:
        """Subscribe to its topics (`/deltoid/...`); `fresh` is set at every update."""
        self.newest = NewestState(fresh)
        self._mover = mover
        self.taken = 0
        self._pending: dict[str, Any] = {}
        self._states: JointState | None = None
        self._markers: list[bytes] = []
        self._node = node
        self._prefix = prefix
        self._labels: tuple[tuple[str, ...], tuple[str, ...]] | None = None
        self._parameters: dict[str, Any] = {}
        self._heard: HeardJoints | None = None
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
            self._subscribe(kind, f'{prefix}/{topic}', callback, best_effort_profile())
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
        if len(names) != 2 or len(message.data) != len(names[0]) * len(names[1]):
            return
        if len(names[0]) > MOST_BANDS or not 0 < len(names[1]) <= MOST_COORDINATES:
            return
        if not np.isfinite(message.data).all():
            return
        if (names[1], names[0]) != self._labels:
            self._labels = names[1], names[0]
            self._answer = None  # the node has changed: ask it again
            self._update_info()
        self._pending['arms'] = np.array(message.data).reshape(len(names[0]), -1)

    def _take_states(self, message: JointState) -> None:
        if np.isfinite(message.position).all():
            self._states = message

    def _take_wrap(self, message: UInt8MultiArray) -> None:
        self._pending['wrap'] = np.array(message.data, np.uint8)

    def _take_joints(self, message: JointState) -> None:
        angles = self._heard.take_message(message) if self._heard else None
        if angles is not None:
            self._poses[message.header.stamp.sec, message.header.stamp.nanosec] = angles
            self._pending['angles'] = angles
        while len(self._poses) > POSES_KEPT:
            self._poses.popitem(last=False)

    @property
    def is_waiting(self) -> bool:
        """Whether a part of an answer has arrived and is not handed over."""
        return self._states is not None or 'arms' in self._pending or self.is_complete

    @property
    def is_complete(self) -> bool:
        """Whether the markers, the last part of an answer, have arrived."""
        return bool(self._markers)

    def hand_over(self) -> None:
        """Hand over all that has arrived since the last time, as one state."""
        messages = self._markers.copy()
        self._markers.clear()
        if self._states is not None:
            stamp = self._states.header.stamp
            self._pending['lengths'] = np.array(self._states.position)
            pose = self._poses.get((stamp.sec, stamp.nanosec))
            self._states = None
            self.newest.add_answer(messages, pose, **self._pending)
            self._pending = {}
        elif messages:
            self.newest.update(messages)

    def _update_info(self) -> None:
        """Pass on what is known of the muscle."""
        if self._joints is None or not (self._labels or self._parameters):
            return
        labels = self._labels or ((), ())
        topic, name = self._joints.topic_name, self._prefix.rpartition('/')[2]
        try:
            info = MuscleInfo.from_parameters(*labels, topic, self._parameters, name)
        except (TypeError, ValueError) as error:  # another program's, of the same names
            line = f'{self._prefix} is not shown: {escape_controls(str(error))}'
            self._node.get_logger().warning(line, once=True)
            return
        if self._heard is None or self._heard.joints != info.joints:
            self._heard = HeardJoints(info.joints)
        self.newest.set_info(info)

    def discover(self) -> None:
        """Find its node, what it is, and the topic of its joint states."""
        publishers = self._node.get_publishers_info_by_topic(f'{self._prefix}/markers')
        self.newest.update(present=bool(publishers), **self._look_out())
        if not publishers:
            self._answer = None  # the next node may be another
            return
        with suppress(StopIteration, NodeNameNonExistentError):  # its name may arrive later
            found = next(each for each in publishers if each.node_namespace.startswith('/'))
            name, namespace = found.node_name, found.node_namespace.rstrip('/')
            self._connect(f'{namespace}/{name}', self._joint_topic(name, namespace))
        if self._answer is None and self._client is not None and self._client.service_is_ready():
            self._answer = self._client.call_async(GetParameters.Request(names=list(NAMES)))
            self._answer.add_done_callback(self._receive_parameters)

    def _look_out(self) -> dict[str, Any]:
        """Return who else moves its arm, and why the viewer may not."""
        if self._joints is None:
            return {}
        topic = self._joints.topic_name
        rivals = len(self._mover.find_rivals(topic))
        obstacle = self._mover.find_obstacle(topic)
        if obstacle:
            self._mover.release(topic)
        return {'rivals': rivals, 'obstacle': obstacle}

    def _joint_topic(self, name: str, namespace: str) -> str:
        """Return the topic that a node takes its joint states from."""
        taken = self._node.get_subscriber_names_and_types_by_node(name, namespace or '/')
        topics = sorted(topic for topic, kinds in taken if JOINT_STATE in kinds)
        own = [topic for topic in topics if topic in self._mover.topics]
        named = [topic for topic in topics if topic.endswith('/joint_states')]
        return [*own, *named, *topics, f'{namespace}/joint_states'][0]

    def _connect(self, source: str, topic: str) -> None:
        """Connect to a node: its parameters and the topic of its joint states."""
        if source == self._source and self._joints.topic_name == topic:
            return
        for old, destroy in (
            (self._joints, self._node.destroy_subscription),
            (self._client, self._node.destroy_client),
        ):
            if old is not None:
                destroy(old)
        self._joints = self._subscribe(JointState, topic, self._take_joints, best_effort_profile(4))
        self._client = self._node.create_client(GetParameters, f'{source}/get_parameters')
        self._source, self._answer = source, None
        self._update_info()

    def _receive_parameters(self, answer: Any) -> None:
        """Store the node's parameters."""
        values = [parameter_value_to_python(value) for value in answer.result().values]
        self._parameters = {
            name: value for name, value in zip(NAMES, values, strict=False) if value is not None
        }
        self._update_info()

    def on_parameter_event(self, event: ParameterEvent) -> None:
        """Ask the node again if its parameters have changed."""
        if event.node == self._source:
            self._answer = None
