# SPDX-License-Identifier: Apache-2.0
"""The bones as they are drawn: each where its pose has it, in the ground bone's frame."""

from __future__ import annotations

import numpy as np
import pytest

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, Skeleton
from linkedplane_ros.drawing.shapes import LINE_STRIP, MuscleShapes, Placement

GIRDLE = BroadMuscle.load('deltoid_girdle')
SHAPES = MuscleShapes(GIRDLE, 16, details=False)
Q = np.array([0.1, -0.2, 0.15, -0.3, 0.4, 0.2, 0.3, 0.8, -0.2])
MIRROR = {'right': np.ones(3), 'left': np.array([-1.0, 1.0, 1.0])}


def bones_at(side: str) -> tuple[dict[str, tuple[np.ndarray, np.ndarray]], list[Placement]]:
    girdle, solver = Skeleton.load('shoulder_girdle'), LinkedPlaneSolver(GIRDLE, side)
    places = SHAPES.placements(solver.answer(girdle, Q, np.zeros(9)).state)
    drawn = zip(SHAPES.shapes, places, strict=True)
    return girdle.pose(Q), [place for shape, place in drawn if shape.namespace == 'bones']


@pytest.mark.parametrize('side', ['right', 'left'])
def test_the_clavicle_is_drawn_from_the_sternum_to_the_shoulder_where_it_is(side: str) -> None:
    poses, (_, _, _, clavicle) = bones_at(side)
    R, t = poses['clavicle']
    assert clavicle.points is not None
    first, last = clavicle.points[[0, -1]]
    ends = [R @ GIRDLE.ground_point + t, R @ GIRDLE.origins[1] + t]
    got = sorted([first.tolist(), last.tolist()])
    want = sorted((end * MIRROR[side]).tolist() for end in ends)
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-15)  # m
    assert np.abs(ends[0] - GIRDLE.ground_point).max() > 0.01


@pytest.mark.parametrize('side', ['right', 'left'])
def test_humerus_and_scapula_are_drawn_where_they_are(side: str) -> None:
    poses, (head, shaft, rim, _) = bones_at(side)
    R, t = poses['humerus']
    assert head.position is not None
    assert shaft.position is not None
    assert rim.points is not None
    np.testing.assert_allclose(head.position, t * MIRROR[side], rtol=0, atol=1e-15)
    down = R.T @ (shaft.position * MIRROR[side] - t)
    assert down[2] == pytest.approx(-0.115)  # m: the middle of the shaft
    scapula = GIRDLE.origins[2:] * MIRROR[side]  # bands 1 and 2 arise from the clavicle
    np.testing.assert_array_equal(rim.points, scapula)


def test_a_muscle_of_two_bones_has_no_strut() -> None:
    shapes = MuscleShapes(BroadMuscle.load('deltoid'), 16, details=False).shapes
    strips = [each for each in shapes if (each.namespace, each.kind) == ('bones', LINE_STRIP)]
    assert [each.number for each in strips] == [2]
