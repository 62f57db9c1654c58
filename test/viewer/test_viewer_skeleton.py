# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser: a node whose bones are moved by a skeleton."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import WINDOW, Page, open_browser, wait_until
from ros_harness import Reader
from sensor_msgs.msg import JointState
from viewer_stage import MISSING, ViewerProcess, shows_state

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver, MuscleState, Skeleton

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
GIRDLE = '--ros-args', '-p', 'skeleton:=shoulder_girdle', '-p', 'muscle:=deltoid_girdle'
SOLVER = LinkedPlaneSolver(BroadMuscle.load('deltoid_girdle'))
SKELETON = Skeleton.load('shoulder_girdle').for_bones(SOLVER.bones)
LINES = '/deltoid_girdle/bands/lines'


def state_at(q: np.ndarray) -> MuscleState:
    return SOLVER.answer(SKELETON, q, np.zeros(len(q))).state


def test_every_joint_of_a_skeleton_has_a_slider_within_its_limits_and_moves_its_bones(
    tmp_path: Path, ros: None
) -> None:
    heard: list[JointState] = []
    listener = Reader('listener')
    listener.keep(JointState, '/muscle_viewer/joint_states', heard.append)
    viewer = ViewerProcess(tmp_path / 'viewer.log', '--node', *GIRDLE)
    d = len(SKELETON.coordinates)
    q = np.zeros(d)
    with viewer, open_browser() as chromium:
        page = Page(chromium.new_page(viewport=WINDOW), viewer.url)
        assert shows_state(page, state_at(q), LINES), viewer.text  # before a control is moved
        assert heard == []
        for name in SKELETON.coordinates:
            assert wait_until(lambda name=name: page.page.get_by_text(f'{name} (deg)').count() > 0)
        sliders = page.page.locator('[role=slider]')
        assert sliders.count() == d
        for i, limits in enumerate(np.degrees(SKELETON.limits)):
            ends = [
                float(sliders.nth(i).get_attribute(f'aria-value{end}')) for end in ('min', 'max')
            ]
            np.testing.assert_allclose(ends, limits, atol=0.1)  # shown to a tenth
        for i, degrees in ((0, 10.0), (1, 8.0), (3, -6.0), (d - 2, 12.0)):  # of each bone
            low, high = np.degrees(SKELETON.limits[i])
            degrees = float(np.clip(degrees, low, high))
            page.type_number(i, f'{degrees:.1f}')
            q[i] = np.radians(round(degrees, 1))
            assert shows_state(page, state_at(q), LINES), (SKELETON.coordinates[i], viewer.text)
        assert listener.until(lambda: bool(heard))
        assert tuple(heard[-1].name) == SKELETON.coordinates
        np.testing.assert_allclose(heard[-1].position, q, atol=1e-12)
        assert page.errors == []
    assert 'Traceback' not in viewer.text
    listener.destroy_node()
