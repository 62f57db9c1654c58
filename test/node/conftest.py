# SPDX-License-Identifier: Apache-2.0
"""A node of its own, for tests that neither feed nor read it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher


@pytest.fixture
def lone_node(ros: None) -> Iterator[MuscleStatePublisher]:
    """Create the node in this process, without a peer."""
    node = MuscleStatePublisher()
    yield node
    node.destroy_node()
