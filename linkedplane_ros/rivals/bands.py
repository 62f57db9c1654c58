"""Bands that know nothing of each other, each a path model, solved one or many at a time.

All in m and rad, right shoulder, in the frames of the solver: origins in the scapula frame,
insertions in the humerus frame, a pose the rotation that takes humerus to scapula coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from ..joints.rotations import FAULTS, as_matrices, as_matrix
from ..linked_planes.compiled import COMPILED
from ..linked_planes.vectors import Vector
from ..solver.batches import run_kernel
from ..solver.kernels import SOLVED
from ..solver.states import WrapState
from ..types import Bytes, Floats
from .path import ARC_NUMBERS, Kernel

Bone = Literal['scapula', 'humerus']
BONES = ('scapula', 'humerus')


@dataclass(frozen=True)
class PathModel:
    """One band: its attachments and, in each kind of model, its obstacle; m."""

    origin: Vector
    """In the scapula frame."""
    insertion: Vector
    """In the humerus frame."""
    kernel: ClassVar[Kernel]
    arcs_are_points: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check what all have; ValueError names the field."""
        check_point('origin', self.origin)
        check_point('insertion', self.insertion)

    @property
    def row(self) -> tuple[float, ...]:
        """The model as its kernel reads it."""
        return (*self.origin, *self.insertion, *self._obstacle())

    def _obstacle(self) -> tuple[float, ...]:
        raise NotImplementedError

    @property
    def most_arcs(self) -> int:
        """Arcs, or points passed through, that its path has at most."""
        return 2

    def solve(self, rotation: npt.ArrayLike) -> PathState:
        """Solve one pose, a (3, 3) rotation humerus -> scapula; ValueError for anything else."""
        return Bands((self,)).solve(rotation)[0]


def check_point(name: str, value: Sequence[float]) -> None:
    """Refuse what is not three finite numbers; ValueError names the field."""
    if not (len(value) == 3 and all(math.isfinite(x) for x in value)):
        raise ValueError(f'{name}: {value!r} given, 3 finite numbers in m expected')


def check_axis(name: str, value: Sequence[float]) -> None:
    """Refuse what is no direction."""
    if not (len(value) == 3 and 0.0 < math.hypot(*value) < math.inf):
        raise ValueError(f'{name}: {value!r} given, 3 finite numbers, not all 0, expected')


def check_radius(name: str, value: float) -> None:
    """Refuse what is no radius."""
    if not 0.0 < value < math.inf:
        raise ValueError(f'{name}: {value!r} given, a finite length > 0 in m expected')


def check_bone(name: str, value: str) -> None:
    """Refuse what is no bone."""
    if value not in BONES:
        raise ValueError(f"{name}: {value!r} given, 'scapula' or 'humerus' expected")


def unit(axis: Vector) -> Vector:
    """Return a direction as a unit vector."""
    size = math.hypot(*axis)
    x, y, z = axis
    return x / size, y / size, z / size


def on_humerus(bone: Bone) -> float:
    """Return a bone as the kernels read it."""
    return 1.0 if bone == 'humerus' else 0.0


@dataclass(frozen=True, eq=False)
class PathState:
    """One band at one pose."""

    length: float
    """m"""
    moment_vector: Floats
    """(3,) -dL/domega about the scapula axes, m."""
    wrap: WrapState
    """MISSED: straight, though on its side there would be a way of more than half a turn."""
    contacts: int
    """Which parts of the obstacle it lies on: 0 none, 1 the first, 2 the second, 3 both."""
    model: PathModel
    rotation: Floats
    """(3, 3) humerus -> scapula, as it was given."""

    def path(self, points: int = 16) -> Floats:
        """Return the path as a polyline (k, 3), m, scapula frame: origin, arcs, insertion."""
        return Bands((self.model,)).solve(self.rotation).paths(points)[0]


@dataclass(frozen=True, eq=False)
class BandState:
    """n bands at one pose; lengths, moment vectors and wrap as in MuscleState."""

    lengths: Floats
    moment_vectors: Floats
    wrap: Bytes
    contacts: Bytes
    """(n,) as in PathState."""
    rotation: Floats
    bands: Bands

    def __getitem__(self, i: int) -> PathState:
        return PathState(
            float(self.lengths[i]),
            self.moment_vectors[i],
            WrapState(self.wrap[i]),
            int(self.contacts[i]),
            self.bands.models[i],
            self.rotation,
        )

    def __len__(self) -> int:
        return len(self.lengths)

    def paths(self, points: int = 16) -> list[Floats]:
        """Return each band's path as a polyline: n arrays (k, 3), m, scapula frame."""
        lines, counts = self.bands.lines(self.rotation[np.newaxis], points)
        return [line[:count] for line, count in zip(lines[0], counts[0].tolist(), strict=True)]


@dataclass(frozen=True, eq=False)
class BandStates:
    """n bands at m poses: the fields of BandState with a leading m."""

    lengths: Floats
    moment_vectors: Floats
    wrap: Bytes
    contacts: Bytes
    rotation: Floats
    bands: Bands

    def __len__(self) -> int:
        return len(self.lengths)


class Bands:
    """Bands of one kind of path model, independent of each other."""

    def __init__(self, models: Sequence[PathModel]) -> None:
        """Prepare n bands; ValueError if they are none, or not of one kind."""
        self.models = tuple(models)
        if len({type(model) for model in self.models}) != 1:
            raise ValueError(f'models: {len(self.models)} given, 1 or more of one kind expected')
        rows = [model.row for model in self.models]
        longest = max(map(len, rows))
        padded = np.array([row + (0.0,) * (longest - len(row)) for row in rows])
        self._rows: Any = padded if COMPILED else padded.tolist()
        self._most_arcs = max(model.most_arcs for model in self.models)

    def solve(self, rotation: npt.ArrayLike) -> BandState:
        """Solve one pose, a (3, 3) rotation humerus -> scapula; ValueError for anything else."""
        matrix = as_matrix(rotation)
        lengths, moments, wrap, contacts = self._solved(matrix[np.newaxis], 'rotation')
        return BandState(lengths[0], moments[0], wrap[0], contacts[0], matrix, self)

    def solve_batch(self, rotations: npt.ArrayLike) -> BandStates:
        """Solve m poses, (m, 3, 3); each answer is, to the bit, that of `solve`. m may be 0."""
        matrices = as_matrices(rotations)
        return BandStates(*self._solved(matrices, 'rotations[{}]'), matrices, self)

    def _solved(
        self, rotations: Floats, name: str, arcs: Floats | None = None
    ) -> tuple[Floats, Floats, Bytes, Bytes]:
        m, n = len(rotations), len(self.models)
        lengths, moments = np.empty((m, n)), np.empty((m, n, 3))
        wrap, contacts = np.empty((m, n), dtype=np.uint8), np.empty((m, n), dtype=np.uint8)
        drawn = np.empty((m, n, 0)) if arcs is None else arcs
        filled = lengths, moments.reshape(m, 3 * n), wrap, contacts, drawn
        k, fault, _ = run_kernel(type(self.models[0]).kernel, (self._rows,), rotations, filled)
        if fault != SOLVED:
            raise ValueError(f'{name.format(k)}: {FAULTS[fault]}')
        return lengths, moments, wrap, contacts

    def lines(self, rotations: Floats, points: int) -> tuple[Floats, npt.NDArray[np.int64]]:
        """Return the paths at m rotations as polylines (m, n, k, 3), m, and their sizes (m, n).

        `points` (2 or more) an arc, but one a via point; where a polyline is shorter than k it
        stays at its insertion.
        """
        if points < 2:
            raise ValueError(f'points: {points} given, at least 2 needed (the ends of an arc)')
        if type(self.models[0]).arcs_are_points:
            points = 1
        m, n, most = len(rotations), len(self.models), self._most_arcs
        numbers = np.zeros((m, n, 1 + ARC_NUMBERS * most))
        self._solved(rotations, 'rotations[{}]', numbers)
        origins = np.array([model.origin for model in self.models])
        insertions = np.array([model.insertion for model in self.models]) @ rotations.swapaxes(1, 2)
        lines = np.empty((m, n, 2 + points * most, 3))
        lines[:] = insertions[:, :, np.newaxis]
        lines[:, :, 0] = origins
        for i in range(most):
            arcs = numbers[..., 1 + ARC_NUMBERS * i :][..., :ARC_NUMBERS]
            there = numbers[..., 0] > i
            lines[there, 1 + points * i : 1 + points * (i + 1)] = on_arcs(arcs[there], points)
        return lines, 2 + points * numbers[..., 0].astype(np.int64)


def on_arcs(arcs: Floats, points: int) -> Floats:
    """Return points (k, points, 3) on arcs (k, 11), each the numbers of an Arc in order."""
    start, centre, axis = (arcs[:, np.newaxis, 3 * i : 3 * i + 3] for i in range(3))
    turn, rise = arcs[:, np.newaxis, 9:10], arcs[:, np.newaxis, 10:11]
    part = np.linspace(0.0, 1.0, points)[:, np.newaxis]
    v = start - centre
    along = (v * axis).sum(axis=-1, keepdims=True) * axis
    c, s = np.cos(part * turn), np.sin(part * turn)
    return np.asarray(centre + along + c * (v - along) + s * np.cross(axis, v) + part * rise * axis)
