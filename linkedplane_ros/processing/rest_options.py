# SPDX-License-Identifier: Apache-2.0
"""Where measured frames stand at rest, as a user says it: `BONE:=WHERE`, or WHERE of all bones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..errors import LinkedPlaneError, describe_value
from ..joints.rotations import compose_poses, invert_poses
from ..joints.sides import mirror_poses
from ..recordings.bone_frames import COINCIDE, FIRST, GIVEN, LINK, RestPlace
from ..skeleton.packing import place_in_link
from ..skeleton.skeleton import Skeleton
from ..types import Floats

EXPECTED = (
    f'{COINCIDE}, {FIRST}, six numbers X,Y,Z,ROLL,PITCH,YAW (m, rad), or a skeleton expected, '
    'for all bones or as BONE:=...'
)


def read_rest_frames(
    entries: Sequence[str], bones: Sequence[str], links: Mapping[str, str], side: str
) -> dict[str, RestPlace]:
    """Return where the frames of bones stand at rest; those of which nothing is said are left out.

    Parameters
    ----------
    entries
        Each BONE:=WHERE, or WHERE of all other bones: `coincide`, `first`, a place in the ground
        bone's frame, or a skeleton whose links have these frames.
    bones
        All that have frames; the ground first.
    links
        The links of bones that are not named as they are.
    side
        Of the muscle.

    Raises
    ------
    LinkedPlaneError
        For a bone without a frame, and for what is no place.
    """
    said: dict[str, str] = {}
    for entry in entries:
        bone, named, where = (part.strip() for part in entry.partition(':='))
        if not named:
            said.update({each: bone for each in bones if each not in said})
        elif bone not in bones:
            raise LinkedPlaneError(
                f'rest_frames: {describe_value(bone)} has no frame; those are {", ".join(bones)}'
            )
        else:
            said[bone] = where
    return {bone: read_rest_place(where, bone, bones, links, side) for bone, where in said.items()}


def read_rest_place(
    text: str, bone: str, bones: Sequence[str], links: Mapping[str, str], side: str
) -> RestPlace:
    """Return where a bone's frame stands at rest; LinkedPlaneError for what says no such place."""
    if text in (COINCIDE, FIRST):
        return RestPlace(text)
    try:
        numbers = [float(each) for each in text.split(',')]
    except ValueError:
        return link_places(load_rest_skeleton(text), bones, links, side)[bone]
    if len(numbers) != 6 or not np.isfinite(numbers).all():
        raise LinkedPlaneError(f'rest_frames: {describe_value(text)} given; {EXPECTED}')
    x, y, z, roll, pitch, yaw = numbers
    return RestPlace(GIVEN, place_in_link((x, y, z), (roll, pitch, yaw)))


def load_rest_skeleton(text: str) -> Skeleton:
    """Return the skeleton of a name or path; LinkedPlaneError if it is neither."""
    try:
        return Skeleton.load(text)
    except LinkedPlaneError as error:
        if Path(text).suffix:
            raise
        raise LinkedPlaneError(f'rest_frames: {describe_value(text)} given; {EXPECTED}') from error


def link_places(
    skeleton: Skeleton, bones: Sequence[str], links: Mapping[str, str], side: str
) -> dict[str, RestPlace]:
    """Return where the links of bones stand at rest, which are the measured frames.

    Of a bone whose frame is called otherwise than its link, that is the one of the bone's name.
    """
    posed = skeleton.for_bones(bones, links_of(skeleton, bones, links))
    frames: Floats = posed.frames
    if (posed.side or side) == 'left':
        frames = mirror_poses(frames)
    at_rest = compose_poses(frames[:1], invert_poses(frames[1:]))
    places = [frames[0], *at_rest]
    return {bone: RestPlace(LINK, each) for bone, each in zip(bones, places, strict=True)}


def link_name(link: str) -> str:
    """Return the link in LINK or LINK@PLACE."""
    return link.partition('@')[0]


def has_link(skeleton: Skeleton, bone: str, links: Mapping[str, str]) -> bool:
    """Return whether a skeleton has a link for a bone."""
    return bone in skeleton.tree.links or link_name(links.get(bone, bone)) in skeleton.tree.links


def links_of(skeleton: Skeleton, bones: Sequence[str], links: Mapping[str, str]) -> dict[str, str]:
    """Return the links of those bones that are not named as they are, among the skeleton's."""
    return {
        bone: links[bone]
        for bone in bones
        if bone in links
        and (link_name(links[bone]) in skeleton.tree.links or bone not in skeleton.tree.links)
    }
