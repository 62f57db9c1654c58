# SPDX-License-Identifier: Apache-2.0
"""Where the scene is seen from, of either shoulder and in any window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from linkedplane_ros.viewer.scene.camera import choose_view


def test_a_left_shoulder_is_seen_from_the_mirrored_place_and_both_from_the_middle() -> None:
    right, left = choose_view(['right']), choose_view(['left'])
    assert left == replace(
        right,
        position=(-right.position[0], *right.position[1:]),
        target=(-right.target[0], *right.target[1:]),
    )
    assert right.position[0] > 0.0
    assert choose_view(['left', 'right']).position[0] == 0.0


def test_a_narrow_picture_is_as_wide_as_the_view_needs_it_and_a_wide_one_no_farther() -> None:
    chosen = choose_view(['right'])
    away = np.subtract(chosen.position, chosen.target)
    assert chosen.position_for(2.0) == pytest.approx(chosen.position)
    # half as wide at the same height: twice as far
    np.testing.assert_allclose(chosen.position_for(0.5 * chosen.aspect) - chosen.target, 2.0 * away)
