# SPDX-License-Identifier: Apache-2.0
"""The sample messages and the sample recording: what their script makes, and good of their kind."""

from __future__ import annotations

import dataclasses
import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState

from linkedplane_ros import JOINT_CONVENTIONS, WrapState
from linkedplane_ros.recordings.bags.recording import Recording

EXAMPLES = Path(__file__).parents[2] / 'msg_examples'
TYPES = get_typestore(Stores.ROS2_JAZZY)
FILES = sorted(path.name for path in EXAMPLES.glob('*.yaml'))
MESSAGES = [name for name in FILES if not name.endswith('.expected.yaml')]


@pytest.fixture(scope='module')
def script() -> ModuleType:
    """Import the script of the folder."""
    spec = importlib.util.spec_from_file_location('generate', EXAMPLES / 'generate.py')
    assert spec is not None
    assert spec.loader is not None
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    return generate


@pytest.fixture(scope='module')
def made(script: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the script into another folder."""
    folder = tmp_path_factory.mktemp('examples') / 'new'
    script.main(folder)
    return folder


@pytest.fixture(scope='module')
def raised() -> list[JointState]:
    """The messages of the sample recording."""
    recording = Recording.from_bag(EXAMPLES / 'arm_raise')
    return [deserialize_message(message.data, JointState) for message in recording.messages()]


def content(folder: Path) -> list[tuple[str, str, int, bytes]]:
    """Return every message of a bag: topic, type, time, CDR."""
    with AnyReader([folder]) as reader:
        return [
            (connection.topic, connection.msgtype, time, bytes(data))
            for connection, time, data in reader.messages()
        ]


def test_the_script_makes_all_files_of_the_folder_and_no_others(made: Path) -> None:
    assert sorted(path.name for path in made.glob('*.yaml')) == FILES
    assert sorted(path.name for path in (made / 'arm_raise').iterdir()) == sorted(
        path.name for path in (EXAMPLES / 'arm_raise').iterdir()
    )


@pytest.mark.parametrize('name', FILES)
def test_the_script_makes_each_yaml_file_to_the_byte(made: Path, name: str) -> None:
    assert (made / name).read_bytes() == (EXAMPLES / name).read_bytes()


def test_the_script_makes_each_message_of_the_recording_to_the_byte_but_for_rounding(
    made: Path,
) -> None:
    new, old = content(made / 'arm_raise'), content(EXAMPLES / 'arm_raise')
    assert len(new) == len(old) == 601
    for one, other in zip(new, old, strict=True):
        assert one[:3] == other[:3]
        message, kept = (TYPES.deserialize_cdr(item[3], item[1]) for item in (one, other))
        # rad, rad/s: sines and matrix products round differently from machine to machine
        np.testing.assert_allclose(message.position, kept.position, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(message.velocity, kept.velocity, rtol=0.0, atol=1e-12)
        same = dataclasses.replace(message, position=kept.position, velocity=kept.velocity)
        assert bytes(TYPES.serialize_cdr(same, one[1])) == other[3]


def test_the_script_writes_over_what_it_has_made_before(script: ModuleType, made: Path) -> None:
    before = content(made / 'arm_raise')
    script.main(made)
    assert content(made / 'arm_raise') == before


@pytest.mark.parametrize('name', MESSAGES)
def test_a_sample_is_a_joint_state_with_an_expected_answer(name: str) -> None:
    message = JointState(**yaml.safe_load((EXAMPLES / name).read_text()))  # checks its fields
    assert len(message.name) == len(message.position)
    assert len(message.velocity) in (0, len(message.name))
    want = yaml.safe_load((EXAMPLES / name.replace('.yaml', '.expected.yaml')).read_text())
    coordinates = JOINT_CONVENTIONS[want['joint_convention']].coordinates
    assert tuple(want['coordinates']) == coordinates
    assert set(coordinates) <= set(message.name)
    n = len(want['bands'])
    assert len(want['band_lengths']) == len(want['moment_arms']) == len(want['wrap_states']) == n
    assert set(want['wrap_states']) <= set(WrapState.__members__)
    assert len(want['lengthening_velocity']) == (n if len(message.velocity) else 0)


def test_every_expected_answer_has_its_sample() -> None:
    expected = {name.removesuffix('.expected.yaml') for name in FILES if name not in MESSAGES}
    assert expected == {name.removesuffix('.yaml') for name in MESSAGES}


def test_the_samples_show_velocities_another_convention_and_joints_among_others() -> None:
    samples = [yaml.safe_load((EXAMPLES / name).read_text()) for name in MESSAGES]
    assert any(sample['velocity'] for sample in samples)
    assert any(len(sample['name']) > 3 for sample in samples)
    assert any('plane_of_elevation' in sample['name'] for sample in samples)


def test_the_recording_is_six_seconds_of_joint_states_stamped_as_recorded(
    raised: list[JointState],
) -> None:
    recording = Recording.from_bag(EXAMPLES / 'arm_raise')
    assert recording.topics == ('/joint_states',)
    assert recording.count == len(raised) == 601
    messages = list(recording.messages())
    assert [message.time - recording.start for message in messages] == [
        k * 10**7 for k in range(601)
    ]
    for message, recorded in zip(raised, messages, strict=True):
        stamp = message.header.stamp
        assert stamp.sec * 10**9 + stamp.nanosec == recorded.time
        assert tuple(message.name) == JOINT_CONVENTIONS['flexion_abduction_rotation'].coordinates


def test_the_velocities_of_the_recording_are_the_derivative_of_its_positions(
    raised: list[JointState],
) -> None:
    positions = np.array([message.position for message in raised])
    velocities = np.array([message.velocity for message in raised])
    h = 0.01  # s
    slopes = (positions[2:] - positions[:-2]) / (2.0 * h)
    # rad/s: a central difference errs by h^2 / 6 times the third derivative between its ends, which
    # the velocities' second difference shows; it jumps where the arm turns back, hence twice
    bound = 2.0 / 6.0 * np.abs(np.diff(velocities, 2, axis=0)).max()
    assert bound < 1e-3 * np.abs(velocities).max()
    assert np.abs(slopes - velocities[1:-1]).max() <= bound


def test_the_arm_of_the_recording_starts_and_ends_at_rest_at_the_side(
    raised: list[JointState],
) -> None:
    for message in (raised[0], raised[-1]):
        assert np.abs(message.position).max() <= 1e-12  # rad
        assert np.abs(message.velocity).max() <= 1e-12  # rad/s
    elevation = [
        np.arccos(JOINT_CONVENTIONS['flexion_abduction_rotation'].rotation(m.position)[2, 2])
        for m in raised
    ]
    assert int(np.argmax(elevation)) == 300
    assert max(elevation) == pytest.approx(np.radians(110.0), abs=1e-9)
