# SPDX-License-Identifier: Apache-2.0
"""The values of a skeleton's joints at which its bones stand as measured ones do.

Turns decide; where they leave a joint free, places do (a subject's bones are not as long as the
skeleton's). The values are within the joints' limits, and depend on nothing but the poses: each
search begins at the middle of the limits, and where that does not fit, at other fixed places.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from ..errors import SkeletonError
from ..joints.articulation import PRISMATIC, MovedBones
from ..types import Floats, Intervals

PLACE_WEIGHT = 1e-2  # rad per m: 30 mm turn a bone 10 cm away by less than 1e-6 rad
FITS = 1e-6  # rad: the search has found all turns
STEPS = 60
LARGEST_STEP = 0.5  # rad or m
FEWEST, STARTS = 1e-13, 12


class JointedBones(Protocol):
    """What `Skeleton` is: bones that move with joints within limits."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates, d of them."""

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of each coordinate."""

    @property
    def limits(self) -> Intervals:
        """Of each coordinate, rad or m."""

    @property
    def moving(self) -> tuple[str, ...]:
        """The coordinates that move a bone."""

    def move_bones(self, values: Floats, bones: Sequence[str], side: str) -> MovedBones:
        """Return the bones at values (m, d)."""


class Postures(NamedTuple):
    """The postures found for m poses."""

    values: Floats
    """(m, d) rad or m, within the limits."""
    turn: Floats
    """(m,) rad, by which the bone that fits worst is turned against the measured one."""
    shift: Floats
    """(m,) m, by which the bone's frame that fits worst stands beside the measured one."""


@dataclass(frozen=True)
class PostureSearch:
    """Finds the postures of a skeleton for measured poses of its bones."""

    skeleton: JointedBones
    bones: tuple[str, ...]
    """Its bones, the ground first."""
    side: str = 'right'

    @cached_property
    def _box(self) -> tuple[Floats, Floats]:
        """Return the limits, lowest and highest (d,)."""
        lower, upper = np.array(self.skeleton.limits).reshape(-1, 2).T
        return lower, upper

    @cached_property
    def starts(self) -> Floats:
        """(s, d) where searches begin: the middle of the limits, then places around it.

        Joints that move no bone stay at 0.
        """
        lower, upper = self._box
        bounded = np.isfinite(lower) & np.isfinite(upper)
        turning = np.array([kind != PRISMATIC for kind in self.skeleton.kinds], dtype=bool)
        middle = np.clip(0.0, lower, upper)
        middle[bounded] = 0.5 * (lower[bounded] + upper[bounded])
        reach = np.where(turning, 1.5, 0.1)
        reach[bounded] = 0.35 * (upper[bounded] - lower[bounded])
        moving = set(self.skeleton.moving)
        idle = np.array([name not in moving for name in self.skeleton.coordinates], dtype=bool)
        middle[idle], reach[idle] = np.clip(0.0, lower, upper)[idle], 0.0
        around = np.random.default_rng(0).uniform(-1.0, 1.0, (STARTS - 1, len(middle)))
        starts = np.vstack([middle, middle + around * reach])
        return np.asarray(np.clip(starts, lower, upper))

    def find(self, poses: Floats) -> Postures:
        """Return the postures.

        Parameters
        ----------
        poses
            (m, k, 3, 4) of the bones that move, ground frame, right-shoulder form.

        Raises
        ------
        SkeletonError
            For a skeleton none of whose joints moves a bone.
        """
        if not self.skeleton.coordinates:
            raise SkeletonError('skeleton: it has no joint that moves')
        values, cost = self._descend(poses, np.repeat(self.starts[:1], len(poses), axis=0))
        postures = self._compare(poses, values)
        for start in self.starts[1:]:
            poor = np.flatnonzero(postures.turn > FITS)
            if not len(poor):
                break
            others, costs = self._descend(poses[poor], np.repeat(start[np.newaxis], len(poor), 0))
            better = poor[costs < cost[poor] * (1.0 - 1e-9)]
            chosen = np.isin(poor, better)
            values[better], cost[better] = others[chosen], costs[chosen]
            postures = self._compare(poses, values)
        return postures._replace(values=self._within_a_turn(values))

    def _within_a_turn(self, values: Floats) -> Floats:
        """Return values with those of joints that may turn on for ever in [-pi, pi)."""
        lower, upper = self._box
        endless = np.array([kind != PRISMATIC for kind in self.skeleton.kinds], dtype=bool)
        endless &= np.isinf(lower) & np.isinf(upper)
        turned = (values + np.pi) % (2.0 * np.pi) - np.pi
        return np.where(endless, turned, values)

    def _compare(self, poses: Floats, values: Floats) -> Postures:
        moved = self.skeleton.move_bones(values, self.bones, self.side).poses
        apart = np.linalg.norm((moved - poses)[..., :3], axis=(-2, -1))
        turn = 2.0 * np.arcsin(np.clip(apart / np.sqrt(8.0), 0.0, 1.0))
        shift = np.linalg.norm((moved - poses)[..., 3], axis=-1)
        return Postures(values, turn.max(axis=1, initial=0.0), shift.max(axis=1, initial=0.0))

    def _residuals(self, poses: Floats, values: Floats) -> tuple[Floats, Floats]:
        """Return what is left (m, 12 k), and how it falls with the values (m, 12 k, d)."""
        moved, screws = self.skeleton.move_bones(values, self.bones, self.side)
        m, k = poses.shape[:2]
        left = poses - moved
        w, v = screws[..., np.newaxis, :3], screws[..., 3:]  # (m, d, k, [1,] 3)
        columns = moved.swapaxes(-2, -1)[:, np.newaxis]  # (m, 1, k, 4, 3)
        falls = np.cross(w, columns)
        falls[..., 3, :] += v
        weights = np.array([np.sqrt(0.5)] * 3 + [PLACE_WEIGHT])[:, np.newaxis]
        left = (left.swapaxes(-2, -1) * weights).reshape(m, 12 * k)
        return left, (falls * weights).reshape(m, -1, 12 * k).swapaxes(1, 2)

    def _descend(self, poses: Floats, values: Floats) -> tuple[Floats, Floats]:
        """Return the values (m, d) of a minimum within the limits, and its cost (m,).

        Levenberg-Marquardt, each pose by itself: what the others are changes nothing.
        """
        lower, upper = self._box
        values = values.copy()
        left, falls = self._residuals(poses, values)
        cost = np.einsum('mi,mi->m', left, left)
        damping = np.full(len(values), 1e-3)
        going = np.arange(len(values))
        for _ in range(STEPS):
            if not len(going):
                break
            r, J, q = left[going], falls[going], values[going]
            gradient = np.einsum('mij,mi->mj', J, r)
            held = ((q <= lower) & (gradient < 0.0)) | ((q >= upper) & (gradient > 0.0))
            J = np.where(held[:, np.newaxis], 0.0, J)
            gradient = np.where(held, 0.0, gradient)
            A = np.einsum('mij,mik->mjk', J, J)
            diagonal = np.einsum('mjj->mj', A)
            spread = damping[going, np.newaxis] * (diagonal + 1e-9) + 1e-15
            A = A + spread[..., np.newaxis] * np.eye(A.shape[1])
            step = np.linalg.solve(A, gradient[..., np.newaxis])[..., 0]
            trial = np.clip(q + np.clip(step, -LARGEST_STEP, LARGEST_STEP), lower, upper)
            r, J = self._residuals(poses[going], trial)
            costs = np.einsum('mi,mi->m', r, r)
            better = costs <= cost[going]
            moved = np.abs(trial - q).max(axis=1)
            won = going[better]
            values[won], left[won], falls[won] = trial[better], r[better], J[better]
            cost[won] = costs[better]
            damping[going] *= np.where(better, 0.1, 10.0)
            damping = np.clip(damping, 1e-14, 1e8)
            going = going[(moved > FEWEST) & ~(~better & (damping[going] >= 1e8))]
        return values, cost
