"""From a muscle state to messages: pure functions of message types, no node."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from builtin_interfaces.msg import Time
from std_msgs.msg import MultiArrayDimension, MultiArrayLayout

from ..processing.topics import ANSWERS, dimension_names, label_dimensions
from ..solver.linked_plane_solver import MuscleState
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
    """The messages on one muscle's topics: built once, then filled in for state after state."""

    def __init__(self, bands: Sequence[str], coordinates: Sequence[str], frame_id: str) -> None:
        """Name the bands and the coordinates in the layouts."""
        names = dimension_names(bands, coordinates)
        self._topics = {topic.name: message_class(topic.type)() for topic in ANSWERS}
        for topic in ANSWERS:
            if topic.dimensions:
                self._topics[topic.name].layout = layout(
                    *((kind, names[kind]) for kind in topic.dimensions)
                )
        states = self._topics['band_states']
        states.name, states.header.frame_id = list(bands), frame_id

    def at(
        self, stamp: Time, state: MuscleState, arms: Floats, lengthening: Floats | None
    ) -> Mapping[str, Any]:
        """Return each topic's message. The next call changes the same messages.

        `arms` (n, 3), m, about the coordinates; `lengthening` (n,), m/s, or None: not known. The
        bands are joints as well: their lengths the positions, their lengthening the velocities.
        """
        topics = self._topics
        lengths = array('d', state.lengths.tobytes())
        topics['band_lengths'].data = lengths
        topics['moment_arms'].data = array('d', arms.tobytes())
        topics['wrap_states'].data = array('B', state.wrap.tobytes())
        topics['moment_vectors'].data = array('d', state.moment_vectors.tobytes())
        states = topics['band_states']
        states.header.stamp = stamp
        states.position = lengths
        states.velocity = array('d', b'' if lengthening is None else lengthening.tobytes())
        return topics
