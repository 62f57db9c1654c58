"""The node's parameters: what is taken, what is refused and how, and changes while it runs."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter
from ros_harness import Peer
from visualization_msgs.msg import Marker

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.node.parameters import NAMES, SPECS
from linkedplane_ros.node.settings import Settings

EXACT = 1e-12  # m: the node computes what the solver computes
DEFAULTS = {spec.name: spec.default for spec in SPECS}
DELTOID = BroadMuscle.load('deltoid')
MODEL = (Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml').read_text()
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
POSE = (0.3, 0.8, -0.2)

WRONG: list[tuple[str, Any, str]] = [
    ('muscle', 3, 'text expected'),
    ('muscle', 'biceps', 'neither a bundled model (deltoid, deltoid_ackland2008, example_'),
    ('muscle', '', 'neither a bundled model'),
    ('muscle', ['biceps', 'triceps'], "'biceps' is neither a bundled model"),
    ('muscle', ['deltoid', 'deltoid'], 'different names expected'),
    ('muscle', [1, 2], 'a list of text expected'),
    ('scale', 'large', 'one factor, 3'),
    ('scale', -1.0, 'a factor > 0'),
    ('scale', True, 'numbers or text'),
    ('scale', ['1', '2'], 'numbers or text'),
    ('side', 'up', 'one of right, left expected'),
    ('side', True, 'text expected'),
    ('side', ['left'], 'text expected'),
    ('joint_convention', 'euler', 'one of flexion_abduction_rotation, isb_yxy, opensim_tsm'),
    ('joint_convention', 1.0, 'text expected'),
    ('joint_names', ['a', 'b'], '3 joint names expected'),
    ('joint_names', ['a', 'b', 'c', 'd'], '3 joint names expected'),
    ('joint_names', ['a', 'b', ''], '3 joint names expected'),
    ('joint_names', ['a', 'b', 'a'], '3 different joints expected'),
    ('joint_names', [1, 2, 3], '3 joint names expected'),
    ('joint_names', 'abc', '3 joint names expected'),
    ('joint_signs', [1.0, 1.0], '3 finite numbers expected'),
    ('joint_signs', [1.0, 0.5, 1.0], '1.0 or -1.0 expected'),
    ('joint_signs', [1, 0, 1], '1.0 or -1.0 expected'),
    ('joint_signs', ['+', '-', '+'], '3 finite numbers expected'),
    ('joint_signs', 1.0, '3 finite numbers expected'),
    ('joint_offsets', [0.0, math.nan, 0.0], '3 finite numbers expected'),
    ('joint_offsets', [0.0, 0.0, math.inf], '3 finite numbers expected'),
    ('joint_offsets', [0.0] * 4, '3 finite numbers expected'),
    ('joint_offsets', [True, False, True], '3 finite numbers expected'),
    ('frame_id', '', 'the name of a frame expected'),
    ('frame_id', 7, 'text expected'),
    ('markers.enabled', 1, 'true or false expected'),
    ('markers.enabled', 'yes', 'true or false expected'),
    ('markers.details', 1, 'true or false expected'),
    ('markers.rate', -1.0, '0 to 10000 expected'),
    ('markers.rate', 1e6, '0 to 10000 expected'),
    ('markers.rate', math.nan, 'a finite number, as 30.0 expected'),
    ('markers.rate', True, 'a finite number, as 30.0 expected'),
    ('markers.rate', '30', 'a finite number, as 30.0 expected'),
    ('markers.details', 'all', 'true or false expected'),
    ('markers.points', 1, '2 to 1000 expected'),
    ('markers.points', 1001, '2 to 1000 expected'),
    ('markers.points', 16.0, 'a whole number expected'),
    ('markers.points', True, 'a whole number expected'),
]


def test_every_default_is_valid_and_comes_out_as_it_is() -> None:
    for spec in SPECS:
        meant = [] if spec.name == 'joint_names' else spec.default
        assert spec.check(spec.default) == meant
        assert type(spec.check(spec.default)) is type(spec.default)
    settings = Settings.from_values(DEFAULTS)
    assert settings.solvers[0].muscle.name == 'deltoid'
    assert settings.solvers[0].side == 'right'
    assert settings.convention is THESIS
    assert settings.markers_points == 16


def test_every_wrong_kind_of_value_is_among_the_tests() -> None:
    assert {name for name, _, _ in WRONG} == set(NAMES)


@pytest.mark.parametrize(('name', 'value', 'right'), WRONG)
def test_a_wrong_value_is_refused_in_one_line_that_names_it_and_what_would_be_right(
    name: str, value: Any, right: str
) -> None:
    with pytest.raises(ValueError, match=name) as caught:
        Settings.from_values({**DEFAULTS, name: value})
    assert right in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_model_file_at_fault_is_named_in_the_refusal(tmp_path: Path) -> None:
    path = tmp_path / 'broken.yaml'
    for content, reason in ((None, 'No such file'), (MODEL.replace('version: 1', ''), 'version')):
        if content is not None:
            path.write_text(content)
        with pytest.raises(ValueError, match=reason) as caught:
            Settings.from_values({**DEFAULTS, 'muscle': str(path)})
        assert str(path) in str(caught.value)
        assert '\n' not in str(caught.value)


def test_whole_numbers_are_taken_for_doubles() -> None:
    settings = Settings.from_values(
        {**DEFAULTS, 'joint_signs': [1, -1, 1], 'joint_offsets': [0, 1, -2], 'markers.rate': 5}
    )
    assert settings.joints.signs == (1.0, -1.0, 1.0)
    assert settings.joints.offsets == (0.0, 1.0, -2.0)
    assert settings.markers_rate == 5.0
    numbers = (*settings.joints.signs, *settings.joints.offsets, settings.markers_rate)
    assert all(type(number) is float for number in numbers)


def test_the_arrays_that_rclpy_gives_are_taken_for_lists() -> None:
    values = {**DEFAULTS, 'joint_offsets': array('d', (0.1, 0.2, 0.3))}
    assert Settings.from_values(values).joints.offsets == (0.1, 0.2, 0.3)


@pytest.mark.parametrize('convention', JOINT_CONVENTIONS)
@pytest.mark.parametrize('empty', [[], ['']], ids=['no name', 'an empty name'])
def test_no_joint_names_means_the_names_of_the_conventions_coordinates(
    convention: str, empty: list[str]
) -> None:
    values = {**DEFAULTS, 'joint_convention': convention, 'joint_names': empty}
    assert Settings.from_values(values).joints.names == JOINT_CONVENTIONS[convention].coordinates


def test_joint_names_are_taken_in_the_conventions_order() -> None:
    names = ['c', 'a', 'b']
    assert Settings.from_values({**DEFAULTS, 'joint_names': names}).joints.names == tuple(names)


@pytest.fixture
def node(ros: None) -> Iterator[MuscleStatePublisher]:
    """Make the node, in this process."""
    made = MuscleStatePublisher()
    yield made
    made.destroy_node()


@pytest.fixture
def peer(node: MuscleStatePublisher) -> Iterator[Peer]:
    """Read and feed the node, and let it work."""
    with connected(node) as made:
        yield made


@contextmanager
def connected(node: MuscleStatePublisher) -> Iterator[Peer]:
    """Give a peer that works together with a node."""
    peer = Peer()
    peer.executor_of_its_own.add_node(node)
    peer.connect()
    try:
        yield peer
    finally:
        peer.executor_of_its_own.remove_node(node)
        peer.destroy_node()


def as_sent(name: str, value: Any, kind: Parameter.Type | None = None) -> Parameter:
    """Return a parameter as it arrives from another process, as with `ros2 param set`."""
    parameter = Parameter(name, kind, value)
    return Parameter.from_parameter_msg(parameter.to_parameter_msg())


def change(node: MuscleStatePublisher, **values: Any) -> SetParametersResult:
    """Set a batch of parameters at once; a double underscore stands for a dot."""
    return node.set_parameters_atomically(
        [as_sent(name.replace('__', '.'), value) for name, value in values.items()]
    )


def answer(peer: Peer, names: tuple[str, ...] = THESIS.coordinates) -> tuple[Any, ...]:
    """Send a pose; return the answer: lengths, moment arms, band states, moment arms' message."""
    before = min(peer.counts().values())
    peer.send(names, POSE, nanoseconds=before + 1)
    assert peer.answers(before + 1)
    got = [peer.got[topic][before] for topic in ('band_lengths', 'moment_arms', 'band_states')]
    assert got[2].header.stamp.nanosec == before + 1
    return np.array(got[0].data), np.array(got[1].data).reshape(-1, 3), got[2], got[1]


def solved(
    convention: str = THESIS.name, side: str = 'right', angles: tuple[float, ...] = POSE
) -> tuple[Any, Any]:
    """Return lengths and moment arms of the solver alone."""
    chosen = JOINT_CONVENTIONS[convention]
    state = LinkedPlaneSolver(DELTOID, side).solve(chosen.rotation(angles))
    return state.lengths, state.moment_vectors @ chosen.axes(angles, side)


def same(got: tuple[Any, ...], want: tuple[Any, Any]) -> bool:
    """Tell whether an answer is what the solver gives."""
    return bool(np.abs(got[0] - want[0]).max() <= EXACT and np.abs(got[1] - want[1]).max() <= EXACT)


def test_every_parameter_is_described_with_its_range_or_its_choices(
    node: MuscleStatePublisher,
) -> None:
    for spec in SPECS:
        described = node.describe_parameter(spec.name)
        assert described.description == spec.meaning
        assert len(spec.meaning) > 10
        for choice in spec.choices:
            assert choice in described.additional_constraints
        ranges = [*described.floating_point_range, *described.integer_range]
        if spec.low is None:
            assert ranges == []
        else:
            [allowed] = ranges
            assert (allowed.from_value, allowed.to_value) == (spec.low, spec.high)
    assert node.describe_parameter('markers.points').integer_range
    assert node.describe_parameter('markers.rate').floating_point_range


def test_the_node_has_each_parameter_at_its_default(node: MuscleStatePublisher) -> None:
    for spec in SPECS:
        assert node.get_parameter(spec.name).value == spec.default


def test_a_good_batch_is_taken_as_a_whole(node: MuscleStatePublisher, peer: Peer) -> None:
    assert same(answer(peer), solved())
    result = change(
        node,
        joint_signs=[1.0, -1.0, 1.0],
        joint_offsets=[0.0, 0.1, 0.0],
        joint_names=['f', 'a', 'r'],
        frame_id='right_scapula',
    )
    assert result.successful, result.reason
    got = answer(peer, ('f', 'a', 'r'))
    assert same(got, solved(angles=(POSE[0], 0.1 - POSE[1], POSE[2])))
    assert got[2].header.frame_id == 'right_scapula'


@pytest.mark.parametrize(('name', 'value', 'right'), WRONG)
def test_a_bad_change_is_refused_with_a_reason_and_changes_nothing(
    node: MuscleStatePublisher, name: str, value: Any, right: str
) -> None:
    before = node.get_parameter(name).value
    result = node.set_parameters_atomically([as_sent(name, value)])
    assert not result.successful
    assert name in result.reason
    assert '\n' not in result.reason
    assert node.get_parameter(name).value == before


def test_a_half_bad_batch_is_refused_as_a_whole(node: MuscleStatePublisher, peer: Peer) -> None:
    for bad in ({'joint_offsets': [math.nan] * 3}, {'markers__points': 1}, {'muscle': 'biceps'}):
        for batch in ({'side': 'left', **bad}, {**bad, 'side': 'left'}):
            result = change(node, frame_id='elsewhere', **batch)
            assert not result.successful
            assert result.reason
            assert node.get_parameter('side').value == 'right'
            assert node.get_parameter('frame_id').value == 'scapula'
    got = answer(peer)
    assert same(got, solved())
    assert got[2].header.frame_id == 'scapula'


def test_a_refused_change_does_not_come_with_the_next_one(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    assert not change(node, side='left', joint_signs=[0.0] * 3).successful
    assert change(node, markers__rate=10.0).successful
    assert same(answer(peer), solved())


def test_a_parameter_cannot_be_deleted(node: MuscleStatePublisher) -> None:
    for name in NAMES:
        result = node.set_parameters_atomically([Parameter(name, Parameter.Type.NOT_SET)])
        assert not result.successful
        assert node.has_parameter(name)


def test_an_empty_list_of_joint_names_is_taken_whatever_it_is_a_list_of(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    for kind in ('STRING_ARRAY', 'BOOL_ARRAY', 'BYTE_ARRAY'):
        assert change(node, joint_names=['f', 'a', 'r']).successful
        empty = as_sent('joint_names', [], Parameter.Type[kind])
        assert node.set_parameters_atomically([empty]).successful
        assert same(answer(peer), solved())


def test_whole_numbers_are_taken_for_doubles_while_it_runs(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    result = change(node, markers__rate=10, joint_signs=[1, 1, -1], joint_offsets=[0, 0, 0])
    assert result.successful, result.reason
    assert same(answer(peer), solved(angles=(POSE[0], POSE[1], -POSE[2])))


def test_a_change_of_convention_changes_the_joints_and_the_coordinates_label(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    for name, convention in JOINT_CONVENTIONS.items():
        assert change(node, joint_convention=name).successful
        got = answer(peer, convention.coordinates)
        assert same(got, solved(name))
        label = got[3].layout.dim[1].label
        assert label == 'coordinate:' + ','.join(convention.coordinates)


def test_a_change_of_joints_forgets_the_values_of_the_old_ones(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    answer(peer)
    assert change(node, joint_convention='opensim_tsm').successful
    answer(peer, JOINT_CONVENTIONS['opensim_tsm'].coordinates)
    assert change(node, joint_convention='opensim_mobl').successful  # shares one name with it
    peer.send(('elv_angle', 'shoulder_rot'), (0.1, 0.2))
    assert peer.until(
        lambda: bool(peer.diagnostics) and peer.values()['rejected: incomplete'] == '1'
    )
    assert set(peer.counts().values()) == {2}


def test_a_change_of_side_keeps_the_moment_arms_and_mirrors_the_markers(
    node: MuscleStatePublisher, peer: Peer
) -> None:
    right = answer(peer)
    assert change(node, side='left').successful
    left = answer(peer)
    assert same(left, solved(side='left'))
    # m: the mirror image has the same moment arms about the anatomical coordinates
    np.testing.assert_allclose(left[1], right[1], rtol=0.0, atol=EXACT)
    assert peer.until(
        lambda: any(
            m.action == Marker.DELETEALL for a in peer.got['markers'][1:] for m in a.markers
        )
    )
    assert peer.until(lambda: len(peer.got['markers'][-1].markers) > 1)
    first, last = (
        next(m for m in array.markers if m.ns == 'attachments' and m.id == 0)
        for array in (peer.got['markers'][1], peer.got['markers'][-1])
    )
    assert [p.x for p in last.points] == [-p.x for p in first.points]


def test_a_change_of_muscle_moves_the_topics_there_and_back(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path
) -> None:
    path = tmp_path / 'thin.yaml'
    path.write_text(MODEL.replace('name: deltoid', 'name: thin').replace('37.294653', '35.294653'))
    thin = Peer('thin')
    peer.executor_of_its_own.add_node(thin)
    for _ in range(2):
        for muscle, reader in ((str(path), thin), ('deltoid', peer)):
            assert change(node, muscle=muscle).successful
            lengths = reader.got['band_lengths']
            lengths.clear()
            while not lengths:  # until the new topic's publisher and its reader have met
                peer.send(THESIS.coordinates, POSE)
                peer.until(lambda lengths=lengths: bool(lengths), 0.2)
            solver = LinkedPlaneSolver(BroadMuscle.load(muscle))
            want = solver.solve(THESIS.rotation(POSE)).lengths
            assert np.abs(np.array(lengths[-1].data) - want).max() <= EXACT
            found = {topic for topic, _ in node.get_publisher_names_and_types_by_node(
                node.get_name(), node.get_namespace())}  # fmt: skip
            gone = {'thin': 'deltoid', 'deltoid': 'thin'}[solver.muscle.name]
            assert f'/{solver.muscle.name}/moment_arms' in found
            assert f'/{gone}/moment_arms' not in found
    peer.executor_of_its_own.remove_node(thin)
    thin.destroy_node()


def thin_muscle(folder: Path) -> str:
    """Return the path of a model of another name and fewer bands."""
    model = yaml.safe_load(MODEL)
    model['name'] = 'thin'
    model['bands']['names'] = model['bands']['names'][:3]
    model['heads'] = {'anterior': model['heads']['anterior']}
    path = folder / 'thin.yaml'
    path.write_text(yaml.safe_dump(model))
    return str(path)


def test_a_muscle_changed_while_the_input_rests_does_no_harm_to_a_new_viewer(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path
) -> None:
    answer(peer)
    assert change(node, muscle=thin_muscle(tmp_path)).successful
    thin = Peer('thin')
    thin.executor_of_its_own = peer.executor_of_its_own
    peer.executor_of_its_own.add_node(thin)
    count = len(peer.diagnostics)
    assert peer.until(lambda: len(peer.diagnostics) > count + 2)
    assert thin.got['markers'] == []
    while not thin.got['band_lengths']:
        peer.send(THESIS.coordinates, POSE)
        peer.until(lambda: bool(thin.got['band_lengths']), 0.2)
    assert len(thin.got['band_lengths'][0].data) == 3
    peer.executor_of_its_own.remove_node(thin)
    thin.destroy_node()


@pytest.mark.parametrize('how', ['disabled', 'another muscle'])
def test_no_muscle_is_left_behind_in_a_viewer(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path, how: str
) -> None:
    answer(peer)
    assert peer.until(lambda: len(peer.got['markers']) >= 2)
    changes = {'markers.enabled': False} if how == 'disabled' else {
        'muscle': thin_muscle(tmp_path)}  # fmt: skip
    assert change(node, **changes).successful
    assert peer.until(lambda: peer.got['markers'][-1].markers[0].action == Marker.DELETEALL)


def test_a_muscle_with_a_wrong_quality_of_service_is_refused_and_the_old_one_works_on(
    ros: None, tmp_path: Path
) -> None:
    override = as_sent('qos_overrides./thin/markers.publisher.reliability', 'fast')
    made = MuscleStatePublisher(parameter_overrides=[override])
    with connected(made) as peer:
        result = change(made, muscle=thin_muscle(tmp_path))
        assert not result.successful
        assert 'reliable or best_effort' in result.reason
        assert same(answer(peer), solved())
    made.destroy_node()


NO_TOPIC = 'my muscle'


def test_a_muscle_whose_name_cannot_be_a_topic_is_refused_while_it_runs(
    node: MuscleStatePublisher, peer: Peer, tmp_path: Path
) -> None:
    path = tmp_path / 'spaced.yaml'
    path.write_text(MODEL.replace('name: deltoid', f'name: {NO_TOPIC}'))
    result = change(node, muscle=str(path))
    assert not result.successful
    assert NO_TOPIC in result.reason
    assert same(answer(peer), solved())


def test_a_muscle_whose_name_cannot_be_a_topic_is_refused_at_the_start(
    ros: None, tmp_path: Path
) -> None:
    path = tmp_path / 'spaced.yaml'
    path.write_text(MODEL.replace('name: deltoid', f'name: {NO_TOPIC}'))
    with pytest.raises(ValueError, match=NO_TOPIC) as caught:
        MuscleStatePublisher(parameter_overrides=[as_sent('muscle', str(path))])
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(('name', 'value', 'right'), WRONG)
def test_a_wrong_override_at_the_start_is_a_value_error_in_one_line(
    ros: None, name: str, value: Any, right: str
) -> None:
    with pytest.raises(ValueError, match=name) as caught:
        MuscleStatePublisher(parameter_overrides=[as_sent(name, value)])
    assert right in str(caught.value)
    assert '\n' not in str(caught.value)


def test_overrides_at_the_start_count_and_an_unknown_one_does_no_harm(ros: None) -> None:
    overrides = {'no_such_thing': 3, 'side': 'left', 'joint_offsets': [0, 1, 0], 'markers.rate': 5}
    made = MuscleStatePublisher(
        parameter_overrides=[as_sent(name, value) for name, value in overrides.items()]
    )
    with connected(made) as peer:
        assert same(answer(peer), solved(side='left', angles=(POSE[0], POSE[1] + 1.0, POSE[2])))
        assert not made.has_parameter('no_such_thing')
    made.destroy_node()
