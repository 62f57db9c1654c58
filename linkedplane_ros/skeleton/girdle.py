# SPDX-License-Identifier: Apache-2.0
"""The bones of the shoulder girdle against the thorax: at rest, and at a pose of the humerus.

All rotations are of the right shoulder, against the thorax, in the model's axes (x lateral,
y anterior, z superior), between frames built on landmarks. The humerus is described by `isb_yxy`
(plane of elevation, elevation, axial rotation), scapula and clavicle by `GIRDLE`: protraction about
the upward axis, then lateral rotation (of the clavicle: elevation) about the backward one, then
tilt (axial rotation) about the bone's own lateral axis. These are de Groot and Brand's y-z-y and
y-z-x in Delft's axes (x right, y up, z back).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError, describe_value
from ..joints.conventions import JOINT_CONVENTIONS, MINUS_Y, JointConvention, X, Z, as_triple
from ..types import Floats, Triple
from .skeleton import BonePose, Skeleton

HUMERUS = JOINT_CONVENTIONS['isb_yxy']
GIRDLE = JointConvention(
    'girdle_yzx',
    ('protraction', 'lateral_rotation', 'tilt'),
    (Z, MINUS_Y, X),
    (-np.pi / 2, np.pi / 2),
    'R(z, protraction) R(-y, lateral_rotation) R(x, tilt)',
    'thorax',
)
"""The angles of scapula and clavicle against the thorax."""
# Larger angles of a hanging arm are degrees: nobody's scapula or clavicle is a right angle from the
# thorax's axes (the range of the second turn, too), and an arm that is raised so far does not hang.
MOST_AT_REST = np.pi / 2
MOST_PLANE = 3.15  # a plane of elevation goes all around: pi, also if it was rounded up


@dataclass(frozen=True)
class Rest:
    """A subject's girdle with the arm hanging, rad, as `GIRDLE`; the defaults are DSEM's means."""

    scapula: Triple = (0.559332, 0.186211, -0.180122)  # 32.05, 10.67, -10.32 deg
    clavicle: Triple = (-0.498699, 0.203851, 0.130586)  # -28.57, 11.68, 7.48 deg
    humerus: tuple[float, float] | None = None
    """Plane of elevation and elevation, rad, at which the girdle is so; None: not known."""

    def __str__(self) -> str:
        angles = ' '.join(f'{each:.6g}' for each in (*self.scapula, *(self.humerus or ())))
        return f'{angles} rad'

    def __post_init__(self) -> None:
        for bone, angles in ('scapula', self.scapula), ('clavicle', self.clavicle):
            as_triple(f'rest: {bone}', angles, 'rad')
            _refuse_degrees(f'rest: {bone}', angles, (MOST_AT_REST,) * 3)
        if self.humerus is not None:
            _check_plane_and_elevation(self.humerus)
            _refuse_degrees('rest: humerus', self.humerus, (MOST_PLANE, MOST_AT_REST))

    @classmethod
    def measured(
        cls,
        scapula: npt.ArrayLike | None,
        clavicle: npt.ArrayLike | None,
        humerus: npt.ArrayLike,
    ) -> Rest:
        """Return the rest of measured poses.

        Parameters
        ----------
        scapula, clavicle, humerus
            (3, 3) against the thorax, right shoulder, the model's axes; as a mean of still frames.
            None: not known, an average subject's.

        Returns
        -------
        Rest
            Its angles, those of the humerus included.

        Raises
        ------
        LinkedPlaneError
            For anything but proper rotations.
        """
        plane, elevation, _ = HUMERUS.angles(humerus).tolist()
        a, b, c = cls.scapula if scapula is None else GIRDLE.angles(scapula).tolist()
        d, e, f = cls.clavicle if clavicle is None else GIRDLE.angles(clavicle).tolist()
        return cls((a, b, c), (d, e, f), (plane, elevation))

    @classmethod
    def from_numbers(cls, numbers: Sequence[Any], name: str = 'rest') -> Rest:
        """Return the rest of 3 or 5 numbers, rad, as a user gives them.

        Parameters
        ----------
        numbers
            The scapula's three angles, and if known the humerus' plane of elevation and elevation.
        name
            What they are called where they were given, for the error.

        Returns
        -------
        Rest
            With an average subject's clavicle.

        Raises
        ------
        LinkedPlaneError
            For another count, for numbers that are not finite, and for such as only degrees are.
        """
        if len(numbers) not in (3, 5):
            raise LinkedPlaneError(
                f'{name}: {len(numbers)} numbers given; 3 expected, the angles of the scapula, '
                'or 5, with plane and elevation of the humerus'
            )
        a, b, c, *humerus = numbers
        try:
            return cls((a, b, c), humerus=(humerus[0], humerus[1]) if humerus else None)
        except LinkedPlaneError as error:
            raise LinkedPlaneError(name + str(error).removeprefix('rest')) from None


def _refuse_degrees(name: str, angles: Sequence[float], most: Sequence[float]) -> None:
    """Raise a LinkedPlaneError for angles, rad, that a hanging arm has only in degrees."""
    if any(abs(angle) > bound for angle, bound in zip(angles, most, strict=True)):
        bounds = ' and '.join(dict.fromkeys(f'{bound:.4g}' for bound in most))
        raise LinkedPlaneError(
            f'{name}: {describe_value(angles)} given, degrees? rad expected, at most {bounds} '
            'either way with the arm hanging'
        )


def _check_plane_and_elevation(given: Sequence[float]) -> None:
    try:
        plane, elevation = given
        as_triple('rest: humerus', (plane, elevation, 0.0), 'rad')
    except (TypeError, ValueError, LinkedPlaneError):
        raise LinkedPlaneError(
            f'rest: humerus: {describe_value(given)} given, 2 finite numbers in rad expected'
        ) from None


def check_rest(rest: object) -> None:
    """Refuse what is neither a rest nor None."""
    if rest is not None and not isinstance(rest, Rest):
        raise LinkedPlaneError(f'rest: {describe_value(rest)} given, a Rest or None expected')


@dataclass(frozen=True, eq=False)
class GirdlePose:
    """The bones of the girdle at a pose of the humerus, and how they turn with its coordinates."""

    scapula: Floats
    """(3, 3) scapula -> thorax."""
    clavicle: Floats
    """(3, 3) clavicle -> thorax; without a rhythm of its own it keeps its place at the scapula."""
    humerus: Floats
    """(3, 3) humerus -> thorax, as it was given."""
    scapula_axes: Floats
    """(3, 3) column j: how the scapula turns with coordinate j of the humerus, thorax's axes."""
    clavicle_axes: Floats
    humerus_axes: Floats

    @property
    def rotation(self) -> Floats:
        """(3, 3) humerus -> scapula: what a muscle's solver takes."""
        return np.asarray(self.scapula.T @ self.humerus)

    @property
    def axes(self) -> Floats:
        """(3, 3) column j: how the humerus turns against the scapula with coordinate j.

        In the scapula's axes; ``moment_vectors @ axes`` are the moment arms about the coordinates
        of the humerus against the thorax, what follows them included. They are no unit vectors.
        """
        return np.asarray(self.scapula.T @ (self.humerus_axes - self.scapula_axes))

    @property
    def bones(self) -> dict[str, BonePose]:
        """(R, t) of clavicle, scapula and humerus, (3, 3) and (3,) m, in the thorax's frame.

        The joints' centres are those of the bundled skeleton `shoulder_girdle`.
        """
        sternoclavicular, acromion, glenoid = joint_centres()
        centre = sternoclavicular + self.clavicle @ acromion + self.scapula @ glenoid
        return {
            'clavicle': (self.clavicle, sternoclavicular.copy()),
            'scapula': (self.scapula, centre),
            'humerus': (self.humerus, centre.copy()),
        }


@cache
def joint_centres() -> tuple[Floats, Floats, Floats]:
    """Return SC in the thorax, AC in the clavicle, and the glenoid from AC in the scapula, m."""
    joints = {joint.name: joint for joint in Skeleton.load('shoulder_girdle').tree.joints}
    names = 'sc_protraction', 'ac_protraction', 'acromion_to_glenoid'
    first, second, third = (np.array(joints[name].xyz) for name in names)
    return first, second, third
