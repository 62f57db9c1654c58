# SPDX-License-Identifier: Apache-2.0
"""The pictures' geometry: views of a right shoulder, what hides what, labels apart."""

from __future__ import annotations

import numpy as np
import pytest

from linkedplane_ros.study.pictures.scene import (
    AXES,
    FRONTAL,
    LATERAL,
    POSTERIOR,
    SUPERIOR,
    TOP_BACK,
    Scene,
    Viewpoint,
    push_apart,
    visible_axes,
)

VIEWS = (LATERAL, FRONTAL, POSTERIOR, SUPERIOR, TOP_BACK)


@pytest.mark.parametrize('view', VIEWS, ids=lambda view: view.name)
def test_a_view_is_right_handed_and_true_to_scale(view: Viewpoint) -> None:
    np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(view.axes) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ('view', 'right', 'up'),
    [
        (LATERAL, 'anterior', 'superior'),
        (POSTERIOR, 'lateral', 'superior'),
        (SUPERIOR, 'lateral', 'anterior'),
    ],
)
def test_a_right_shoulder_is_seen_the_right_way_round(view: Viewpoint, right: str, up: str) -> None:
    assert view.project(np.array(AXES[right])).tolist() == [1.0, 0.0, 0.0]
    assert view.project(np.array(AXES[up])).tolist() == [0.0, 1.0, 0.0]


def test_from_the_front_a_right_shoulder_lies_to_the_left() -> None:
    assert FRONTAL.project(np.array(AXES['lateral'])).tolist() == [-1.0, 0.0, 0.0]


def test_axes_that_look_alike_share_a_label() -> None:
    assert [names for names, _ in visible_axes(TOP_BACK)] == ['lateral', 'anterior, superior']


def test_what_is_near_is_drawn_over_what_is_far() -> None:
    from matplotlib.figure import Figure

    scene = Scene(LATERAL)
    near, far = np.array((0.05, 0.0, 0.0)), np.array((-0.05, 0.0, 0.0))
    scene.add_sphere(near, 0.01, (1.0, 0.0, 0.0))
    scene.add_sphere(far, 0.01, (0.0, 0.0, 1.0))
    drawn = scene.draw(Figure().add_subplot())
    faces = [tuple(face[:3]) for face in drawn.get_facecolor()]
    assert faces.index((0.0, 0.0, 1.0)) < faces.index((1.0, 0.0, 0.0))


def test_labels_are_pushed_apart() -> None:
    crowded = np.zeros((5, 2))
    places = push_apart(crowded, np.zeros((1, 2)), 0.01)
    between = np.linalg.norm(places[:, None] - places[None], axis=2) + np.eye(5)
    assert between.min() > 0.0098
    assert np.linalg.norm(places, axis=1).min() > 0.0098
