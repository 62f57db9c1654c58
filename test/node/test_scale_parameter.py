# SPDX-License-Identifier: Apache-2.0
"""The node at a subject's size, set at the start or while it runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rclpy.parameter import Parameter
from ros_harness import Peer

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.parameters import SPECS
from linkedplane_ros.node.settings import Settings

DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


@pytest.mark.parametrize(
    ('value', 'want'),
    [('1.1', 1.1), (1.1, 1.1), (2, 2.0), ([1.1, 0.9, 1.3], (1.1, 0.9, 1.3)), ('1', 1.0)],
)
def test_the_nodes_scale_is_text_or_numbers(value: Any, want: Any) -> None:
    values = {spec.name: spec.default for spec in SPECS} | {'scale': value}
    assert Settings.from_values(values).solvers[0].muscle == DELTOID.scaled(want)


@pytest.mark.parametrize('value', ['large', 0.0, -1, [1.0, 2.0], True, 'absent.yaml', ''])
def test_a_scale_that_is_none_is_refused(value: Any) -> None:
    values = {spec.name: spec.default for spec in SPECS} | {'scale': value}
    with pytest.raises(ValueError, match=r'scale|cannot be read'):
        Settings.from_values(values)


def test_a_running_node_takes_another_scale(node: MuscleStatePublisher, peer: Peer) -> None:
    pose = (0.3, 0.8, -0.2)
    for scale in ('1', 1.25, [1.1, 0.9, 1.3]):
        done = node.set_parameters([Parameter('scale', value=scale)])
        assert done[0].successful, done[0].reason
        for topic in peer.got.values():
            topic.clear()
        peer.send(THESIS.coordinates, pose)
        assert peer.answers(1)
        muscle = DELTOID.scaled(scale if isinstance(scale, list) else float(scale))
        state = LinkedPlaneSolver(muscle).solve(THESIS.rotation(pose))
        np.testing.assert_allclose(
            peer.got['band_lengths'][0].data, state.lengths, rtol=0.0, atol=1e-12
        )
    assert peer.until(lambda: bool(peer.diagnostics) and peer.values()['scale'] == '1.1,0.9,1.3')
    [refused] = node.set_parameters([Parameter('scale', value=-1.0)])
    assert not refused.successful
    assert refused.reason == 'scale: -1 given, a factor > 0 expected, from 0.2 to 5'
