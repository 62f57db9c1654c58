# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser: a node of two muscles."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import WINDOW, Page, open_browser, wait_until
from viewer_stage import MISSING, ViewerProcess, shows_state

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
MUSCLES = ('deltoid', 'deltoid_ackland2008')


def test_a_node_of_two_muscles_is_one_arm(tmp_path: Path) -> None:
    viewer = ViewerProcess(
        tmp_path / 'viewer.log', '--node', '--ros-args', '-p', f'muscle:=[{", ".join(MUSCLES)}]'
    )
    with viewer, open_browser() as chromium:
        page = Page(chromium.new_page(viewport=WINDOW), viewer.url, 0.3)
        page.move_slider(0, 40.0)
        assert wait_until(lambda: page.slider_angles()[0] > 0.5)
        rotation = THESIS.rotation(page.slider_angles())
        for name in MUSCLES:
            state = LinkedPlaneSolver(BroadMuscle.load(name)).solve(rotation)
            assert shows_state(page, state, f'/{name}/bands/lines'), viewer.text
        assert page.page.get_by_text(', '.join(MUSCLES)).count() == 1  # one arm: one panel
        assert 'another publisher' not in viewer.text  # its readers are of one publisher
        assert page.errors == []
