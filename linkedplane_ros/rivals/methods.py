# SPDX-License-Identifier: Apache-2.0
"""The rivals set up for a broad muscle: the same attachments, a band each, independent bands.

No obstacles of these methods are published for the deltoid's nine bands, so they are chosen here,
by two rules that favour no method. *Own* obstacles reproduce the linked planes' path with the arm
at the side, as Garner and Pandy fit theirs to a path known at one pose: from the plane, the circle
and the transition points Q and T of each band come its sphere, cylinder, double cylinder and via
points, and with the arm at the side all but the double cylinder give the very path of the linked
planes. *Bone* obstacles are only the humeral head, as thesis Table 5.1 has it, or with the shaft
(the sphere and cylinder that Marsden, Swailes and Johnson 2008 wrap an element of the deltoid on).
A cylinder along the shaft, without the head, would hold three origins that lie above the head
(anterior_2 to middle_1) with the arm at the side.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np

from ..linked_planes.band import WRAPPED
from ..linked_planes.vectors import Vector
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver
from ..solver.states import MuscleState
from ..types import Floats
from .bands import Bands, PathModel
from .capped_cylinder import CappedCylinder
from .cylinder import Cylinder
from .double_cylinder import DoubleCylinder
from .fields import Bone
from .sphere import Sphere
from .straight import Straight, ViaPoints


@dataclass(frozen=True, eq=False)
class NeutralBand:
    """A band of the linked planes with the arm at the side, where the two frames are one; m."""

    origin: Vector
    insertion: Vector
    normal: Vector
    """Of its plane; the band turns right-handed about it."""
    centre: Vector
    """Of the circle in which its plane cuts its sphere, or of a sphere that the plane misses."""
    radius: float
    transitions: tuple[Vector, Vector] | None
    """Q and T; None for a straight band."""


@dataclass(frozen=True, eq=False)
class Method:
    """A solver of the paths of all bands of a muscle."""

    name: str
    obstacles: str
    """How its obstacles were chosen, in words."""
    solver: LinkedPlaneSolver | Bands


def as_vector(values: Floats) -> Vector:
    """Return an array (3,) as a vector."""
    x, y, z = values.tolist()
    return x, y, z


def neutral_bands(solver: LinkedPlaneSolver, state: MuscleState) -> list[NeutralBand]:
    """Return the bands of a muscle solved with the arm at the side (spec section 2)."""
    muscle = solver.muscle
    paths = state.paths(points=2)
    normal = muscle.reference_normal
    bands = []
    for i, (P, S) in enumerate(zip(muscle.origins, muscle.insertions, strict=True)):
        u = (S - P) / np.linalg.norm(S - P)
        m = normal - (normal @ u) * u
        m /= np.linalg.norm(m)
        phi = state.theta if i == 0 else muscle.plane_angles[i]
        normal = m * np.cos(phi) + np.cross(u, m) * np.sin(phi)
        C, R = state.sphere_centres[i], float(muscle.sphere_radii[i])
        d = float((C - P) @ normal)
        centre, radius = (C - d * normal, (R * R - d * d) ** 0.5) if abs(d) < R else (C, R)
        ends = None
        if state.wrap[i] == WRAPPED:
            ends = as_vector(paths[i][1]), as_vector(paths[i][2])
        plane = as_vector(normal), as_vector(centre), radius
        bands.append(NeutralBand(as_vector(P), as_vector(S), *plane, ends))
    return bands


def build_straight(band: NeutralBand) -> PathModel:
    """Return a straight line."""
    return Straight(band.origin, band.insertion)


def build_via_points(band: NeutralBand) -> PathModel:
    """Return a band through its Q, fixed to the scapula, and its T, fixed to the humerus."""
    if band.transitions is None:
        return ViaPoints(band.origin, band.insertion)
    Q, T = band.transitions
    return ViaPoints(band.origin, band.insertion, (Q,), (T,))


def build_sphere(band: NeutralBand, bone: Bone) -> PathModel:
    """Return a band round the sphere that has its circle for a great circle."""
    return Sphere(band.origin, band.insertion, band.centre, band.radius, bone)


def build_cylinder(band: NeutralBand, bone: Bone) -> PathModel:
    """Return a band round the cylinder across its plane, through its circle."""
    return Cylinder(band.origin, band.insertion, band.centre, band.normal, band.radius, bone)


def build_double_cylinder(band: NeutralBand) -> PathModel:
    """Return a band round two cylinders across its plane, one on each bone.

    Each has half the radius of the circle and touches it from within, the scapula's at Q, the
    humerus's at T: with the arm at the side the band leaves P and meets S as the linked one does,
    and cuts the arc short in between. A straight band has both in its circle's centre.
    """
    c = np.array(band.centre)
    Q, T = (c, c) if band.transitions is None else np.array(band.transitions)
    return DoubleCylinder(
        band.origin, band.insertion,
        as_vector((c + Q) / 2.0), band.normal, band.radius / 2.0, 'scapula',
        as_vector((c + T) / 2.0), band.normal, band.radius / 2.0, 'humerus',
    )  # fmt: skip


def humeral_head(muscle: BroadMuscle) -> tuple[Vector, float] | None:
    """Return centre and radius, m, of the bone sphere round the joint's centre, if there is one."""
    distance = np.linalg.norm(muscle.interference_centres, axis=1)
    inside = distance < muscle.interference_radii
    if not inside.any():
        return None
    i = int(np.where(inside, distance, np.inf).argmin())
    return as_vector(muscle.interference_centres[i]), float(muscle.interference_radii[i])


LINKED = 'linked planes'
CIRCLE = "each band's own: its circle of the arm at the side"
OWN: Mapping[str, tuple[str, Callable[[NeutralBand], PathModel]]] = MappingProxyType(
    {
        'straight': ('none', build_straight),
        'via points': (
            "each band's own transition points of the arm at the side, Q on the scapula, T on the "
            'humerus',
            build_via_points,
        ),
        'sphere, scapula': (
            f'{CIRCLE} as a great circle, on the scapula',
            partial(build_sphere, bone='scapula'),
        ),
        'sphere, humerus': (
            f'{CIRCLE} as a great circle, on the humerus',
            partial(build_sphere, bone='humerus'),
        ),
        'cylinder, scapula': (
            f'{CIRCLE}, across its plane, on the scapula',
            partial(build_cylinder, bone='scapula'),
        ),
        'cylinder, humerus': (
            f'{CIRCLE}, across its plane, on the humerus',
            partial(build_cylinder, bone='humerus'),
        ),
        'double cylinder': (
            f'{CIRCLE}, two of half its radius within it, at Q on the scapula, at T on the humerus',
            build_double_cylinder,
        ),
    }
)
HEAD = 'one for all bands: the humeral head (thesis Table 5.1), on the humerus'
STUB = 'one for all bands: the humeral head and a shaft as thick, along -z of the humerus'


def methods(muscle: BroadMuscle) -> list[Method]:
    """Return the linked planes and their rivals for a muscle, right shoulder.

    Those round the humeral head are left out for a muscle whose file names no such bone sphere.
    """
    muscle.require_ball_joint('a comparison with rivals')
    solver = LinkedPlaneSolver(muscle)
    bands = neutral_bands(solver, solver.solve(np.eye(3)))
    found = [Method(LINKED, "each band's own, moving (the model file)", solver)]
    for name, (obstacles, build) in OWN.items():
        found.append(Method(name, obstacles, Bands([build(band) for band in bands])))
    head = humeral_head(muscle)
    if head is not None:
        heads = [Sphere(band.origin, band.insertion, *head, 'humerus') for band in bands]
        stubs = [
            CappedCylinder(band.origin, band.insertion, head[0], (0, 0, 1), head[1], 'humerus',
                           'shorter')
            for band in bands
        ]  # fmt: skip
        found.append(Method('sphere, humeral head', HEAD, Bands(heads)))
        found.append(Method('sphere-capped cylinder', STUB, Bands(stubs)))
    return found
