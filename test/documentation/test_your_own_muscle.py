# SPDX-License-Identifier: Apache-2.0
"""The guide to a muscle of one's own: its blocks are run, and its node answers."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from blocks import Reader, blocks, commands, linkedplane
from pages import TOP
from ros_harness import NodeProcess, Peer

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver

PAGE = TOP / 'doc' / 'how_to' / 'your_own_muscle.md'
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def page_commands(start: str) -> list[list[str]]:
    """Return the words of all commands of the page that begin so."""
    consoles = [block for block in blocks(PAGE) if block.language == 'console']
    words = [words for console in consoles for words, _ in commands(console)]
    return [each for each in words if shlex.join(each).startswith(start)]


@pytest.fixture(scope='module')
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Be in the folder of a reader who has done what every block says."""
    path = tmp_path_factory.mktemp('your_own_muscle')
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        Reader(PAGE).read()
        yield path


def test_a_reader_gets_from_a_scan_to_a_running_node(folder: Path, ros: None) -> None:
    assert (folder / 'my_muscle.png').read_bytes().startswith(b'\x89PNG')
    muscle = BroadMuscle.load('my_muscle.yaml')
    one, other = (linkedplane(words[1:]) for words in page_commands('linkedplane solve'))
    assert one.splitlines()[-1] == other.splitlines()[-1]  # total and theta of the same pose
    [scaled] = page_commands('linkedplane info my_muscle.yaml --scale')
    assert 'as subject_2.yaml has it (2 distances' in linkedplane(scaled[1:])
    [pub] = page_commands('ros2 topic pub')
    message = yaml.safe_load(pub[-1])
    angles = [message['position'][message['name'].index(each)] for each in THESIS.coordinates]
    for words, expected in zip(
        page_commands('ros2 run'), (muscle, muscle.scaled('subject_2.yaml')), strict=True
    ):
        assert ' '.join(words[1:5]) == 'run linkedplane_ros muscle_state_publisher --ros-args'
        parameters = dict(word.split(':=') for word in words[6::2])
        peer = Peer('my_muscle')
        with NodeProcess(folder / 'node.log', **parameters) as process:
            peer.connect(process)
            peer.send(message['name'], message['position'])
            assert peer.answers(1)
        peer.destroy_node()
        state = LinkedPlaneSolver(expected).solve(THESIS.rotation(angles))
        lengths = peer.got['band_states'][0].position
        np.testing.assert_allclose(lengths, state.lengths, rtol=0.0, atol=1e-12)


def test_the_muscle_of_the_guide_is_where_the_scan_was_made_from(folder: Path) -> None:
    # the points were made from these, elsewhere, with 0.15 mm of noise, and rounded to 0.1 mm
    ends = np.array(((-34, 50, 40), (-48, -33, 24)))
    tips = np.array(((23, 15, -92), (23, -15, -94)))
    muscle = BroadMuscle.load('my_muscle.yaml')
    # mm: the axes of the bones are told by their landmarks alone, not by those of the making
    assert np.abs(1e3 * np.linalg.norm(muscle.origins[[0, -1]], axis=1)
                  - np.linalg.norm(ends, axis=1)).max() < 1.0  # fmt: skip
    assert np.abs(1e3 * np.linalg.norm(muscle.insertions[[0, -1]], axis=1)
                  - np.linalg.norm(tips, axis=1)).max() < 1.0  # fmt: skip
    assert muscle.sphere_radii[0] == pytest.approx(0.0245 + 0.003, abs=0.3e-3)
