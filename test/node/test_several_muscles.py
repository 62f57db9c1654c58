# SPDX-License-Identifier: Apache-2.0
"""Several muscles in one node: each under its own topics, none noticing that another fails."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from parameter_changes import change_parameters
from ros_harness import ANSWERS, PATIENCE, NodeProcess, Peer, muscles_published, reader_of, running
from visualization_msgs.msg import Marker

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.parameters import SPECS
from linkedplane_ros.node.settings import Settings

EXACT = 1e-12  # m, m/s: the node computes what the solver computes
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
NAMES = THESIS.coordinates
POSE, SPEEDS = (0.3, 0.8, -0.2), (0.4, -0.1, 0.2)  # rad, rad/s
BOTH = ['deltoid', 'example_shared_sphere']
DEFAULTS = {spec.name: spec.default for spec in SPECS}
DELTOID = BroadMuscle.load('deltoid')


@pytest.fixture
def other(peer: Peer) -> Iterator[Peer]:
    """Read the second muscle; the first one's peer feeds both."""
    with reader_of(BOTH[1], peer) as made:
        yield made


def check_newest(reader: Peer, muscle: BroadMuscle, side: str = 'right', pose: Any = POSE) -> None:
    """Compare the newest answers on a muscle's topics with the solver alone."""
    answer = LinkedPlaneSolver(muscle, side).answer(THESIS, pose, SPEEDS)
    want, lengthening = answer.state, answer.lengthening
    got = {topic: reader.got[topic][-1] for topic in ANSWERS}
    for topic, values in (
        ('band_lengths', want.lengths),
        ('moment_arms', answer.moment_arms.ravel()),
        ('moment_vectors', want.moment_vectors.ravel()),
        ('wrap_states', want.wrap),
    ):
        np.testing.assert_allclose(got[topic].data, values, rtol=0.0, atol=EXACT)
    arms, names = got['moment_arm_states'], muscle.band_names
    assert arms.name == [f'{band}/{each}' for band in names for each in THESIS.coordinates]
    assert arms.position == got['moment_arms'].data
    states = got['band_states']
    assert tuple(states.name) == muscle.band_names
    np.testing.assert_allclose(states.position, want.lengths, rtol=0.0, atol=EXACT)
    np.testing.assert_allclose(states.velocity, lengthening, rtol=0.0, atol=EXACT)


def statuses(peer: Peer) -> dict[str, tuple[bytes, dict[str, str]]]:
    """Return the newest level and values of each muscle; waits for the first."""
    assert peer.until(lambda: bool(peer.diagnostics))
    return {
        status.name.removeprefix('muscle_state_publisher: '): (
            status.level,
            {item.key: item.value for item in status.values},
        )
        for status in peer.diagnostics[-1].status
    }


def without_a_plane(folder: Path) -> str:
    """Return the path of a muscle one of whose bands has no plane at POSE, and there alone."""
    insertions = DELTOID.insertions.copy()
    insertions[2] = THESIS.rotation(POSE).T @ DELTOID.origins[2]
    path = folder / 'pinched.yaml'
    replace(DELTOID, name='pinched', insertions=insertions).to_yaml(path)
    return str(path)


def test_every_muscle_answers_under_its_own_name_what_its_solver_gives(
    peer: Peer, other: Peer, tmp_path: Path
) -> None:
    given = {'muscle': f'[{", ".join(BOTH)}]', 'scale': 1.1, 'side': 'left'}
    with NodeProcess(tmp_path / 'node.log', **given) as process:
        peer.connect(process)
        other.connect(process)
        for k in range(20):
            pose = (0.3, 0.04 * k, -0.2)
            peer.send(NAMES, pose, SPEEDS, nanoseconds=k)
            for reader, name in zip((peer, other), BOTH, strict=True):
                assert reader.answers(k + 1)
                check_newest(reader, BroadMuscle.load(name).scaled('1.1'), 'left', pose)
    stamps = [[m.header.stamp.nanosec for m in r.got['band_states']] for r in (peer, other)]
    assert stamps == [list(range(20))] * 2


def test_a_message_is_taken_once_for_all_muscles(peer: Peer, other: Peer) -> None:
    with running(peer, other, muscle=BOTH):
        for name, angle in zip(NAMES, POSE, strict=True):  # the last of three parts is answered
            peer.send((name,), (angle,))
        peer.send(NAMES, (0.0, 90.0, 0.0))
        peer.send(NAMES, POSE, SPEEDS)
        assert peer.answers(2)
        assert other.answers(2)
        peer.diagnostics.clear()
        assert peer.until(lambda: bool(peer.diagnostics))
    told = statuses(peer)
    assert list(told) == BOTH
    for name in BOTH:
        _, values = told[name]
        assert values['muscle'] == name
        counts = [values[f'messages {each}'] for each in ('received', 'answered')]
        assert counts == ['5', '2']
        assert values['rejected: incomplete'] == '2'
        assert values['rejected: degrees'] == '1'
    assert len(peer.got['band_lengths']) == len(other.got['band_lengths']) == 2


def test_a_muscle_that_cannot_be_loaded_is_one_line_and_the_others_run(
    peer: Peer, tmp_path: Path
) -> None:
    absent = str(tmp_path / 'absent.yaml')
    with NodeProcess(tmp_path / 'node.log', muscle=f'[{absent}, deltoid]') as process:
        peer.connect(process)
        peer.send(NAMES, POSE, SPEEDS)
        assert peer.answers(1)
        check_newest(peer, DELTOID)
        [line] = [line for line in process.text.splitlines() if absent in line]
        assert '[ERROR]' in line
        assert 'No such file' in line


def test_if_none_can_be_loaded_the_node_ends_with_one_line(tmp_path: Path) -> None:
    absent = str(tmp_path / 'absent.yaml')
    process = NodeProcess(tmp_path / 'node.log', muscle=f'[{absent}, biceps]')
    assert process.process.wait(PATIENCE) == 1
    [line] = process.text.splitlines()
    assert absent in line
    assert 'biceps' in line


def test_a_muscle_left_out_at_the_start_hinders_no_change_and_comes_in_when_it_can(
    peer: Peer, tmp_path: Path
) -> None:
    path = tmp_path / 'late.yaml'
    with running(peer, muscle=['deltoid', str(path)]) as node, reader_of('late', peer) as late:
        assert change_parameters(node, side='left').successful
        peer.send(NAMES, POSE, SPEEDS)
        assert peer.answers(1)
        check_newest(peer, DELTOID, 'left')
        refused = change_parameters(
            node, muscle=['deltoid', str(path)]
        )  # who asks for it anew wants it
        assert not refused.successful
        assert str(path) in refused.reason
        replace(DELTOID, name='late').to_yaml(path)
        assert change_parameters(node, side='right').successful
        late.connect()
        peer.send(NAMES, POSE, SPEEDS)
        assert late.answers(1)
        check_newest(late, DELTOID)


@pytest.mark.parametrize('may_fail', [True, False], ids=['at the start', 'while it runs'])
def test_two_muscles_of_one_name_are_refused_in_one_line(tmp_path: Path, may_fail: bool) -> None:
    path = str(tmp_path / 'again.yaml')
    DELTOID.to_yaml(path)
    muscles = ['deltoid', path]
    with pytest.raises(ValueError, match='different names expected') as caught:
        Settings.from_values(DEFAULTS | {'muscle': muscles}, muscles if may_fail else ())
    assert '\n' not in str(caught.value)
    assert "'deltoid'" in str(caught.value)
    assert path in str(caught.value)


def test_a_pose_without_a_plane_is_told_and_counted_for_its_muscle_alone(
    peer: Peer, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with reader_of('pinched', peer) as pinched:
        with running(peer, pinched, muscle=[without_a_plane(tmp_path), 'deltoid']):
            for pose in (POSE, (0.1, 0.2, 0.3)):
                peer.send(NAMES, pose, SPEEDS)
            assert peer.answers(2)
            assert pinched.answers(1)
            peer.diagnostics.clear()
            assert peer.until(lambda: bool(peer.diagnostics))
        told = statuses(peer)
        assert pinched.counts() == dict.fromkeys(ANSWERS, 1)
    assert told['pinched'][0] == DiagnosticStatus.WARN
    assert told['deltoid'][0] == DiagnosticStatus.OK
    for name, answered, refused in (('pinched', '1', '1'), ('deltoid', '2', '0')):
        assert told[name][1]['messages answered'] == answered
        assert told[name][1]['rejected: no_plane'] == refused
    [line] = [line for line in capfd.readouterr().err.splitlines() if 'not used' in line]
    assert '[muscle_state_publisher.pinched]: joint state not used: band anterior_3' in line


def test_a_second_muscle_comes_and_goes_and_leaves_nothing_in_a_viewer(
    peer: Peer, other: Peer
) -> None:
    with running(peer) as node:
        peer.send(NAMES, POSE, SPEEDS)
        assert peer.answers(1)
        assert change_parameters(node, muscle=BOTH).successful
        assert peer.until(lambda: muscles_published(node) == set(BOTH))
        other.connect()
        peer.send(NAMES, POSE, SPEEDS)
        assert other.answers(1)
        assert peer.until(lambda: len(other.got['markers']) >= 2)
        peer.diagnostics.clear()
        assert peer.until(lambda: bool(peer.diagnostics))
        counts = {name: v['messages answered'] for name, (_, v) in statuses(peer).items()}
        assert counts == {'deltoid': '2', 'example_shared_sphere': '1'}
        shown = len(peer.got['markers'])
        assert change_parameters(node, muscle='deltoid').successful
        assert peer.until(lambda: muscles_published(node) == {'deltoid'})
        assert peer.until(lambda: other.got['markers'][-1].markers[0].action == Marker.DELETEALL)
        peer.send(NAMES, POSE, SPEEDS, nanoseconds=10**9)
        assert peer.answers(3)
        assert peer.until(lambda: len(peer.got['markers']) > shown)
        check_newest(peer, DELTOID)
    assert other.counts() == dict.fromkeys(ANSWERS, 1)


def test_a_list_with_one_bad_muscle_is_refused_and_the_old_ones_work_on(
    peer: Peer, other: Peer, tmp_path: Path
) -> None:
    with running(peer, other, muscle=BOTH) as node:
        for bad in (['deltoid', 'biceps'], [str(tmp_path / 'absent.yaml'), 'deltoid'], []):
            result = change_parameters(node, side='left', muscle=bad)
            assert not result.successful
            assert '\n' not in result.reason
            assert node.get_parameter('muscle').value == BOTH
        assert peer.until(lambda: muscles_published(node) == set(BOTH))
        peer.send(NAMES, POSE, SPEEDS)
        for reader, name in zip((peer, other), BOTH, strict=True):
            assert reader.answers(1)
            check_newest(reader, BroadMuscle.load(name))


def test_of_muscles_that_are_refused_no_topic_is_left(peer: Peer) -> None:
    wrong = 'qos_overrides./example_humerus_spheres/markers.publisher.durability'
    with running(peer, **{wrong: 'eternal'}) as node:
        result = change_parameters(node, muscle=[*BOTH, 'example_humerus_spheres'])
        assert not result.successful
        assert 'volatile or transient_local' in result.reason
        assert peer.until(lambda: muscles_published(node) == {'deltoid'})


def test_a_list_of_one_muscle_is_that_muscle(peer: Peer, capfd: pytest.CaptureFixture[str]) -> None:
    with running(peer, muscle=['deltoid']):
        peer.send(NAMES, POSE, SPEEDS)
        assert peer.answers(1)
        check_newest(peer, DELTOID)
        assert list(statuses(peer)) == ['deltoid']
    assert '[muscle_state_publisher]: deltoid, right shoulder; ' in capfd.readouterr().err
