# SPDX-License-Identifier: Apache-2.0
"""Which measured frames are a muscle's bones, and where the bones are by them.

In a muscle the frames of all bones coincide at rest (spec bones.md, section 1). Measured frames
need not: a clavicle's is built on its own landmarks. So each has its place at rest, one of these:

* `COINCIDE`: the bone's frame is the measured one.
* `FIRST`: the muscle was at rest in the first frame of the motion.
* `GIVEN`: it stands at a place in the ground bone's measured frame then.
* `LINK`: the same of the bone's link in a skeleton, in right-shoulder form.
* `DOUBTED`: nobody said: it coincides, unless it begins too far from the ground's for that; then
  as `FIRST`, and a note says so.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..joints.joint_state import Rejected
from ..joints.rotations import compose_poses, invert_poses
from ..joints.sides import mirror_poses
from ..skeleton.girdle import Rest
from ..skeleton.rhythm import Rhythm
from ..types import Floats

# rows: the model's axes in ISB's (Wu 2005): lateral is ISB's z, anterior its x, superior its y
FRAME_AXES = {
    'model': np.eye(3),
    'isb': np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
}
COINCIDE, FIRST, LINK, GIVEN, DOUBTED = 'coincide', 'first', 'link', 'given', 'doubted'
NEAR = 0.05  # m: frames that coincide at rest are not farther apart when a motion begins
FARTHEST = 3.0  # m: no bone of a body is farther from another


@dataclass(frozen=True)
class RestPlace:
    """Where a bone's measured frame stands at rest."""

    kind: str = DOUBTED
    """One of the above."""
    place: Floats | None = None
    """(3, 4) of GIVEN and LINK: the measured frame in the ground's measured one, at rest; of the
    ground itself: the muscle's frame in the measured one."""

    def __str__(self) -> str:
        if self.place is None:
            return self.kind
        return f'{self.kind} {" ".join(f"{each:.9g}" for each in self.place.ravel())}'


@dataclass(frozen=True)
class BoneFrames:
    """Which frames are the bones: names of topics of poses, or of frames in /tf."""

    names: Mapping[str, str]
    """Of each bone's frame; the first bone is what the others are measured against: the muscle's
    ground, or the thorax where the scapula follows by a rhythm."""
    axes: str = 'model'
    """Of all frames: a key of FRAME_AXES."""
    rhythm: Rhythm | None = None
    """How the scapula follows; None: it is measured."""
    rest: Rest | None = None
    """Where the subject's girdle starts from; None: the rhythm's own."""
    at_rest: Mapping[str, RestPlace] | None = None
    """The place of each bone at rest; None: only the turn of the last bone counts."""

    @property
    def base(self) -> str:
        """The frame that the others are measured against."""
        return next(iter(self.names.values()))

    @property
    def last(self) -> str:
        """The frame of the bone on the ball joint."""
        return list(self.names.values())[-1]

    @property
    def facts(self) -> Mapping[str, str]:
        """Where the angles, and the poses, come from."""
        facts = {
            'angles_from': f'{self.last} against {self.base}, {self.axes} axes',
            'velocities': 'none',
            'scapulohumeral_rhythm': str(self.rhythm or 'none: measured against the scapula'),
        }
        if self.rest:
            facts['scapula_at_rest'] = str(self.rest)
        if self.at_rest is not None:
            facts['poses_from'] = json.dumps(dict(self.names))
            facts['frames_at_rest'] = json.dumps({k: str(v) for k, v in self.at_rest.items()})
        return facts


@dataclass
class BonePlacer:
    """Places the bones by their measured frames.

    Parameters
    ----------
    bones
        The frames, `at_rest` among them.
    side
        'right' or 'left': which side of the body the frames are of.
    """

    bones: BoneFrames
    side: str = 'right'
    notes: list[str] = field(default_factory=list)
    """What is worth knowing of what was decided, a line each."""
    _own: dict[str, Floats] = field(default_factory=dict)
    """Of each bone whose place at rest is known, its frame in the measured one (3, 4)."""

    def place(self, frames: Mapping[str, tuple[Floats, Floats]]) -> Floats:
        """Return the poses (k, 3, 4) of all bones but the first, in its frame.

        Parameters
        ----------
        frames
            Where the measured frame of each bone stands in a common one, R (3, 3), t (3,) m.

        Returns
        -------
        Floats
            Right-shoulder form, the model's axes.

        Raises
        ------
        Rejected
            For a bone whose place is not finite, or not that of a body's.
        """
        at = {bone: self._to_model(np.column_stack(frames[bone])) for bone in self.bones.names}
        ground, *moving = self.bones.names
        seen = invert_poses(at[ground])
        against = {bone: compose_poses(seen, at[bone]) for bone in moving}
        for bone, pose in against.items():
            self._check(bone, ground, pose)
        own_ground = self._frame_of_ground(ground)
        back = invert_poses(own_ground)
        poses = np.empty((len(moving), 3, 4))
        for k, bone in enumerate(moving):
            if bone not in self._own:
                self._own[bone] = self._find_own(bone, against[bone], own_ground)
            poses[k] = compose_poses(back, compose_poses(against[bone], self._own[bone]))
        return poses

    def _to_model(self, pose: Floats) -> Floats:
        """Return a measured pose (3, 4) as the model has it: its axes, right-shoulder form."""
        axes = FRAME_AXES[self.bones.axes]
        pose = np.column_stack([axes @ pose[:, :3] @ axes.T, axes @ pose[:, 3]])
        return mirror_poses(pose) if self.side == 'left' else pose

    def _check(self, bone: str, ground: str, pose: Floats) -> None:
        if not np.isfinite(pose).all():
            raise Rejected('not_finite', f'the place of {bone} is not finite; finite m expected')
        away = float(np.linalg.norm(pose[:, 3]))
        if away > FARTHEST:
            raise Rejected(
                'far',
                f'{bone} stands {away:.4g} m from {ground}; {FARTHEST:g} m at most expected: mm?',
            )

    def _frame_of_ground(self, ground: str) -> Floats:
        place = self._place_at_rest(ground)
        return np.eye(3, 4) if place is None else place

    def _place_at_rest(self, bone: str) -> Floats | None:
        rest = self._rest_of(bone)
        if rest.place is None or rest.kind == LINK:
            return rest.place
        return self._to_model(rest.place)

    def _rest_of(self, bone: str) -> RestPlace:
        return (self.bones.at_rest or {}).get(bone, RestPlace())

    def _find_own(self, bone: str, pose: Floats, ground: Floats) -> Floats:
        """Return the bone's frame in its measured one, which stands at a pose when it is first met.

        At rest it is the ground's: the measured frame at its place at rest, and the bone's in it.
        """
        rest = self._rest_of(bone)
        place = self._place_at_rest(bone)
        if place is not None:
            return compose_poses(invert_poses(place), ground)
        away = float(np.linalg.norm(pose[:, 3]))
        if rest.kind == DOUBTED and away > NEAR:
            base = next(iter(self.bones.names))
            self.notes.append(
                f'the frame of {bone} begins {1e3 * away:.0f} mm from that of {base}: they cannot '
                'coincide at rest, so the first frame is taken for the rest; rest_frames says '
                f'otherwise ({bone}:=first, or its place, X,Y,Z,ROLL,PITCH,YAW)'
            )
        elif rest.kind != FIRST:
            return ground
        return compose_poses(invert_poses(pose), ground)
