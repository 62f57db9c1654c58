# SPDX-License-Identifier: Apache-2.0
"""A survey of a model over its range of motion: interference, order, jumps of length."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import LinkedPlaneError
from ..joints.conventions import THESIS_CONVENTION
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.range_check import DEFAULT_RANGE
from ..solver.states import WrapState
from ..types import Floats, Intervals
from .space import pack_definition
from .states import evaluate_poses, fan_side, pose_grid, sphere_array

STEPS = (math.radians(10.0), math.radians(10.0), math.radians(10.0))
RANDOM = 2000  # poses beside the grid's
LINES = 60  # straight lines between random poses, beside those along single coordinates
STRIDE = math.radians(0.25)  # on a line


@dataclass(frozen=True, eq=False)
class Survey:
    """A model at m poses of its range, a grid and then random ones, and on lines through it."""

    ranges: Intervals
    """The range, rad."""
    angles: Floats
    """(m, 3) rad, flexion, abduction, rotation."""
    depths: Floats
    """(m, n) m, how deep each band enters the interference spheres; negative: its distance."""
    gaps: Floats
    """(m, n - 1) m, how far each band lies behind the one before it; negative: in front of it."""
    spacing: Floats
    """(n - 1,) m, the distances between the origins of neighbours."""
    inside: int
    """How many bands, over the poses, have an end in their own sphere, and so no path."""
    jump: float
    """m, the largest change of a length on the lines that its moment arms do not explain."""

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


def survey_range(
    muscle: BroadMuscle,
    steps: tuple[float, float, float] = STEPS,
    random: int = RANDOM,
    lines: int = LINES,
    seed: int = 0,
) -> Survey:
    """Return a survey of a model over its range of motion; without one, over DEFAULT_RANGE.

    Parameters
    ----------
    muscle
        The model.
    steps
        The longest steps of the grid, rad: flexion, abduction, rotation.
    random
        How many random poses there are.
    lines
        How many lines between random poses there are.
    seed
        Of the random numbers.

    Raises
    ------
    LinkedPlaneError
        Where a band has no plane, or no path at any pose.

    """
    ranges = muscle.range_of_motion or DEFAULT_RANGE
    generator = np.random.default_rng(seed)
    low, high = np.array(ranges).T
    angles, rotations = pose_grid(ranges, steps)
    more = generator.uniform(low, high, (random, 3))
    angles = np.concatenate((angles, more))
    rotations = np.concatenate((rotations, THESIS_CONVENTION.rotations_and_axes(more)[0]))
    flat = pack_definition(muscle.definition)
    states = evaluate_poses(flat, rotations, sphere_array(muscle), 0, fan_side(flat))
    if isinstance(states, float):
        raise LinkedPlaneError(
            f'{muscle.name}: a band has no path anywhere: an end lies in its sphere'
        )
    inside = int((states.wrap == WrapState.INSIDE).sum())
    jump = _largest_jump(muscle, low, high, lines, generator)
    return Survey(ranges, angles, states.depths, states.gaps, states.spacing, inside, jump)


def _largest_jump(
    muscle: BroadMuscle, low: Floats, high: Floats, lines: int, generator: np.random.Generator
) -> float:
    """Return the largest change of a length on lines that the moment vectors do not explain, m.

    The lines run along each coordinate, the others at 0 or as near to it as the range allows, and
    between random poses.
    """
    still = np.clip(np.zeros(3), low, high)
    ends = [np.where(np.eye(3)[axis] > 0.0, (low, high), still) for axis in range(3)]
    ends += list(generator.uniform(low, high, (lines, 2, 3)))
    solver, most = LinkedPlaneSolver(muscle), 0.0
    for first, last in ends:
        count = 2 + int(np.abs(last - first).max() / STRIDE)
        angles = first + np.linspace(0.0, 1.0, count)[:, np.newaxis] * (last - first)
        states = solver.solve_batch(THESIS_CONVENTION.rotations_and_axes(angles)[0])
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
