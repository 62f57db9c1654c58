# SPDX-License-Identifier: Apache-2.0
"""How far a model is from measurements: the thesis's criterion, equation 5.7.

It is the sum of the squared deviations of lengths (mm) and of moment arms (mm) over parts, motions
and steps, each times the weight of its row and of its kind. Penalties are added for what no muscle
may do, for each band and pose, each 100 mm^-2 times the square of a length: how deep the
path enters an interference sphere (the thesis added 10,000 at any depth; here that is reached at
10 mm, and the slope leads out); how much a band falls short of its place behind the band before it,
or parts from that band; how far it is past the edge of its own obstacle sphere, where its length
jumps; and how deep an end of it lies in that sphere, where it has no path.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from ..drawing.units import MILLIMETRES
from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats
from .measurements import Data
from .space import Space, pack_definition
from .states import FitStates, evaluate_poses, fan_side, sphere_array

PENALTY = 100.0  # mm^-2
MARGIN = 1e-3  # m: the distance kept from jumps, from parting, and between ends and own spheres
IMPOSSIBLE = 1e9  # mm^2, of a muscle without a path at any pose; more the farther it is from one


@dataclass(frozen=True)
class Weights:
    """What each kind of deviation counts in the criterion, and from where on."""

    length: float = 1.0
    arm: float = 1.0
    """Of moment arms."""
    interference: float = 1.0
    """Of paths in interference spheres."""
    order: float = 0.0
    """Of bands that are not behind the one before, or part from it."""
    jumps: float = 0.0
    """Of bands past the edge where their length jumps."""
    clearance: float = 0.0
    """m: how far paths have to keep off the interference spheres."""
    gap: float = 1e-3
    """m: how far each band has to lie behind the one before it."""
    arm_scale: float = 1.0
    """The factor of modelled moment arms; the thesis's is 0.5 (ch. 5)."""


@dataclass(frozen=True, eq=False)
class MeasuredValues:
    """Measured values of one kind."""

    places: npt.NDArray[np.int64]
    """(r,) the place of each among the bands of all poses: pose * n + band."""
    values: Floats
    """(r,) m"""
    roots: Floats
    """(r,) the square roots of their weights."""
    axes: Floats
    """(r, 3) what moment arms are about, in the scapula."""

    @staticmethod
    def from_list(rows: list[tuple[int, float, float, Floats]]) -> MeasuredValues:
        """Return the columns of rows."""
        places, values, roots, axes = zip(*rows, strict=True) if rows else ((), (), (), ())
        return MeasuredValues(
            np.array(places, dtype=np.int64),
            np.array(values, dtype=np.float64),
            np.array(roots, dtype=np.float64),
            np.array(axes, dtype=np.float64).reshape(-1, 3),
        )


@dataclass(frozen=True, eq=False)
class Criterion:
    """The criterion of equation 5.7 over the parameters of a fit.

    x (p,) are the parameters of `space`, in the file's units. A muscle without a path at any pose
    has no states but a float: m, the smaller the nearer it is to having one.
    """

    space: Space
    rotations: Floats
    """(m, 3, 3) the poses: first those of the measurements, then those only for penalties."""
    spheres: Floats
    """(k, 4) m: centres and radii of the interference spheres."""
    measured: int
    """How many of the poses are those of measurements."""
    measured_lengths: MeasuredValues
    measured_arms: MeasuredValues
    weights: Weights = field(default_factory=Weights)
    side: float = 1.0
    """To which side the fan runs: `fan_side` of the model to start from."""

    @staticmethod
    def from_data(
        muscle: BroadMuscle,
        space: Space,
        data: Data,
        weights: Weights | None = None,
        more: Floats | None = None,
    ) -> Criterion:
        """Return the criterion for data.

        Parameters
        ----------
        muscle
            The model to start from.
        space
            The parameters of it that are free.
        data
            The measurements, each of a band of the muscle.
        weights
            Those of `Weights` by default.
        more
            (j, 3, 3) poses where nothing was measured, only for penalties.

        """
        rotations: list[Floats] = []
        numbers: dict[bytes, int] = {}
        lengths, arms = [], []
        for each in data.measurements:
            rotation, axis = each.pose()
            rotation += 0.0  # -0.0 is 0.0
            pose = numbers.setdefault(rotation.tobytes(), len(numbers))
            rotations += [rotation] if pose == len(rotations) else []
            place, root = pose * len(muscle.band_names) + each.band, each.weight**0.5
            if np.isfinite(each.length):
                lengths.append((place, each.length, root, axis))
            if np.isfinite(each.arm):
                arms.append((place, each.arm, root, axis))
        more = np.empty((0, 3, 3)) if more is None else more
        return Criterion(
            space,
            np.concatenate((np.array(rotations), more)),
            sphere_array(muscle),
            len(rotations),
            MeasuredValues.from_list(lengths),
            MeasuredValues.from_list(arms),
            weights or Weights(),
            fan_side(pack_definition(muscle.definition)),
        )

    def with_poses(self, more: Floats) -> Criterion:
        """Return the criterion with further poses (j, 3, 3), only for penalties."""
        return replace(self, rotations=np.concatenate((self.rotations, more)))

    def states(self, x: Floats) -> FitStates | float:
        """Return the muscle at the poses; a float for one without a path."""
        muscle = self.space.flat_muscle(x)
        return evaluate_poses(muscle, self.rotations, self.spheres, self.measured, self.side)

    def deviations(self, states: FitStates) -> tuple[Floats, Floats]:
        """Return modelled less measured lengths and moment arms, mm, without weights.

        Two arrays with an element for each measured value, in the order of the measurements.
        """
        rows = self.measured_lengths
        lengths = states.lengths.take(rows.places) - rows.values
        rows = self.measured_arms
        moments = states.moments.reshape(-1, 3).take(rows.places, axis=0)
        arms = self.weights.arm_scale * np.einsum('ij,ij->i', moments, rows.axes) - rows.values
        return MILLIMETRES * lengths, MILLIMETRES * arms

    def weighted_deviations(self, states: FitStates) -> list[Floats]:
        """Return arrays, mm, whose squares sum up to the criterion; without weights of 0.

        First lengths, then moment arms, then the penalties of all poses.
        """
        weights = self.weights
        lengths, arms = self.deviations(states)
        parts = [
            weights.length**0.5 * self.measured_lengths.roots * lengths,
            weights.arm**0.5 * self.measured_arms.roots * arms,
        ]
        return parts + [part.ravel() for part in self.penalties(states)]

    def penalties(self, states: FitStates) -> list[Floats]:
        """Return the penalties of every pose and band, kind by kind, (m, n) or (m, n - 1), mm."""
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
            (PENALTY * weight) ** 0.5 * MILLIMETRES * np.maximum(by + more, 0.0)
            for weight, by, more in kinds
        ]

    def residuals(self, x: Floats) -> Floats | float:
        """Return the numbers, mm, whose squares sum up to the criterion; a float without a path."""
        states = self.states(x)
        if isinstance(states, float):
            return states
        return np.concatenate(self.weighted_deviations(states))

    def value(self, x: Floats) -> float:
        """Return the criterion at x, mm^2."""
        states = self.states(x)
        if isinstance(states, float):
            return IMPOSSIBLE * (1.0 + states)
        return float(sum(part @ part for part in self.weighted_deviations(states)))

    def values(self, xs: Floats, pool: ThreadPoolExecutor | None = None) -> Floats:
        """Return the criterion (j,) at each of xs (j, p), mm^2; the same with any threads."""
        return np.array(list((pool.map if pool else map)(self.value, xs)))
