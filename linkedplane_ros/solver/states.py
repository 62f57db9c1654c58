# SPDX-License-Identifier: Apache-2.0
"""What the solver answers: the muscle at one pose, at many, and what a stream of angles needs."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from ..linked_planes.band import CLEAR, INSIDE, MISSED, WRAPPED
from ..types import Bools, Bytes, Floats
from .results import Placed, PosedBones, Result

if TYPE_CHECKING:
    from .linked_plane_solver import LinkedPlaneSolver


class WrapState(IntEnum):
    """How a band lies to its obstacle sphere (spec section 2).

    Only a WRAPPED band lies on its sphere; all others are straight lines from origin to insertion.
    """

    WRAPPED = WRAPPED
    """Round the sphere."""
    CLEAR = CLEAR
    """Straight: its plane cuts the sphere, the line keeps off it."""
    MISSED = MISSED
    """Straight: its plane does not reach the sphere."""
    INSIDE = INSIDE
    """Drawn straight: no valid path, an end lies inside the sphere."""


@dataclass(frozen=True, eq=False)
class MuscleState(Placed):
    """The muscle at one pose, n bands, k bones that move; its arrays are read-only.

    Moment arms about a convention's coordinates are
    ``state.moment_vectors @ convention.axes(angles, side)``: positive where shortening turns the
    joint in the coordinate's positive direction.
    """

    theta: float
    """Angle of the first band's plane from the reference plane, rad, in (-pi, pi]."""
    lengths: Floats
    """(n,) band lengths, m."""
    moment_vectors: Floats
    """(n, 3) -dL/domega about the scapula axes, m (thesis eq. 5.1)."""
    wrap: Bytes
    """(n,) WrapState of each band."""
    one_sided: Bools
    """(n,) which moment vectors are one-sided derivatives, those of this wrap state (theta stands
    at a corner of two edges, or a line touches its sphere's rim); all others are two-sided."""
    rotation: Floats
    """(3, 3) humerus -> scapula, as it was given; of several bones, the last one's."""
    solver: LinkedPlaneSolver
    """What solved it: the muscle and its side."""
    posed: PosedBones | None = None
    """Where the bones are, (k, 3, 4), and the wrenches on them (n, k, 6); None from a rotation."""

    def __post_init__(self) -> None:
        for array in (self.lengths, self.moment_vectors, self.wrap, self.one_sided, self.rotation):
            array.setflags(False)  # type: ignore[call-arg]  # by name it takes twice as long
        if self.posed is not None:
            self.posed.keep_as_is()

    @property
    def total_length(self) -> float:
        """Sum of the band lengths, m: what theta makes least."""
        return float(self.lengths.sum())

    def to_scapula(self, points: Floats) -> Floats:
        """Return points of the humerus where they are at this pose.

        Parameters
        ----------
        points
            (..., 3) m, humerus frame of the right shoulder.

        Returns
        -------
        Floats
            (..., 3) m, scapula frame of the solver's side.

        """
        placed = points @ self.rotation.T
        if self.posed is not None:
            placed = placed + self.posed.poses[-1, :, 3]
        return self.solver.to_side(placed)

    def paths(self, points: int = 16) -> list[Floats]:
        """Return each band's path as a polyline.

        Parameters
        ----------
        points
            How many on an arc, from the first transition point Q to the second, T; at least 2.

        Returns
        -------
        list of Floats
            n arrays (k, 3), m, scapula frame. A wrapped band is its origin, the points of its arc,
            and its insertion; a straight one its origin and insertion.

        Raises
        ------
        LinkedPlaneError
            For fewer than 2 points.

        """
        insertions, _, arcs = self.solver.draw_bands(self, points)
        return _polylines(self.origins, insertions, arcs, self.wrap)


@dataclass(frozen=True, eq=False)
class MuscleStates(Placed):
    """The muscle at m poses: the fields of MuscleState with a leading m, read-only.

    ``states[3]`` is a MuscleState; a slice, an array of indices, or of m booleans, gives
    MuscleStates. To go over them gives a MuscleState for each pose.
    """

    theta: Floats
    """(m,) rad."""
    lengths: Floats
    """(m, n) m."""
    moment_vectors: Floats
    """(m, n, 3) m, about the scapula axes."""
    wrap: Bytes
    """(m, n) WrapState of each band."""
    one_sided: Bools
    """(m, n) which moment vectors are one-sided derivatives, as in MuscleState."""
    rotation: Floats
    """(m, 3, 3) humerus -> scapula, as they were given; of several bones, the last one's."""
    solver: LinkedPlaneSolver
    """What solved them: the muscle and its side."""
    posed: PosedBones | None = None
    """The same with a leading m as a MuscleState's; None from rotations alone."""

    def __post_init__(self) -> None:
        for array in self._values()[:6]:
            array.setflags(write=False)
        if self.posed is not None:
            self.posed.keep_as_is()

    @property
    def total_length(self) -> Floats:
        """(m,) sums of the band lengths, m."""
        return np.asarray(self.lengths.sum(axis=1))

    def paths(self, points: int = 16) -> list[list[Floats]]:
        """Return each band's path at each pose as a polyline.

        Parameters
        ----------
        points
            How many on an arc, as for `MuscleState.paths`; at least 2.

        Returns
        -------
        list of lists of Floats
            For each of the m poses, n arrays (k, 3), m, scapula frame, as from `MuscleState.paths`.

        Raises
        ------
        LinkedPlaneError
            For fewer than 2 points.

        """
        insertions, _, arcs = self.solver.draw_bands(self, points)
        poses = zip(self.origins, insertions, arcs, self.wrap, strict=True)
        return [_polylines(*pose) for pose in poses]

    def __len__(self) -> int:
        return len(self.theta)

    @overload
    def __getitem__(self, index: int | np.integer) -> MuscleState: ...

    @overload
    def __getitem__(self, index: slice | Sequence[int] | npt.NDArray[Any]) -> MuscleStates: ...

    def __getitem__(self, index: Any) -> MuscleState | MuscleStates:
        try:
            i = operator.index(index)
        except TypeError:
            return self._chosen(index)
        return MuscleState(
            float(self.theta[i]),
            self.lengths[i],
            self.moment_vectors[i],
            self.wrap[i],
            self.one_sided[i],
            self.rotation[i],
            self.solver,
            self.posed and self.posed.choose(i),
        )

    def _chosen(self, index: Any) -> MuscleStates:
        chosen = np.arange(len(self))[index]
        if chosen.ndim != 1:
            raise IndexError(f'{index!r} given; an integer, a slice, or (k,) indices expected')
        part = index if isinstance(index, slice) else chosen
        return MuscleStates(
            self.theta[part],
            self.lengths[part],
            self.moment_vectors[part],
            self.wrap[part],
            self.one_sided[part],
            self.rotation[part],
            self.solver,
            self.posed and self.posed.choose(part),
        )

    def __iter__(self) -> Iterator[MuscleState]:
        return (self[index] for index in range(len(self)))


@dataclass(frozen=True, eq=False)
class Answer(Result):
    """The muscle at values and speeds of d coordinates; its arrays are read-only."""

    state: MuscleState
    """The muscle at the values."""
    moment_arms: Floats
    """(n, d) about the coordinates, m: positive where shortening turns the joint forwards. Of a
    prismatic joint they have no unit."""
    lengthening: Floats
    """(n,) how fast the bands grow longer at the speeds, m/s."""
    axes: Floats | None = None
    """(3, 3) column j is the axis of coordinate j, scapula frame (`JointConvention.axes`); None
    where it is no joint convention that moves the bones."""

    def __post_init__(self) -> None:
        for array in (self.moment_arms, self.lengthening):
            array.setflags(False)  # type: ignore[call-arg]  # as above
        if self.axes is not None:
            self.axes.setflags(False)  # type: ignore[call-arg]


@dataclass(frozen=True, eq=False)
class AnswerBatch(Result):
    """The muscle at m values and speeds of d coordinates."""

    states: MuscleStates
    """The muscle at the values."""
    moment_arms: Floats
    """(m, n, d) as those of an Answer."""
    lengthening: Floats
    """(m, n) m/s."""

    def __post_init__(self) -> None:
        for array in (self.moment_arms, self.lengthening):
            array.setflags(write=False)


def _polylines(origins: Floats, insertions: Floats, arcs: Floats, wrap: Bytes) -> list[Floats]:
    return [
        np.concatenate((origins[i : i + 1], arcs[i], insertions[i : i + 1]))
        if state == WRAPPED
        else np.array((origins[i], insertions[i]))
        for i, state in enumerate(wrap.tolist())
    ]
