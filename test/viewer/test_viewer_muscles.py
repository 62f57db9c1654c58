# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser: a node of two muscles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import WINDOW, Page, open_browser, wait_until
from viewer_stage import DRAWN, MISSING, ViewerProcess

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
MUSCLES = ('deltoid', 'deltoid_ackland2008')


def test_a_node_of_two_muscles_is_shown_once_a_person_moves_its_arm(tmp_path: Path) -> None:
    viewer = ViewerProcess(
        tmp_path / 'viewer.log', '--node', '--ros-args', '-p', f'muscle:=[{", ".join(MUSCLES)}]'
    )
    with viewer, open_browser() as chromium:
        page = Page(chromium.new_page(viewport=WINDOW), viewer.url, 0.3)
        page.press_button('neutral')
        for name in MUSCLES:
            paths = LinkedPlaneSolver(BroadMuscle.load(name)).solve(np.eye(3)).paths(16)
            wanted = np.concatenate([np.stack((p[:-1], p[1:]), axis=1) for p in paths])
            lines = f'/{name}/bands/lines'

            def drawn(lines: str = lines, wanted: np.ndarray = wanted) -> bool:
                there = page.lines(lines)
                return there.shape == wanted.shape and bool(np.abs(there - wanted).max() < DRAWN)

            assert wait_until(drawn), viewer.text
        assert page.page.get_by_text(', '.join(MUSCLES)).count() == 1  # one arm: one panel
        page.move_slider(0, 40.0)
        assert wait_until(lambda: page.slider_angles()[0] > 0.5)
        assert 'another publisher' not in viewer.text  # its readers are of one publisher
        assert page.errors == []
