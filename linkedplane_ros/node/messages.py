# SPDX-License-Identifier: Apache-2.0
"""From a muscle state to the arrays and joint states that the node publishes."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from builtin_interfaces.msg import Time
from std_msgs.msg import MultiArrayDimension, MultiArrayLayout

from ..processing.topics import (
    ANSWERS,
    WRENCHES,
    dimension_names,
    label_dimensions,
    moment_arm_names,
)
from ..solver.states import MuscleState
from ..types import Floats


def message_class(name: str) -> Any:
    """Return the class of a message type such as `std_msgs/msg/Float64MultiArray`."""
    package, _, kind = name.split('/')
    return getattr(import_module(f'{package}.msg'), kind)


def layout(*dimensions: tuple[str, Sequence[str]]) -> MultiArrayLayout:
    """Return the row-major layout of these dimensions, as `topics.label_dimensions`."""
    return MultiArrayLayout(
        dim=[
            MultiArrayDimension(label=label, size=size, stride=stride)
            for label, size, stride in label_dimensions(*dimensions)
        ]
    )


class Answers:
    """The messages of one muscle's topics: built once, then filled in for each state.

    Parameters
    ----------
    bands, coordinates, bones
        The names in the layouts of the arrays, and of the joints of the states.
    frame_id
        The frame of the states.

    """

    def __init__(
        self,
        bands: Sequence[str],
        coordinates: Sequence[str],
        frame_id: str,
        bones: Sequence[str] = (),
    ) -> None:
        names = dimension_names(bands, coordinates, bones)
        self._wrenches = message_class(WRENCHES.type)()
        self._wrenches.layout = layout(*((kind, names[kind]) for kind in WRENCHES.dimensions))
        self._topics = {topic.name: message_class(topic.type)() for topic in ANSWERS}
        for topic in ANSWERS:
            if topic.dimensions:
                self._topics[topic.name].layout = layout(
                    *((kind, names[kind]) for kind in topic.dimensions)
                )
        for topic, joints in (
            ('band_states', list(bands)),
            ('moment_arm_states', moment_arm_names(bands, coordinates)),
        ):
            states = self._topics[topic]
            states.name, states.header.frame_id = joints, frame_id

    def update(
        self, stamp: Time, state: MuscleState, arms: Floats, lengthening: Floats | None
    ) -> Mapping[str, Any]:
        """Return the message of each topic. The next call changes the same messages.

        Parameters
        ----------
        stamp
            The input's.
        state
            The muscle's.
        arms
            (n, d) moment arms about the coordinates, m.
        lengthening
            (n,) lengthening speeds, m/s; None if the input has no velocities.

        """
        topics = self._topics
        lengths = array('d', state.lengths.tobytes())
        topics['band_lengths'].data = lengths
        moment_arms = array('d', arms.tobytes())
        topics['moment_arms'].data = moment_arms
        topics['wrap_states'].data = array('B', state.wrap.tobytes())
        topics['moment_vectors'].data = array('d', state.moment_vectors.tobytes())
        states = topics['band_states']
        states.header.stamp = stamp
        states.position = lengths
        speeds = array('d', b'' if lengthening is None else lengthening.tobytes())
        states.velocity = speeds
        arm_states = topics['moment_arm_states']
        arm_states.header.stamp = stamp
        arm_states.position = moment_arms
        self._numbers = lengths, moment_arms, speeds
        return topics

    def update_wrenches(self, state: MuscleState) -> Any:
        """Return the message of the wrenches on the bones; the next call changes the same one."""
        self._wrenches.data = array('d', state.wrenches.tobytes())
        return self._wrenches

    def add_up(self) -> float:
        """Return the sum of all lengths, arms and speeds of the newest messages."""
        return sum(map(sum, self._numbers))
