# SPDX-License-Identifier: Apache-2.0
"""What one evaluation of a fit's criterion costs, beside solving its poses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from linkedplane_ros import LinkedPlaneSolver
from linkedplane_ros.fit.criterion import Criterion
from linkedplane_ros.fit.measurements import Data, Measurement
from linkedplane_ros.fit.parameters import build_space

CASE_STUDY = {'flexion': 80, 'abduction': 90, 'scaption': 60}  # deg, by tens: 26 poses
PART = 1e-3  # m: what the bands are off by, so that nothing is zero


def criterion_calls(one: LinkedPlaneSolver) -> dict[str, Callable[[], Any]]:
    """Return the criterion over all bands at the poses of the case study; solve_batch at them."""
    measured = [
        Measurement(band, i, motion, (float(np.radians(angle)),), 0.1 + PART, PART)
        for motion, last in CASE_STUDY.items()
        for angle in range(0, last + 1, 10)
        for i, band in enumerate(one.muscle.band_names)
    ]
    parameters = build_space(one.muscle.definition)
    data = Data(Path('case study'), tuple(measured), 1.0, None)
    criterion = Criterion.from_data(one.muscle, parameters, data)
    rotations = np.array([row.pose()[0] for row in measured if row.band == 0])
    start = parameters.start
    return {
        'criterion': lambda: criterion.value(start),
        'criterion poses': lambda: one.solve_batch(rotations),
    }
