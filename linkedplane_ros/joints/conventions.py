"""Joint conventions: from three glenohumeral angles to a rotation, its axes, and back.

A rotation takes humerus to scapula coordinates, both in the axes of the right shoulder: x lateral,
y anterior, z superior. Angles are anatomical, so the left shoulder takes the same numbers; see
`axes` for the one place where the side shows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import cos, sin
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from ..linked_planes.compiled import compiled, entry
from ..types import Floats

Rows = tuple[tuple[float, float, float], ...]

SIDES = ('right', 'left')
LEFT_AXES = np.array([[1.0], [-1.0], [-1.0]])  # axes of rotation mirrored, x -> -x
NEAR_SINGULAR = 0.02  # the sine of the elevation below which two moment arms are nearly one
SINGULAR = 1e-14  # below this sine the first and third turn are about one axis
TOLERANCE = 1e-6  # how far R^T R of a rotation may be from the identity


@dataclass(frozen=True)
class JointConvention:
    """Three angles as a sequence of turns about axes that move with the humerus.

    rotation = R(axis 1, m1) R(axis 2, m2) R(axis 3, m3), with m = mix @ angles: mix is the identity
    but where a convention turns by a difference of two of its coordinates.
    """

    name: str
    coordinates: tuple[str, str, str]
    sequence: Rows
    """The three axes of the turns, each in the frame that the turns before it have made."""
    middle: tuple[float, float]
    """The range of the second turn, rad, in which `angles` answers."""
    formula: str
    relative_to: str
    """What the convention's usual streams measure the humerus against."""
    mix: Rows = ((1, 0, 0), (0, 1, 0), (0, 0, 1))

    def rotation(self, angles: npt.ArrayLike) -> Floats:
        """Return the (3, 3) rotation humerus -> scapula of three angles (3,), rad."""
        return self.rotation_and_axes(angles)[0]

    def axes(self, angles: npt.ArrayLike, side: str = 'right') -> Floats:
        """Return (3, 3): column j is the unit axis about which coordinate j turns the humerus.

        Scapula frame, at this pose (3,), rad. (Where a coordinate enters two turns its column is
        their sum and not of unit length.) For side='left' the axes are those of the left scapula
        frame, x to the body's right: mirrored as axes of rotation are, (x, -y, -z).
        """
        return self.rotation_and_axes(angles, side)[1]

    def rotation_and_axes(
        self, angles: npt.ArrayLike, side: str = 'right'
    ) -> tuple[Floats, Floats]:
        """Return `rotation` (always the right shoulder's) and `axes` of three angles, at once."""
        if side not in SIDES:
            raise ValueError(f"side: {side!r} given, 'right' or 'left' expected")
        rotation, axes = np.empty((3, 3)), np.empty((3, 3))
        turn_in_sequence(self._units, self._mix, three(angles), rotation, axes)
        return rotation, axes * LEFT_AXES if side == 'left' else axes

    def rotations_and_axes(self, angles: Floats, side: str = 'right') -> tuple[Floats, Floats]:
        """Return `rotation` and `axes` (m, 3, 3) of many angles (m, 3), finite, rad."""
        rotations, axes = np.empty((len(angles), 3, 3)), np.empty((len(angles), 3, 3))
        for each, rotation, columns in zip(angles, rotations, axes, strict=True):
            turn_in_sequence(self._units, self._mix, each, rotation, columns)
        return rotations, axes * LEFT_AXES if side == 'left' else axes

    def _unmixed(self, turns: Floats) -> Floats:
        return np.asarray(np.linalg.solve(self._mix, turns), dtype=np.float64)

    @property
    def sequence_and_mix(self) -> tuple[Floats, Floats]:
        """(3, 3) the unit axes of the turns, by rows, and the mix, as the kernels take them."""
        return self._units, self._mix

    @cached_property
    def _units(self) -> Floats:
        axes = np.array(self.sequence, dtype=np.float64)
        return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))

    @cached_property
    def _mix(self) -> Floats:
        return np.array(self.mix, dtype=np.float64)

    def angles(self, rotation: npt.ArrayLike) -> Floats:
        """Return the angles (3,), rad, of a (3, 3) rotation: the inverse of `rotation`.

        The second turn is taken in `middle`, so an elevation is not negative. Where the first and
        the third turn share an axis (arm at the side, for the conventions with an elevation) only
        their sum is defined: the first is then 0. ValueError where no angles give the rotation
        (opensim_tsm alone, for its third axis leans; see the message).
        """
        R = proper(rotation)
        e1, e2, e3 = self._units
        # R^T e1 = R3^T R2^T e1, and R2^T e1 keeps its component along e2: one equation for m3
        w = R.T @ e1
        along = (e3 @ w) * e3
        constant = e2 @ along - e2 @ e1
        cosine, sine = e2 @ (w - along), e2 @ np.cross(e3, w)
        swing = np.hypot(cosine, sine)
        if abs(constant) > swing + 1e-9:
            raise ValueError(
                f'rotation: no {self.name} angles give it: seen from the humerus, the first axis '
                f'lies within {np.degrees(np.arcsin(abs(e2 @ e3))):.1f} deg of the third'
            )
        if swing < SINGULAR:
            return self._unmixed(self._at_singularity(R))
        middle_of = np.arctan2(sine, cosine)
        half = np.arccos(np.clip(-constant / swing, -1.0, 1.0))
        found = [
            self._from_third(R, w, m3) for m3 in (float(middle_of + half), float(middle_of - half))
        ]
        return self._unmixed(min(found, key=self._outside))

    def _from_third(self, R: Floats, w: Floats, m3: float) -> Floats:
        e1, e2, e3 = self._units
        back = turn(e3, m3)
        m2 = -angle_about(e2, e1, back @ w)
        first = R @ back.T @ turn(e2, m2).T
        m1 = angle_about(e1, e2, first @ e2)
        return np.array([m1, m2, in_circle(m3)])

    def _at_singularity(self, R: Floats) -> Floats:
        e1, e2, e3 = self._units
        m2 = -angle_about(e2, e1, R.T @ e1)
        low, high = self.middle
        m2 = min(max(m2 if m2 > low - 1.0 else m2 + 2.0 * np.pi, low), high)
        return np.array([0.0, m2, angle_about(e3, e2, turn(e2, m2).T @ R @ e2)])

    def _outside(self, turns: Floats) -> tuple[float, float]:
        low, high = self.middle
        m2 = float(turns[1])
        return max(low - m2, m2 - high, 0.0), m2


def sine_of_singularity(axes: Floats) -> float:
    """Return the sine of the angle between the first and the third turn's axis; 0: singular.

    `axes` (3, 3) are those of `JointConvention.axes`. For a sequence like Y-X-Y it is the sine of
    the elevation. Near 0 the first and third coordinate's moment arms, though right, say the same.
    """
    (ax, _, bx), (ay, _, by), (az, _, bz) = axes.tolist()
    return math.hypot(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


def three(angles: npt.ArrayLike) -> Floats:
    """Return three finite angles (3,), rad; ValueError for anything else."""
    try:
        array = np.asarray(angles, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,) or not all(map(math.isfinite, array.tolist())):
        raise ValueError(f'angles: {angles!r} given, 3 finite numbers in rad expected')
    return array


def proper(rotation: npt.ArrayLike) -> Floats:
    """Return a proper rotation (3, 3) as an array; ValueError for anything else."""
    try:
        R = np.asarray(rotation, dtype=np.float64)
    except (TypeError, ValueError):
        R = np.empty(0)
    if R.shape != (3, 3) or not np.isfinite(R).all():
        raise ValueError(f'rotation: shape {R.shape} given, (3, 3) finite numbers expected')
    if np.abs(R.T @ R - np.eye(3)).max() > TOLERANCE or np.linalg.det(R) < 0.0:
        raise ValueError('rotation: R^T R = 1 and a determinant of 1 expected of a (3, 3) rotation')
    return R


def turn(axis: Floats, angle: float) -> Floats:
    """Return the (3, 3) right-handed rotation about a unit axis (3,) by an angle in rad."""
    return np.array(turn_rows(axis, angle))


@compiled
def turn_rows(axis: Floats, angle: float) -> Rows:
    """Return the rows of the right-handed rotation about a unit axis by an angle in rad."""
    x, y, z = axis[0], axis[1], axis[2]
    c, s = cos(angle), sin(angle)
    k = 1.0 - c
    return (
        (c + k * x * x, k * x * y - s * z, k * x * z + s * y),
        (k * x * y + s * z, c + k * y * y, k * y * z - s * x),
        (k * x * z - s * y, k * y * z + s * x, c + k * z * z),
    )


@entry
def turn_in_sequence(
    units: Floats, mix: Floats, angles: Floats, rotation: Floats, axes: Floats
) -> None:
    """Fill in the rotation and the coordinates' axes of a convention, all (3, 3)."""
    for i in range(3):
        for j in range(3):
            rotation[i, j] = 1.0 if i == j else 0.0
            axes[i, j] = 0.0
    for k in range(3):
        angle = mix[k, 0] * angles[0] + mix[k, 1] * angles[1] + mix[k, 2] * angles[2]
        x, y, z = units[k]
        (a, b, c), (d, e, f), (g, h, m) = turn_rows(units[k], angle)
        for i in range(3):
            # the axis of this turn, by the turns before it; then the turns with this one
            p, q, r = rotation[i]
            along = p * x + q * y + r * z
            for j in range(3):
                axes[i, j] += along * mix[k, j]
            rotation[i, 0] = p * a + q * d + r * g
            rotation[i, 1] = p * b + q * e + r * h
            rotation[i, 2] = p * c + q * f + r * m


def angle_about(axis: Floats, start: Floats, end: Floats) -> float:
    """Return the angle (rad) about a unit axis that turns start's part across it to end's."""
    across = start - (axis @ start) * axis
    return float(np.arctan2(end @ np.cross(axis, across), end @ across))


def in_circle(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    return float(np.pi - (np.pi - angle) % (2.0 * np.pi))


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
MINUS_Y, MINUS_Z = (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)
ELEVATION = (0.0, np.pi)
TSM_AXIAL = (-0.0584, -0.0846, 0.9947)  # ThoracoscapularShoulderModel.osim, in these axes

JOINT_CONVENTIONS: Mapping[str, JointConvention] = MappingProxyType(
    {
        convention.name: convention
        for convention in (
            JointConvention(
                'flexion_abduction_rotation',
                ('flexion', 'abduction', 'rotation'),
                (X, MINUS_Y, Z),
                (-np.pi / 2, np.pi / 2),
                'R(x, flexion) R(-y, abduction) R(z, rotation)',
                'scapula',
            ),
            JointConvention(
                'isb_yxy',
                ('plane_of_elevation', 'elevation', 'axial_rotation'),
                (Z, MINUS_Y, Z),
                ELEVATION,
                'R(z, plane_of_elevation) R(-y, elevation) R(z, axial_rotation)',
                'scapula',
            ),
            JointConvention(
                'opensim_tsm',
                ('plane_elv', 'shoulder_elv', 'axial_rot'),
                (Z, MINUS_Y, TSM_AXIAL),
                ELEVATION,
                'R(z, plane_elv) R(-y, shoulder_elv) R(k, axial_rot), '
                'k = (-0.0584, -0.0846, 0.9947) normalised',
                'scapula',
            ),
            JointConvention(
                'opensim_mobl',
                ('elv_angle', 'shoulder_elv', 'shoulder_rot'),
                (Z, MINUS_Y, Z),
                ELEVATION,
                'R(z, elv_angle) R(-y, shoulder_elv) R(z, shoulder_rot - elv_angle)',
                'thorax',
                mix=((1, 0, 0), (0, 1, 0), (-1, 0, 1)),
            ),
            JointConvention(
                'rep155',
                ('y_shoulder', 'p_shoulder', 'r_shoulder'),
                (Z, MINUS_Y, MINUS_Z),
                ELEVATION,
                'R(z, y_shoulder) R(-y, p_shoulder) R(z, -r_shoulder)',
                'torso',
            ),
        )
    }
)
"""The joint conventions by name; the node's parameter `joint_convention` takes these names."""
