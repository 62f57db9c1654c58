# SPDX-License-Identifier: Apache-2.0
"""Joint conventions: from three glenohumeral angles to a rotation, its axes, and back.

A rotation takes humerus to scapula coordinates, both in the axes of the right shoulder: x lateral,
y anterior, z superior. Angles are anatomical, so the left shoulder takes the same numbers; see
`axes` for the one place where the side shows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError, describe_value
from ..linked_planes.compilation import entry
from ..types import Floats, Interval, Triple
from .articulation import REVOLUTE, MovedBones, rotated_poses
from .rotations import as_rotation, rotation_about, rotation_rows
from .sides import check_side, mirror_columns

Triples = tuple[Triple, Triple, Triple]

IDENTITY: Triples = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
NEAR_SINGULAR = 0.02  # the sine of the elevation below which two moment arms are nearly one
SINGULAR = 1e-14  # below this sine the first and third turn are about one axis


@dataclass(frozen=True)
class JointConvention:
    """Three angles as a sequence of turns about axes that move with the humerus.

    The rotation is R(axis 1, m1) R(axis 2, m2) R(axis 3, m3), with m = mix @ angles; mix is the
    identity except where a convention turns by a difference of two of its coordinates.
    """

    name: str
    coordinates: tuple[str, str, str]
    """What the three angles are called."""
    sequence: Triples
    """The three axes of the turns, each in the frame that the turns before it have made."""
    middle: Interval
    """The range of the second turn, rad, in which `angles` answers."""
    formula: str
    """The rotation in words, for people."""
    relative_to: str
    """What the convention's usual streams measure the humerus against."""
    mix: Triples = IDENTITY
    """(3, 3) what each turn takes of each angle."""

    @property
    def kinds(self) -> tuple[str, str, str]:
        """Of each coordinate: REVOLUTE."""
        return REVOLUTE, REVOLUTE, REVOLUTE

    def move_bones(self, values: npt.ArrayLike, bones: Sequence[str], side: str) -> MovedBones:
        """Return the bones: the last one turned, the others at rest (`Articulation`).

        Parameters
        ----------
        values
            (m, 3) rad.
        bones
            The muscle's: the ground first, then the k that move.
        side
            The muscle's; the answer is the same for both.

        Returns
        -------
        MovedBones
            Poses and screws, right-shoulder form.

        Raises
        ------
        LinkedPlaneError
            For anything but triples of finite numbers.
        """
        rotations, axes = self.rotations_and_axes(values)
        poses = rotated_poses(rotations, len(bones) - 1)
        screws = np.zeros((len(poses), 3, len(bones) - 1, 6))
        screws[:, :, -1, :3] = axes.swapaxes(1, 2)
        return MovedBones(poses, screws)

    def rotation(self, angles: npt.ArrayLike) -> Floats:
        """Return the rotation humerus -> scapula of three angles.

        Parameters
        ----------
        angles
            (3,) rad.

        Returns
        -------
        Floats
            (3, 3) the right shoulder's; the left shoulder is solved for the same one.

        Raises
        ------
        LinkedPlaneError
            For anything but three finite numbers.

        """
        return self.rotation_and_axes(angles)[0]

    def axes(self, angles: npt.ArrayLike, side: str = 'right') -> Floats:
        """Return the axes about which the coordinates turn the humerus.

        Parameters
        ----------
        angles
            (3,) rad.
        side
            'right', or 'left' for the axes in the left scapula's frame, x to the body's right:
            mirrored as axes of rotation are, (x, -y, -z).

        Returns
        -------
        Floats
            (3, 3) column j is the unit axis of coordinate j at this pose, scapula frame. Where a
            coordinate enters two turns its column is their sum, and not of unit length.

        Raises
        ------
        LinkedPlaneError
            For anything but three finite numbers, and for another side.

        """
        return self.rotation_and_axes(angles, side)[1]

    @property
    def caution(self) -> str:
        """What its streams usually measure; empty if that is what the model needs."""
        if self.relative_to == 'scapula':
            return ''
        return (
            f'{self.name} streams usually measure the humerus against the {self.relative_to}; '
            'the model needs it against the scapula'
        )

    def rotation_and_axes(
        self, angles: npt.ArrayLike, side: str = 'right'
    ) -> tuple[Floats, Floats]:
        """Return `rotation` and `axes` of three angles, at once.

        Parameters
        ----------
        angles
            (3,) rad.
        side
            As for `axes`.

        Returns
        -------
        rotation : Floats
            (3, 3) humerus -> scapula, always the right shoulder's.
        axes : Floats
            (3, 3) column j is the axis of coordinate j, scapula frame.

        Raises
        ------
        LinkedPlaneError
            For anything but three finite numbers, and for another side.

        """
        given = [as_triple('angles', angles, 'rad')]
        rotations, axes = self.rotations_and_axes(given, side)
        return rotations[0], axes[0]

    def rotations_and_axes(
        self, angles: npt.ArrayLike, side: str = 'right'
    ) -> tuple[Floats, Floats]:
        """Return `rotation` and `axes` of many angles at once.

        Parameters
        ----------
        angles
            (m, 3) rad; m may be 0.
        side
            As for `axes`.

        Returns
        -------
        rotations : Floats
            (m, 3, 3) humerus -> scapula, always the right shoulder's.
        axes : Floats
            (m, 3, 3) as those of `axes`.

        Raises
        ------
        LinkedPlaneError
            For anything but triples of finite numbers, and for another side.

        """
        check_side(side)
        triples = as_triples(angles)
        rotations, axes = np.empty((len(triples), 3, 3)), np.empty((len(triples), 3, 3))
        for each, rotation, columns in zip(triples, rotations, axes, strict=True):
            turn_in_sequence(*self.units_and_mix, each, rotation, columns)
        if side == 'left':
            axes = mirror_columns(axes)
        return rotations, axes

    @cached_property
    def units_and_mix(self) -> tuple[Floats, Floats]:
        """(3, 3) the unit axes of the turns, by rows, and the mix, as the kernels take them."""
        axes = np.array(self.sequence, dtype=np.float64)
        units = axes / np.linalg.norm(axes, axis=1, keepdims=True)
        return units, np.array(self.mix, dtype=np.float64)

    def angles(self, rotation: npt.ArrayLike) -> Floats:
        """Return the angles of a rotation: the inverse of `rotation`.

        The second turn is taken in `middle`, so an elevation is not negative. Where the first and
        the third turn share an axis (arm at the side, for the conventions with an elevation) only
        their sum is defined: the first is then 0.

        Parameters
        ----------
        rotation
            (3, 3) humerus -> scapula, right shoulder.

        Returns
        -------
        Floats
            (3,) rad, each in (-pi, pi].

        Raises
        ------
        LinkedPlaneError
            For anything but a proper rotation, and where no angles give it (only opensim_tsm, as
            its third axis leans; see the message).

        """
        R = as_rotation(rotation)
        (e1, e2, e3), mix = self.units_and_mix
        # R^T e1 = R3^T R2^T e1, and R2^T e1 keeps its component along e2: one equation for m3
        w = R.T @ e1
        along = (e3 @ w) * e3
        constant = e2 @ along - e2 @ e1
        cosine, sine = e2 @ (w - along), e2 @ np.cross(e3, w)
        swing = np.hypot(cosine, sine)
        if abs(constant) > swing + 1e-9:
            raise LinkedPlaneError(
                f'rotation: no {self.name} angles give it: seen from the humerus, the first axis '
                f'lies within {np.degrees(np.arcsin(abs(e2 @ e3))):.1f} deg of the third'
            )
        if swing < SINGULAR:
            m2 = self._nearest_middle(self._second_turn(w, 0.0))
            m3 = angle_about(e3, e2, rotation_about(e2, m2).T @ R @ e2)
            return _unmix(mix, np.array([0.0, m2, m3]))
        middle_of = np.arctan2(sine, cosine)
        half = np.arccos(np.clip(-constant / swing, -1.0, 1.0))
        candidates = []
        for m3 in (float(middle_of + half), float(middle_of - half)):
            m2 = self._second_turn(w, m3)
            first = R @ rotation_about(e3, m3).T @ rotation_about(e2, m2).T
            candidates.append(np.array([angle_about(e1, e2, first @ e2), m2, principal_angle(m3)]))
        return _unmix(mix, min(candidates, key=self._outside))

    def _second_turn(self, w: Floats, m3: float) -> float:
        """Return the second turn, rad, from the third and w = R^T e1."""
        e1, e2, e3 = self.units_and_mix[0]
        return -angle_about(e2, e1, rotation_about(e3, m3) @ w)

    def _nearest_middle(self, m2: float) -> float:
        low, high = self.middle
        return min(max(m2 if m2 > low - 1.0 else m2 + 2.0 * np.pi, low), high)

    def _outside(self, turns: Floats) -> tuple[float, float]:
        """Return how far the second turn is outside its range, and the turn, to order by."""
        low, high = self.middle
        m2 = float(turns[1])
        return max(low - m2, m2 - high, 0.0), m2


def _unmix(mix: Floats, turns: Floats) -> Floats:
    """Return the angles of turns, each in (-pi, pi]: a whole turn of any is none."""
    return np.array([principal_angle(each) for each in np.linalg.solve(mix, turns).tolist()])


def as_triple(name: str, values: Any, unit: str) -> Triple:
    """Return three finite numbers as floats; LinkedPlaneError names what and their unit."""
    try:
        x, y, z = values
        if math.isfinite(x) and math.isfinite(y) and math.isfinite(z):
            return float(x), float(y), float(z)
    except (TypeError, ValueError, OverflowError):
        pass
    raise LinkedPlaneError(
        f'{name}: {describe_value(values)} given, 3 finite numbers in {unit} expected'
    )


def as_triples(angles: npt.ArrayLike) -> Floats:
    """Return angles (m, 3), rad; LinkedPlaneError for anything but triples of finite numbers."""
    try:
        triples = np.asarray(angles, dtype=np.float64)
    except (TypeError, ValueError):
        raise LinkedPlaneError('angles: numbers (m, 3) in rad expected') from None
    if triples.ndim != 2 or triples.shape[1] != 3:
        raise LinkedPlaneError(f'angles: shape {triples.shape} given, (m, 3) in rad expected')
    wrong = np.flatnonzero(~np.isfinite(triples).all(axis=1)).tolist()
    if wrong:
        given = triples[wrong[0]].tolist()
        raise LinkedPlaneError(f'angles[{wrong[0]}]: {given} given, finite numbers expected')
    return triples


def sine_of_singularity(axes: Floats) -> float:
    """Return the sine of the angle between the first and the third turn's axis; 0: singular.

    `axes` (3, 3) are those of `JointConvention.axes`. For a sequence like Y-X-Y it is the sine of
    the elevation. Near 0 the first and third coordinate's moment arms, though right, say the same.
    """
    (ax, _, bx), (ay, _, by), (az, _, bz) = axes.tolist()
    return math.hypot(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


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
        (a, b, c), (d, e, f), (g, h, m) = rotation_rows(units[k], angle)
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


def principal_angle(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    if -np.pi < angle <= np.pi:
        return float(angle)
    return float(np.pi - (np.pi - angle) % (2.0 * np.pi))


X, MINUS_Y, Z, MINUS_Z = (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
TSM_AXIAL = (-0.0584, -0.0846, 0.9947)  # ThoracoscapularShoulderModel.osim, in these axes


def _elevating(
    name: str,
    coordinates: tuple[str, str, str],
    formula: str,
    relative_to: str,
    axial: Triple = Z,
    mix: Triples = IDENTITY,
) -> JointConvention:
    """Return a convention of plane of elevation, elevation, and turn about an axial axis."""
    sequence = (Z, MINUS_Y, axial)
    return JointConvention(name, coordinates, sequence, (0.0, np.pi), formula, relative_to, mix)


_CONVENTIONS = (
    JointConvention(
        'flexion_abduction_rotation',
        ('flexion', 'abduction', 'rotation'),
        (X, MINUS_Y, Z),
        (-np.pi / 2, np.pi / 2),
        'R(x, flexion) R(-y, abduction) R(z, rotation)',
        'scapula',
    ),
    _elevating(
        'isb_yxy',
        ('plane_of_elevation', 'elevation', 'axial_rotation'),
        'R(z, plane_of_elevation) R(-y, elevation) R(z, axial_rotation)',
        'scapula',
    ),
    _elevating(
        'opensim_tsm',
        ('plane_elv', 'shoulder_elv', 'axial_rot'),
        'R(z, plane_elv) R(-y, shoulder_elv) R(k, axial_rot), '
        'k = (-0.0584, -0.0846, 0.9947) normalised',
        'scapula',
        TSM_AXIAL,
    ),
    _elevating(
        'opensim_mobl',
        ('elv_angle', 'shoulder_elv', 'shoulder_rot'),
        'R(z, elv_angle) R(-y, shoulder_elv) R(z, shoulder_rot - elv_angle)',
        'thorax',
        mix=((1, 0, 0), (0, 1, 0), (-1, 0, 1)),
    ),
    _elevating(
        'rep155',
        ('y_shoulder', 'p_shoulder', 'r_shoulder'),
        'R(z, y_shoulder) R(-y, p_shoulder) R(z, -r_shoulder)',
        'torso',
        MINUS_Z,
    ),
)
JOINT_CONVENTIONS: Mapping[str, JointConvention] = MappingProxyType(
    {convention.name: convention for convention in _CONVENTIONS}
)
"""The joint conventions by name; the node's parameter `joint_convention` takes these names."""
THESIS_CONVENTION = JOINT_CONVENTIONS['flexion_abduction_rotation']
"""The thesis's own: a model's range of motion is stated in its coordinates."""
