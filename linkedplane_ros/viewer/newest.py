"""The newest state of each muscle, handed from the thread of ROS to the thread that draws."""

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
from ..joints.conventions import JOINT_CONVENTIONS, JointConvention
from ..joints.joint_state import JointMap
from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats, Intervals

DEFAULT = 'flexion_abduction_rotation'
MARKERS_KEPT = 10  # messages: a clearing and what follows it are not to be torn apart


@dataclass(frozen=True)
class Facts:
    """What a muscle is, beside its states."""

    coordinates: tuple[str, ...]
    bands: tuple[str, ...]
    """None where they are not known yet."""
    convention: JointConvention
    joints: JointMap
    joint_topic: str
    side: str = 'right'
    heads: tuple[tuple[str, int], ...] = ()
    """Each head and the band that stands for it."""
    motion: Intervals | None = None
    """The model's range of flexion, abduction and rotation, rad."""

    @staticmethod
    def told(
        coordinates: tuple[str, ...],
        bands: tuple[str, ...],
        joint_topic: str,
        parameters: Mapping[str, Any],
    ) -> Facts:
        """Return what the labels of the arrays and the parameters of their node tell.

        The labels are empty before the first answer. Without parameters the joints are the
        coordinates, and the convention is that which has them. Where the model is not to be had
        here, each band is a head of its own.
        """
        named = JOINT_CONVENTIONS
        alike = [each for each in named.values() if each.coordinates == coordinates]
        convention = named.get(parameters.get('joint_convention', ''), [*alike, named[DEFAULT]][0])
        coordinates = coordinates or convention.coordinates
        names = [name for name in parameters.get('joint_names', ()) if name]
        joints = JointMap(
            three(names or coordinates),
            three(parameters.get('joint_signs', (1.0, 1.0, 1.0))),
            three(parameters.get('joint_offsets', (0.0, 0.0, 0.0))),
        )
        heads: tuple[tuple[str, int], ...] = tuple((band, i) for i, band in enumerate(bands))
        motion = None
        given = parameters.get('muscle', 'deltoid')
        one = isinstance(given, str)
        for muscle in [given] if one else given:
            with suppress(ModelError):
                model = BroadMuscle.load(muscle)
                bands = bands or (model.band_names if one else ())
                if model.band_names == bands:
                    heads = tuple((h.name, bands.index(h.represented_by)) for h in model.heads)
                    motion = model.range_of_motion
        side = parameters.get('side', 'right')
        return Facts(coordinates, bands, convention, joints, joint_topic, side, heads, motion)


def three(items: Sequence[Any]) -> Any:
    """Return three things as a tuple."""
    first, second, third = items
    return first, second, third


@dataclass(frozen=True, eq=False)
class Values:
    """The numbers of a state; None or empty where nothing has come yet."""

    lengths: Floats | None = None
    """(n,) m."""
    arms: Floats | None = None
    """(n, 3) m."""
    wrap: npt.NDArray[np.uint8] | None = None
    """(n,)"""
    angles: Floats | None = None
    """(3,) rad: the newest."""
    pose: Floats | None = None
    """(3,) rad: the angles that lengths and arms belong to; None where they were missed."""
    answered: int = 0
    """How many states have come."""
    present: bool = False
    """Whether a node publishes the muscle now."""
    rivals: int = 0
    """How many others publish joint states for it."""


class Newest:
    """What is newest of one muscle; any thread may put, any may take."""

    def __init__(self, fresh: Event) -> None:
        """`fresh` is set whenever something is put."""
        self._fresh = fresh
        self._lock = RLock()
        self._values = Values()
        self._facts: Facts | None = None
        self._messages: deque[bytes] = deque(maxlen=MARKERS_KEPT)

    def put(self, messages: Sequence[bytes] = (), **values: Any) -> None:
        """Take serialised MarkerArrays in, and values by their names in Values."""
        with self._lock:
            self._values = replace(self._values, **values)
            self._messages.extend(messages)
        self._fresh.set()

    def put_answer(self, messages: Sequence[bytes], pose: Floats | None, **values: Any) -> None:
        """Take in a state: markers, values and the angles (3,), rad, that it belongs to."""
        with self._lock:
            self.put(messages, pose=pose, answered=self._values.answered + 1, **values)

    def put_facts(self, facts: Facts) -> None:
        """Take in what the muscle is."""
        with self._lock:
            self._facts = facts
        self._fresh.set()

    def take(self) -> tuple[Facts | None, Values, list[bytes]]:
        """Return what is newest, and the markers that came since the last call."""
        with self._lock:
            messages = list(self._messages)
            self._messages.clear()
            return self._facts, self._values, messages
