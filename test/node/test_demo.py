# SPDX-License-Identifier: Apache-2.0
"""The demonstration finds its recording."""

from __future__ import annotations

from linkedplane_ros.node.demo import sample_folder
from linkedplane_ros.recordings.bags.recording import Recording


def test_the_recording_of_the_demonstration_is_found_from_the_sources() -> None:
    assert Recording.from_bag(sample_folder() / 'arm_raise').topics == ('/joint_states',)
