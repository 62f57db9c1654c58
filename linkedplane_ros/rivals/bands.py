# SPDX-License-Identifier: Apache-2.0
"""Bands that know nothing of each other, each a path model, solved one or many at a time.

All in m and rad, right shoulder, in the frames of the solver: origins in the scapula frame,
insertions in the humerus frame, a pose the rotation that takes humerus to scapula coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError
from ..joints.rotations import FAULTS, as_matrices, as_matrix
from ..linked_planes.compilation import COMPILED
from ..linked_planes.vectors import Vector
from ..solver.batches import run_kernel
from ..solver.kernels import SOLVED
from ..solver.states import WrapState
from ..types import Bytes, Floats
from .fields import field_fault, field_kind
from .path import ARC_NUMBERS, PathKernel


@dataclass(frozen=True)
class PathModel:
    """One band: its attachments and, in each kind of model, its obstacle; m.

    Raises
    ------
    LinkedPlaneError
        For a field that cannot be used; it is named.

    """

    origin: Vector
    """(3,) scapula frame."""
    insertion: Vector
    """(3,) humerus frame."""
    kernel: ClassVar[PathKernel]
    arcs_are_points: ClassVar[bool] = False

    def __post_init__(self) -> None:
        faults = (field_fault(name, value) for name, value in self._fields())
        if fault := next(filter(None, faults), ''):
            raise LinkedPlaneError(fault)

    @property
    def row(self) -> tuple[float, ...]:
        """The model as its kernel reads it: the numbers of its fields, in their order."""
        return tuple(x for name, value in self._fields() for x in field_kind(name).numbers(value))

    @property
    def most_arcs(self) -> int:
        """Arcs, or points passed through, that its path has at most."""
        return 2

    def _fields(self) -> Iterator[tuple[str, Any]]:
        return ((field.name, getattr(self, field.name)) for field in fields(self))

    def solve(self, rotation: npt.ArrayLike) -> PathState:
        """Solve one pose.

        Parameters
        ----------
        rotation
            (3, 3) humerus -> scapula.

        Returns
        -------
        PathState
            Length in m, moment vector (3,) in m about the scapula axes, wrap state.

        Raises
        ------
        LinkedPlaneError
            For anything but a proper, finite rotation.

        """
        return Bands((self,)).solve(rotation)[0]


@dataclass(frozen=True, eq=False)
class PathState:
    """One band at one pose."""

    length: float
    """m"""
    moment_vector: Floats
    """(3,) -dL/domega about the scapula axes, m."""
    wrap: WrapState
    """MISSED: straight, though a path of more than half a turn leads round on its side."""
    contacts: int
    """Which parts of the obstacle it lies on: 0 none, 1 the first, 2 the second, 3 both."""
    model: PathModel
    rotation: Floats
    """(3, 3) humerus -> scapula, as it was given."""

    def path(self, points: int = 16) -> Floats:
        """Return the path as a polyline.

        Parameters
        ----------
        points
            How many on an arc, at least 2; a via point is one.

        Returns
        -------
        Floats
            (k, 3) m, scapula frame: origin, points on the arcs, insertion.

        Raises
        ------
        LinkedPlaneError
            For fewer than 2 points.

        """
        return Bands((self.model,)).solve(self.rotation).paths(points)[0]


@dataclass(frozen=True, eq=False)
class BandState:
    """n bands at one pose; ``state[i]`` is the PathState of one."""

    lengths: Floats
    """(n,) m"""
    moment_vectors: Floats
    """(n, 3) -dL/domega about the scapula axes, m."""
    wrap: Bytes
    """(n,) WrapState."""
    contacts: Bytes
    """(n,) as in PathState."""
    rotation: Floats
    """(3, 3) humerus -> scapula, as it was given."""
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
        """Return each band's path as a polyline.

        Parameters
        ----------
        points
            How many on an arc, at least 2; a via point is one.

        Returns
        -------
        list of Floats
            n arrays (k, 3), m, scapula frame: origin, points on the arcs, insertion.

        Raises
        ------
        LinkedPlaneError
            For fewer than 2 points.

        """
        lines, counts = self.bands.lines(self.rotation[np.newaxis], points)
        return [line[:count] for line, count in zip(lines[0], counts[0].tolist(), strict=True)]


@dataclass(frozen=True, eq=False)
class BandStates:
    """n bands at m poses: the fields of BandState with a leading m."""

    lengths: Floats
    """(m, n) m"""
    moment_vectors: Floats
    """(m, n, 3) -dL/domega about the scapula axes, m."""
    wrap: Bytes
    """(m, n) WrapState."""
    contacts: Bytes
    """(m, n) as in PathState."""
    rotation: Floats
    """(m, 3, 3) humerus -> scapula, as they were given."""
    bands: Bands

    def __len__(self) -> int:
        return len(self.lengths)


class Bands:
    """Bands of one kind of path model, independent of each other.

    Parameters
    ----------
    models
        n of them, 1 or more.

    Raises
    ------
    LinkedPlaneError
        For no models, and for models of several kinds.

    """

    def __init__(self, models: Sequence[PathModel]) -> None:
        self.models = tuple(models)
        if len({type(model) for model in self.models}) != 1:
            given = len(self.models)
            raise LinkedPlaneError(f'models: {given} given, 1 or more of one kind expected')
        rows = [model.row for model in self.models]
        longest = max(map(len, rows))
        padded = np.array([row + (0.0,) * (longest - len(row)) for row in rows])
        self._rows: Any = padded if COMPILED else padded.tolist()
        self._most_arcs = max(model.most_arcs for model in self.models)

    def solve(self, rotation: npt.ArrayLike) -> BandState:
        """Solve one pose.

        Parameters
        ----------
        rotation
            (3, 3) humerus -> scapula.

        Returns
        -------
        BandState
            Lengths (n,) in m, moment vectors (n, 3) in m about the scapula axes, wrap states.

        Raises
        ------
        LinkedPlaneError
            For anything but a proper, finite rotation.

        """
        matrix = as_matrix(rotation)
        lengths, moments, wrap, contacts = self._solve(matrix[np.newaxis], 'rotation')
        return BandState(lengths[0], moments[0], wrap[0], contacts[0], matrix, self)

    def solve_batch(self, rotations: npt.ArrayLike) -> BandStates:
        """Solve many poses; each answer is, to the bit, that of `solve`.

        Parameters
        ----------
        rotations
            (m, 3, 3) humerus -> scapula; m may be 0.

        Returns
        -------
        BandStates
            The fields of BandState with a leading m.

        Raises
        ------
        LinkedPlaneError
            As `solve`, for the first pose that has no answer.

        """
        matrices = as_matrices(rotations)
        return BandStates(*self._solve(matrices, 'rotations[{}]'), matrices, self)

    def _solve(
        self, rotations: Floats, name: str, arcs: Floats | None = None
    ) -> tuple[Floats, Floats, Bytes, Bytes]:
        """Return lengths (m, n), moment vectors (m, n, 3), wrap and contacts (m, n)."""
        m, n = len(rotations), len(self.models)
        lengths, moments = np.empty((m, n)), np.empty((m, n, 3))
        wrap, contacts = np.empty((m, n), dtype=np.uint8), np.empty((m, n), dtype=np.uint8)
        drawn = np.empty((m, n, 0)) if arcs is None else arcs
        filled = lengths, moments.reshape(m, 3 * n), wrap, contacts, drawn
        k, fault, _ = run_kernel(type(self.models[0]).kernel, (self._rows,), rotations, filled)
        if fault != SOLVED:
            raise LinkedPlaneError(f'{name.format(k)}: {FAULTS[fault]}')
        return lengths, moments, wrap, contacts

    def lines(self, rotations: Floats, points: int) -> tuple[Floats, npt.NDArray[np.int64]]:
        """Return the paths at many poses as polylines.

        Parameters
        ----------
        rotations
            (m, 3, 3) humerus -> scapula.
        points
            How many on an arc, at least 2; a via point is one.

        Returns
        -------
        lines : Floats
            (m, n, k, 3) m, scapula frame; a polyline with fewer points stays at its insertion.
        counts : NDArray
            (m, n) how many points each polyline has.

        Raises
        ------
        LinkedPlaneError
            For fewer than 2 points, and for anything but proper rotations.

        """
        if points < 2:
            raise LinkedPlaneError(f'points: {points} given, at least 2 expected (an arc has ends)')
        if type(self.models[0]).arcs_are_points:
            points = 1
        m, n, most = len(rotations), len(self.models), self._most_arcs
        numbers = np.zeros((m, n, 1 + ARC_NUMBERS * most))
        self._solve(rotations, 'rotations[{}]', numbers)
        origins = np.array([model.origin for model in self.models])
        insertions = np.array([model.insertion for model in self.models]) @ rotations.swapaxes(1, 2)
        lines = np.empty((m, n, 2 + points * most, 3))
        lines[:] = insertions[:, :, np.newaxis]
        lines[:, :, 0] = origins
        for i in range(most):
            arcs = numbers[..., 1 + ARC_NUMBERS * i :][..., :ARC_NUMBERS]
            there = numbers[..., 0] > i
            lines[there, 1 + points * i : 1 + points * (i + 1)] = arc_points(arcs[there], points)
        return lines, 2 + points * numbers[..., 0].astype(np.int64)


def arc_points(arcs: Floats, points: int) -> Floats:
    """Return points (k, points, 3) on arcs (k, 11), each the numbers of an Arc in order."""
    start, centre, axis = (arcs[:, np.newaxis, 3 * i : 3 * i + 3] for i in range(3))
    turn, rise = arcs[:, np.newaxis, 9:10], arcs[:, np.newaxis, 10:11]
    part = np.linspace(0.0, 1.0, points)[:, np.newaxis]
    v = start - centre
    along = (v * axis).sum(axis=-1, keepdims=True) * axis
    c, s = np.cos(part * turn), np.sin(part * turn)
    return np.asarray(centre + along + c * (v - along) + s * np.cross(axis, v) + part * rise * axis)
