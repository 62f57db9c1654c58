"""Solve the linked-plane muscle for a pose: lengths, moment vectors, wrap states and paths.

The scapula frame of the right shoulder has its origin at the glenohumeral centre, x lateral,
y anterior, z superior; a pose is the rotation that takes humerus coordinates to scapula ones. The
left shoulder is the mirror image: its frame has x to the body's right as well, and it is posed by
the rotation of the right shoulder at the same anatomical angles.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..joints.conventions import SIDES, JointConvention
from ..linked_planes.band import CLEAR, INSIDE, MISSED, WRAPPED
from ..linked_planes.compiled import COMPILED
from ..linked_planes.layout import pack_muscle
from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats, Triple
from .kernels import (
    NO_PLANE,
    NOT_FINITE,
    NOT_ORTHONORMAL,
    ORTHONORMAL,
    REFLECTION,
    SOLVED,
    answer,
    draw,
    solve_poses,
)

MIRROR = np.array([-1.0, 1.0, 1.0])  # x -> -x: points and other true vectors
TURN_MIRROR = -MIRROR  # rotations and moments keep x and change y and z
PARALLEL_FROM = 512  # poses: below this, threads cost more than they give
BLOCK = 1000  # poses that are lists at a time, uncompiled

FAULTS = {
    NOT_FINITE: 'a value is not finite; finite numbers expected',
    NOT_ORTHONORMAL: f'R^T R is not the identity within {ORTHONORMAL:g}; a rotation expected',
    REFLECTION: 'its determinant is -1, a reflection; a proper rotation expected',
    NO_PLANE: 'band {} has no plane at this pose: it ends where it begins, or the normal before it '
    'runs along its line',
}
NO_FRAME = ', or its sphere has no frame: HM lies in line with its origin and SC'


class WrapState(IntEnum):
    """How a band lies to its obstacle sphere (spec section 2)."""

    WRAPPED = WRAPPED  # round the sphere
    CLEAR = CLEAR  # straight: its plane cuts the sphere, the line keeps off it
    MISSED = MISSED  # straight: its plane does not reach the sphere
    INSIDE = INSIDE  # straight for want of a path: an end lies inside the sphere


@dataclass(frozen=True, eq=False)
class MuscleState:
    """The muscle at one pose.

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
    wrap: npt.NDArray[np.uint8]
    """(n,) WrapState of each band."""
    rotation: Floats
    """(3, 3) humerus -> scapula, as it was given."""
    solver: LinkedPlaneSolver

    @property
    def total_length(self) -> float:
        """Sum of the band lengths, m: what theta makes least."""
        return float(self.lengths.sum())

    @cached_property
    def _posed(self) -> tuple[Floats, Floats, Floats]:
        return self.solver.drawn(self, 2)

    @property
    def insertions(self) -> Floats:
        """(n, 3) insertions, m, scapula frame."""
        return self._posed[0]

    @property
    def sphere_centres(self) -> Floats:
        """(n, 3) obstacle sphere centres, m, scapula frame."""
        return self._posed[1]

    def moved(self, points: Floats) -> Floats:
        """Return points (..., 3) of the right humerus, m, at this pose: m, scapula frame."""
        return self.solver.mirrored(points @ self.rotation.T)

    def paths(self, points: int = 16) -> list[Floats]:
        """Return each band's path as a polyline: n arrays (k, 3), m, scapula frame.

        A wrapped band is its origin, `points` points on the arc from the first transition point Q
        to the second, T, and its insertion; a straight one its origin and insertion.
        """
        if points < 2:
            raise ValueError(f'points: {points} given, at least 2 needed (the transition points)')
        insertions, _, arcs = self.solver.drawn(self, points)
        origins = self.solver.origins
        return [
            np.concatenate((origins[i : i + 1], arcs[i], insertions[i : i + 1]))
            if state == WRAPPED
            else np.array((origins[i], insertions[i]))
            for i, state in enumerate(self.wrap.tolist())
        ]


@dataclass(frozen=True, eq=False)
class MuscleStates:
    """The muscle at m poses: the fields of MuscleState with a leading m."""

    theta: Floats
    lengths: Floats
    moment_vectors: Floats
    wrap: npt.NDArray[np.uint8]
    rotation: Floats
    solver: LinkedPlaneSolver

    @property
    def total_length(self) -> Floats:
        """(m,) sums of the band lengths, m."""
        return np.asarray(self.lengths.sum(axis=1))

    def __len__(self) -> int:
        return len(self.theta)

    def __getitem__(self, index: int) -> MuscleState:
        return MuscleState(
            float(self.theta[index]),
            self.lengths[index],
            self.moment_vectors[index],
            self.wrap[index],
            self.rotation[index],
            self.solver,
        )

    def __iter__(self) -> Iterator[MuscleState]:
        return (self[index] for index in range(len(self)))


class LinkedPlaneSolver:
    """Solves a broad muscle at a pose; the answer is a function of the pose alone."""

    def __init__(self, muscle: BroadMuscle, side: str = 'right') -> None:
        """Prepare a muscle for one side of the body; ValueError for any other side.

        Where numba is installed this compiles the solver, or loads it from numba's cache.
        """
        if side not in SIDES:
            raise ValueError(f"side: {side!r} given, 'right' or 'left' expected")
        self.muscle = muscle
        self.side = side
        self._flat = flat(muscle)
        self._neutral = 0.0
        neutral = self.solve(np.eye(3))
        neutral.paths()
        self._neutral = neutral.theta

    @property
    def origins(self) -> Floats:
        """(n, 3) origins, m, scapula frame."""
        return self.mirrored(self.muscle.origins)

    def solve(self, rotation: npt.ArrayLike) -> MuscleState:
        """Solve one pose, a (3, 3) rotation humerus -> scapula (right-shoulder form).

        Raises ValueError for anything but a proper, finite rotation, and where a band's plane is
        undefined at that pose.
        """
        matrix = one_rotation(rotation)
        theta, lengths, moments, wrap = self._solved(matrix[np.newaxis], 'rotation')
        return MuscleState(float(theta[0]), lengths[0], moments[0], wrap[0], matrix, self)

    def answer(
        self, convention: JointConvention, angles: Triple, speeds: Triple
    ) -> tuple[MuscleState, Floats, Floats, Floats]:
        """Return the state at a convention's angles (3), rad; moment arms, lengthening and axes.

        Moment arms (n, 3), m; lengthening (n,), m/s, at speeds (3), rad/s; axes (3, 3). To
        rounding the same as `convention.rotation_and_axes`, `solve` and their products, in one
        call. Raises ValueError where a band's plane is undefined.
        """
        n = len(self.muscle.band_names)
        rotation, axes, theta = np.empty((1, 3, 3)), np.empty((3, 3)), np.empty(1)
        lengths, moments, arms = np.empty((1, n)), np.empty((1, 3 * n)), np.empty((n, 3))
        wrap, lengthening = np.empty((1, n), dtype=np.uint8), np.empty(n)
        _, fault, band = answer(
            self._flat,
            self._neutral,
            *convention.sequence_and_mix,
            np.array(angles),
            np.array(speeds),
            -1.0 if self.side == 'left' else 1.0,
            rotation,
            axes,
            theta,
            lengths,
            moments,
            wrap,
            arms,
            lengthening,
        )
        if fault != SOLVED:
            raise ValueError(self._reason(fault, band))
        state = MuscleState(
            theta.item(), lengths[0], moments.reshape(n, 3), wrap[0], rotation[0], self
        )
        return state, arms, lengthening, axes

    def solve_batch(self, rotations: npt.ArrayLike) -> MuscleStates:
        """Solve m poses, (m, 3, 3); each answer is, to the bit, that of `solve`. m may be 0."""
        matrices = rotations_of(rotations)
        return MuscleStates(*self._solved(matrices, 'rotations[{}]'), matrices, self)

    def _solved(
        self, rotations: Floats, name: str
    ) -> tuple[Floats, Floats, Floats, npt.NDArray[np.uint8]]:
        """Return theta (m,), lengths (m, n), moment vectors (m, n, 3) and wrap (m, n)."""
        m, n = len(rotations), len(self.muscle.band_names)
        theta = np.empty(m)
        lengths = np.empty((m, n))
        moments = np.empty((m, n, 3))
        wrap = np.empty((m, n), dtype=np.uint8)
        filled = theta, lengths, moments.reshape(m, 3 * n), wrap
        k, fault, band = in_parts(solve_poses, (self._flat, self._neutral), rotations, filled)
        if fault != SOLVED:
            raise ValueError(f'{name.format(k)}: {self._reason(fault, band)}')
        if self.side == 'left':
            moments *= TURN_MIRROR
        return theta, lengths, moments, wrap

    def _reason(self, fault: int, band: int) -> str:
        """Return why a pose has no answer; `band` is the one that has no plane."""
        reason = FAULTS[fault].format(self.muscle.band_names[band])
        moving = self.muscle.sphere_frames[band] == 'moving'
        return reason + NO_FRAME if fault == NO_PLANE and moving else reason

    def drawn(self, state: MuscleState, points: int) -> tuple[Floats, Floats, Floats]:
        """Return insertions (n, 3), sphere centres (n, 3), arcs (n, points, 3): m, scapula frame.

        The arcs of bands that are not wrapped are zero.
        """
        n = len(self.muscle.band_names)
        insertions, centres, arcs = np.empty((n, 3)), np.empty((n, 3)), np.zeros((n, points, 3))
        draw(self._flat, state.rotation, state.theta, state.wrap, insertions, centres, arcs)
        return self.mirrored(insertions), self.mirrored(centres), self.mirrored(arcs)

    def mirrored(self, points: Floats) -> Floats:
        """Return points (..., 3) of the right scapula as this side's: m, its scapula frame."""
        return points * MIRROR if self.side == 'left' else points


def in_parts(
    kernel: Callable[..., tuple[int, int, int]],
    given: tuple[Any, ...],
    rotations: Floats,
    filled: tuple[npt.NDArray[Any], ...],
) -> tuple[int, int, int]:
    """Run a kernel: in threads if that pays; on lists, which are quicker, if uncompiled."""
    m = len(rotations)
    if not COMPILED:
        for start in range(0, m, BLOCK):
            part = slice(start, start + BLOCK)
            lists = [array[part].tolist() for array in filled]
            given_rotations = rotations[part].tolist()
            k, fault, band = kernel(*given, given_rotations, 0, len(lists[0]), *lists)
            if fault != SOLVED:
                return start + k, fault, band
            for array, values in zip(filled, lists, strict=True):
                array[part] = values
        return m, SOLVED, 0
    threads = available_cores() if m >= PARALLEL_FROM else 1
    if threads == 1:
        return kernel(*given, rotations, 0, m, *filled)
    bounds = [m * i // threads for i in range(threads + 1)]
    with ThreadPoolExecutor(threads) as pool:
        answers = pool.map(
            lambda start, stop: kernel(*given, rotations, start, stop, *filled),
            bounds[:-1],
            bounds[1:],
        )
    return next((answer for answer in answers if answer[1] != SOLVED), (m, SOLVED, 0))


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, 'sched_getaffinity'):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def flat(muscle: BroadMuscle) -> Any:
    """Return the muscle as the kernels read it: an array compiled, a list, quicker, if not."""
    numbers = pack_muscle(
        muscle.reference_normal,
        muscle.ground_point,
        muscle.humeral_point,
        muscle.origins,
        muscle.insertions,
        muscle.sphere_centres,
        muscle.sphere_radii,
        np.cos(muscle.plane_angles),
        np.sin(muscle.plane_angles),
        muscle.sphere_frames,
    )
    return numbers if COMPILED else numbers.tolist()


def one_rotation(rotation: npt.ArrayLike) -> Floats:
    """Return a copy of a (3, 3) matrix; ValueError if it is of another shape or no numbers."""
    matrix = numbers('rotation', rotation, '(3, 3)')
    if matrix.shape != (3, 3):
        raise ValueError(f'rotation: shape {matrix.shape} given, (3, 3) expected')
    return matrix


def rotations_of(rotations: npt.ArrayLike) -> Floats:
    """Return a copy of m matrices (m, 3, 3); ValueError for other shapes. m may be 0."""
    matrices = numbers('rotations', rotations, '(m, 3, 3)')
    if matrices.shape == (0,):
        matrices = np.empty((0, 3, 3))
    if matrices.ndim != 3 or matrices.shape[1:] != (3, 3):
        raise ValueError(f'rotations: shape {matrices.shape} given, (m, 3, 3) expected')
    return matrices


def numbers(name: str, values: npt.ArrayLike, expected: str) -> Floats:
    """Return a copy of values as an array of floats; ValueError if they are no such thing."""
    if isinstance(values, np.ndarray) and values.dtype == np.float64:
        return values.copy()
    try:
        array = np.asarray(values)
        if array.dtype.kind in 'fiu' or array.size == 0:
            return np.array(array, dtype=np.float64, order='C')
    except (TypeError, ValueError):
        pass
    raise ValueError(f'{name}: not an array of numbers; real ones, {expected} expected')
