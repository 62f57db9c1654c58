# SPDX-License-Identifier: Apache-2.0
"""What moves a muscle's bones in a recording: angles, joints of a skeleton, a rhythm, or poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..errors import LinkedPlaneError, describe_value
from ..joints.articulation import Articulation
from ..joints.conventions import JointConvention
from ..joints.joint_state import JointMap
from ..recordings.bone_frames import BoneFrames
from ..skeleton.followed_girdle import FollowedGirdle
from ..skeleton.measured import ConventionReading, PoseReading, SkeletonReading
from ..skeleton.rhythms import rhythm_from
from ..skeleton.skeleton import Skeleton, parse_pairs
from ..solver.linked_plane_solver import LinkedPlaneSolver
from .options import Options
from .rest_options import has_link, link_places, links_of, read_rest_frames

ONES, ZEROS = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class MotionSource:
    """How a recording moves a muscle's bones."""

    moved_by: Articulation
    """What values move the bones by."""
    reading: PoseReading | None = None
    """What reads values in whole poses, where these are recorded."""
    joints: JointMap | None = None
    """The recorded joints; None: poses are recorded."""
    frames: BoneFrames | None = None
    """The recorded frames; None: joints are recorded."""
    skeleton: str = ''
    """Its name or path; empty: there is none."""
    notes: tuple[str, ...] = ()
    """What is worth knowing, a line each."""
    held: tuple[str, ...] = ()
    """The muscle's bones that stay at rest, for nothing is recorded of them."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates."""
        return self.moved_by.coordinates


def choose_motion_source(
    options: Options, solver: LinkedPlaneSolver, skeleton: Skeleton | None = None
) -> MotionSource:
    """Return how a recording moves the bones of a muscle, as the options say.

    Raises
    ------
    LinkedPlaneError
        For a bone without a frame, a frame of two bones, a skeleton that does not suit, and
        numbers of joints that do not.
    """
    if skeleton is None and options.skeleton is not None:
        skeleton = Skeleton.load(options.skeleton)
    moved = _choose_source(options, solver, skeleton)
    held = solver.bones[1:-1]
    if not held or moved.reading is not None or not isinstance(moved.moved_by, JointConvention):
        return moved
    line = (
        f'{", ".join(held)}: held at rest, only the {solver.bones[-1]} moves; the poses of all '
        f'bones (--{held[0]}, --input tf), a --skeleton or a --rhythm move all'
    )
    return replace(moved, held=held, notes=(*moved.notes, line))


def _choose_source(
    options: Options, solver: LinkedPlaneSolver, skeleton: Skeleton | None
) -> MotionSource:
    frames = options.list_frames(solver.bones)
    if frames is None:
        return _by_joints(options, solver, skeleton)
    _check_different(frames)
    if options.follows:
        return _by_rhythm_of_poses(options, solver, frames)
    names, notes = _choose_frames(options, solver, skeleton, frames)
    if len(names) == 2 and skeleton is None and options.rest_frames is None:
        axes = options.frame_axes or 'model'
        return MotionSource(options.joint_convention, frames=BoneFrames(names, axes), notes=notes)
    return _by_poses(options, solver, skeleton, names, notes)


def _check_different(frames: Mapping[str, str]) -> None:
    """Raise a LinkedPlaneError for a frame that is given for two bones."""
    bones: dict[str, str] = {}
    for bone, frame in frames.items():
        if frame in bones:
            raise LinkedPlaneError(
                f'frame {describe_value(frame)} given for {bones[frame]} and {bone}; '
                'a frame of its own expected for each bone'
            )
        bones[frame] = bone


def _by_joints(
    options: Options, solver: LinkedPlaneSolver, skeleton: Skeleton | None
) -> MotionSource:
    if skeleton is not None:
        posed = skeleton.for_bones(solver.bones, options.links)
        joints = _map_skeleton_joints(options, posed)
        return MotionSource(posed, joints=joints, skeleton=options.skeleton or '')
    convention = options.joint_convention
    joints = _map_joints(options)
    if options.rhythm is not None:
        rhythm = rhythm_from(options.rhythm)
        girdle = FollowedGirdle(convention, rhythm, options.given_rest)
        return MotionSource(girdle, joints=joints)
    return MotionSource(convention, joints=joints)


def _by_rhythm_of_poses(
    options: Options, solver: LinkedPlaneSolver, names: Mapping[str, str]
) -> MotionSource:
    """Return the humerus against a scapula that follows it; of more bones, those that follow."""
    axes, convention = options.frame_axes or 'model', options.joint_convention
    rhythm = rhythm_from(options.rhythm or 'constant_ratio')
    frames = BoneFrames(names, axes, rhythm, options.given_rest)
    if len(solver.bones) == 2:
        return MotionSource(convention, frames=frames)
    girdle = FollowedGirdle(convention, rhythm, options.given_rest)
    return MotionSource(girdle, frames=replace(frames, rhythm=None))


def _choose_frames(
    options: Options,
    solver: LinkedPlaneSolver,
    skeleton: Skeleton | None,
    frames: Mapping[str, str],
) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return the frames that count, the ground's first, and a line for each that does not."""
    bones = solver.bones
    if bones[0] not in frames or bones[-1] not in frames:
        raise LinkedPlaneError(
            f'{solver.muscle.name}: its bones are {", ".join(bones)}, and frames of '
            f'{", ".join(frames)} are given; --input tf with --bone-links BONE:=FRAME names any'
        )
    links = {**frames, **options.links}
    others = [
        bone
        for bone in frames
        if bone not in bones and skeleton is not None and has_link(skeleton, bone, links)
    ]
    own = [bone for bone in bones[1:] if bone in frames]
    names = {bone: frames[bone] for bone in (bones[0], *others, *own)}
    notes = tuple(
        f'the frame of {bone}, {frame}, is not used: {solver.muscle.name} has no such bone'
        for bone, frame in frames.items()
        if bone not in names
    )
    return names, notes


def _by_poses(
    options: Options,
    solver: LinkedPlaneSolver,
    skeleton: Skeleton | None,
    names: Mapping[str, str],
    notes: tuple[str, ...],
) -> MotionSource:
    bones, side = solver.bones, solver.side
    missing = [bone for bone in bones if bone not in names]
    if missing:
        raise LinkedPlaneError(
            f'{solver.muscle.name}: no frame of {missing[0]}; its bones are {", ".join(bones)}: '
            f'--{missing[0]} NAME, or --input tf with --bone-links {missing[0]}:=NAME'
        )
    links, at_rest = {**names, **options.links}, {}
    reading: PoseReading = ConventionReading(options.joint_convention)
    moved_by: Articulation = options.joint_convention
    if skeleton is not None:
        at_rest = link_places(skeleton, tuple(names), links, side)
        posed = skeleton.for_bones(bones, links_of(skeleton, bones, links))
        whole = skeleton.for_bones(tuple(names), links_of(skeleton, tuple(names), links))
        reading, moved_by = SkeletonReading(posed, whole, side), posed
    at_rest |= read_rest_frames(options.rest_frames or (), tuple(names), links, side)
    axes = options.frame_axes or 'model'
    placed = BoneFrames(names, axes, at_rest=at_rest)
    return MotionSource(moved_by, reading, None, placed, options.skeleton or '', notes)


def _map_joints(options: Options) -> JointMap:
    """Return which recorded joints are a convention's coordinates."""
    a, b, c = options.joints or options.joint_convention.coordinates
    return JointMap((a, b, c), tuple(options.signs or ONES), tuple(options.offsets or ZEROS))


def _map_skeleton_joints(options: Options, skeleton: Skeleton) -> JointMap:
    """Return which recorded joints are a skeleton's; those that move no bone are not read."""
    names = parse_pairs('joint_names', 'JOINT:=NAME', options.joint_names or ())
    unknown = [joint for joint in names if joint not in skeleton.coordinates]
    if unknown:
        raise LinkedPlaneError(
            f'joint_names: {describe_value(unknown[0])} is no joint of {options.skeleton}; those '
            f'are {", ".join(skeleton.coordinates)}'
        )
    joints = tuple(names.get(each, each) for each in skeleton.coordinates)
    moving = {names.get(each, each) for each in skeleton.moving}
    d = len(joints)
    return JointMap(joints, (1.0,) * d, (0.0,) * d, skeleton.kinds, frozenset(set(joints) - moving))
