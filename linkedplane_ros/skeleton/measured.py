# SPDX-License-Identifier: Apache-2.0
"""Bones whose poses were measured, as what moves them: no joint says where they are.

Coordinates are read from the poses: a convention's angles of the last bone against the ground, or
the values of a skeleton's joints that fit. Moment arms are about these, at the measured poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError
from ..joints.articulation import MovedBones
from ..joints.conventions import JointConvention
from ..types import Floats
from .posture import PostureSearch
from .skeleton import Skeleton


@dataclass(frozen=True)
class MeasuredBones:
    """Bones at m measured poses, and the coordinates' values there (an `Articulation`)."""

    coordinates: tuple[str, ...]
    kinds: tuple[str, ...]
    values: Floats
    """(m, d) rad or m."""
    moved: MovedBones
    turn: Floats
    """(m,) rad, how far the worst bone is turned against where the values have it."""
    shift: Floats
    """(m,) m, how far its frame stands beside that."""

    def move_bones(self, values: npt.ArrayLike, bones: Sequence[str], side: str) -> MovedBones:
        """Return the bones where they were measured, whatever the values."""
        if len(bones) - 1 != self.moved.poses.shape[1]:
            raise LinkedPlaneError(
                f'bones: {self.moved.poses.shape[1]} measured, the muscle has {len(bones) - 1}'
            )
        return self.moved


class PoseReading(Protocol):
    """What finds the coordinates' values in measured poses."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates, d of them."""

    def read_poses(self, poses: Floats) -> MeasuredBones:
        """Return the bones at measured poses (m, k, 3, 4), right-shoulder form.

        Raises
        ------
        LinkedPlaneError
            For a pose that no values give.
        """


@dataclass(frozen=True)
class ConventionReading:
    """Reads a convention's angles: how the last bone is turned against the ground.

    They move that bone alone, about its own origin; moment arms are those with the others held.
    """

    convention: JointConvention

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The convention's."""
        return self.convention.coordinates

    def read_poses(self, poses: Floats) -> MeasuredBones:
        """Return the bones at measured poses (`PoseReading`)."""
        convention = self.convention
        m, k = poses.shape[:2]
        values = np.array([convention.angles(R) for R in poses[:, -1, :, :3]]).reshape(m, 3)
        _, axes = convention.rotations_and_axes(values)
        screws = np.zeros((m, 3, k, 6))
        screws[:, :, -1, :3] = axes.swapaxes(1, 2)
        screws[:, :, -1, 3:] = np.cross(poses[:, np.newaxis, -1, :, 3], screws[:, :, -1, :3])
        moved, nothing = MovedBones(poses, screws), np.zeros(m)
        return MeasuredBones(
            convention.coordinates, convention.kinds, values, moved, nothing, nothing
        )


class SkeletonReading:
    """Reads the values of a skeleton's joints.

    Parameters
    ----------
    skeleton
        For the muscle's bones.
    all_measured
        The same skeleton for all bones that are measured: the muscle's ground, bones that are none
        of the muscle's, and those that are.
    side
        The muscle's.
    """

    def __init__(self, skeleton: Skeleton, all_measured: Skeleton, side: str) -> None:
        """Prepare the search."""
        self._skeleton, self._side = skeleton, side
        self._others = len(all_measured.bones) - len(skeleton.bones)
        self._search = PostureSearch(all_measured, all_measured.bones, side)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The skeleton's."""
        return self._skeleton.coordinates

    def read_poses(self, poses: Floats) -> MeasuredBones:
        """Return the bones at measured poses, and the screws at the posture that fits them."""
        found, skeleton = self._search.find(poses), self._skeleton
        screws = skeleton.move_bones(found.values, skeleton.bones, self._side).screws
        moved = MovedBones(np.ascontiguousarray(poses[:, self._others :]), screws)
        return MeasuredBones(
            skeleton.coordinates, skeleton.kinds, found.values, moved, found.turn, found.shift
        )
