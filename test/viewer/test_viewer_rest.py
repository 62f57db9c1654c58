# SPDX-License-Identifier: Apache-2.0
"""The viewer in a browser: the arm is there before anybody has moved a control."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import WINDOW, Page, open_browser
from ros_harness import Reader
from sensor_msgs.msg import JointState
from viewer_stage import MISSING, ViewerProcess, shows_state

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver

pytestmark = [pytest.mark.skipif(bool(MISSING), reason=MISSING), pytest.mark.browser]
OWN, COMMON = '/muscle_viewer/joint_states', '/joint_states'
QUIET = 3.0  # s: the viewer begins to publish 1.5 s after its start
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


@pytest.mark.parametrize(
    ('name', 'side', 'scale'), [('deltoid', 'right', 1.0), ('deltoid_girdle', 'left', 1.2)]
)
def test_the_arm_is_drawn_at_rest_before_a_control_is_moved_and_nothing_is_published(
    name: str, side: str, scale: float, tmp_path: Path, ros: None
) -> None:
    heard: list[JointState] = []
    answered: list[JointState] = []
    listener = Reader('listener')
    for topic in (OWN, COMMON):
        listener.keep(JointState, topic, heard.append)
    listener.keep(JointState, f'/{name}/band_states', answered.append)
    given = (f'muscle:={name}', f'side:={side}', f'scale:={scale}')
    parameters = [part for each in given for part in ('-p', each)]
    viewer = ViewerProcess(tmp_path / 'viewer.log', '--node', '--ros-args', *parameters)
    solver = LinkedPlaneSolver(BroadMuscle.load(name).scaled(scale), side)
    lines = f'/{name}/bands/lines'
    with viewer, open_browser() as chromium:
        page = Page(chromium.new_page(viewport=WINDOW), viewer.url)
        assert shows_state(page, solver.solve(np.eye(3)), lines), viewer.text
        assert not listener.until(lambda: bool(heard or answered), QUIET)
        publishers = [listener.get_publishers_info_by_topic(topic) for topic in (OWN, COMMON)]
        assert publishers == [[], []]
        page.type_number(1, '30')  # from here on the node's markers are drawn
        assert shows_state(page, solver.solve(THESIS.rotation((0.0, np.radians(30), 0.0))), lines)
        assert listener.until(lambda: bool(heard and answered))
        assert page.errors == []
    listener.destroy_node()
