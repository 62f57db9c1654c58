# SPDX-License-Identifier: Apache-2.0
"""How well each method keeps a broad muscle together as the joint moves.

The thesis says (ch. 1, 3 and 7) that independent bands slip off their obstacles, slip quickly round
a sphere, and ignore each other, and that linked planes keep adjacent bands together in a natural
breadth. What these words are taken to mean, at each pose and, where they concern a place on a band,
a quarter, half and three quarters of its length from its origin:

* *spacing*: the distance between a band and its neighbour, over that with the arm at the side;
* *breadth*: the sum of the spacings at half the length, over that with the arm at the side;
* *crossed*: the order of two neighbours is reversed. Seen along the two, each is on the other side
  of its neighbour than at their origins and than at their insertions; straight lines never are.
  (The order by angle about the joint's centre, or about the muscle's line, would be no measure: the
  deltoid's row of origins is a horseshoe, which looks folded from the front with every method.);
* *move*: the farthest that the middle of a band moves from a pose to the next, half a degree apart
  by default (not a speed: round a sphere the middle may move without bound as a band comes to lie
  across its centre);
* *slip*: how fast the middle of a band moves as the joint turns, all but the fastest hundredth;
* *jump*: what is left of a change of length, beyond what the moment vectors explain, and of a
  change of a moment vector, as two poses come together;
* *in bone*: below the surface of a bone sphere of the model file (thesis Table 5.1).

Where a band is INSIDE its obstacle it has no path. Its share is counted; moves and jumps leave it
out, the other measures take the straight line.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError
from ..linked_planes.band import INSIDE, MISSED, WRAPPED
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import MuscleStates
from ..types import Bools, Floats
from .bands import Bands, BandStates
from .methods import Method, methods
from .sweeps import (
    RANDOM_SWEEPS,
    STEP,
    poses_between,
    random_sweeps,
    single_axes,
    thesis_motions,
    turns_between,
)

FRACTIONS = (0.25, 0.5, 0.75)
MIDDLE = 1
POINTS = 10  # of an arc, on which places are found
CANDIDATES = 3  # the largest changes of each sweep, which may be jumps
PARTS = 8  # into which the step of such a change is divided, and
LEVELS = 8  # how often
USUAL = 0.99  # of the speeds, the slower ones
COINCIDENT = 1e-6  # m: bands no farther apart are one


@dataclass(frozen=True)
class Breadth:
    """What a method does over some motions; m and rad, ratios and shares as numbers from 0."""

    method: str
    obstacles: str
    """How its obstacles were chosen: none are published for the rivals' deltoid."""
    motion: str
    poses: int
    spacing_least: float
    spacing_most: float
    breadth_least: float
    breadth_most: float
    crossed: float
    """Share of the poses at which any two neighbours are crossed."""
    move: float
    """The farthest, m."""
    slip: float
    """m/rad"""
    length_jump: float
    """The largest, m."""
    moment_jump: float
    """The largest, m."""
    wrapped: float
    """Share of bands and poses, as the next two."""
    missed: float
    inside: float
    in_bone: float
    """Share of the poses at which any band is in bone."""
    deepest: float
    """How deep a band is in bone, m; 0 if none is."""


def compare(
    muscle: BroadMuscle, sweeps: int = RANDOM_SWEEPS, seed: int = 0, step: float = STEP
) -> list[Breadth]:
    """Measure every method over the thesis's motions, single coordinates, and random motions.

    Parameters
    ----------
    muscle
        Of two bands or more.
    sweeps
        How many random motions.
    seed
        Of the random motions: the same seed, the same answer.
    step
        The largest step from a pose to the next, rad.

    Raises
    ------
    LinkedPlaneError
        For a muscle of a single band, and where two bands are one with the arm at the side.

    """
    if len(muscle.band_names) < 2:
        raise LinkedPlaneError('muscle: 1 band given, 2 or more expected: one band has no breadth')
    motions: Mapping[str, Sequence[Floats]] = {
        "the thesis's motions": thesis_motions(step),
        'each coordinate alone': single_axes(muscle, step),
        f'{sweeps} random motions': random_sweeps(muscle, sweeps, seed, step),
    }
    return [
        measure(muscle, method, motion, poses)
        for method in methods(muscle)
        for motion, poses in motions.items()
    ]


def measure(muscle: BroadMuscle, method: Method, motion: str, sweeps: Sequence[Floats]) -> Breadth:
    """Return what a method does over sweeps, each (m, 3, 3) neighbouring poses."""
    rotations = np.concatenate(sweeps)
    states, lines = solve_and_draw(method.solver, rotations)
    at_rest = solve_and_draw(method.solver, np.eye(3)[np.newaxis])[1]
    places, directions = places_along(lines)
    gaps, gaps_at_rest = spacing(places), spacing(places_along(at_rest)[0])
    if not gaps_at_rest.min() > COINCIDENT:
        raise LinkedPlaneError(f'muscle: {method.name}: two bands are one with the arm at the side')
    wide = gaps[:, MIDDLE].sum(axis=1) / gaps_at_rest[:, MIDDLE].sum(axis=1)
    gaps /= gaps_at_rest
    depth = depth_in_bone(lines, muscle)
    # the last pose of a sweep and the first of the next are no neighbours
    neighbours = np.ones(len(rotations) - 1, dtype=bool)
    neighbours[np.cumsum([len(sweep) for sweep in sweeps])[:-1] - 1] = False
    turns = turns_between(rotations)
    moves = changes_with_paths(states, np.linalg.norm(np.diff(places[:, MIDDLE], axis=0), axis=2))
    speeds = moves[neighbours] / np.linalg.norm(turns[neighbours], axis=1, keepdims=True)
    given = method.solver, rotations, states, turns, neighbours
    return Breadth(
        method=method.name,
        obstacles=method.obstacles,
        motion=motion,
        poses=len(rotations),
        spacing_least=float(gaps.min()),
        spacing_most=float(gaps.max()),
        breadth_least=float(wide.min()),
        breadth_most=float(wide.max()),
        crossed=true_share(are_crossed(places, directions, lines).any(axis=(1, 2))),
        move=float(moves[neighbours].max()),
        slip=float(np.quantile(speeds, USUAL)),
        length_jump=largest_jump(*given, unexplained_changes),
        moment_jump=largest_jump(*given, moment_changes),
        wrapped=true_share(states.wrap == WRAPPED),
        missed=true_share(states.wrap == MISSED),
        inside=true_share(states.wrap == INSIDE),
        in_bone=true_share(depth > 0.0),
        deepest=float(depth.max()),
    )


def true_share(which: Any) -> float:
    """Return the share of an array that is true."""
    return float(np.mean(which))


MethodStates = MuscleStates | BandStates


def solve_and_draw(
    solver: LinkedPlaneSolver | Bands, rotations: Floats
) -> tuple[MethodStates, Floats]:
    """Return the states at m poses and all paths as polylines (m, n, k, 3), m.

    A polyline that needs fewer than k points stays at its insertion.
    """
    if isinstance(solver, Bands):
        return solver.solve_batch(rotations), solver.lines(rotations, POINTS)[0]
    states = solver.solve_batch(rotations)
    insertions, _, arcs = solver.draw_bands(states, POINTS)
    lines = np.empty((*states.lengths.shape, POINTS + 2, 3))
    lines[:, :, 0] = solver.origins
    lines[:, :, 1:] = insertions[:, :, np.newaxis]
    wrapped = states.wrap == WRAPPED
    lines[wrapped, 1:-1] = arcs[wrapped]
    return states, lines


def places_along(lines: Floats) -> tuple[Floats, Floats]:
    """Return the places at the fractions of polylines, and the unit directions: (m, f, n, 3)."""
    parts = np.diff(lines, axis=2)
    lengths = np.linalg.norm(parts, axis=3)
    sums = np.cumsum(lengths, axis=2)
    places, directions = [], []
    for fraction in FRACTIONS:
        part = fraction * sums[:, :, -1]
        k = (sums < part[:, :, np.newaxis]).sum(axis=2)[:, :, np.newaxis]
        length = np.take_along_axis(lengths, k, axis=2)
        left = np.take_along_axis(sums, k, axis=2) - part[:, :, np.newaxis]
        k = k[..., np.newaxis]
        direction = np.take_along_axis(parts, k, axis=2)[:, :, 0] / length
        places.append(np.take_along_axis(lines, k + 1, axis=2)[:, :, 0] - left * direction)
        directions.append(direction)
    return np.stack(places, axis=1), np.stack(directions, axis=1)


def spacing(places: Floats) -> Floats:
    """Return the distances (..., n - 1) of neighbours among places (..., n, 3)."""
    return np.asarray(np.linalg.norm(np.diff(places, axis=-2), axis=-1))


def are_crossed(places: Floats, directions: Floats, lines: Floats) -> Bools:
    """Return whether neighbours (m, f, n - 1) stand in reverse order between their attachments.

    From the steps from a band to its neighbour, there and at both ends, only what is across the two
    bands there counts.
    """
    steps = np.diff(places, axis=2)
    t = directions[:, :, 1:] + directions[:, :, :-1]
    steps -= ((steps * t).sum(axis=3) / (t * t).sum(axis=3))[..., np.newaxis] * t
    ends = (np.diff(lines[:, np.newaxis, :, k], axis=2) for k in (0, -1))
    from_origins, from_insertions = ((steps * end).sum(axis=3) < 0.0 for end in ends)
    return np.asarray(from_origins & from_insertions)


def depth_in_bone(lines: Floats, muscle: BroadMuscle) -> Floats:
    """Return how deep polylines (m, n, k, 3) lie in the muscle's bone spheres: (m,), m, from 0."""
    start, part = lines[:, :, :-1], np.diff(lines, axis=2)
    size = np.maximum(np.einsum('...i,...i', part, part), 1e-30)
    deepest = np.zeros(len(lines))
    for centre, radius in zip(muscle.interference_centres, muscle.interference_radii, strict=True):
        off = centre - start
        forth = np.einsum('...i,...i', off, part)
        nearest = np.clip(forth / size, 0.0, 1.0)
        squared = np.einsum('...i,...i', off, off) - nearest * (2.0 * forth - nearest * size)
        distance = np.sqrt(np.maximum(squared.min(axis=(1, 2)), 0.0))
        deepest = np.maximum(deepest, radius - distance)
    return deepest


Change = Callable[[MethodStates, Floats], Floats]


def unexplained_changes(states: MethodStates, turns: Floats) -> Floats:
    """Return what the lengths (m - 1, n) change by beyond what the moment vectors explain, m."""
    v = states.moment_vectors
    explained = -0.5 * np.einsum('kni,ki->kn', v[1:] + v[:-1], turns)
    return changes_with_paths(states, np.abs(np.diff(states.lengths, axis=0) - explained))


def moment_changes(states: MethodStates, turns: Floats) -> Floats:
    """Return what the moment vectors (m - 1, n) change by, m."""
    changes = np.linalg.norm(np.diff(states.moment_vectors, axis=0), axis=2)
    return changes_with_paths(states, changes)


def changes_with_paths(states: MethodStates, changes: npt.NDArray[Any]) -> Floats:
    """Return changes (m - 1, n) with 0 where a band has no path before or after."""
    inside = states.wrap == INSIDE
    return np.where(inside[1:] | inside[:-1], 0.0, changes)


def largest_jump(
    solver: LinkedPlaneSolver | Bands, rotations: Floats, states: MethodStates, turns: Floats,
    neighbours: Bools, change: Change,
) -> float:  # fmt: skip
    """Return what is left of the largest changes as their two poses come together.

    `neighbours` (m - 1) says which poses follow each other on a sweep.
    """
    steps = change(states, turns).max(axis=1) * neighbours
    found = 0.0
    for k in np.argsort(-steps)[:CANDIDATES].tolist():
        start, end = rotations[k], rotations[k + 1]
        left = 0.0
        for _ in range(LEVELS):
            poses = poses_between(start, end, PARTS)
            finer = change(solver.solve_batch(poses), turns_between(poses)).max(axis=1)
            worst = int(finer.argmax())
            start, end, left = poses[worst], poses[worst + 1], float(finer[worst])
        found = max(found, left)
    return found
