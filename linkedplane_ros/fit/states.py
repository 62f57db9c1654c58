# SPDX-License-Identifier: Apache-2.0
"""The muscle at the poses of a fit: what the criterion and a survey look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..joints.conventions import THESIS_CONVENTION
from ..linked_planes.layout import band_count
from ..muscle.broad_muscle import BroadMuscle
from ..types import Bytes, Floats, Interval
from .kernel import evaluate


@dataclass(frozen=True, eq=False)
class FitStates:
    """The muscle at the criterion's m poses; the first k of them are those of measurements."""

    lengths: Floats
    """(k, n) m"""
    moments: Floats
    """(k, n, 3) m, -dL/domega about the scapula axes."""
    wrap: Bytes
    """(m, n) WrapState"""
    depths: Floats
    """(m, n) m: how deep each band enters the interference spheres; negative: its distance."""
    insides: Floats
    """(m, n) m: how deep its ends lie in its own obstacle sphere."""
    edges: Floats
    """(m, n) m: how far each band is past the edge where its length jumps."""
    gaps: Floats
    """(m, n - 1) m: how far each band lies past the one before it, halfway along, to the side to
    which the fan runs."""
    spacing: Floats
    """(n - 1,) m: the distances between the origins of neighbours, the largest in a fan."""


def sphere_array(muscle: BroadMuscle) -> Floats:
    """Return the interference spheres of a muscle (k, 4): centres and radii, m, ground frame."""
    muscle.require_ball_joint('a fit')
    return np.column_stack((muscle.interference_centres, muscle.interference_radii))


def fan_side(muscle: Floats) -> float:
    """Return 1 if the bands are numbered in the deltoid's direction, the arm hanging; else -1."""
    states = evaluate_poses(muscle.copy(), np.eye(3)[np.newaxis], np.empty((0, 4)), 0)
    return -1.0 if isinstance(states, FitStates) and states.gaps.sum() < 0.0 else 1.0


def evaluate_poses(
    muscle: Floats, rotations: Floats, spheres: Floats, measured: int, side: float = 1.0
) -> FitStates | float:
    """Return a flat muscle at poses, or how far it is from having a path.

    Parameters
    ----------
    muscle
        As `Space.flat_muscle` returns it; it is changed.
    rotations
        (m, 3, 3)
    spheres
        (k, 4) interference spheres: centres and radii, m.
    measured
        For how many of the poses, the first ones, lengths and moments are wanted.
    side
        To which side the fan runs.

    Returns
    -------
    FitStates or float
        A float where there is no path at a pose: how deep the ends lie in their spheres, m.

    """
    m, n = len(rotations), band_count(muscle)
    lengths, moments = np.empty((measured, n)), np.empty((measured, 3 * n))
    wrap = np.empty((m, n), dtype=np.uint8)
    depths, insides, edges = np.empty((m, n)), np.empty((m, n)), np.empty((m, n))
    gaps, spacing = np.empty((m, n - 1)), np.empty(n - 1)
    of_poses = wrap, depths, insides, edges, gaps, spacing
    solved, off = evaluate(muscle, rotations, spheres, lengths, moments, *of_poses)
    if solved < m:
        return min(float(off), 1.0)
    if side < 0.0:
        np.negative(gaps, out=gaps)
    return FitStates(lengths, moments.reshape(-1, n, 3), *of_poses)


def pose_grid(ranges: Sequence[Interval], steps: Sequence[float]) -> tuple[Floats, Floats]:
    """Return the poses of a grid over flexion, abduction and rotation.

    Parameters
    ----------
    ranges
        The lowest and the highest of each angle, rad; both are in the grid.
    steps
        The longest step of each angle, rad; steps of one angle are equal.

    Returns
    -------
    angles : Floats
        (m, 3) rad
    rotations : Floats
        (m, 3, 3) humerus -> scapula.

    """
    sides = [
        np.linspace(low, high, 1 + int(np.ceil((high - low) / step - 1e-6)))
        for (low, high), step in zip(ranges, steps, strict=True)
    ]
    angles = np.stack(np.meshgrid(*sides, indexing='ij'), axis=-1).reshape(-1, 3)
    return angles, THESIS_CONVENTION.rotations_and_axes(angles)[0]
