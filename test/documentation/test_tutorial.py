"""The tutorial does what it says: every block of it is run, in order, in one folder."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from ros_harness import NodeProcess, Peer

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.commands.main import main

DOCUMENT = (Path(__file__).parents[2] / 'doc' / 'how_to' / 'your_own_muscle.md').read_text()
BLOCKS = re.findall(r'^```(\w+)\n(.*?)^```', DOCUMENT, re.DOTALL | re.MULTILINE)
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def blocks(kind: str) -> list[str]:
    return [text for each, text in BLOCKS if each == kind]


def commands(start: str) -> list[list[str]]:
    """Return the words of all commands that begin so, without what they print."""
    lines = '\n'.join(blocks('console')).replace('\\\n', ' ').splitlines()
    return [shlex.split(line[2:]) for line in lines if line.startswith(f'$ {start}')]


def printed(do: Callable[[], object]) -> str:
    """Return what something prints."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        do()
    return out.getvalue()


def linkedplane(words: list[str]) -> str:
    assert words[0] == 'linkedplane'
    return printed(lambda: sys.exit(status) if (status := main(words[1:])) else None)


@pytest.fixture(scope='module')
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Be in the folder that a reader has come to by section 4."""
    path = tmp_path_factory.mktemp('tutorial')
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        Path('scan.csv').write_text(*blocks('csv'))
        make, limit = blocks('python')
        output = printed(lambda: exec(make, {}))
        assert f'$ python make_muscle.py\n{output}' in blocks('console')
        first, second = commands('linkedplane info my_muscle.yaml')[:2]
        before, after = blocks('text')
        assert linkedplane(first).endswith(before)
        exec(limit, {})
        assert linkedplane(second).endswith(after)
        Path('subject_2.yaml').write_text(*blocks('yaml'))
        yield path


def test_a_reader_gets_from_a_scan_to_a_running_node(folder: Path, ros: None) -> None:
    assert (folder / 'my_muscle.png').read_bytes().startswith(b'\x89PNG')
    muscle = BroadMuscle.load('my_muscle.yaml')
    one, other = (linkedplane(words) for words in commands('linkedplane solve'))
    assert one.splitlines()[-1] == other.splitlines()[-1]  # total and theta of the same pose
    [scaled] = commands('linkedplane info my_muscle.yaml --scale')
    assert 'as subject_2.yaml has it (2 distances' in linkedplane(scaled)
    [pub] = commands('ros2 topic pub')
    message = yaml.safe_load(pub[-1])
    angles = [message['position'][message['name'].index(each)] for each in THESIS.coordinates]
    for words, expected in zip(
        commands('ros2 run'), (muscle, muscle.scaled('subject_2.yaml')), strict=True
    ):
        assert ' '.join(words[1:5]) == 'run linkedplane_ros muscle_state_publisher --ros-args'
        parameters = dict(word.split(':=') for word in words[6::2])
        peer = Peer('my_muscle')
        process = NodeProcess(folder / 'node.log', **parameters)
        try:
            peer.connect(process)
            peer.send(message['name'], message['position'])
            assert peer.answers(1)
        finally:
            status = process.stop()
            peer.destroy_node()
        assert status == 0, process.text
        state = LinkedPlaneSolver(expected).solve(THESIS.rotation(angles))
        lengths = peer.got['band_states'][0].position
        np.testing.assert_allclose(lengths, state.lengths, rtol=0.0, atol=1e-12)


def test_the_muscle_of_the_tutorial_is_where_the_scan_was_made_from(folder: Path) -> None:
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
