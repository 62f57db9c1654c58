"""How far a model is from measurements: the thesis's criterion, without a model object a time.

Equation 5.7 of the thesis: the sum of the squared deviations of lengths (mm) and of moment arms
(mm) over parts, motions and steps; each times the weight of its row and of its kind. What no muscle
may do is added band by band and pose by pose, 100 mm^-2 times a square: how deep its path enters an
interference sphere (the thesis added 10,000 at any depth; here that is reached at 10 mm, and the
slope shows the way out), how much it falls short of its place behind the band before it or parts
from that band, how far it is past the edge of its own obstacle sphere where its length jumps, and
how deep an end of it lies in that sphere, where it has no path.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from ..joints.conventions import JOINT_CONVENTIONS
from ..linked_planes.layout import band_count
from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats
from .data import Data
from .kernel import evaluate
from .parameters import Space, flat_numbers

MM = 1e3  # millimetres in a metre
PENALTY = 100.0  # mm^-2
MARGIN = 1e-3  # m: by how much bands keep off jumps and off parting, and ends off their own spheres
IMPOSSIBLE = 1e9  # of a muscle that has no path at any pose; more the farther from having one


@dataclass(frozen=True)
class Weights:
    """What each kind of deviation counts in the criterion."""

    length: float = 1.0
    arm: float = 1.0
    interference: float = 1.0
    order: float = 0.0
    jumps: float = 0.0
    clearance: float = 0.0
    """By which paths have to keep off the interference spheres, m."""
    gap: float = 1e-3
    """By which each band has to lie behind the one before it, m."""
    arm_scale: float = 1.0
    """What modelled moment arms are multiplied by; the thesis's is 0.5 (ch. 5)."""


@dataclass(frozen=True, eq=False)
class States:
    """The muscle at the criterion's m poses, of which the first m' are those of measurements."""

    lengths: Floats
    """(m', n) m"""
    moments: Floats
    """(m', n, 3) m"""
    wrap: npt.NDArray[np.uint8]
    """(m, n)"""
    depths: Floats
    """(m, n) how deep each band enters the interference spheres, m; negative: how far off."""
    insides: Floats
    """(m, n) how deep its ends lie in its own obstacle sphere, m."""
    edges: Floats
    """(m, n) how far each band is past the edge where its length jumps, m."""
    gaps: Floats
    """(m, n - 1) by how much each band lies past the one before it, halfway along, m: to the side
    to which the fan runs."""
    spacing: Floats
    """(n - 1,) the distances between the origins of neighbours, m: a fan's are nowhere wider."""


@dataclass(frozen=True, eq=False)
class Criterion:
    """A criterion over the parameters of a space, for measurements and further poses."""

    space: Space
    rotations: Floats
    """(m, 3, 3) the poses: first those of the measurements, then those to keep order at."""
    spheres: Floats
    """(k, 4) interference spheres: centres and radii, m."""
    measured: int
    """How many of the poses are those of measurements."""
    of_length: tuple[npt.NDArray[np.int64], Floats, Floats, Floats]
    """Of each measured length: its place among the bands of all poses, m, the square root of its
    weight; and an axis that means nothing."""
    of_arm: tuple[npt.NDArray[np.int64], Floats, Floats, Floats]
    """The same of each measured moment arm, with its axis (3,)."""
    weights: Weights = field(default_factory=Weights)
    side: float = 1.0
    """To which side the fan runs: `side_of` of the model that is fitted."""

    @staticmethod
    def of(
        muscle: BroadMuscle,
        space: Space,
        data: Data,
        weights: Weights | None = None,
        more: Floats | None = None,
    ) -> Criterion:
        """Return the criterion for data; `more` (k, 3, 3) are poses where nothing was measured."""
        rotations: list[Floats] = []
        places: dict[bytes, int] = {}
        lengths, arms = [], []
        for each in data.measurements:
            rotation, axis = each.pose()
            rotation += 0.0  # -0.0 is 0.0
            at = places.setdefault(rotation.tobytes(), len(places))
            rotations += [rotation] if at == len(rotations) else []
            place, root = at * len(muscle.band_names) + each.band, each.weight**0.5
            if np.isfinite(each.length):
                lengths.append((place, each.length, root, axis))
            if np.isfinite(each.arm):
                arms.append((place, each.arm, root, axis))
        more = np.empty((0, 3, 3)) if more is None else more
        return Criterion(
            space,
            np.concatenate((np.array(rotations), more)),
            spheres_of(muscle),
            len(rotations),
            _columns(lengths),
            _columns(arms),
            weights or Weights(),
            side_of(flat_numbers(muscle.definition)),
        )

    def also_at(self, more: Floats) -> Criterion:
        """Return the criterion with further poses (k, 3, 3) where nothing was measured."""
        return replace(self, rotations=np.concatenate((self.rotations, more)))

    def states(self, x: Floats) -> States | float:
        """Return the muscle at the poses; for one that has no path, how far it is from one, m."""
        muscle = self.space.muscle(x)
        return posed(muscle, self.rotations, self.spheres, self.measured, self.side)

    def deviations(self, states: States) -> tuple[Floats, Floats]:
        """Return modelled less measured lengths and moment arms, mm, row by row, no weights."""
        place, length, _, _ = self.of_length
        lengths = states.lengths.take(place) - length
        place, arm, _, axes = self.of_arm
        moments = states.moments.reshape(-1, 3).take(place, axis=0)
        arms = self.weights.arm_scale * np.einsum('ij,ij->i', moments, axes) - arm
        return MM * lengths, MM * arms

    def parts(self, states: States) -> list[Floats]:
        """Return what squared and summed is the criterion, mm; what weighs nothing is left out.

        Lengths, moment arms, then the faults of all poses.
        """
        weights = self.weights
        lengths, arms = self.deviations(states)
        parts = [
            weights.length**0.5 * self.of_length[2] * lengths,
            weights.arm**0.5 * self.of_arm[2] * arms,
        ]
        return parts + [part.ravel() for part in self.faults(states)]

    def faults(self, states: States) -> list[Floats]:
        """Return the parts that are of every pose and band, (m, n) or (m, n - 1), mm."""
        weights = self.weights
        kinds: list[tuple[float, Floats, float | Floats]] = [(1.0, states.insides, MARGIN)]
        if weights.interference:
            kinds.append((weights.interference, states.depths, weights.clearance))
        if weights.order:
            kinds.append((weights.order, -states.gaps, weights.gap))
            kinds.append((weights.order, states.gaps, MARGIN - states.spacing))
        if weights.jumps:
            kinds.append((weights.jumps, states.edges, MARGIN))
        return [
            (PENALTY * weight) ** 0.5 * MM * np.maximum(by + more, 0.0)
            for weight, by, more in kinds
        ]

    def residuals(self, x: Floats) -> Floats | float:
        """Return all parts at x in a row, mm; for a muscle without paths as `states`."""
        states = self.states(x)
        return states if isinstance(states, float) else np.concatenate(self.parts(states))

    def value(self, x: Floats) -> float:
        """Return the criterion, mm^2."""
        states = self.states(x)
        if isinstance(states, float):
            return IMPOSSIBLE * (1.0 + states)
        return float(sum(part @ part for part in self.parts(states)))

    def values(self, xs: Floats, pool: ThreadPoolExecutor | None = None) -> Floats:
        """Return the criterion of many x (k, p); each by itself, in whatever thread."""
        found = map(self.value, xs) if pool is None else pool.map(self.value, xs)
        return np.array(list(found))


def spheres_of(muscle: BroadMuscle) -> Floats:
    """Return a muscle's interference spheres (k, 4): centres and radii, m, ground frame."""
    return np.column_stack((muscle.interference_centres, muscle.interference_radii))


def side_of(muscle: Floats) -> float:
    """Return 1 if a flat muscle's bands, hanging, run as the deltoid's do, -1 if backwards."""
    states = posed(muscle.copy(), np.eye(3)[np.newaxis], np.empty((0, 4)), 0)
    return -1.0 if isinstance(states, States) and states.gaps.sum() < 0.0 else 1.0


def posed(
    muscle: Floats, rotations: Floats, spheres: Floats, measured: int, side: float = 1.0
) -> States | float:
    """Return a flat muscle (kernel.py) at m poses, lengths and moments for the first ones alone.

    Gaps are positive to the side to which the fan runs. For a muscle that has no path at a pose,
    how deep its ends lie in their spheres, m.
    """
    m, n = len(rotations), band_count(muscle)
    lengths, moments = np.empty((measured, n)), np.empty((measured, 3 * n))
    wrap = np.empty((m, n), dtype=np.uint8)
    depths, insides, edges = np.empty((m, n)), np.empty((m, n)), np.empty((m, n))
    filled = lengths, moments, wrap, depths, insides, edges, np.empty((m, n - 1)), np.empty(n - 1)
    solved, off = evaluate(muscle, rotations, spheres, *filled)
    if solved < m:
        return min(float(off), 1.0)
    if side < 0.0:
        np.negative(filled[6], out=filled[6])
    return States(lengths, moments.reshape(-1, n, 3), *filled[2:])


def grid(ranges: Sequence[tuple[float, float]], steps: Sequence[float]) -> tuple[Floats, Floats]:
    """Return the poses of a grid over flexion, abduction and rotation: angles (m, 3), (m, 3, 3).

    rad; the ends are in it, and steps of even size between that are not longer than those given.
    """
    sides = [
        np.linspace(low, high, 1 + int(np.ceil((high - low) / step - 1e-6)))
        for (low, high), step in zip(ranges, steps, strict=True)
    ]
    angles = np.stack(np.meshgrid(*sides, indexing='ij'), axis=-1).reshape(-1, 3)
    convention = JOINT_CONVENTIONS['flexion_abduction_rotation']
    return angles, convention.rotations_and_axes(angles)[0]


def _columns(
    rows: list[tuple[int, float, float, Floats]],
) -> tuple[npt.NDArray[np.int64], Floats, Floats, Floats]:
    places, values, roots, axes = zip(*rows, strict=True) if rows else ((), (), (), ())
    return (
        np.array(places, dtype=np.int64),
        np.array(values, dtype=np.float64),
        np.array(roots, dtype=np.float64),
        np.array(axes, dtype=np.float64).reshape(-1, 3),
    )
