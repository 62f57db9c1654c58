# SPDX-License-Identifier: Apache-2.0
"""Whether a shoulder could have moved so: a recording's postures beside the model's range."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from operator import itemgetter

import numpy as np

from ..joints.articulation import PRISMATIC
from ..joints.conventions import JOINT_CONVENTIONS, JointConvention
from ..muscle.broad_muscle import BroadMuscle
from ..recordings.motion import Motion
from ..recordings.units import AngleRange, doubt_radians
from ..skeleton.followed_girdle import FollowedGirdle
from ..skeleton.joint_limits import JointLimits
from ..skeleton.lost_plane import count_without_plane
from ..skeleton.skeleton import Skeleton
from ..types import Floats
from .motion_source import MotionSource
from .options import Options
from .outputs import SolvedChunk

# Real recordings in radians, of the shoulder blade or the thorax, have at most 0.2 % of their
# frames so far outside; angles of some degrees, taken for radians, nearly always more than a tenth.
FAR = math.radians(45.0)
FAR_SHARE = 0.1
# Real glenohumeral motion lies up to 28 % outside.
OUTSIDE_SHARE = 0.5
DEGREES = math.degrees(1.0)
SAMPLES = 100  # frames of a chunk that are kept, to look for the cause


class Plausibility:
    """The postures of a recording, beside the model's range of motion.

    Parameters
    ----------
    muscle
        The model.
    options
        How the angles are read.
    motion
        The recording.
    moved
        How it moves the bones.
    """

    def __init__(
        self, muscle: BroadMuscle, options: Options, motion: Motion, moved: MotionSource
    ) -> None:
        """Begin with no frame."""
        self.muscle, self.options, self.motion, self.moved = muscle, options, motion, moved
        self.frames = self.outside = self.far = 0
        kinds = moved.moved_by.kinds
        self.met = AngleRange(
            moved.coordinates, [' m' if kind == PRISMATIC else '' for kind in kinds]
        )
        self._to_shown = np.array([1.0 if kind == PRISMATIC else DEGREES for kind in kinds])
        self.without_plane = 0
        self._limits = _limits_of(moved)
        self._beyond = np.zeros(len(kinds), dtype=np.int64)
        self._samples: list[Floats] = []

    def extend(self, solved: SolvedChunk) -> None:
        """Take the frames of a chunk in."""
        angles, rotations = solved.chunk.angles, solved.states.rotation
        self.frames += len(angles)
        self.outside += self.muscle.count_outside_range(rotations)
        if not self.motion.unit.said:
            self.far += self.muscle.count_outside_range(rotations, FAR)
        self.met.extend(angles * self._to_shown)
        if isinstance(self.moved.moved_by, FollowedGirdle):
            self.without_plane += count_without_plane(self.moved.moved_by, angles)
        if self._limits is not None:
            self._beyond += self._limits.find_beyond(angles).sum(axis=0)
        self._samples.append(angles[:: max(1, len(angles) // SAMPLES)])

    def check_unit(self) -> None:
        """Raise a RecordingError if the postures speak against radians that nobody stated.

        Only an angle that goes on beyond pi passes pi in radians. It stands for a posture
        that a shoulder takes, as one below pi does; angles of up to six degrees do not.
        """
        met = self.motion.met
        if met.largest > math.pi and self.far > FAR_SHARE * self.frames:
            raise doubt_radians(
                self.motion.path,
                met,
                f'in radians {self.far:,} of {self.frames:,} frames would lie more than '
                f'{math.degrees(FAR):.0f} deg outside the range of motion of {self.muscle.name}',
            )

    @property
    def notes(self) -> Iterator[str]:
        """What is odd of the values, a line each."""
        if self.without_plane:
            yield (
                f'{self.without_plane:,} of {self.frames:,} frames near the singularity, the arm '
                'at the side, whose plane of elevation the rhythm needs: moment arms jump there'
            )
        for k in np.flatnonzero(self._beyond).tolist():
            assert self._limits is not None
            low, high = (
                ends[k] / self._to_shown[k] for ends in (self.met.lowest, self.met.highest)
            )
            yield (
                f'warning: {self.motion.path}: {self._beyond[k]:,} of {self.frames:,} frames far '
                'beyond the limits of a joint: '
                + self._limits.describe(k, low, high, self.motion.unit.said)
            )

    @property
    def warning(self) -> str:
        """What to say where most frames lie outside the model's range; empty: nothing."""
        if self.outside <= OUTSIDE_SHARE * self.frames:
            return ''
        said = self.motion.unit.said or self.options.has_poses
        causes = [] if said else ['degrees (--degrees)?']
        causes += self._better_readings() or self._other_options()
        if not (self.options.follows or self.options.skeleton):
            causes.append('angles against the thorax instead of the scapula?')
        return (
            f"{self.outside:,} of {self.frames:,} frames lie outside the model's range of motion; "
            f'met, in deg: {self.met.describe()}; {" ".join(causes)}'
        )

    def _other_options(self) -> list[str]:
        """Return what may be wrong of the options that this motion takes."""
        if self.options.has_poses:
            return ['other frames, or other axes (--frame-axes)?', 'another rest (--rest-frames)?']
        if self.options.skeleton:
            return ['other joints (--joint-names)?', 'another --skeleton?']
        return ['another --convention?', 'other --signs?']

    def _better_readings(self) -> list[str]:
        """Return the options that would bring most frames into the range, the best one first."""
        if not isinstance(self.moved.moved_by, JointConvention) or self.moved.joints is None:
            return []
        angles = np.concatenate(self._samples)
        found = []
        for text, convention, reading in self._other_readings(angles):
            rotations, _ = convention.rotations_and_axes(reading, self.options.side)
            outside = self.muscle.count_outside_range(rotations)
            if outside < (1.0 - OUTSIDE_SHARE) * len(angles):
                found.append((outside, f'{text}?'))
        found.sort(key=itemgetter(0))  # of equal ones those with the fewest changes stay first
        return [text for _, text in found[:2]]

    def _other_readings(self, angles: Floats) -> Iterator[tuple[str, JointConvention, Floats]]:
        """Yield options, and how the sampled angles (k, 3) would be read with them."""
        chosen, joints = self.options.joint_convention, self.moved.joints
        assert joints is not None
        for convention in JOINT_CONVENTIONS.values():
            if convention is not chosen:
                yield f'--convention {convention.name}', convention, angles
        recorded = (angles - joints.offsets) * joints.signs
        turns = sorted(product((1.0, -1.0), repeat=3), key=lambda each: each.count(-1.0))[1:]
        for turn in turns:
            signs = np.array(turn) * joints.signs
            text = ' '.join(f'{sign:g}' for sign in signs)
            yield f'--signs {text}', chosen, recorded * signs + joints.offsets


def _limits_of(moved: MotionSource) -> JointLimits | None:
    """Return the limits of recorded joints; values that are found from poses keep to them."""
    if moved.joints is None or not isinstance(moved.moved_by, Skeleton):
        return None
    return JointLimits.from_skeleton(moved.moved_by)
