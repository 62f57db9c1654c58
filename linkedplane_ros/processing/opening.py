# SPDX-License-Identifier: Apache-2.0
"""From a recording and how it moves the bones to the motion that is solved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ..errors import RecordingError
from ..joints.conventions import JointConvention
from ..recordings.bag_motion import BagMotion
from ..recordings.formats import TABLES, check_format
from ..recordings.motion import Motion
from ..recordings.smoothing import SmoothedMotion
from ..recordings.table_motion import TableMotion
from ..skeleton.followed_girdle import FollowedGirdle
from ..skeleton.girdle import HUMERUS, Rest
from ..skeleton.still_second import NOT_STILL, find_rest
from .motion_source import MotionSource
from .options import Options


def open_motion(source: Path, options: Options, moved: MotionSource) -> Motion:
    """Open a recording as it is to be solved; RecordingError if it cannot be used."""
    motion = open_recorded(source, options, moved)
    motion.refused.notes += moved.notes
    if options.rate is None and options.lowpass is None and not options.differentiate:
        return motion
    if moved.frames is not None and moved.frames.at_rest is not None:
        raise RecordingError(f'{source}: whole poses are neither filtered nor resampled')
    return SmoothedMotion(motion, options.rate, options.lowpass)


def open_recorded(source: Path, options: Options, moved: MotionSource) -> BagMotion | TableMotion:
    """Open the recording as it is."""
    check_format(source)
    frames, joints = moved.frames, moved.joints
    if source.suffix.lower() in TABLES:
        if joints is None:
            raise RecordingError(f'{source}: a table has no frames; --humerus is for bags')
        return TableMotion(source, joints, options.degrees, options.time)
    if options.time is not None:
        raise RecordingError(f'{source}: a bag has stamps; --time is for tables')
    if frames is not None:
        return BagMotion.from_poses(source, frames, options.joint_convention, options.side)
    assert joints is not None
    return BagMotion.from_joint_states(source, joints, options.topic, options.degrees)


def settle_rest(source: Path, options: Options, moved: MotionSource) -> MotionSource:
    """Return how the bones are moved, with the rest that the recording says where it is asked to.

    RecordingError if it has no still second.
    """
    if not options.rests_still:
        return moved
    convention = options.joint_convention
    motion: Motion
    if moved.frames is not None:  # read as the rhythm's own angles
        against_thorax = replace(moved.frames, rhythm=None)
        motion = BagMotion.from_poses(source, against_thorax, HUMERUS, options.side)
        convention = HUMERUS
    else:
        motion = open_recorded(source, options, moved)
    rest = read_rest(motion, convention, options.given_rest)
    moved_by, frames = moved.moved_by, moved.frames
    if isinstance(moved_by, FollowedGirdle):
        moved_by = replace(moved_by, rest=rest)
    if frames is not None and frames.rhythm is not None:
        frames = replace(frames, rest=rest)
    return replace(moved, moved_by=moved_by, frames=frames)


def read_rest(motion: Motion, convention: JointConvention, given: Rest | None) -> Rest:
    """Return the rest with the humerus' of the first still second; RecordingError if there is none.

    Parameters
    ----------
    motion
        The humerus against the thorax.
    convention
        What its angles mean.
    given
        What is known of the rest.
    """
    motion.keeps_records = False
    still = find_rest(
        (stamp, {'humerus': convention.rotation(angles)})
        for chunk in motion.chunks()
        for stamp, angles in zip(chunk.stamps.tolist(), chunk.angles, strict=True)
    )
    if still.rest is None:
        raise RecordingError(
            f'{motion.path}: --rest still: {NOT_STILL}; give --rest PROTRACTION LATERAL TILT PLANE '
            'ELEVATION, rad, or leave it out'
        )
    return replace(given or still.rest, humerus=still.rest.humerus)
