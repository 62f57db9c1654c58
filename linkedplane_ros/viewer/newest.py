# SPDX-License-Identifier: Apache-2.0
"""The newest state of a muscle, passed from the thread of ROS to the thread that draws."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from threading import Event, RLock
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ModelError
from ..joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION, JointConvention
from ..joints.joint_state import JointMap
from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats, Intervals

MARKERS_KEPT = 10  # messages: one that clears and those after it stay together


@dataclass(frozen=True)
class MuscleInfo:
    """What is known of a muscle besides its states."""

    coordinates: tuple[str, ...]
    bands: tuple[str, ...]
    """Empty until they are known."""
    convention: JointConvention
    joints: JointMap
    joint_topic: str
    side: str = 'right'
    heads: tuple[tuple[str, int], ...] = ()
    """Each head and the band that represents it."""
    motion: Intervals | None = None
    """The model's range of flexion, abduction and rotation, rad."""
    model: BroadMuscle | None = None
    """The model at the subject's size; None if it cannot be loaded here."""

    @staticmethod
    def from_parameters(
        coordinates: tuple[str, ...],
        bands: tuple[str, ...],
        joint_topic: str,
        node_parameters: Mapping[str, Any],
        muscle_name: str = '',
    ) -> MuscleInfo:
        """Return what the labels of the arrays and the parameters of their node say.

        Parameters
        ----------
        coordinates, bands
            From the labels; empty before the first answer.
        joint_topic
            The topic of the node's joint states.
        node_parameters
            The node's, by name. Without them the joints are the coordinates, and the convention
            is the one that has them. If the model cannot be loaded here, each band is a head.
        muscle_name
            That in its topics; it says which of the node's muscles it is.

        """
        conventions = JOINT_CONVENTIONS
        alike = [each for each in conventions.values() if each.coordinates == coordinates]
        default = [*alike, THESIS_CONVENTION][0]
        convention = conventions.get(node_parameters.get('joint_convention', ''), default)
        coordinates = coordinates or convention.coordinates
        names = [name for name in node_parameters.get('joint_names', ()) if name]
        joints = JointMap(
            unpack_three(names or coordinates),
            unpack_three(node_parameters.get('joint_signs', (1.0, 1.0, 1.0))),
            unpack_three(node_parameters.get('joint_offsets', (0.0, 0.0, 0.0))),
        )
        heads: tuple[tuple[str, int], ...] = tuple((band, i) for i, band in enumerate(bands))
        motion = None
        model = find_model(node_parameters.get('muscle', 'deltoid'), muscle_name, bands)
        if model is not None:
            bands = model.band_names
            heads = tuple((h.name, bands.index(h.represented_by)) for h in model.heads)
            motion = model.range_of_motion
        return MuscleInfo(
            coordinates,
            bands,
            convention,
            joints,
            joint_topic,
            node_parameters.get('side', 'right'),
            heads,
            motion,
            scale_model(model, node_parameters.get('scale', '1')),
        )


def find_model(given: str | Sequence[str], name: str, bands: tuple[str, ...]) -> BroadMuscle | None:
    """Return the model of a muscle among those of its node: by its name, or else by its bands.

    None if it cannot be loaded here, or has other bands; none in `bands` are those of any model.
    """
    texts = [given] if isinstance(given, str) else given
    models = []
    for text in texts:
        with suppress(ModelError):
            models.append(BroadMuscle.load(text))
    fitting = [model for model in models if bands in ((), model.band_names)]
    named = [model for model in fitting if model.name == name]
    if named or bands or len(texts) == 1:
        return next(iter(named or fitting), None)
    return None


def scale_model(model: BroadMuscle | None, scale: Any) -> BroadMuscle | None:
    """Return a model at the scale of its node; None if it cannot be scaled here."""
    with suppress(ModelError):
        return model and model.scaled(scale)
    return None


def group_by_arm(muscles: Mapping[str, MuscleInfo]) -> list[list[str]]:
    """Return the prefixes of muscles, in one list those that the same joint states move."""
    arms: dict[tuple[str, JointMap], list[str]] = {}
    for prefix, info in muscles.items():
        arms.setdefault((info.joint_topic, info.joints), []).append(prefix)
    return list(arms.values())


def unpack_three(items: Sequence[Any]) -> Any:
    """Return three items as a tuple."""
    first, second, third = items
    return first, second, third


@dataclass(frozen=True, eq=False)
class Values:
    """The numbers of a state; None where nothing has arrived yet."""

    lengths: Floats | None = None
    """(n,) m."""
    arms: Floats | None = None
    """(n, 3) m."""
    wrap: npt.NDArray[np.uint8] | None = None
    """(n,)"""
    angles: Floats | None = None
    """(3,) rad: the newest."""
    pose: Floats | None = None
    """(3,) rad: the angles of lengths and arms; None if they were missed."""
    answered: int = 0
    """The number of states so far."""
    present: bool = False
    """Whether a node publishes the muscle now."""
    rivals: int = 0
    """The number of other publishers of its joint states."""
    obstacle: str = ''
    """Why its arm is not moved from here; empty if it may be."""


class NewestState:
    """What is newest of one muscle; any thread may update it, any may take it."""

    def __init__(self, fresh: Event) -> None:
        """`fresh` is set at every update."""
        self._fresh = fresh
        self._lock = RLock()
        self._values = Values()
        self._info: MuscleInfo | None = None
        self._messages: deque[bytes] = deque(maxlen=MARKERS_KEPT)

    def update(self, messages: Sequence[bytes] = (), **values: Any) -> None:
        """Add serialised MarkerArrays, and replace values by their names in Values."""
        with self._lock:
            self._values = replace(self._values, **values)
            self._messages.extend(messages)
        self._fresh.set()

    def add_answer(self, messages: Sequence[bytes], pose: Floats | None, **values: Any) -> None:
        """Add a state: its markers, its values and the angles (3,), rad, that it belongs to."""
        with self._lock:
            self.update(messages, pose=pose, answered=self._values.answered + 1, **values)

    def set_info(self, info: MuscleInfo) -> None:
        """Replace what is known of the muscle."""
        with self._lock:
            self._info = info
        self._fresh.set()

    def take_newest(self) -> tuple[MuscleInfo | None, Values, list[bytes]]:
        """Return what is newest, and the markers since the last call."""
        with self._lock:
            messages = list(self._messages)
            self._messages.clear()
            return self._info, self._values, messages
