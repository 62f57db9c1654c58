# SPDX-License-Identifier: Apache-2.0
"""Measurements simulated by the deltoid, models to start from, and options of a quick fit."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from reference import Array

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.fit.data import find_band
from linkedplane_ros.fit.measurements import Data, Measurement
from linkedplane_ros.solver.interference import depths
from linkedplane_ros.solver.states import MuscleStates

DELTOID = BroadMuscle.load('deltoid')
CASE_STUDY = (('flexion', 80), ('abduction', 90), ('scaption', 60))  # deg (thesis ch. 5)
HEADS = ('anterior', 'middle', 'posterior')
QUICK_OPTIONS = (
    '--particles',
    6,
    '--generations',
    2,
    '--polish',
    40,
    '--weights',
    'interference=0',
)


def deepest(states: MuscleStates) -> Array:
    """Return how deep the bands enter any interference sphere (m, n), m."""
    return np.array([depths(state)[0].max(axis=1) for state in states])


def simulated(
    muscle: BroadMuscle, parts: tuple[str, ...] = HEADS, off: float = 0.0, seed: int = 0
) -> Data:
    """Return the case study's measurements of a muscle: 26 poses; each off by up to `off`, m."""
    solver, rng, found = LinkedPlaneSolver(muscle), np.random.default_rng(seed), []
    for motion, last in CASE_STUDY:
        for angle in np.radians(np.arange(0, last + 1, 10)).tolist():
            rotation, axis = Measurement('', 0, motion, (angle,), 0.0, 0.0).pose()
            state = solver.solve(rotation)
            for part in parts:
                band = find_band(muscle, part, 0)
                length = float(state.lengths[band]) + off * rng.uniform(-1.0, 1.0)
                arm = float(state.moment_vectors[band] @ axis) + off * rng.uniform(-1.0, 1.0)
                weight = 1.0 if off == 0.0 else float(rng.uniform(0.5, 2.0))
                found.append(Measurement(part, band, motion, (angle,), length, arm, weight))
    return Data(Path('simulated'), tuple(found), 1.0, None)


def numbered_backwards() -> BroadMuscle:
    """Return the deltoid's bands, arm at the side, numbered from the back to the front."""
    return replace(
        DELTOID,
        **{
            name: getattr(DELTOID, name)[::-1]
            for name in ('origins', 'insertions', 'sphere_centres', 'sphere_radii')
        },
        plane_angles=-np.roll(DELTOID.plane_angles[::-1], 1),
    )


def ten_percent_off(seed: int) -> BroadMuscle:
    """Return the deltoid with its 25 coefficients and HM's distance 10 % too large or small."""
    rng = np.random.default_rng(seed)
    off = {
        place: value * (1.0 + 0.1 * rng.choice((-1.0, 1.0)))
        for place, value in DELTOID.coefficients.items()
        if place.startswith(('sphere.centre', 'sphere.radius', 'plane_angle'))
    }
    assert len(off) == 25
    farther = 1.0 + 0.1 * rng.choice((-1.0, 1.0))
    for axis in range(3):
        place = f'sphere.humeral_point[{axis}]'
        off[place] = farther * DELTOID.coefficients[place]
    return DELTOID.with_coefficients(off)


def write_data(folder: Path, data: Data) -> Path:
    """Write measurements as a table that reads as they are, to a nanometre."""
    rows = [
        f'{row.motion},{math.degrees(row.angle):.9f},{row.part},{1e3 * row.length:.6f},'
        f'{1e3 * row.arm:.6f}'
        for row in data.measurements
    ]
    path = folder / 'data.csv'
    header = '# simulated by the published deltoid\nmotion,angle_deg,head,length_mm,moment_arm_mm'
    path.write_text('\n'.join([header, *rows, '']), encoding='utf-8')
    return path
