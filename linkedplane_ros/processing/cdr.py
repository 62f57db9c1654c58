# SPDX-License-Identifier: Apache-2.0
"""The answers as a recording holds them: CDR bytes, many messages at a time, without ROS.

The messages of a topic differ only in their numbers: rosbags serialises one, and the numbers of the
others replace its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import RecordingError
from ..recordings.bags.topics import JOINT_STATE
from ..types import Bytes, Floats, Stamps
from .topics import (
    ANSWERS,
    UINT8_ARRAY,
    WRENCHES,
    Topic,
    dimension_names,
    label_dimensions,
    moment_arm_names,
)

STAMP = np.array((0x5EC0FEED, 0x0DDBA115), dtype='<u4')  # found again in the bytes


class MessageTemplate:
    """One serialised message whose numbers can be replaced.

    Parameters
    ----------
    message
        CDR.
    placeholders
        The numbers in it, by name, as they are in the bytes; those named `stamp` may be repeated.
    """

    def __init__(self, message: bytes, **placeholders: npt.NDArray[Any]) -> None:
        """Find where each placeholder is in the message."""
        self._bytes = np.frombuffer(message, np.uint8)
        self._places = {}
        for name, placeholder in placeholders.items():
            sought = placeholder.tobytes()
            starts = [message.rindex(sought)]  # numbers come after names
            if name == 'stamp':
                starts = [match.start() for match in re.finditer(re.escape(sought), message)]
            self._places[name] = [slice(start, start + len(sought)) for start in starts]

    def fill(self, count: int, **values: npt.NDArray[Any]) -> list[bytes]:
        """Return `count` messages with values (count, ...) for the placeholders of their names."""
        if not count:
            return []
        rows = np.tile(self._bytes, (count, 1))
        for name, each in values.items():
            row = np.ascontiguousarray(each).reshape(count, -1).view(np.uint8)
            for place in self._places[name]:
                rows[:, place] = row.reshape(count, -1)
        return [row.tobytes() for row in rows]


def split_stamps(stamps: Stamps) -> npt.NDArray[np.uint32]:
    """Return stamps (m,), ns, as messages hold them (m, 2): whole seconds, and the rest in ns."""
    seconds, rest = np.divmod(stamps, 10**9)
    if len(seconds) and not -(2**31) <= seconds.min() <= seconds.max() < 2**31:
        raise RecordingError('a stamp holds whole seconds below 2^31: times in s expected')
    return np.column_stack((seconds.astype('<i4').view('<u4'), rest.astype('<u4')))


class JointStateSerializer:
    """Serialises joint states of the same joints.

    Parameters
    ----------
    store
        The type store of rosbags.
    names
        The n joints.
    frame_id
        Of the header.
    """

    def __init__(self, store: Any, names: Sequence[str], frame_id: str) -> None:
        """Serialise the templates: one with velocities, one without."""
        placeholders = np.linspace(0.1, 0.2, 2 * len(names))
        position, velocity = placeholders[: len(names)], placeholders[len(names) :]
        self._moving, self._still = (
            self._template(store, names, frame_id, position, each)
            for each in (velocity, np.empty(0))
        )

    def _template(
        self, store: Any, names: Sequence[str], frame_id: str, position: Floats, velocity: Floats
    ) -> MessageTemplate:
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
        return MessageTemplate(bytes(store.serialize_cdr(message, JOINT_STATE)), **places)

    def serialize(
        self, stamps: Stamps, positions: Floats, velocities: Floats | None = None
    ) -> list[bytes]:
        """Return the messages.

        Parameters
        ----------
        stamps
            (m,) ns.
        positions, velocities
            (m, n); a message with an unknown velocity, NaN, has no velocities. None: no message
            has any.
        """
        split = split_stamps(stamps)
        made = self._still.fill(len(stamps), stamp=split, position=positions)
        if velocities is None:
            return made
        known = np.flatnonzero(np.isfinite(velocities).all(axis=1))
        moving = self._moving.fill(
            len(known), stamp=split[known], position=positions[known], velocity=velocities[known]
        )
        for k, message in zip(known.tolist(), moving, strict=True):
            made[k] = message
        return made


def answer_topics(bones: Sequence[str]) -> tuple[Topic, ...]:
    """Return the topics of answers; the wrenches among them where there are bones for them."""
    return (*ANSWERS, WRENCHES) if bones else ANSWERS


class AnswerSerializer:
    """Serialises the answers of one muscle and convention; the same messages as the node's.

    Parameters
    ----------
    store
        The type store of rosbags.
    bands
        The names of the n bands.
    coordinates
        The names of the d coordinates.
    frame_id
        Of the headers.
    bones
        Those that move, where the wrenches on them are among the answers.
    """

    def __init__(
        self,
        store: Any,
        bands: Sequence[str],
        coordinates: Sequence[str],
        frame_id: str,
        bones: Sequence[str] = (),
    ) -> None:
        """Serialise a template for each topic."""
        self._store = store
        names = dimension_names(bands, coordinates, bones)
        self._topics = answer_topics(bones)
        self._templates = {
            topic.name: self._array(topic, *((kind, names[kind]) for kind in topic.dimensions))
            for topic in self._topics
            if topic.dimensions
        }
        self._states = JointStateSerializer(store, bands, frame_id)
        self._arm_states = JointStateSerializer(
            store, moment_arm_names(bands, coordinates), frame_id
        )

    def _message(self, kind: str, **fields: Any) -> Any:
        return self._store.types[kind](**fields)

    def _array(self, topic: Topic, *dimensions: tuple[str, Sequence[str]]) -> MessageTemplate:
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
        data = np.linspace(0.1, 0.2, size)  # found again in the bytes
        if topic.type == UINT8_ARRAY:
            data = np.arange(200, 200 + size).astype(np.uint8)
        message = self._message(topic.type, layout=layout, data=data)
        return MessageTemplate(bytes(self._store.serialize_cdr(message, topic.type)), data=data)

    def serialize(
        self,
        stamps: Stamps,
        lengths: Floats,
        arms: Floats,
        lengthening: Floats,
        wrap: Bytes,
        vectors: Floats,
        wrenches: Floats | None = None,
    ) -> dict[str, list[bytes]]:
        """Return the messages of each topic.

        Parameters
        ----------
        stamps
            (m,) ns.
        lengths
            (m, n) m.
        arms
            (m, n, d) m, about the coordinates.
        lengthening
            (m, n) m/s; NaN where not known: the velocity is then empty.
        wrap
            (m, n) WrapState.
        vectors
            (m, n, 3) m.
        wrenches
            (m, n, k, 6) m and 1; None where they are not among the answers.
        """
        m = len(stamps)
        made = {
            topic: self._templates[topic].fill(m, data=values)
            for topic, values in (
                ('band_lengths', lengths),
                ('moment_arms', arms),
                ('wrap_states', wrap),
                ('moment_vectors', vectors),
            )
        }
        made['band_states'] = self._states.serialize(stamps, lengths, lengthening)
        made['moment_arm_states'] = self._arm_states.serialize(stamps, arms)
        if wrenches is not None:
            made[WRENCHES.name] = self._templates[WRENCHES.name].fill(m, data=wrenches)
        return {topic.name: made[topic.name] for topic in self._topics}
