# SPDX-License-Identifier: Apache-2.0
"""The deltoid over a sweep of elevations, to be plotted, and what tests read from the panels."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.drawing.processed import ProcessedRecording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRAMES = 60
ROWS = 5
DELTOID = BroadMuscle.load('deltoid')
ISB = JOINT_CONVENTIONS['isb_yxy']
Array = np.ndarray


def sweep(elevations: Array) -> ProcessedRecording:
    """Return the deltoid's answers at these elevations, rad, 0.02 s from one to the next."""
    angles = np.column_stack((np.full(len(elevations), 0.5), elevations, 0.3 * elevations))
    states = LinkedPlaneSolver(DELTOID).solve_batch([ISB.rotation(row) for row in angles])
    return ProcessedRecording(
        title='sweep.csv: deltoid, right, isb_yxy',
        heads={head.name: head.bands for head in DELTOID.heads},
        bands=DELTOID.band_names,
        coordinates=ISB.coordinates,
        times=0.02 * np.arange(len(elevations)),
        angles=angles,
        lengths=states.lengths,
        arms=states.moment_vectors @ np.array([ISB.axes(row) for row in angles]),
        wrap=states.wrap,
    )


SWEEP = sweep(np.linspace(0.1, 2.2, FRAMES))
ONE_HEAD = dataclasses.replace(SWEEP, heads={'middle': ('middle_1', 'middle_2')})  # quickly drawn


def repeated(processed: ProcessedRecording, frames: int) -> ProcessedRecording:
    """Return the recording over and over, 0.02 s from one frame to the next."""
    which = np.arange(frames) % len(processed.times)
    fields = {
        name: getattr(processed, name)[which] for name in ('angles', 'lengths', 'arms', 'wrap')
    }
    return dataclasses.replace(processed, times=0.02 * np.arange(frames), **fields)


def panels(figure: Figure) -> Any:
    """Return the axes, (5, number of heads)."""
    return np.array(figure.axes).reshape(ROWS, -1)
