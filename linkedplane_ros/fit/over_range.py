"""What a model does over its range of motion: interference, order, jumps of length."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..joints.conventions import JOINT_CONVENTIONS
from ..muscle.broad_muscle import BroadMuscle
from ..solver.check import DEFAULT_RANGE
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import WrapState
from ..types import Floats, Intervals
from .criterion import grid, posed, side_of, spheres_of
from .parameters import flat_numbers

STEPS = (math.radians(10.0), math.radians(10.0), math.radians(10.0))
RANDOM = 2000  # poses beside the grid's
WAYS = 60  # straight ways between random poses, beside those along single coordinates
STRIDE = math.radians(0.25)  # on a way
CONVENTION = JOINT_CONVENTIONS['flexion_abduction_rotation']


@dataclass(frozen=True, eq=False)
class OverRange:
    """A model at m poses of its range: a grid, then random ones; and on ways through it."""

    ranges: Intervals
    angles: Floats
    """(m, 3) flexion, abduction, rotation, rad"""
    depths: Floats
    """(m, n) m; above 0: the band enters an interference sphere."""
    gaps: Floats
    """(m, n - 1) m; not above 0: the band does not lie behind the one before it."""
    spacing: Floats
    """(n - 1,) m; the distances between the origins of neighbours."""
    inside: int
    """How many bands, over the poses, have an end in their own sphere, and so no path."""
    jump: float
    """The largest change of a length on the ways that its moment arms do not explain, m."""

    @property
    def entered(self) -> int:
        """How many bands, over the poses, enter a sphere."""
        return int((self.depths >= 0.0).sum())

    @property
    def disordered(self) -> int:
        """How many bands, over the poses, do not lie behind the one before them."""
        return int((self.gaps <= 0.0).sum())

    @property
    def parted(self) -> int:
        """How many bands, over the poses, are farther from the one before than at their origins."""
        return int((self.gaps > self.spacing).sum())


def over_range(
    muscle: BroadMuscle,
    steps: tuple[float, float, float] = STEPS,
    random: int = RANDOM,
    ways: int = WAYS,
    seed: int = 0,
) -> OverRange:
    """Look at a model over its range of motion; without one, over DEFAULT_RANGE.

    ValueError where a band has no plane, or no path at any pose.
    """
    ranges = muscle.range_of_motion or DEFAULT_RANGE
    generator = np.random.default_rng(seed)
    low, high = np.array(ranges).T
    angles, rotations = grid(ranges, steps)
    more = generator.uniform(low, high, (random, 3))
    angles = np.concatenate((angles, more))
    rotations = np.concatenate((rotations, CONVENTION.rotations_and_axes(more)[0]))
    flat = flat_numbers(muscle.definition)
    states = posed(flat, rotations, spheres_of(muscle), 0, side_of(flat))
    if isinstance(states, float):
        raise ValueError(f'{muscle.name}: a band has no path anywhere: an end lies in its sphere')
    inside = int((states.wrap == WrapState.INSIDE).sum())
    jump = _jump(muscle, low, high, ways, generator)
    return OverRange(ranges, angles, states.depths, states.gaps, states.spacing, inside, jump)


def _jump(
    muscle: BroadMuscle, low: Floats, high: Floats, ways: int, generator: np.random.Generator
) -> float:
    """Return the largest change of a length on ways that the moment vectors do not explain, m.

    On the three coordinates, the others at 0 or as near as the range has it, and on straight ways
    between random poses.
    """
    still = np.clip(np.zeros(3), low, high)
    ends = [np.where(np.eye(3)[axis] > 0.0, (low, high), still) for axis in range(3)]
    ends += list(generator.uniform(low, high, (ways, 2, 3)))
    solver, most = LinkedPlaneSolver(muscle), 0.0
    for first, last in ends:
        count = 2 + int(np.abs(last - first).max() / STRIDE)
        angles = first + np.linspace(0.0, 1.0, count)[:, np.newaxis] * (last - first)
        states = solver.solve_batch(CONVENTION.rotations_and_axes(angles)[0])
        between = np.einsum('kij,klj->kil', states.rotation[1:], states.rotation[:-1])
        turned = 0.5 * np.stack(
            [between[:, (i + 2) % 3, (i + 1) % 3] - between[:, (i + 1) % 3, (i + 2) % 3]
             for i in range(3)],
            axis=1,
        )  # fmt: skip
        arms = 0.5 * (states.moment_vectors[1:] + states.moment_vectors[:-1])
        explained = -np.einsum('kni,ki->kn', arms, turned)
        change = np.diff(states.lengths, axis=0) - explained
        most = max(most, float(np.abs(change).max(initial=0.0)))
    return most
