# SPDX-License-Identifier: Apache-2.0
"""The parameters of a fit as numbers, and the muscle that they make."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..linked_planes.layout import (
    CENTRE,
    GROUND_POINT,
    HUMERAL_POINT,
    INSERTION,
    NORMAL,
    ORIGIN,
    RADIUS,
    pack_muscle,
)
from ..muscle.definition import Definition, expand_frame
from ..muscle.parts import METRES, RADIANS
from ..types import Floats
from .kernel import PHI, combine

# Where the curves' values stand in the flat layout of a band, and the points in that of a muscle.
SLOTS = {
    'origin.x': ORIGIN, 'origin.y': ORIGIN + 1, 'origin.z': ORIGIN + 2,
    'insertion.x': INSERTION, 'insertion.y': INSERTION + 1, 'insertion.z': INSERTION + 2,
    'sphere.centre.x': CENTRE, 'sphere.centre.y': CENTRE + 1, 'sphere.centre.z': CENTRE + 2,
    'sphere.radius': RADIUS, 'plane_angle': PHI,
}  # fmt: skip
POINTS = {
    'reference_normal': NORMAL,
    'sphere.ground_point': GROUND_POINT,
    'sphere.humeral_point': HUMERAL_POINT,
}


@dataclass(frozen=True)
class Parameter:
    """A number that a fit looks for, in the file's units."""

    name: str
    unit: str
    start: float
    """Where the model to start from has it."""
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Space:
    """The p parameters of a fit; the model is linear in them.

    A flat muscle is a sequence of numbers, m and rad, that `kernel.evaluate` takes.
    """

    definition: Definition
    """The model to start from."""
    parameters: tuple[Parameter, ...]
    """(p)"""
    flat_base: Floats
    """(size,) the flat muscle with all parameters zero."""
    flat_rows: Floats
    """(size, p) what one unit of each parameter adds to the flat muscle."""
    places: tuple[str, ...]
    """(q) the places of the model file that change, as in `BroadMuscle.coefficients`."""
    place_base: Floats
    """(q,) their numbers with all parameters zero."""
    place_rows: Floats
    """(q, p) what one unit of each parameter adds to them."""

    @property
    def start(self) -> Floats:
        """(p,) the parameters of the model to start from."""
        return np.array([parameter.start for parameter in self.parameters])

    @property
    def low(self) -> Floats:
        """(p,) the lower bounds."""
        return np.array([parameter.low for parameter in self.parameters])

    @property
    def high(self) -> Floats:
        """(p,) the upper bounds."""
        return np.array([parameter.high for parameter in self.parameters])

    def flat_muscle(self, x: Floats) -> Floats:
        """Return the flat muscle (size,) at the parameters x (p,)."""
        return np.asarray(combine(self.flat_base, self.flat_rows, x))

    def coefficients(self, x: Floats) -> dict[str, float]:
        """Return the numbers of the model file at the parameters x (p,), by their places."""
        numbers = self.place_base + self.place_rows @ x
        return dict(zip(self.places, numbers.tolist(), strict=True))


def pack_definition(definition: Definition) -> Floats:
    """Return a definition as the flat muscle (size,) that `kernel.evaluate` takes: m and rad."""
    metres, values = METRES[definition.length], definition.values
    origins, insertions, centres = (
        metres * np.column_stack([values[f'{key}.{axis}'] for axis in 'xyz'])
        for key in ('origin', 'insertion', 'sphere.centre')
    )
    ground_point, humeral_point = (
        None if point is None else metres * np.array(point)
        for point in (definition.ground_point, definition.humeral_point)
    )
    phi = RADIANS[definition.angle] * values['plane_angle']
    return pack_muscle(
        definition.reference_normal,
        ground_point,
        humeral_point,
        origins,
        insertions,
        centres,
        metres * values['sphere.radius'],
        phi,
        np.zeros_like(phi),
        definition.bones.number_on_ball_joint(expand_frame(definition.sphere_frame, len(phi))),
    )
