# SPDX-License-Identifier: Apache-2.0
"""From the poses of bones to joint angles: the humerus against the scapula, or the thorax.

A pose is that of a frame fixed to the bone: its axes are the model's (x to the body's right,
y anterior, z superior) or ISB's (x anterior, y superior, z to the body's right), on both sides.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import LinkedPlaneError
from ..joints.conventions import JointConvention
from ..joints.joint_state import Rejected, summarize_names
from ..joints.sides import mirror_rotation
from ..skeleton.girdle import Rest
from ..skeleton.rhythms import RHYTHMS, Rhythm
from ..types import Floats, Triple
from .motion import Frame, Place, Refused
from .units import AngleRange, AngleUnit

Quaternion = tuple[float, float, float, float]  # x, y, z, w

POSE_TYPES = ('geometry_msgs/msg/PoseStamped', 'geometry_msgs/msg/TransformStamped')
TF_TYPE = 'tf2_msgs/msg/TFMessage'
# rows: the model's axes in ISB's (Wu 2005): lateral is ISB's z, anterior its x, superior its y
FRAME_AXES = {
    'model': np.eye(3),
    'isb': np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
}
MOST_WAITING = 1000  # stamps on a topic that wait for the other: it may lag so far behind


@dataclass(frozen=True)
class BoneFrames:
    """Which frames are the bones: names of topics of poses, or of frames in /tf."""

    humerus: str
    scapula: str | None = None
    thorax: str | None = None
    """Instead of the scapula, which then follows the humerus by the rhythm."""
    axes: str = 'model'
    """Of all frames: a key of FRAME_AXES."""
    rhythm: Rhythm = RHYTHMS['constant_ratio']
    """How the scapula follows."""
    rest: Rest | None = None
    """Where the subject's girdle starts from; None: the rhythm's own."""

    @property
    def base(self) -> str:
        """The frame that the humerus is measured against."""
        return self.scapula or self.thorax or ''


POSES = AngleUnit(False, 'poses')


@dataclass
class PoseFrameReader:
    """Reads frames of a motion out of poses: the humerus against another bone.

    On topics, two poses of one stamp count together, in any order. In /tf the newest of each frame
    counts, once all messages of a stamp have come.

    Parameters
    ----------
    bones
        Which frames are the bones.
    convention
        What the angles mean.
    side
        'right' or 'left': which shoulder the frames are of.
    """

    bones: BoneFrames
    convention: JointConvention
    side: str = 'right'
    unit: AngleUnit = POSES
    met: AngleRange = field(default_factory=lambda: AngleRange(()))
    _poses: dict[str, Quaternion] = field(default_factory=dict)
    _parents: dict[str, str] = field(default_factory=dict)
    _origins: dict[str, Place] = field(default_factory=dict)
    """The message that each pose came with."""
    _stamps: dict[str, int] = field(default_factory=dict)
    """The newest stamp of each frame in /tf."""
    _waiting: dict[int, dict[str, tuple[Quaternion, Place]]] = field(default_factory=dict)
    """Poses on topics, by stamp, that still wait for the other."""
    _unpaired: int = 0
    """How many have waited in vain."""
    _due: tuple[int, Place] | None = None
    """Stamp and message of the newest move of the humerus in /tf, without its frame so far."""
    _frames: int = 0
    """How many frames there have been."""
    _topics: set[str] = field(default_factory=set)

    @property
    def facts(self) -> Mapping[str, str]:
        """Where the angles come from."""
        bones = self.bones
        return {
            'angles_from': f'{bones.humerus} against {bones.base}, {bones.axes} axes',
            'velocities': 'none',
            'scapulohumeral_rhythm': 'none: measured against the scapula'
            if bones.scapula
            else str(bones.rhythm),
            **({'scapula_at_rest': str(bones.rest)} if bones.rest else {}),
        }

    def accepts(self, topic: str, kind: str) -> bool:
        """Return whether a topic may have poses of the two bones."""
        named = topic in (self.bones.humerus, self.bones.base)
        return (named and kind in POSE_TYPES) or kind == TF_TYPE

    def read_frames(self, message: Any, topic: str, place: Place) -> Iterator[Frame | Refused]:
        """Yield the frames that a message completes; speeds are not known.

        Refused where a pose cannot be used, or has no angles in the convention.
        """
        if not hasattr(message, 'transforms'):
            pose = message.pose if hasattr(message, 'pose') else message.transform
            turn = pose.orientation if hasattr(pose, 'orientation') else pose.rotation
            yield from self._read_topic(message.header, turn, topic, place)
            return
        for each in message.transforms:
            stamp = stamp_in_nanoseconds(each.header.stamp)
            if stamp == 0 and place.instead is not None:
                stamp = place.instead
            name = each.child_frame_id.lstrip('/')
            falls = stamp < self._stamps.get(name, stamp)
            if self._due is not None and (stamp > self._due[0] or falls):
                yield from self._due_frame()
            self._stamps[name] = stamp
            self._store(each, stamp, place)

    def last_frames(self) -> Iterator[Frame | Refused]:
        """Yield the frame of the last stamp in /tf."""
        yield from self._due_frame()

    def unused_messages(self) -> Iterator[tuple[str, int, str]]:
        """Yield why, how many and where: poses without a frame."""
        left = self._unpaired + sum(map(len, self._waiting.values()))
        if left:
            names = ' or '.join(self._names)
            yield 'alone', left, f'poses of {names} without the other at their stamp'
        elif not self._frames and not self._has_both():
            yield 'lacking', 0, self._explain_missing()

    @property
    def _names(self) -> tuple[str, str]:
        """Of the two bones: topics, or frames without the slash that some put in front."""
        humerus, base = self.bones.humerus, self.bones.base
        if humerus in self._topics:
            return humerus, base
        return humerus.lstrip('/'), base.lstrip('/')

    def _read_topic(
        self, header: Any, turn: Any, topic: str, place: Place
    ) -> Iterator[Frame | Refused]:
        stamp = stamp_in_nanoseconds(header.stamp)
        self._topics.add(topic)
        self._parents[topic] = header.frame_id.lstrip('/')
        here = self._waiting.setdefault(stamp, {})
        here[topic] = (turn.x, turn.y, turn.z, turn.w), place
        if len(here) == 2:
            for name, (pose, origin) in self._waiting.pop(stamp).items():
                self._poses[name], self._origins[name] = pose, origin
            if self._has_both():
                yield self._frame(stamp if place.instead is None else place.instead, place)
        elif len(self._waiting) > MOST_WAITING:
            self._unpaired += len(self._waiting.pop(next(iter(self._waiting))))

    def _store(self, transform: Any, stamp: int, place: Place) -> None:
        name, turn = transform.child_frame_id.lstrip('/'), transform.transform.rotation
        self._parents[name] = transform.header.frame_id.lstrip('/')
        self._poses[name] = turn.x, turn.y, turn.z, turn.w
        self._origins[name] = place
        humerus, base = self._names
        if name in set(self._chain(humerus)) - set(self._chain(base)):
            self._due = stamp, place

    def _due_frame(self) -> Iterator[Frame | Refused]:
        due, self._due = self._due, None
        if due is not None and self._has_both():
            yield self._frame(*due)

    def _frame(self, stamp: int, place: Place) -> Frame | Refused:
        self._frames += 1
        for name in (*self._chain(self._names[0]), *self._chain(self._names[1])):
            try:
                rotation_from_quaternion(*self._poses[name])
            except Rejected as error:  # the message that brought it is at fault, not the newest
                return Refused(error.reason, str(error), self._origins[name])
        try:
            return Frame(stamp, place, self._angles())
        except Rejected as error:
            return Refused(error.reason, str(error), place)

    def _explain_missing(self) -> str:
        humerus, base = self._names
        for bone in (humerus, base):
            if bone not in self._poses and bone not in self._parents.values():
                met = sorted({*self._poses, *self._parents, *self._parents.values()} - {''})
                return (
                    f'no pose of {bone}; frames met: {summarize_names(met, 12) if met else "none"}'
                )
        return (
            f'{humerus} is given in {self._root(humerus)!r}, {base} in {self._root(base)!r}; '
            'poses in one frame expected'
        )

    def _chain(self, frame: str) -> Iterator[str]:
        """Yield a frame and its parents, up to the one below the root."""
        seen: set[str] = set()
        while frame in self._poses and frame not in seen:
            seen.add(frame)
            yield frame
            frame = self._parents.get(frame, '')

    def _root(self, frame: str) -> str:
        chain = list(self._chain(frame))
        return self._parents.get(chain[-1], '') if chain else frame

    def _has_both(self) -> bool:
        humerus, base = self._names
        if self._root(humerus) != self._root(base):
            return False
        return humerus in self._poses and (base in self._poses or base == self._root(humerus))

    def _rotation_in_root(self, frame: str) -> Floats:
        R = np.eye(3)
        for each in self._chain(frame):
            R = rotation_from_quaternion(*self._poses[each]) @ R
        return R

    def _angles(self) -> Triple:
        axes = FRAME_AXES[self.bones.axes]
        humerus, base = (self._rotation_in_root(name) for name in self._names)
        R = axes @ base.T @ humerus @ axes.T
        if self.side == 'left':  # the right shoulder's rotation at the same anatomical angles
            R = mirror_rotation(R)
        if self.bones.scapula is None:
            R = self.bones.rhythm.pose(R, rest=self.bones.rest).rotation
        try:
            a, b, c = self.convention.angles(R).tolist()
        except LinkedPlaneError as error:
            raise Rejected('no_angles', str(error)) from None
        return a, b, c


def stamp_in_nanoseconds(stamp: Any) -> int:
    """Return a message's stamp in ns."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def rotation_from_quaternion(x: float, y: float, z: float, w: float) -> Floats:
    """Return the rotation (3, 3) of a quaternion; Rejected unless it has unit length."""
    size = x * x + y * y + z * z + w * w
    if not 0.99 < size < 1.01:
        raise Rejected('not_unit', f'quaternion ({x:g}, {y:g}, {z:g}, {w:g}): unit length expected')
    s = 2.0 / size
    return np.array(
        (
            (1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
            (s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)),
            (s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)),
        )
    )
