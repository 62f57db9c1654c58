# SPDX-License-Identifier: Apache-2.0
"""What moves a muscle's bones: coordinates by name, and the poses and screws that they give.

A joint convention is one: it turns the last bone about a ball joint. So is a skeleton, which moves
the bones by a chain of joints, and a shoulder rhythm, where bones follow that nobody measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError, describe_value
from ..types import Floats
from .rotations import as_floats

REVOLUTE, CONTINUOUS, PRISMATIC = 'revolute', 'continuous', 'prismatic'


class MovedBones(NamedTuple):
    """The k bones that move, at m values of d coordinates; right-shoulder form, ground frame."""

    poses: Floats
    """(m, k, 3, 4) R and t of each, side by side: a point x of the bone stands at R x + t, m."""
    screws: Floats
    """(m, d, k, 6) how each coordinate moves each bone at unit speed: w turns it about the ground's
    axes, v is the velocity of its point at the ground's origin, m (of prismatic joints: 0, 1)."""


class Articulation(Protocol):
    """What moves the bones of a muscle; see `LinkedPlaneSolver.answer`."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates, d of them."""

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of each: REVOLUTE, CONTINUOUS (both rad) or PRISMATIC (m)."""

    def move_bones(self, values: npt.ArrayLike, bones: Sequence[str], side: str) -> MovedBones:
        """Return the bones of a muscle at values of the coordinates.

        Parameters
        ----------
        values
            (m, d) rad or m.
        bones
            The muscle's: the ground first, then the k that move.
        side
            The muscle's. Whatever the side, the answer is in right-shoulder form.

        Returns
        -------
        MovedBones
            Poses and screws.

        Raises
        ------
        LinkedPlaneError
            For anything but finite numbers (m, d), and for bones that it does not move.

        """


def check_articulation(given: object) -> None:
    """Refuse what moves no bones."""
    if not hasattr(given, 'move_bones'):  # isinstance would take longer than to solve
        expected = 'one of JOINT_CONVENTIONS expected, or a Skeleton for the bones'
        raise LinkedPlaneError(f'convention: {describe_value(given)} given, {expected}')


def name_unit(kinds: Sequence[str]) -> str:
    """Return the unit of values of these kinds, in words."""
    units = ['m' if kind == PRISMATIC else 'rad' for kind in kinds]
    return ' or '.join(dict.fromkeys(units))


def as_values(name: str, values: npt.ArrayLike, moved_by: Articulation, per: str = '') -> Floats:
    """Return one finite number for each coordinate (d,); LinkedPlaneError for anything else.

    `per` is what follows the unit, as in rad/s.
    """
    d = len(moved_by.coordinates)
    try:
        if len(values) == d and all(map(isfinite, values)):  # type: ignore[arg-type]
            return np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        pass
    unit = name_unit(moved_by.kinds)
    given = describe_value(values)
    raise LinkedPlaneError(f'{name}: {given} given, {d} finite numbers in {unit}{per} expected')


def as_value_batch(
    name: str, values: npt.ArrayLike, m: int, moved_by: Articulation, per: str = ''
) -> Floats:
    """Return m finite numbers for each coordinate (m, d); LinkedPlaneError for anything else.

    `per` is what follows the unit, as in rad/s.
    """
    d = len(moved_by.coordinates)
    expected = f'({m}, {d}) finite numbers in {name_unit(moved_by.kinds)}{per} expected'
    array = as_floats(name, values, expected.removesuffix(' expected'))
    if m == 0 and array.shape == (0,):
        array = array.reshape(0, d)
    if array.shape != (m, d):
        raise LinkedPlaneError(f'{name}: shape {array.shape} given, {expected}')
    wrong = np.flatnonzero(~np.isfinite(array).all(axis=1)).tolist()
    if wrong:
        given = array[wrong[0]].tolist()
        raise LinkedPlaneError(f'{name}[{wrong[0]}]: {given} given, {expected}')
    return array


def rest_poses(m: int, k: int) -> Floats:
    """Return m poses of k bones, all of them at rest (m, k, 3, 4)."""
    poses = np.zeros((m, k, 3, 4))
    poses[..., :3] = np.eye(3)
    return poses


def rotated_poses(rotations: Floats, k: int) -> Floats:
    """Return the poses (m, k, 3, 4) at which the last bone is rotated (m, 3, 3), others at rest."""
    poses = rest_poses(len(rotations), k)
    poses[:, -1, :, :3] = rotations
    return poses
