"""From the poses of bones to joint angles: the humerus against the scapula, or the thorax.

A pose is that of a frame fixed to the bone: its axes are the model's (x to the body's right,
y anterior, z superior) or ISB's (x anterior, y superior, z to the body's right), on both sides.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .conventions import JOINT_CONVENTIONS, JointConvention
from .joint_input import Rejected, Three

Floats = npt.NDArray[np.float64]

POSE_TYPES = ('geometry_msgs/msg/PoseStamped', 'geometry_msgs/msg/TransformStamped')
TF_TYPE = 'tf2_msgs/msg/TFMessage'
# rows: the model's axes in ISB's (Wu 2005): lateral is ISB's z, anterior its x, superior its y
FRAME_AXES = {
    'model': np.eye(3),
    'isb': np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
}
MIRROR = np.diag((-1.0, 1.0, 1.0))  # x -> -x


@dataclass(frozen=True)
class Bones:
    """Which frames are the bones: names of topics of poses, or of frames in /tf."""

    humerus: str
    scapula: str | None = None
    thorax: str | None = None
    """Instead of the scapula; its share of an elevation is then taken off by the rhythm."""
    axes: str = 'model'
    rhythm: float = 2.0
    """Glenohumeral to scapulothoracic elevation."""

    @property
    def base(self) -> str:
        """What the humerus is measured against."""
        return self.scapula or self.thorax or ''


@dataclass
class PoseMemory:
    """The newest pose of each frame, and the rotation of the humerus that follows from two."""

    bones: Bones
    convention: JointConvention
    side: str = 'right'
    poses: dict[str, Floats] = field(default_factory=dict)
    parents: dict[str, str] = field(default_factory=dict)
    _stamps: dict[str, int] = field(default_factory=dict)

    @property
    def facts(self) -> Mapping[str, str]:
        """Where the angles come from."""
        bones = self.bones
        return {
            'angles_from': f'{bones.humerus} against {bones.base}, {bones.axes} axes',
            'velocities': 'none',
            'scapulohumeral_rhythm': 'none: measured against the scapula'
            if bones.scapula
            else f'{bones.rhythm:g} to 1',
        }

    def lacking(self) -> str:
        """Return which frames came, where none of their messages gave angles."""
        for bone in (self.bones.humerus, self.bones.base):
            if bone not in self.poses and bone not in self.parents.values():
                met = sorted({*self.poses, *self.parents.values()} - {''})
                return f'no pose of {bone}; frames met: {", ".join(met) or "none"}'
        humerus, base = (self._root(each) for each in (self.bones.humerus, self.bones.base))
        if humerus != base:
            return (
                f'{self.bones.humerus} is given in {humerus!r}, {self.bones.base} in {base!r}; '
                'poses in one frame expected'
            )
        return f'poses of {self.bones.humerus} and {self.bones.base} at no common stamp'

    def wants(self, topic: str, kind: str) -> bool:
        """Return whether a topic may have poses of the two bones."""
        named = topic in (self.bones.humerus, self.bones.base)
        return (named and kind in POSE_TYPES) or kind == TF_TYPE

    def take(self, message: Any, topic: str) -> Iterator[tuple[int, Three, None]]:
        """Take a message in; yield stamp (ns), angles, no speeds where the humerus has moved.

        Poses on two topics count together where their stamps are the same. In /tf the newest of
        each frame counts, once for a message that moves the humerus against the other bone.
        Raises Rejected where the pose is no good, or has no angles in the convention.
        """
        tree = hasattr(message, 'transforms')
        moved = {}
        for each in message.transforms if tree else (message,):
            name = each.child_frame_id.lstrip('/') if tree else topic
            self.parents[name] = each.header.frame_id.lstrip('/')
            pose = each.pose.orientation if hasattr(each, 'pose') else each.transform.rotation
            self.poses[name] = rotation(pose.x, pose.y, pose.z, pose.w)
            moved[name] = each.header.stamp.sec * 10**9 + each.header.stamp.nanosec
        self._stamps.update(moved)
        if not self._known():
            return
        humerus, base = self.bones.humerus, self.bones.base
        if tree:
            above = set(self._chain(base))
            own = [moved[name] for name in self._chain(humerus)
                   if name in moved and name not in above]  # fmt: skip
            if own:
                yield own[0], self._angles(), None
        elif self._stamps[humerus] == self._stamps[base]:
            yield self._stamps[humerus], self._angles(), None

    def _chain(self, frame: str) -> Iterator[str]:
        """Yield a frame and those it hangs on, up to the root."""
        seen: set[str] = set()
        while frame in self.poses and frame not in seen:
            seen.add(frame)
            yield frame
            frame = self.parents.get(frame, '')

    def _root(self, frame: str) -> str:
        chain = list(self._chain(frame))
        return self.parents.get(chain[-1], '') if chain else frame

    def _known(self) -> bool:
        humerus, base = self.bones.humerus, self.bones.base
        if self._root(humerus) != self._root(base):
            return False
        return humerus in self.poses and (base in self.poses or base == self._root(humerus))

    def _in_root(self, frame: str) -> Floats:
        R = np.eye(3)
        for each in self._chain(frame):
            R = self.poses[each] @ R
        return R

    def _angles(self) -> Three:
        axes = FRAME_AXES[self.bones.axes]
        R = axes @ self._in_root(self.bones.base).T @ self._in_root(self.bones.humerus) @ axes.T
        if self.side == 'left':  # the right shoulder's rotation at the same anatomical angles
            R = MIRROR @ R @ MIRROR
        if self.bones.scapula is None:
            R = glenohumeral(R, self.bones.rhythm)
        try:
            a, b, c = self.convention.angles(R).tolist()
        except ValueError as error:
            raise Rejected('no_angles', str(error)) from None
        return a, b, c


def glenohumeral(thoracic: Floats, rhythm: float) -> Floats:
    """Return the humerus against the scapula (3, 3) from that against the thorax.

    The scapula takes 1 / (1 + rhythm) of the elevation, in the plane of elevation (ISB's Y-X-Y):
    an assumption on the average shoulder (Inman 1944: 2 to 1), not a measurement.
    """
    convention = JOINT_CONVENTIONS['isb_yxy']
    plane, elevation, axial = convention.angles(thoracic)
    return convention.rotation((plane, elevation * rhythm / (1.0 + rhythm), axial))


def rotation(x: float, y: float, z: float, w: float) -> Floats:
    """Return the (3, 3) rotation of a quaternion; Rejected if it is none."""
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
