"""Where the scene is seen from, of either shoulder and in any window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from linkedplane_ros.viewer.scene.camera import view


def test_a_left_shoulder_is_seen_from_the_mirrored_place_and_both_from_the_middle() -> None:
    right, left = view(['right']), view(['left'])
    assert left == replace(
        right, place=(-right.place[0], *right.place[1:]), at=(-right.at[0], *right.at[1:])
    )
    assert right.place[0] > 0.0
    assert view(['left', 'right']).place[0] == 0.0


def test_a_narrow_picture_is_as_wide_as_the_view_needs_it_and_a_wide_one_no_farther() -> None:
    chosen = view(['right'])
    away = np.subtract(chosen.place, chosen.at)
    assert chosen.place_for(2.0) == pytest.approx(chosen.place)
    # half as wide at the same height: twice as far
    np.testing.assert_allclose(chosen.place_for(0.5 * chosen.aspect) - chosen.at, 2.0 * away)
