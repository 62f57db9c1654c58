"""From a muscle state to messages: pure functions of message types, no node."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import (
    Float64MultiArray,
    Header,
    MultiArrayDimension,
    MultiArrayLayout,
    UInt8MultiArray,
)

from ..processing.layouts import BAND, dimensions
from ..solver.linked_plane_solver import MuscleState
from ..types import Floats


def layout(*dims: tuple[str, Sequence[str]]) -> MultiArrayLayout:
    """Return the row-major layout of these dimensions, as `layouts.dimensions`."""
    return MultiArrayLayout(
        dim=[
            MultiArrayDimension(label=label, size=size, stride=stride)
            for label, size, stride in dimensions(*dims)
        ]
    )


class Answers:
    """The answers on one muscle's topics: made once, then filled in for state after state."""

    def __init__(self, bands: Sequence[str], coordinates: Sequence[str], frame_id: str) -> None:
        """Name the bands and the coordinates in the layouts."""
        band = (BAND, bands)
        self._lengths = Float64MultiArray(layout=layout(band))
        self._arms = Float64MultiArray(layout=layout(band, ('coordinate', coordinates)))
        self._states = JointState(name=list(bands), header=Header(frame_id=frame_id))
        self._wrap = UInt8MultiArray(layout=layout(band))
        self._vectors = Float64MultiArray(layout=layout(band, ('axis', ('x', 'y', 'z'))))
        self._topics = {
            'band_lengths': self._lengths,
            'moment_arms': self._arms,
            'band_states': self._states,
            'wrap_states': self._wrap,
            'moment_vectors': self._vectors,
        }

    def at(
        self, stamp: Time, state: MuscleState, arms: Floats, lengthening: Floats | None
    ) -> Mapping[str, Any]:
        """Return each topic's message. The next call changes the same messages.

        `arms` (n, 3), m, about the coordinates; `lengthening` (n,), m/s, or None: not known. The
        bands are joints as well: their lengths the positions, their lengthening the velocities.
        """
        lengths = array('d', state.lengths.tobytes())
        self._lengths.data = lengths
        self._arms.data = array('d', arms.tobytes())
        self._states.header.stamp = stamp
        self._states.position = lengths
        self._states.velocity = array('d', b'' if lengthening is None else lengthening.tobytes())
        self._wrap.data = array('B', state.wrap.tobytes())
        self._vectors.data = array('d', state.moment_vectors.tobytes())
        return self._topics
