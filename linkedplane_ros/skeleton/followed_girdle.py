# SPDX-License-Identifier: Apache-2.0
"""A girdle that follows the humerus by a rhythm, as what moves a muscle's bones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ..errors import LinkedPlaneError, describe_value
from ..joints.articulation import MovedBones
from ..joints.conventions import JointConvention, as_triples
from ..types import Floats
from .girdle import HUMERUS, GirdlePose, Rest, check_rest, joint_centres
from .joint_tree import list_names
from .rhythm import Rhythm

BONES = ('thorax', 'clavicle', 'scapula', 'humerus')


@dataclass(frozen=True)
class FollowedGirdle:
    """Clavicle, scapula and humerus at angles of the humerus against the thorax.

    An articulation (`LinkedPlaneSolver.answer`): its coordinates are the convention's, of the
    humerus against the thorax. Moment arms about them include what follows, scapula and clavicle.

    Frames coincide with the ground's where the rhythm has clavicle and scapula with the arm at its
    rest: at the plane and elevation that `rest` says, else hanging, all angles of `isb_yxy` 0. The
    humerus' frame is that of the scapula there.
    """

    convention: JointConvention
    """What the angles mean; they are measured against the thorax."""
    rhythm: Rhythm
    """How clavicle and scapula follow."""
    rest: Rest | None = None
    """Where the subject's girdle starts from; None: the rhythm's own."""

    def __post_init__(self) -> None:
        for name, given, kind, those in (
            ('convention', self.convention, JointConvention, 'JOINT_CONVENTIONS'),
            ('rhythm', self.rhythm, Rhythm, 'RHYTHMS'),
        ):
            if not isinstance(given, kind):
                value = describe_value(given)
                raise LinkedPlaneError(f'{name}: {value} given, one of {those} expected')
        check_rest(self.rest)

    @property
    def coordinates(self) -> tuple[str, str, str]:
        """Those of the convention."""
        return self.convention.coordinates

    @property
    def kinds(self) -> tuple[str, str, str]:
        """Those of the convention."""
        return self.convention.kinds

    def move_bones(self, values: npt.ArrayLike, bones: Sequence[str], side: str) -> MovedBones:
        """Return the bones of a muscle at humerothoracic angles (`Articulation`)."""
        wrong = [bone for bone in bones if bone not in BONES]
        if wrong:
            raise LinkedPlaneError(
                f'rhythm: moves {list_names(BONES)}; the muscle has {list_names(bones)}'
            )
        angles, k = as_triples(values), len(bones) - 1
        moved = MovedBones(np.empty((len(angles), k, 3, 4)), np.empty((len(angles), 3, k, 6)))
        for each, poses, screws in zip(angles, *moved, strict=True):
            self._move(each, bones, poses, screws)
        return moved

    def _move(self, angles: Floats, bones: Sequence[str], poses: Floats, screws: Floats) -> None:
        """Fill in poses (k, 3, 4) and screws (3, k, 6) of the bones that move, seen from the first.

        Bones stand in the thorax at G and T; in the ground's frame at G^-1 T, and in the frame that
        is the ground's at rest at G^-1 T (G0^-1 T0)^-1.
        """
        girdle = self._pose(angles)
        places, motions = _place_bones(girdle), _move_bones(girdle)
        ground = bones[0]
        G, g = places[ground]
        at_rest = self._at_rest
        for i, bone in enumerate(bones[1:]):
            R, t = _seen_from(places[ground], places[bone])
            if at_rest[bone] is not at_rest[ground]:
                R0, t0 = _seen_from(at_rest[ground], at_rest[bone])
                R = R @ R0.T
                t = t - R @ t0
            poses[i, :, :3], poses[i, :, 3] = R, t
            w, v = (of - by for of, by in zip(motions[bone], motions[ground], strict=True))
            screws[:, i, :3] = w @ G
            screws[:, i, 3:] = (v + np.cross(w, g)) @ G

    def _pose(self, angles: Floats) -> GirdlePose:
        """Return the girdle; by the angles themselves where they say the plane of elevation."""
        slopes = self.slopes
        if slopes is None:
            return self.rhythm.pose(*self.convention.rotation_and_axes(angles), self.rest)
        return self.rhythm.pose_at(slopes @ angles, slopes, self.rest)

    @cached_property
    def slopes(self) -> Floats | None:
        """(3, 3) what plane, elevation and axial rotation take of each coordinate; None: unknown.

        Of the conventions that turn about the same axes, the last one in either sense.
        """
        units, mix = self.convention.units_and_mix
        signs = np.einsum('ij,ij->i', units, HUMERUS.units_and_mix[0])
        if signs[:2].tolist() == [1.0, 1.0] and abs(signs[2]) == 1.0:
            return np.asarray(signs[:, np.newaxis] * mix)
        return None

    @cached_property
    def _at_rest(self) -> dict[str, tuple[Floats, Floats]]:
        """The bones where the rhythm has them with the arm at its rest, or at the side.

        The humerus as the scapula, for its frame is the scapula's there.
        """
        plane, elevation = (self.rest and self.rest.humerus) or (0.0, 0.0)
        places = _place_bones(self.rhythm.pose_at((plane, elevation, 0.0), rest=self.rest))
        return {**places, 'humerus': places['scapula']}


def _seen_from(ground: tuple[Floats, Floats], bone: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Return a bone's pose in the ground's frame."""
    (G, g), (R, t) = ground, bone
    return G.T @ R, G.T @ (t - g)


def _place_bones(girdle: GirdlePose) -> dict[str, tuple[Floats, Floats]]:
    """Return (R, t) of all bones in the thorax's frame."""
    return {'thorax': (np.eye(3), np.zeros(3)), **girdle.bones}


def _move_bones(girdle: GirdlePose) -> dict[str, tuple[Floats, Floats]]:
    """Return w and v (3, 3), by rows of coordinates, of all bones; thorax's axes and origin.

    Each bone turns about the joint that holds it, which moves with the bone before it.
    """
    sternoclavicular, acromion, glenoid = joint_centres()
    C, S, H = girdle.clavicle_axes.T, girdle.scapula_axes.T, girdle.humerus_axes.T
    at_AC = sternoclavicular + girdle.clavicle @ acromion
    centre = at_AC + girdle.scapula @ glenoid
    of_clavicle = np.cross(sternoclavicular, C)
    of_scapula = of_clavicle + np.cross(at_AC, S - C)
    return {
        'thorax': (np.zeros((3, 3)), np.zeros((3, 3))),
        'clavicle': (C, of_clavicle),
        'scapula': (S, of_scapula),
        'humerus': (H, of_scapula + np.cross(centre, H - S)),
    }
