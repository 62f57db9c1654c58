# SPDX-License-Identifier: Apache-2.0
"""The double cylinder (Garner and Pandy 2000): two cylinders, one after the other.

The band turns right-handed about each axis, and touches both, one or none. The first cylinder is
wrapped by the path to where the second is met, the second by the path from where the first is left;
these two points are found in turn. Each step shortens the band, so they settle. Each point moves
the other only along one line, so the steps soon shrink by a constant factor, and the sum of all
that remain is added at once.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..linked_planes.band import CLEAR, INSIDE, MISSED, WRAPPED
from ..linked_planes.compilation import compiled
from ..linked_planes.vectors import ZERO, Rotation, Vector, dot, minus, mix, norm
from .cylinder import (
    CYLINDER_SIZE,
    RoundAnAxis,
    Tube,
    TubePath,
    inside,
    path_round,
    straight_past,
    tube_at,
)
from .fields import Bone
from .path import OBSTACLE, BandRow, ObstaclePath, ends, make_kernel, moment_of, straight_path

ROUNDS = 100
SETTLING = 40  # rounds after which a cylinder that is not touched is dropped for good
CLOSE = 1e-12  # of the radii: how little the second contact moves when the search ends
STRAIGHT = 1e-6  # rad: what the part between may bend by


@compiled
def paths_round(P: Vector, S: Vector, tube: Tube, tube2: Tube) -> tuple[TubePath, TubePath, bool]:
    """Return the paths from P over the first cylinder to the second, and from the first on to S.

    And whether they have settled, with one straight part between the two. They have not where the
    band would have to pass between two cylinders that overlap.
    """
    meets, step, last = S, ZERO, ZERO
    plain = 0  # steps since the last that was summed up
    first, second = True, True  # whether each still counts
    one = path_round(P, meets, tube)
    two = path_round(one.leaves, S, tube2)
    for k in range(ROUNDS):
        last, step = step, minus(two.meets, meets)
        if norm(step) < CLOSE * (tube.R + tube2.R):
            return one, two, norm(minus(one.t2, two.t1)) < STRAIGHT
        plain += 1
        meets = two.meets
        shrinks = dot(step, last) / max(dot(last, last), 1e-300)
        if plain > 2 and 0.0 < shrinks < 1.0:
            meets = mix(1.0, meets, shrinks / (1.0 - shrinks), step)
            plain = 0
        if k > SETTLING and one.state != WRAPPED:
            first = False
        elif k > SETTLING and two.state != WRAPPED:
            second = False
        one = path_round(P, meets, tube) if first else straight_past(P, meets, MISSED)
        Q = one.leaves
        two = path_round(Q, S, tube2) if second else straight_past(Q, S, MISSED)
    return one, two, False


@compiled
def double_cylinder(row: BandRow, rotation: Rotation) -> ObstaclePath:
    """Return the path of a band of P, S and two cylinders."""
    P, S = ends(row, rotation)
    tube = tube_at(row, OBSTACLE, rotation)
    tube2 = tube_at(row, OBSTACLE + CYLINDER_SIZE, rotation)
    if inside(P, tube) or inside(S, tube2):
        return straight_path(P, S, INSIDE)
    one, two, settled = paths_round(P, S, tube, tube2)
    if inside(one.leaves, tube2) or inside(two.meets, tube):
        return straight_path(P, S, INSIDE)
    if not settled:
        return straight_path(P, S, MISSED)
    # a cylinder that is not touched counts as the attachment beside it
    contacts, bone, bone2 = 0, 0.0, 1.0
    if one.state == WRAPPED:
        contacts, bone = contacts + 1, tube.on_humerus
    if two.state == WRAPPED:
        contacts, bone2 = contacts + 2, tube2.on_humerus
    if contacts == 0:
        missed = one.state == MISSED or two.state == MISSED
        return straight_path(P, S, MISSED if missed else CLEAR)
    length = one.length - one.after + two.length
    moment = moment_of(P, one.t1, bone, one.leaves, two.t1, bone2, S, two.t2)
    return ObstaclePath(length, WRAPPED, contacts, moment, one.arc, two.arc)


@dataclass(frozen=True)
class DoubleCylinder(RoundAnAxis):
    """Two cylinders without ends, each fixed to a bone, in the order in which the band meets them.

    WRAPPED (contacts: 1 the first, 2 the second, 3 both), CLEAR; MISSED as for a single one, and
    where no band passes both, in their order and each on its side; INSIDE where the origin lies in
    the first, the insertion in the second, or an end that lies on neither in the other. The
    straight parts before the first and after the second are not kept out of the other cylinder.
    """

    second_centre: Vector
    """The second cylinder's fields are as the first one's."""
    second_axis: Vector
    second_radius: float
    second_bone: Bone
    kernel = make_kernel(double_cylinder)
