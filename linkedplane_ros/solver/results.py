# SPDX-License-Identifier: Apache-2.0
"""What all results of the solver have in common: equality by value, and where everything is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..joints.articulation import rotated_poses
from ..types import Floats

if TYPE_CHECKING:
    from .linked_plane_solver import LinkedPlaneSolver


class PosedBones(NamedTuple):
    """The k bones that move, and what n bands do to them; all with a leading m at m poses."""

    poses: Floats
    """(k, 3, 4) R and t of each, side by side."""
    wrenches: Floats
    """(n, k, 6)"""

    def keep_as_is(self) -> None:
        """Make the arrays read-only."""
        for array in self:
            array.setflags(write=False)

    def choose(self, part: Any) -> PosedBones:
        """Return one, or some, of m."""
        return PosedBones(self.poses[part], self.wrenches[part])


class Result:
    """What all results have in common: equality by value, and small pickles."""

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        return all(map(_are_equal, self._values(), other._values()))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self._values()  # only the fields: drawings are made again

    def _values(self) -> tuple[Any, ...]:
        return tuple(getattr(self, field.name) for field in fields(self))  # type: ignore[arg-type]


def _are_equal(one: Any, other: Any) -> bool:
    if isinstance(one, PosedBones) and isinstance(other, PosedBones):
        return all(map(np.array_equal, one, other))
    return np.array_equal(one, other) if isinstance(one, np.ndarray) else bool(one == other)


class Placed(Result):
    """What states at one pose and at many have in common: where the bands are."""

    solver: LinkedPlaneSolver
    rotation: Floats
    posed: PosedBones | None

    @cached_property
    def _drawn(self) -> tuple[Floats, Floats, Floats]:
        return self.solver.draw_bands(self, 2)  # type: ignore[arg-type]

    @cached_property
    def wrenches(self) -> Floats:
        """(n, k, 6) what each band at unit tension does to each bone that moves.

        About the ground's origin: moment, m, and force, 1. They are -(m, f) of the change of length
        dL = m.dw + f.dv that a turn dw and a slide dv of the bone make (spec bones.md, section 2).
        The ground's is less the sum over the others. (m, n, k, 6) at m poses.
        """
        if self.posed is not None:
            return self.posed.wrenches
        rotations = self.rotation.reshape(-1, 3, 3)
        pose = rotations, np.zeros((len(rotations), 3))
        wrenches = self.solver.solve_bones_batch({self.solver.bones[-1]: pose}).wrenches
        return wrenches.reshape(*self.rotation.shape[:-2], *wrenches.shape[1:])

    @property
    def poses(self) -> dict[str, tuple[Floats, Floats]]:
        """The pose (R, t) of each bone that moves, by its name, right-shoulder form."""
        if self.posed is not None:
            poses = self.posed.poses
        else:
            bones = len(self.solver.bones) - 1
            rotations = self.rotation.reshape(-1, 3, 3)
            poses = rotated_poses(rotations, bones).reshape(*self.rotation.shape[:-2], bones, 3, 4)
        return {
            name: (poses[..., k, :, :3], poses[..., k, :, 3])
            for k, name in enumerate(self.solver.bones[1:])
        }

    def place_points(self, points: Floats, bones: Sequence[str], shift: bool = True) -> Floats:
        """Return points where their bones have them.

        Parameters
        ----------
        points
            (p, 3) m, frames of their bones, right side.
        bones
            (p) their bones.
        shift
            False for directions: they turn only.

        Returns
        -------
        Floats
            (p, 3) m, ground frame of the right side; (m, p, 3) at m poses.

        """
        placed = np.empty((*self.rotation.shape[:-2], *points.shape))
        placed[:] = points
        moved = self.solver.bones[1:] if self.posed is not None else self.solver.bones[-1:]
        for name in moved:
            rows = [i for i, bone in enumerate(bones) if bone == name]
            if rows:
                R, t = self.poses[name]
                placed[..., rows, :] = points[rows] @ R.swapaxes(-2, -1)
                if shift and self.posed is not None:
                    placed[..., rows, :] += t[..., np.newaxis, :]
        return placed

    @property
    def origins(self) -> Floats:
        """(n, 3) origins, m, scapula frame; (m, n, 3) at m poses."""
        muscle = self.solver.muscle
        bones = muscle.bones.of_bands('origin', len(muscle.band_names))
        return self.solver.to_side(self.place_points(muscle.origins, bones))

    @property
    def interference_centres(self) -> Floats:
        """(k, 3) centres of the interference spheres, m, scapula frame; (m, k, 3) at m poses."""
        muscle = self.solver.muscle
        placed = self.place_points(muscle.interference_centres, muscle.bones_of_interference)
        return self.solver.to_side(placed)

    @property
    def insertions(self) -> Floats:
        """(n, 3) insertions, m, scapula frame; (m, n, 3) at m poses."""
        return self._drawn[0]

    @property
    def sphere_centres(self) -> Floats:
        """(n, 3) obstacle sphere centres, m, scapula frame; (m, n, 3) at m poses."""
        return self._drawn[1]
