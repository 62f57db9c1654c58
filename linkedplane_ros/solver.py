"""Solve the linked-plane muscle for a pose: lengths, moment vectors, wrap states and paths.

The scapula frame of the right shoulder has its origin at the glenohumeral centre, x lateral,
y anterior, z superior; a pose is the rotation that takes humerus coordinates to scapula ones. The
left shoulder is the mirror image: its frame has x to the body's right as well, and it is posed by
the rotation of the right shoulder at the same anatomical angles.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .band import CLEAR, INSIDE, MISSED, WRAPPED, wrap
from .compiled import COMPILED, compiled
from .linked_planes import Band, Constants, bands_at, plane_at, solve_theta
from .model import BroadMuscle
from .moment_vectors import muscle_state
from .vectors import Vector

Floats = npt.NDArray[np.float64]

SIDES = ('right', 'left')
MIRROR = np.array([-1.0, 1.0, 1.0])  # x -> -x: points and other true vectors
TURN_MIRROR = -MIRROR  # rotations and moments keep x and change y and z
ORTHONORMAL = 1e-6  # how far R^T R may be from the identity


class WrapState(IntEnum):
    """How a band lies to its obstacle sphere (spec section 2)."""

    WRAPPED = WRAPPED  # round the sphere
    CLEAR = CLEAR  # straight: its plane cuts the sphere, the line keeps off it
    MISSED = MISSED  # straight: its plane does not reach the sphere
    INSIDE = INSIDE  # straight for want of a path: an end lies inside the sphere


@compiled
def solve_pose(
    muscle: Constants,
    rotation: tuple[Vector, Vector, Vector],
    neutral: float,
    lengths: Any,
    moments: Any,
    states: Any,
) -> tuple[float, int]:
    """Fill in the state of one pose; return theta and the number of bands that have a plane."""
    bands = bands_at(muscle, rotation)
    if len(bands) < len(muscle.radii):
        return 0.0, len(bands)
    theta, held = solve_theta(bands, neutral)
    muscle_state(muscle, rotation, bands, theta, held, lengths, moments, states)
    return theta, len(bands)


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
    def bands(self) -> list[Band]:
        """The posed bands in the frame of the right shoulder (SI units)."""
        return self.solver.bands(self.rotation)

    @property
    def sphere_centres(self) -> Floats:
        """(n, 3) obstacle sphere centres, m, scapula frame."""
        offsets = np.array([band.p for band in self.bands])
        return self.solver.mirrored(self.solver.muscle.origins + offsets)

    @property
    def insertions(self) -> Floats:
        """(n, 3) insertions, m, scapula frame."""
        return self.solver.mirrored(np.array([band.S for band in self.bands]))

    def paths(self, points: int = 16) -> list[Floats]:
        """Return each band's path as a polyline: n arrays (k, 3), m, scapula frame.

        A wrapped band is its origin, `points` points on the arc from the first transition point Q
        to the second, T, and its insertion; a straight one its origin and insertion.
        """
        if points < 2:
            raise ValueError(f'points: {points} given, at least 2 needed (the transition points)')
        c, s = float(np.cos(self.theta)), float(np.sin(self.theta))
        drawn = []
        for P, band, state in zip(
            self.solver.muscle.origins, self.bands, self.wrap, strict=True
        ):
            ends = np.array([P, band.S])
            arc = np.empty((0, 3))
            if state == WRAPPED:
                arc = P + wrapped_arc(band, c, s, points)
            drawn.append(self.solver.mirrored(np.vstack([ends[:1], arc, ends[1:]])))
        return drawn


def wrapped_arc(band: Band, c: float, s: float, points: int) -> Floats:
    """Return (points, 3) points from Q to T on a wrapped band's circle, m, from its origin P."""
    normal = np.multiply(band.A, c) + np.multiply(band.B, s)
    normal /= np.linalg.norm(normal)
    u = np.array(band.u)
    e = np.cross(u, normal)
    plane = plane_at(band, c, s)
    w = wrap(band.D, band.a, band.tP, band.tS, band.R, plane.d, plane.b)
    # the direction from the centre to a transition point is t1 turned by a right angle to e
    turn = np.arctan2(w.t1u, -w.t1e) - np.linspace(0.0, w.arc, points)
    circle = np.outer(np.cos(turn), u) + np.outer(np.sin(turn), e)
    centre = np.array(band.p) - plane.d * normal
    return np.asarray(centre + w.r * circle)


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
        """Prepare a muscle for one side of the body; ValueError for any other side."""
        if side not in SIDES:
            raise ValueError(f"side: {side!r} given, 'right' or 'left' expected")
        self.muscle = muscle
        self.side = side
        self._constants = constants(muscle)
        self._neutral = 0.0
        self._neutral = self.solve(np.eye(3)).theta

    def mirrored(self, points: Floats) -> Floats:
        """Return right-shoulder points (..., 3) as points of this solver's side."""
        return points * MIRROR if self.side == 'left' else points

    def solve(self, rotation: npt.ArrayLike) -> MuscleState:
        """Solve one pose, a (3, 3) rotation humerus -> scapula (right-shoulder form).

        Raises ValueError for anything but a proper, finite rotation, and where a band's plane is
        undefined at that pose.
        """
        matrix = proper_rotations(rotation, 2)
        return self._solved(matrix[np.newaxis], 'rotation')[0]

    def solve_batch(self, rotations: npt.ArrayLike) -> MuscleStates:
        """Solve m poses, (m, 3, 3); each answer is, to the bit, that of `solve`. m may be 0."""
        return self._solved(proper_rotations(rotations, 3), 'rotations[{}]')

    def _solved(self, rotations: Floats, name: str) -> MuscleStates:
        m, n = len(rotations), len(self.muscle.band_names)
        theta = np.empty(m)
        lengths = np.empty((m, n))
        moments = np.empty((m, 3 * n))
        states = np.empty((m, n), dtype=np.uint8)
        for k, rows in enumerate(rotations.tolist()):
            row = row_buffers(lengths[k], moments[k], states[k])
            theta[k], placed = solve_pose(
                self._constants, tuple(map(tuple, rows)), self._neutral, *row
            )
            if placed < n:
                raise ValueError(
                    f'{name.format(k)}: band {self.muscle.band_names[placed]} has no plane or no '
                    'sphere frame at this pose: the normal before it runs along its line, or HM '
                    'lies in line with its origin and SC'
                )
            if not COMPILED:
                lengths[k], moments[k], states[k] = row
        moment_vectors = moments.reshape(m, n, 3)
        if self.side == 'left':
            moment_vectors *= TURN_MIRROR
        return MuscleStates(theta, lengths, moment_vectors, states, rotations, self)

    def bands(self, rotation: Floats) -> list[Band]:
        """Return the muscle's bands posed by a (3, 3) rotation, in the right shoulder's frame."""
        rows = tuple(map(tuple, rotation.tolist()))
        return list(bands_at(self._constants, rows))  # type: ignore[arg-type]


def row_buffers(*rows: npt.NDArray[Any]) -> tuple[Any, ...]:
    """Return what the kernel writes to: the rows themselves compiled, quicker lists if not."""
    return rows if COMPILED else tuple(row.tolist() for row in rows)


def constants(muscle: BroadMuscle) -> Constants:
    """Return the muscle as the kernels read it: arrays compiled, quicker lists if not."""
    fields = (
        muscle.origins,
        muscle.insertions,
        muscle.sphere_centres,
        muscle.sphere_radii,
        muscle.plane_angles,
        muscle.reference_normal,
        muscle.ground_point,
        muscle.humeral_point,
    )
    flat = [np.ascontiguousarray(field, dtype=np.float64).ravel() for field in fields]
    return Constants(*flat if COMPILED else [field.tolist() for field in flat])  # type: ignore


def proper_rotations(rotations: npt.ArrayLike, dimensions: int) -> Floats:
    """Return (3, 3) or (m, 3, 3) rotations as an array; ValueError for anything else."""
    expected = '(3, 3)' if dimensions == 2 else '(m, 3, 3)'
    try:
        array = np.array(rotations, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f'rotation: not an array of numbers; {expected} expected') from None
    if array.size == 0 and dimensions == 3:
        return np.empty((0, 3, 3))
    if array.ndim != dimensions or array.shape[-2:] != (3, 3):
        raise ValueError(f'rotation: shape {array.shape} given, {expected} expected')
    if not np.isfinite(array).all():
        raise ValueError(f'rotation: a value is not finite; {expected} finite numbers expected')
    product = array.swapaxes(-1, -2) @ array
    off = float(np.abs(product - np.eye(3)).max())
    if off > ORTHONORMAL:
        raise ValueError(
            f'rotation: R^T R differs from the identity by {off:.3g}; a rotation matrix expected '
            f'(within {ORTHONORMAL:g})'
        )
    if (np.linalg.det(array) < 0.0).any():
        raise ValueError('rotation: determinant -1 (a reflection); a proper rotation expected')
    return array
