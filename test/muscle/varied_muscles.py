# SPDX-License-Identifier: Apache-2.0
"""Muscles that vary in all that a model file can state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from random_muscles import deltoid_with_bands, random_muscle

from linkedplane_ros import BroadMuscle
from linkedplane_ros.muscle.definition import Definition
from linkedplane_ros.muscle.file import bundled_models
from linkedplane_ros.muscle.parts import Head, Landmark, Listed, Polynomial

DELTOID = BroadMuscle.load('deltoid')


def every_variation() -> Definition:
    """Return a model with all that a file may state: lists, a common number, frames, landmarks."""
    return replace(
        DELTOID.definition,
        length='cm',
        angle='deg',
        s=tuple(np.linspace(0.1, 0.85, 9).tolist()),
        insertion=tuple(Listed(tuple(column)) for column in (100 * DELTOID.insertions.T).tolist()),
        sphere_frame=('moving', 'ground', 'humerus') * 3,
        sphere_centre=(Polynomial((9.0,)), Polynomial((1.0 / 3.0, -0.1)), Listed((0.1,) * 9)),
        sphere_radius=Polynomial((2.5,)),
        plane_angle=Listed((7.0, *[11.3] * 8)),
        landmarks=(Landmark('acromion', 'scapula', (1.0, -1.3, 3.3)),),
        range_of_motion=((0.0, 80.0), (-1e-7, 90.0), (-9.5, 9.5)),
        heads=(Head('no', DELTOID.band_names[:4], 'middle_1'),
               Head('42', DELTOID.band_names[4:], 'posterior_3')),
    )  # fmt: skip


MUSCLES: dict[str, Callable[[], BroadMuscle]] = {
    **{name: lambda name=name: BroadMuscle.load(name) for name in bundled_models()},
    'from arrays': lambda: random_muscle(3)[0],
    'of 40 bands': lambda: deltoid_with_bands(40),
    'every variation': lambda: BroadMuscle.from_definition(every_variation()),
    'lists for tuples': lambda: replace(DELTOID, sphere_frame=['humerus', 'ground', 'moving'] * 3),
    'spheres on the ground': lambda: replace(DELTOID, sphere_frame='ground'),
    'no interference': lambda: replace(
        DELTOID,
        interference_centres=np.empty((0, 3)),
        interference_radii=np.empty(0),
        interference_names=(),
    ),
}
