# SPDX-License-Identifier: Apache-2.0
"""From the poses of bones to joint angles, and to how the bones stand: on topics, and in /tf.

A pose is that of a frame fixed to the bone: its axes are the model's (x to the body's right,
y anterior, z superior) or ISB's (x anterior, y superior, z to the body's right), on both sides.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..errors import LinkedPlaneError
from ..joints.conventions import JointConvention
from ..joints.joint_state import Rejected, summarize_names
from ..joints.sides import mirror_rotation
from ..types import Floats, Triple
from .bone_frames import FRAME_AXES, BoneFrames, BonePlacer
from .frame_tree import FrameTree, MisplacedFrame, Transform, stamp_in_nanoseconds
from .motion import Frame, Place, Refused
from .units import AngleRange, AngleUnit

POSE_TYPES = ('geometry_msgs/msg/PoseStamped', 'geometry_msgs/msg/TransformStamped')
TF_TYPE = 'tf2_msgs/msg/TFMessage'
STATIC = 'tf_static'  # how the topic of static frames ends
MOST_WAITING = 1000  # stamps on a topic that wait for the other: it may lag so far behind
POSES = AngleUnit(False, 'poses')


@dataclass
class PoseFrameReader:
    """Reads frames of a motion out of poses: of the bones against the first of them.

    On topics, the poses of one stamp count together, in any order. In /tf the newest of each frame
    counts, once all messages of a stamp have come. Static frames have no stamp.

    Parameters
    ----------
    bones
        Which frames are the bones.
    convention
        What the angles mean.
    side
        'right' or 'left': which shoulder the frames are of.
    prompt
        Whether a frame of /tf is given as soon as all that moves has its stamp, and what is missing
        at a stamp is refused, as a running node wants it; where not, what comes later counts.
    timeout
        How much older than a frame's stamp what it needs may be, s; 0: any time.
    """

    bones: BoneFrames
    convention: JointConvention
    side: str = 'right'
    prompt: bool = False
    timeout: float = 0.0
    unit: AngleUnit = POSES
    met: AngleRange = field(default_factory=lambda: AngleRange(()))
    tree: FrameTree = field(default_factory=FrameTree)
    placer: BonePlacer = field(init=False)
    _waiting: dict[int, dict[str, Transform]] = field(default_factory=dict)
    """Poses on topics, by stamp, that still wait for the others."""
    _unpaired: int = 0
    """How many have waited in vain."""
    _due: tuple[int, Place] | None = None
    """Stamp and message of the newest move of a bone in /tf, without its frame so far."""
    _answered: int | None = None
    """The stamp of the last frame."""
    _frames: int = 0
    """How many frames there have been."""
    _topics: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        """Begin with no pose."""
        self.placer = BonePlacer(self.bones, self.side)

    @property
    def width(self) -> int:
        """How many angles a frame has; none where it has poses."""
        return 3 if self.bones.at_rest is None else 0

    @property
    def facts(self) -> Mapping[str, str]:
        """Where the angles come from."""
        return self.bones.facts

    @property
    def notes(self) -> list[str]:
        """What is worth knowing of how frames were read, a line each."""
        return self.placer.notes

    def accepts(self, topic: str, kind: str) -> bool:
        """Return whether a topic may have poses of the bones."""
        named = topic in self.bones.names.values()
        return (named and kind in POSE_TYPES) or kind == TF_TYPE

    def read_frames(self, message: Any, topic: str, place: Place) -> Iterator[Frame | Refused]:
        """Yield the frames that a message completes; speeds are not known.

        Refused where a pose cannot be used, or has no angles in the convention.
        """
        if not hasattr(message, 'transforms'):
            pose = message.pose if hasattr(message, 'pose') else message.transform
            yield from self._read_topic(message.header, pose, topic, place)
            return
        static = topic.endswith(STATIC)
        for each in message.transforms:
            stamp = stamp_in_nanoseconds(each.header.stamp)
            if stamp == 0 and place.instead is not None:
                stamp = place.instead
            name = each.child_frame_id.lstrip('/')
            falls = name in self.tree and stamp < self.tree[name].stamp
            if self._due is not None and not static and (stamp > self._due[0] or falls):
                yield from self._due_frame()
            self.tree.hang(name, read_transform(each.header, each.transform, stamp, place, static))
            if not static and self._moves_a_bone(name) and not self._is_answered(stamp):
                self._due = stamp, place
        if self.prompt and self._due is not None and self._is_complete(self._due[0]):
            yield from self._due_frame()

    def last_frames(self) -> Iterator[Frame | Refused]:
        """Yield the frame of the last stamp in /tf; that of static frames, if none moves."""
        if not self._frames and self._due is None:
            known = [self.tree[name] for name in self._names if name in self.tree]
            if known:
                newest = max(known, key=lambda each: each.stamp)
                self._due = newest.stamp, newest.place
        yield from self._due_frame()

    def unused_messages(self) -> Iterator[tuple[str, int, str]]:
        """Yield why, how many and where: poses without a frame."""
        left = self._unpaired + sum(map(len, self._waiting.values()))
        if left:
            names = ' or '.join(reversed(self._names))
            yield 'alone', left, f'poses of {names} without the other at their stamp'
        elif not self._frames and (lacking := self.find_lacking()) is not None:
            yield 'lacking', 0, str(lacking)

    @property
    def _names(self) -> list[str]:
        """Of the bones: topics, or frames without the slash that some put in front."""
        names = list(self.bones.names.values())
        if not self._topics.isdisjoint(names):
            return names
        return [name.lstrip('/') for name in names]

    def _read_topic(
        self, header: Any, pose: Any, topic: str, place: Place
    ) -> Iterator[Frame | Refused]:
        stamp = stamp_in_nanoseconds(header.stamp)
        self._topics.add(topic)
        here = self._waiting.setdefault(stamp, {})
        here[topic] = read_transform(header, pose, stamp, place, False)
        if len(here) == len(set(self.bones.names.values())):
            for name, transform in self._waiting.pop(stamp).items():
                self.tree.hang(name, transform)
            if self.find_lacking() is None:
                yield self._frame(stamp if place.instead is None else place.instead, place)
        elif len(self._waiting) > MOST_WAITING:
            self._unpaired += len(self._waiting.pop(next(iter(self._waiting))))

    def _find_chains(self) -> list[list[str]]:
        return [self.tree.find_chain(name) for name in self._names]

    def _find_moving(self) -> set[str]:
        """Return the frames between the bones: those that hang under some, but not under all."""
        chains = [set(chain) for chain in self._find_chains()]
        common = chains[0].intersection(*chains[1:])
        return chains[0].union(*chains[1:]) - common

    def _moves_a_bone(self, name: str) -> bool:
        """Return whether a frame makes a pose: of several bones any, of two the last one's."""
        try:
            if self.bones.at_rest is not None:
                return name in self._find_moving()
            base, last = self._find_chains()
            return name in set(last) - set(base)
        except Rejected:  # a loop
            return name in self._names

    def _is_answered(self, stamp: int) -> bool:
        return self.prompt and stamp == self._answered

    def _is_complete(self, stamp: int) -> bool:
        """Return whether all that moves the bones has come at a stamp."""
        if self.find_lacking() is not None:
            return False
        moving = [self.tree[name] for name in self._find_moving()]
        return all(each.static or each.stamp == stamp for each in moving)

    def _due_frame(self) -> Iterator[Frame | Refused]:
        due, self._due = self._due, None
        if due is None:
            return
        lacking = self.find_lacking()
        if lacking is None:
            self._answered = due[0]
            yield self._frame(*due)
        elif self.prompt or lacking.reason == 'loop':
            yield Refused(lacking.reason, str(lacking), due[1])

    def _frame(self, stamp: int, place: Place) -> Frame | Refused:
        self._frames += 1
        try:
            # of two bones the last one's frames are looked at first
            frames = {
                bone: self.tree.place_in_root(name)
                for bone, name in reversed(list(zip(self.bones.names, self._names, strict=True)))
            }
            if self.timeout:
                self._check_ages(stamp)
            if self.bones.at_rest is not None:
                return Frame(stamp, place, (), None, self.placer.place(frames))
            ground, *_, last = self.bones.names
            return Frame(stamp, place, self._angles(frames[last][0], frames[ground][0]))
        except MisplacedFrame as error:  # the message that brought it is at fault, not the newest
            return Refused(error.reason, str(error), self.tree[error.frame].place)
        except Rejected as error:
            return Refused(error.reason, str(error), place)

    def _check_ages(self, stamp: int) -> None:
        """Reject a frame if what it needs is of another time."""
        for name in sorted(self._find_moving()):
            hung = self.tree[name]
            age = 1e-9 * abs(stamp - hung.stamp)
            if not hung.static and age > self.timeout:
                raise Rejected(
                    'stale',
                    f'frame {name!r} is of {age:.3g} s away; {self.timeout:g} s at most expected '
                    '(joint_timeout)',
                )

    def find_lacking(self) -> Rejected | None:
        """Return why the bones do not hang together; None if they do."""
        try:
            roots = [self.tree.find_root(name) for name in self._names]
        except Rejected as error:
            return error
        names = self._names
        if len(set(roots)) == 1 and all(
            name in self.tree or name == root for name, root in zip(names, roots, strict=True)
        ):
            return None
        met = self.tree.names
        for name in reversed(names):
            if name not in met:
                listed = summarize_names(met, 12) if met else 'none'
                return Rejected('incomplete', f'no pose of {name}; frames met: {listed}')
        last, root = names[-1], roots[-1]
        other = next(k for k, each in enumerate(roots) if each != root)
        return Rejected(
            'apart',
            f'{last} is given in {root!r}, {names[other]} in {roots[other]!r}; '
            'poses in one frame expected',
        )

    def _angles(self, last: Floats, base: Floats) -> Triple:
        axes = FRAME_AXES[self.bones.axes]
        R = axes @ base.T @ last @ axes.T
        if self.side == 'left':  # the right shoulder's rotation at the same anatomical angles
            R = mirror_rotation(R)
        if self.bones.rhythm is not None:
            R = self.bones.rhythm.pose(R, rest=self.bones.rest).rotation
        try:
            a, b, c = self.convention.angles(R).tolist()
        except LinkedPlaneError as error:
            raise Rejected('no_angles', str(error)) from None
        return a, b, c


def read_transform(header: Any, pose: Any, stamp: int, place: Place, static: bool) -> Transform:
    """Return the transform in a message: of a Pose or a Transform."""
    turn = pose.orientation if hasattr(pose, 'orientation') else pose.rotation
    shift = pose.position if hasattr(pose, 'position') else pose.translation
    return Transform(
        header.frame_id.lstrip('/'),
        (turn.x, turn.y, turn.z, turn.w),
        (shift.x, shift.y, shift.z),
        stamp,
        place,
        static,
    )
