# SPDX-License-Identifier: Apache-2.0
"""A shoulder rhythm: how scapula and clavicle follow the humerus, where nobody measured them.

Frames, axes and angles are those of `girdle`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ..joints.conventions import as_triple, principal_angle
from ..joints.rotations import as_rotation
from ..types import Floats, Interval
from .girdle import GIRDLE, HUMERUS, GirdlePose, Rest, check_rest
from .skeleton import BonePose

Coefficients = tuple[float, float, float, float]
"""rad of constant, then per rad of plane, elevation and rest angle."""


@dataclass(frozen=True)
class Rhythm(ABC):
    """How the girdle follows the humerus."""

    name: str
    source: str
    valid: str
    """For which motions it was made."""
    range: Interval
    """The elevations of the humerus against the thorax, rad, for which it is meant; not held to."""
    tested: str
    """Against what it was tested here, and how far off it was."""

    def __str__(self) -> str:
        return self.name

    @property
    @abstractmethod
    def needs_plane(self) -> bool:
        """Whether the girdle depends on the plane of elevation of an arm at the side, too."""

    def bones(self, angles: npt.ArrayLike, rest: Rest | None = None) -> dict[str, BonePose]:
        """Return where the bones are at angles of the humerus.

        Parameters
        ----------
        angles
            (3,) rad, of `isb_yxy`, against the thorax.
        rest
            As for `pose`.

        Returns
        -------
        dict
            Of clavicle, scapula and humerus (R, t), (3, 3) and (3,) m, in the thorax's frame; the
            joints' centres are those of the bundled skeleton `shoulder_girdle`.

        Raises
        ------
        LinkedPlaneError
            For anything but three finite numbers.
        """
        return self.pose_at(angles, rest=rest).bones

    def pose_at(
        self, angles: npt.ArrayLike, slopes: npt.ArrayLike | None = None, rest: Rest | None = None
    ) -> GirdlePose:
        """Return the girdle at angles of the humerus.

        Unlike `pose` it knows the plane of an arm at the side, so it is smooth there, and takes
        an elevation below 0 for a little less, not for one in the opposite plane.

        Parameters
        ----------
        angles
            (3,) rad, of `isb_yxy`, against the thorax.
        slopes
            (3, 3) how much of each angle a coordinate is, column by column; None: the coordinates
            are the angles.
        rest
            As for `pose`.

        Returns
        -------
        GirdlePose
            As of `pose`.

        Raises
        ------
        LinkedPlaneError
            For anything but three finite numbers.
        """
        H, axes = HUMERUS.rotation_and_axes(angles)
        plane, elevation, axial = as_triple('angles', angles, 'rad')
        known = np.array((principal_angle(plane), elevation, axial))
        each = np.eye(3) if slopes is None else np.asarray(slopes, dtype=np.float64)
        return self._pose(H, axes @ each, known, each, rest)

    def pose(
        self,
        humerus: npt.ArrayLike,
        humerus_axes: npt.ArrayLike | None = None,
        rest: Rest | None = None,
    ) -> GirdlePose:
        """Return the girdle at a pose of the humerus.

        Parameters
        ----------
        humerus
            (3, 3) humerus -> thorax, right shoulder, the model's axes.
        humerus_axes
            (3, 3) column j is the axis about which coordinate j turns the humerus, thorax's axes
            (`JointConvention.axes` of angles against the thorax); None: the three axes of the
            thorax.
        rest
            The subject's rest; None: that of an average one.

        Returns
        -------
        GirdlePose
            The bones against the thorax, and how they turn with the humerus' coordinates.

        Raises
        ------
        LinkedPlaneError
            For anything but a proper rotation.
        """
        H = as_rotation(humerus)
        axes = np.eye(3) if humerus_axes is None else np.asarray(humerus_axes, dtype=np.float64)
        angles = HUMERUS.angles(H)
        return self._pose(H, axes, angles, _per_turn(HUMERUS.axes(angles)) @ axes, rest)

    def _pose(
        self, H: Floats, axes: Floats, angles: Floats, slopes: Floats, rest: Rest | None
    ) -> GirdlePose:
        check_rest(rest)
        S, scapula_turn = self.scapula(angles, rest)
        C, clavicle_turn = self.clavicle(angles, rest, S, scapula_turn)
        return GirdlePose(S, C, H, scapula_turn @ slopes, clavicle_turn @ slopes, axes)

    @abstractmethod
    def scapula(self, angles: Floats, rest: Rest | None) -> tuple[Floats, Floats]:
        """Return the scapula at angles of the humerus, and how it turns with them.

        Parameters
        ----------
        angles
            (3,) rad, of `isb_yxy`, against the thorax.
        rest
            As for `pose`.

        Returns
        -------
        scapula : Floats
            (3, 3) scapula -> thorax.
        turn : Floats
            (3, 3) column j is its turn with angle j, thorax's axes.
        """

    def clavicle(
        self, angles: Floats, rest: Rest | None, scapula: Floats, turn: Floats
    ) -> tuple[Floats, Floats]:
        """Return the same of the clavicle; here it keeps its place against the scapula.

        Parameters
        ----------
        angles, rest
            As for `scapula`.
        scapula, turn
            What that returns.

        Returns
        -------
        clavicle : Floats
            (3, 3) clavicle -> thorax.
        turn : Floats
            (3, 3) column j is its turn with angle j, thorax's axes.
        """
        return scapula @ _clavicle_at_rest(rest), turn


def _per_turn(axes: Floats) -> Floats:
    """Return how much of each angle a turn takes, as the inverse of the angles' axes.

    Where plane and axial rotation are about one axis (arm at the side) the turn is theirs
    together: it is counted half and half, and a turn across counts as none in them.
    """
    return np.asarray(np.linalg.pinv(axes, rcond=1e-9))


@dataclass(frozen=True)
class ConstantRatio(Rhythm):
    """The scapula takes a share of each elevation, in the plane of elevation."""

    ratio: float
    """Glenohumeral to scapulothoracic elevation."""

    def __str__(self) -> str:
        return f'{self.name} {self.ratio:g} to 1'

    @property
    def needs_plane(self) -> bool:
        """No: a share of no elevation is none in any plane."""
        return False

    def scapula(self, angles: Floats, rest: Rest | None) -> tuple[Floats, Floats]:
        """Return the scapula; without a rest its frame is the thorax's, arm at the side."""
        S, turn = self._since_side(angles)
        if rest is None:
            return S, turn
        start = GIRDLE.rotation(rest.scapula)
        if rest.humerus is not None:
            start = self._since_side(np.array((*rest.humerus, 0.0)))[0].T @ start
        return S @ start, turn

    def _since_side(self, angles: Floats) -> tuple[Floats, Floats]:
        share = np.array((1.0, self.ratio / (1.0 + self.ratio), 1.0))
        H, humerus_axes = HUMERUS.rotation_and_axes(angles)
        G, glenohumeral_axes = HUMERUS.rotation_and_axes(share * angles)
        S = H @ G.T
        return S, humerus_axes - S @ glenohumeral_axes * share


@dataclass(frozen=True)
class LinearRhythm(Rhythm):
    """Angles of scapula and clavicle, linear in the humerus' plane of elevation and elevation."""

    scapula_coefficients: tuple[Coefficients, Coefficients, Coefficients]
    """Of protraction, lateral rotation and tilt."""
    clavicle_coefficients: tuple[Coefficients, Coefficients] | None = None
    """Of protraction and elevation; its axial rotation is that of the least turn of the AC joint
    since rest. None: it keeps its place at the scapula."""

    @property
    def needs_plane(self) -> bool:
        """Whether any angle has a coefficient of the plane."""
        return bool(self._scapula_slopes[:, 0].any() or self._clavicle_slopes[:, 0].any())

    @cached_property
    def _scapula_slopes(self) -> Floats:
        return _slopes(self.scapula_coefficients)

    @cached_property
    def _clavicle_slopes(self) -> Floats:
        return _slopes((*(self.clavicle_coefficients or ()), (0.0, 0.0, 0.0, 0.0)))

    def scapula(self, angles: Floats, rest: Rest | None) -> tuple[Floats, Floats]:
        """Return the scapula: from the rest on where all of it is known, else by the constants."""
        rest = rest or Rest()
        own = _linear(self.scapula_coefficients, angles, rest.scapula, rest.humerus)
        S, axes = GIRDLE.rotation_and_axes(own)
        return S, axes @ self._scapula_slopes

    def clavicle(
        self, angles: Floats, rest: Rest | None, scapula: Floats, turn: Floats
    ) -> tuple[Floats, Floats]:
        """Return the clavicle: two angles by the coefficients, the third by the scapula."""
        if self.clavicle_coefficients is None:
            return super().clavicle(angles, rest, scapula, turn)
        at_rest = _clavicle_at_rest(rest)
        rest = rest or Rest()
        two = _linear(self.clavicle_coefficients, angles, rest.clavicle[:2], rest.humerus)
        C, axes = GIRDLE.rotation_and_axes((*two, 0.0))
        own_turn = axes @ self._clavicle_slopes
        # the AC joint's turn since rest, C^T A, is least where its trace is largest
        A = C.T @ scapula @ at_rest
        sine, cosine = A[2, 1] - A[1, 2], A[1, 1] + A[2, 2]
        moved = [C.T @ _cross(each) @ scapula @ at_rest for each in (turn - own_turn).T]
        axial_turn = np.array(
            [cosine * (D[2, 1] - D[1, 2]) - sine * (D[1, 1] + D[2, 2]) for D in moved]
        ) / (sine * sine + cosine * cosine)
        C = GIRDLE.rotation((*two, np.arctan2(sine, cosine)))
        return C, own_turn + np.outer(C[:, 0], axial_turn)


def _clavicle_at_rest(rest: Rest | None) -> Floats:
    """Return clavicle -> scapula (3, 3) at rest."""
    rest = rest or Rest()
    return np.asarray(GIRDLE.rotation(rest.scapula).T @ GIRDLE.rotation(rest.clavicle))


def _slopes(coefficients: tuple[Coefficients, ...]) -> Floats:
    """Return (3, 3) rad of each angle per rad of plane, elevation and axial rotation."""
    return np.array([(plane, elevation, 0.0) for _, plane, elevation, _ in coefficients])


def _linear(
    coefficients: tuple[Coefficients, ...],
    angles: Floats,
    rest: tuple[float, ...],
    humerus: tuple[float, float] | None,
) -> list[float]:
    plane, elevation, _ = angles.tolist()
    if humerus is None:
        return [
            constant + a * plane + b * elevation + c * start
            for (constant, a, b, c), start in zip(coefficients, rest, strict=True)
        ]
    plane, elevation = np.remainder(plane - humerus[0] + np.pi, 2 * np.pi) - np.pi, elevation
    return [
        start + a * plane + b * (elevation - humerus[1])
        for (_, a, b, _), start in zip(coefficients, rest, strict=True)
    ]


def _cross(w: Floats) -> Floats:
    x, y, z = w.tolist()
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
