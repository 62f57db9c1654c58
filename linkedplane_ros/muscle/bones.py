# SPDX-License-Identifier: Apache-2.0
"""The bones of a muscle, and which of them each of its points belongs to (spec bones.md)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from ..errors import FieldError, describe_value
from ..linked_planes.layout import GROUND, HUMERUS, MOVING, PointBones

MOVING_FRAME, GROUND_FRAME = 'moving', 'ground'
SINGLE = ('ground_point', 'humeral_point', 'reference_normal')
LINES = ('origin', 'insertion')
MOST_BONES = 100  # no muscle spans as many


@dataclass(frozen=True)
class Bones:
    """The bones of a muscle, and where its points are; by default those of one ball joint.

    The ground bone comes first; it never moves. The last bone is the one that a rotation alone
    poses: about the ground's origin, as a ball joint does. At rest the frames of all bones are one.

    Raises
    ------
    ModelError
        For fewer than two names, names that repeat, and points on a bone that is not there.

    """

    names: tuple[str, ...] = ('scapula', 'humerus')
    origin: str | tuple[str, ...] = ''
    """Of all bands, or one for each; empty: the ground."""
    insertion: str | tuple[str, ...] = ''
    """Of all bands, or one for each; empty: the last bone."""
    ground_point: str = ''
    """Empty: the ground."""
    humeral_point: str = ''
    """Empty: the last bone."""
    reference_normal: str = ''
    """Empty: the ground."""

    def __post_init__(self) -> None:
        """Check the names and fill in what is empty; FieldError names the file's key."""
        object.__setattr__(self, 'names', check_bone_names(self.names))
        for field in (*LINES, *SINGLE):
            given = getattr(self, field)
            if field in LINES and isinstance(given, (list, tuple)):
                given = tuple(given)
                for i, each in enumerate(given):
                    self.require(f'bones.{field}[{i}]', each)
            elif given == '':
                given = self.names[-1 if field in ('insertion', 'humeral_point') else 0]
            else:
                self.require(f'bones.{field}', given)
            object.__setattr__(self, field, given)

    @property
    def ground(self) -> str:
        """The bone that never moves."""
        return self.names[0]

    @property
    def joint(self) -> str:
        """The bone that a rotation alone poses."""
        return self.names[-1]

    @property
    def frames(self) -> tuple[str, ...]:
        """What obstacle spheres may move with."""
        return (MOVING_FRAME, GROUND_FRAME, *self.names[1:])

    def require(self, field: str, value: Any, owner: str = '') -> str:
        """Return a value that is one of the bones; FieldError for any other."""
        if not isinstance(value, str) or value not in self.names:
            expected = f'one of {", ".join(self.names)} expected'
            raise FieldError(field, f'{describe_value(value)} given, {expected}', owner)
        return value

    def of_bands(self, field: str, n: int) -> tuple[str, ...]:
        """Return the bone of each of n bands' `origin` or `insertion`."""
        given: str | tuple[str, ...] = getattr(self, field)
        return (given,) * n if isinstance(given, str) else given

    def check_count(self, n: int) -> None:
        """Refuse lists of bones that do not have one for each of n bands."""
        for field in LINES:
            given: str | tuple[str, ...] = getattr(self, field)
            if isinstance(given, tuple) and len(given) != n:
                reason = f'a list of {n} bones, one for each band, expected, a list of '
                raise FieldError(f'bones.{field}', f'{reason}{len(given)} given')

    def number_points(self, frames: tuple[str, ...]) -> PointBones:
        """Return the number of each point's bone; `frames` (n) are what the spheres move with."""
        numbers = {name: number for number, name in enumerate(self.names)}
        spheres = {**numbers, MOVING_FRAME: MOVING, GROUND_FRAME: GROUND}
        origins, insertions = (
            [numbers[name] for name in self.of_bands(field, len(frames))] for field in LINES
        )
        return PointBones(
            numbers[self.reference_normal],
            numbers[self.ground_point],
            numbers[self.humeral_point],
            origins,
            insertions,
            [spheres[frame] for frame in frames],
        )

    def have_ball_joint(self, frames: tuple[str, ...]) -> bool:
        """Return whether the last bone has every insertion and HM, and neither an origin, SC nor N.

        Where the others are at rest, such a muscle is one of a ground and a bone on a ball joint.
        `frames` (n) are what the spheres move with.
        """
        standing = {self.reference_normal, *self.of_bands('origin', len(frames))}
        turning = {*self.of_bands('insertion', len(frames))}
        if MOVING_FRAME in frames:
            standing.add(self.ground_point)
            turning.add(self.humeral_point)
        return turning == {self.joint} and self.joint not in standing

    def number_on_ball_joint(self, frames: tuple[str, ...]) -> PointBones:
        """Return the bones' numbers where only the last one moves: HUMERUS; the others are GROUND.

        FieldError for a muscle that has no such ball joint.
        """
        if not self.have_ball_joint(frames):
            reason = (
                f'all insertions and HM on {self.joint}, and no origin, SC or N, expected here: '
                'this takes a muscle of one ball joint'
            )
            raise FieldError('bones', reason)
        n = len(frames)
        codes = {MOVING_FRAME: MOVING, self.joint: HUMERUS}
        spheres = [codes.get(frame, GROUND) for frame in frames]
        return PointBones(GROUND, GROUND, HUMERUS, [GROUND] * n, [HUMERUS] * n, spheres)


def check_bone_names(names: Any) -> tuple[str, ...]:
    """Return the names of the bones; FieldError for fewer than two, and for what is no name."""
    key = 'bones.names'
    if isinstance(names, str) or not isinstance(names, (tuple, list)) or len(names) < 2:
        reason = f'{describe_value(names)} given; the ground bone, then those that move expected'
        raise FieldError(key, reason)
    if len(names) > MOST_BONES:
        raise FieldError(key, f'{len(names)} bones given, at most {MOST_BONES} expected')
    for name in names:
        if not isinstance(name, str) or not re.fullmatch(r'[A-Za-z][A-Za-z0-9_]*', name):
            reason = f'{describe_value(name)} given; a letter, then letters, digits and _ expected'
            raise FieldError(key, reason)
        if name in (MOVING_FRAME, GROUND_FRAME):
            raise FieldError(key, f"{name!r} given; a bone's name expected")
        if list(names).count(name) > 1:
            raise FieldError(key, f'{name!r} appears twice; different names expected')
    return tuple(names)


BALL_JOINT = Bones()
"""Scapula and humerus, as version 1 of the model file has them."""
