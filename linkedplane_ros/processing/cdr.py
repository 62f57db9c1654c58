"""The answers as they stand in a recording: CDR bytes, many at a time, without ROS.

All messages of a topic are alike but for their numbers: one is serialised by rosbags, and the
numbers of the others are put in its place.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import RecordingError
from ..recordings.bags import JOINT_STATE
from ..types import Floats
from .topics import ANSWERS, UINT8_ARRAY, Topic, dimension_names, label_dimensions

STAMP = np.array((0x5EC0FEED, 0x0DDBA115), dtype='<u4')  # an example that is found again


class Template:
    """One serialised message with places for numbers."""

    def __init__(self, message: bytes, **examples: npt.NDArray[Any]) -> None:
        """Find each place by the example that stands there; a stamp's are as many as there are."""
        self._bytes = np.frombuffer(message, np.uint8)
        self._places = {}
        for name, example in examples.items():
            sought = example.tobytes()
            starts = [message.rindex(sought)]  # numbers stand behind names
            if name == 'stamp':
                starts = [found.start() for found in re.finditer(re.escape(sought), message)]
            self._places[name] = [slice(start, start + len(sought)) for start in starts]

    def filled(self, count: int, **values: npt.NDArray[Any]) -> list[bytes]:
        """Return so many messages, with rows of values (count, ...) in their places."""
        if not count:
            return []
        rows = np.tile(self._bytes, (count, 1))
        for name, each in values.items():
            row = np.ascontiguousarray(each).reshape(count, -1).view(np.uint8)
            for place in self._places[name]:
                rows[:, place] = row.reshape(count, -1)
        return [row.tobytes() for row in rows]


def split_stamps(stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.uint32]:
    """Return stamps (m,), ns, as messages hold them (m, 2): whole seconds and the rest."""
    seconds, rest = np.divmod(stamps, 10**9)
    if len(seconds) and not -(2**31) <= seconds.min() <= seconds.max() < 2**31:
        raise RecordingError('a stamp holds whole seconds below 2^31: times in s expected')
    return np.column_stack((seconds.astype('<i4').view('<u4'), rest.astype('<u4')))


class JointStates:
    """Makes the joint states of joints whose names stay."""

    def __init__(self, store: Any, names: Sequence[str], frame_id: str) -> None:
        """`store`: the type store of rosbags."""
        examples = np.linspace(0.1, 0.2, 2 * len(names))
        position, velocity = examples[: len(names)], examples[len(names) :]
        self._moving, self._still = (
            self._template(store, names, frame_id, position, each)
            for each in (velocity, np.empty(0))
        )

    def _template(
        self, store: Any, names: Sequence[str], frame_id: str, position: Floats, velocity: Floats
    ) -> Template:
        time = store.types['builtin_interfaces/msg/Time'](*STAMP.tolist())
        message = store.types[JOINT_STATE](
            header=store.types['std_msgs/msg/Header'](stamp=time, frame_id=frame_id),
            name=list(names),
            position=position,
            velocity=velocity,
            effort=np.empty(0),
        )
        places = {'stamp': STAMP, 'position': position}
        if len(velocity):
            places['velocity'] = velocity
        return Template(bytes(store.serialize_cdr(message, JOINT_STATE)), **places)

    def filled(
        self, stamps: npt.NDArray[np.int64], positions: Floats, velocities: Floats
    ) -> list[bytes]:
        """Return a message for each stamp (m,), ns, with positions and velocities (m, n).

        Where a velocity is NaN, not known, that message has none.
        """
        split = split_stamps(stamps)
        made = self._still.filled(len(stamps), stamp=split, position=positions)
        known = np.flatnonzero(np.isfinite(velocities).all(axis=1))
        moving = self._moving.filled(
            len(known), stamp=split[known], position=positions[known], velocity=velocities[known]
        )
        for k, message in zip(known.tolist(), moving, strict=True):
            made[k] = message
        return made


class SerializedAnswers:
    """Makes the answers of one muscle and convention; the same as the node's."""

    def __init__(
        self, store: Any, bands: Sequence[str], coordinates: Sequence[str], frame_id: str
    ) -> None:
        """`store`: the type store of rosbags."""
        self._store = store
        names = dimension_names(bands, coordinates)
        self._templates = {
            topic.name: self._array(topic, *((kind, names[kind]) for kind in topic.dimensions))
            for topic in ANSWERS
            if topic.dimensions
        }
        self._states = JointStates(store, bands, frame_id)

    def _message(self, kind: str, **fields: Any) -> Any:
        return self._store.types[kind](**fields)

    def _array(self, topic: Topic, *dimensions: tuple[str, Sequence[str]]) -> Template:
        layout = self._message(
            'std_msgs/msg/MultiArrayLayout',
            dim=[
                self._message(
                    'std_msgs/msg/MultiArrayDimension', label=label, size=size, stride=stride
                )
                for label, size, stride in label_dimensions(*dimensions)
            ],
            data_offset=0,
        )
        size = math.prod(len(names) for _, names in dimensions)
        data = np.linspace(0.1, 0.2, size)  # an example that is found again
        if topic.type == UINT8_ARRAY:
            data = np.arange(200, 200 + size).astype(np.uint8)
        message = self._message(topic.type, layout=layout, data=data)
        return Template(bytes(self._store.serialize_cdr(message, topic.type)), data=data)

    def of(
        self,
        stamps: npt.NDArray[np.int64],
        lengths: Floats,
        arms: Floats,
        lengthening: Floats,
        wrap: npt.NDArray[np.uint8],
        vectors: Floats,
    ) -> dict[str, list[bytes]]:
        """Return each topic's messages for m states: stamps (m,) ns, the rest with a leading m.

        Lengthening (m, n) is NaN where it is not known; the velocity is then empty.
        """
        m = len(stamps)
        made = {
            topic: self._templates[topic].filled(m, data=values)
            for topic, values in (
                ('band_lengths', lengths),
                ('moment_arms', arms),
                ('wrap_states', wrap),
                ('moment_vectors', vectors),
            )
        }
        made['band_states'] = self._states.filled(stamps, lengths, lengthening)
        return {topic.name: made[topic.name] for topic in ANSWERS}
