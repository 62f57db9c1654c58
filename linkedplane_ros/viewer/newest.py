# SPDX-License-Identifier: Apache-2.0
"""The newest state of a muscle, passed from the thread of ROS to the thread that draws."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from threading import Event, RLock
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError, ModelError, SkeletonError
from ..joints.articulation import PRISMATIC, REVOLUTE
from ..joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION, JointConvention
from ..joints.joint_state import JointMap
from ..muscle.broad_muscle import BroadMuscle
from ..node.articulations import Articulations
from ..node.settings import NONE, ONES, map_joints
from ..skeleton.skeleton import Skeleton, parse_bone_links
from ..types import Floats, Intervals
from .names import short_name

MARKERS_KEPT = 10  # messages: one that clears and those after it stay together


class Unit(NamedTuple):
    """What a coordinate is shown in."""

    name: str
    size: float
    """In rad or m."""


DEGREE, MILLIMETRE = Unit('deg', math.pi / 180.0), Unit('mm', 1e-3)


@dataclass(frozen=True)
class MuscleInfo:
    """What is known of a muscle besides its states; d coordinates move it."""

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
    """The model's range of flexion, abduction and rotation, rad; None where it is not that of the
    coordinates."""
    skeleton: Skeleton | None = None
    """What has the coordinates, if no convention has; for the muscle's bones where these are
    known."""
    obstacle: str = ''
    """Why it can be shown, but not moved."""
    name: str = ''
    """The muscle's."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Those of its node, as far as they are known."""

    @property
    def units(self) -> tuple[Unit, ...]:
        """In which each coordinate is shown."""
        kinds = self.joints.kinds or (REVOLUTE,) * len(self.coordinates)
        return tuple(MILLIMETRE if kind == PRISMATIC else DEGREE for kind in kinds)

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

        Raises
        ------
        LinkedPlaneError
            For coordinates that are not those of the node's convention or skeleton.

        """
        conventions = JOINT_CONVENTIONS
        alike = [each for each in conventions.values() if each.coordinates == coordinates]
        default = [*alike, THESIS_CONVENTION][0]
        convention = conventions.get(node_parameters.get('joint_convention', ''), default)
        models = load_models(node_parameters.get('muscle', 'deltoid'))
        model = find_model(models, muscle_name, bands)
        moved, skeleton, obstacle = find_mover(
            node_parameters, convention, coordinates, models, model
        )
        heads: tuple[tuple[str, int], ...] = tuple((band, i) for i, band in enumerate(bands))
        motion = None
        if model is not None:
            bands = model.band_names
            heads = tuple((h.name, bands.index(h.represented_by)) for h in model.heads)
            motion = None if node_parameters.get('rhythm') else model.range_of_motion
        return MuscleInfo(
            moved.coordinates,
            bands,
            convention,
            map_joints(
                {
                    'joint_names': [
                        name for name in node_parameters.get('joint_names', ()) if name
                    ],
                    'joint_signs': list(node_parameters.get('joint_signs', ONES)),
                    'joint_offsets': list(node_parameters.get('joint_offsets', NONE)),
                },
                moved,
            ),
            joint_topic,
            node_parameters.get('side', 'right'),
            heads,
            motion,
            skeleton,
            obstacle,
            muscle_name,
            node_parameters,
        )


def find_mover(
    parameters: Mapping[str, Any],
    convention: JointConvention,
    labelled: tuple[str, ...],
    models: Sequence[BroadMuscle],
    own: BroadMuscle | None,
) -> tuple[Articulations, Skeleton | None, str]:
    """Return what moves the bones: its coordinates, the skeleton, and why it is not moved here.

    Parameters
    ----------
    parameters
        The node's.
    convention
        Its joint convention, which a skeleton replaces.
    labelled
        The coordinates by the labels of the arrays; empty before the first answer.
    models
        The node's muscles.
    own
        The one for whose bones the skeleton is returned; None: for those of its URDF.

    """
    name = parameters.get('skeleton', '')
    if not name:
        coordinates = labelled or convention.coordinates
        if len(coordinates) != len(convention.coordinates):
            raise LinkedPlaneError(f'{len(coordinates)} coordinates of a convention of 3')
        return Articulations(coordinates=coordinates, kinds=convention.kinds), None, ''
    try:
        skeleton = loaded = Skeleton.load(name)
        links = parse_bone_links(filter(None, parameters.get('bone_links', ())))
        moving: set[str] = set()
        for model in models:
            bones = model.bones.names
            fitted = loaded.for_bones(
                bones, {bone: link for bone, link in links.items() if bone in bones}
            )
            moving.update(fitted.moving)
            if model is own:
                skeleton = fitted
    except SkeletonError:
        if not labelled:
            line = f'skeleton {short_name(name)} is not known here before it has moved'
            raise LinkedPlaneError(line) from None
        obstacle = f'its skeleton, {short_name(name)}, is not known here: it is shown, not moved'
        return Articulations(coordinates=labelled), None, obstacle
    coordinates = skeleton.coordinates
    if labelled not in ((), coordinates):
        raise LinkedPlaneError(f'its coordinates are not those of skeleton {short_name(name)}')
    idle = frozenset(coordinates) - moving if models else frozenset()
    return Articulations((), coordinates, skeleton.kinds, idle), skeleton, ''


def load_models(given: str | Sequence[str]) -> list[BroadMuscle]:
    """Return the models of a node's muscles that can be loaded here."""
    models = []
    for text in [given] if isinstance(given, str) else given:
        with suppress(ModelError):
            models.append(BroadMuscle.load(text))
    return models


def find_model(
    models: Sequence[BroadMuscle], name: str, bands: tuple[str, ...]
) -> BroadMuscle | None:
    """Return the model of a muscle among those of its node: by its name, or else by its bands.

    None if none has these bands; none in `bands` are those of any model.
    """
    fitting = [model for model in models if bands in ((), model.band_names)]
    named = [model for model in fitting if model.name == name]
    if named or bands or len(models) == 1:
        return next(iter(named or fitting), None)
    return None


def group_by_arm(muscles: Mapping[str, MuscleInfo]) -> list[list[str]]:
    """Return the prefixes of muscles, in one list those that the same joint states move."""
    arms: dict[tuple[str, JointMap], list[str]] = {}
    for prefix, info in muscles.items():
        arms.setdefault((info.joint_topic, info.joints), []).append(prefix)
    return list(arms.values())


def match_coordinate(info: MuscleInfo, other: MuscleInfo, number: int) -> int | None:
    """Return which of a muscle's coordinates stands for a number of another's.

    The same one where both have as many, as conventions do; else that of its name, if there is one.
    """
    if len(info.coordinates) == len(other.coordinates):
        return number
    name = other.coordinates[number]
    return info.coordinates.index(name) if name in info.coordinates else None


@dataclass(frozen=True, eq=False)
class Values:
    """The numbers of a state; None where nothing has arrived yet."""

    lengths: Floats | None = None
    """(n,) m."""
    arms: Floats | None = None
    """(n, d) m; about prismatic coordinates without a unit."""
    wrap: npt.NDArray[np.uint8] | None = None
    """(n,)"""
    angles: Floats | None = None
    """(d,) rad or m: the newest."""
    pose: Floats | None = None
    """(d,) rad or m: those of lengths and arms; None if they were missed."""
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
        """Add a state: its markers, its values and the coordinates (d,) that it belongs to."""
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
