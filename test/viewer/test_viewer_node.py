# SPDX-License-Identifier: Apache-2.0
"""The viewer's ROS side: finds muscles, keeps their newest state, moves arms; its arguments."""

from __future__ import annotations

import contextlib
import socket
import sys
from collections.abc import Iterator
from threading import Event, Thread

import numpy as np
import pytest
import rclpy
from browser import wait_until
from rclpy.context import Context
from rclpy.parameter import Parameter
from ros_harness import Peer, together
from ros_harness import running as running_node

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher
from linkedplane_ros.viewer.main import PORT, address_line, find_port, main, parse_arguments
from linkedplane_ros.viewer.newest import MuscleInfo, Values
from linkedplane_ros.viewer.node import ViewerNode, find_muscles
from linkedplane_ros.viewer.scene.geometry import Lines, apply_message, drawables
from linkedplane_ros.viewer.scene.wire import read_markers

THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
SOLVER = LinkedPlaneSolver(BroadMuscle.load('deltoid'))
STILL = np.zeros(3)
MARKERS, LENGTHS = 'visualization_msgs/msg/MarkerArray', 'std_msgs/msg/Float64MultiArray'


@contextlib.contextmanager
def running(viewer: ViewerNode) -> Iterator[ViewerNode]:
    """Run the viewer's node in a thread of its own, as the executable does."""
    ended = Event()
    thread = Thread(target=viewer.spin, args=(lambda: not ended.is_set(),))
    thread.start()
    try:
        yield viewer
    finally:
        ended.set()
        thread.join()
        viewer.destroy_node()


@pytest.fixture
def viewer(peer: Peer, node: MuscleStatePublisher) -> Iterator[ViewerNode]:
    """Run the viewer's node beside the muscle node, until it has been told what that is."""
    with running(ViewerNode(['/joint_states'], take=True)) as made:
        assert peer.until(lambda: learnt(made))
        yield made


def read_info(viewer: ViewerNode) -> MuscleInfo | None:
    return viewer.readers['/deltoid'].newest.take_newest()[0] if viewer.readers else None


def learnt(viewer: ViewerNode) -> bool:
    return read_info(viewer) is not None


def values(viewer: ViewerNode) -> Values:
    return viewer.readers['/deltoid'].newest.take_newest()[1]


def move(viewer: ViewerNode, angles: tuple[float, float, float]) -> bool:
    """Move the arm once something listens; return whether that was so."""
    info = read_info(viewer)
    assert info is not None
    speeds = np.array((0.1, 0.2, 0.3))
    return wait_until(lambda: viewer.move_arm(info, np.array(angles), speeds))


def test_a_muscle_is_known_by_its_markers_beside_its_lengths() -> None:
    topics = [
        ('/deltoid/markers', [MARKERS]),
        ('/deltoid/band_lengths', [LENGTHS]),
        ('/left/deltoid/markers', [MARKERS]),
        ('/left/deltoid/band_lengths', [LENGTHS]),
        ('/robot/markers', [MARKERS]),
        ('/odd/markers', [LENGTHS]),
        ('/odd/band_lengths', [LENGTHS]),
    ]
    assert find_muscles(topics) == ['/deltoid', '/left/deltoid']


def test_an_arm_that_is_moved_is_answered_and_shown(viewer: ViewerNode, peer: Peer) -> None:
    angles = (0.9, 0.3, 0.1)
    move(viewer, angles)
    assert peer.until(lambda: values(viewer).answered > 0 and values(viewer).arms is not None)
    state = SOLVER.solve(THESIS.rotation(angles))
    newest = values(viewer)
    np.testing.assert_array_equal(newest.lengths, state.lengths)
    # another product of the same matrices: rounding
    np.testing.assert_allclose(newest.arms, state.moment_vectors @ THESIS.axes(angles), atol=1e-12)
    assert newest.pose == pytest.approx(angles)
    assert newest.angles == pytest.approx(angles)
    assert peer.until(lambda: values(viewer).wrap is not None)
    np.testing.assert_array_equal(values(viewer).wrap, state.wrap)
    assert peer.until(lambda: bool(peer.got['band_states']))
    [sent] = peer.got['band_states']
    assert sent.header.stamp.sec > 1e9  # stamped with the time of day
    np.testing.assert_allclose(
        sent.velocity, -newest.arms @ (0.1, 0.2, 0.3), atol=1e-12
    )  # the joint state had velocities


def test_the_markers_of_the_newest_pose_are_handed_over(viewer: ViewerNode, peer: Peer) -> None:
    got: list[bytes] = []
    reader = viewer.readers['/deltoid']
    move(viewer, (0.4, 0.2, 0.0))

    def shown() -> bool:
        got.extend(reader.newest.take_newest()[2])
        return len(got) > 1

    assert peer.until(shown)
    there: dict = {}
    for message in got:
        apply_message(there, read_markers(message))
    drawn = drawables(there)['bands/lines']
    assert isinstance(drawn, Lines)
    paths = SOLVER.solve(THESIS.rotation((0.4, 0.2, 0.0))).paths(16)
    np.testing.assert_array_equal(drawn.points[:, 0], np.concatenate([p[:-1] for p in paths]))


def test_joints_of_other_names_signs_and_offsets_are_moved_by_the_same_angles(
    viewer: ViewerNode, node: MuscleStatePublisher, peer: Peer
) -> None:
    node.set_parameters_atomically(
        [
            Parameter('joint_convention', value='isb_yxy'),
            Parameter('joint_names', value=['a', 'b', 'c']),
            Parameter('joint_signs', value=[1.0, -1.0, 1.0]),
            Parameter('joint_offsets', value=[0.0, 0.3, -0.2]),
        ]
    )
    assert peer.until(lambda: read_info(viewer).joints.names == ('a', 'b', 'c'))
    assert read_info(viewer).coordinates == ('plane_of_elevation', 'elevation', 'axial_rotation')
    angles = (0.5, 1.0, 0.2)
    move(viewer, angles)
    assert peer.until(lambda: values(viewer).answered > 0)
    state = SOLVER.solve(JOINT_CONVENTIONS['isb_yxy'].rotation(angles))
    # the angles went through signs and offsets and back: rounding
    np.testing.assert_allclose(values(viewer).lengths, state.lengths, atol=1e-12)
    assert values(viewer).angles == pytest.approx(angles)


def test_another_publisher_of_joint_states_is_noticed(viewer: ViewerNode, peer: Peer) -> None:
    assert peer.until(lambda: values(viewer).present)
    assert peer.until(lambda: values(viewer).rivals == 1)  # the peer


def test_the_viewer_is_no_other_publisher_for_the_second_muscle_of_a_node(peer: Peer) -> None:
    """Else it would wait for itself, and show neither."""
    prefixes = {'/deltoid', '/deltoid_ackland2008'}
    muscles = ['deltoid', 'deltoid_ackland2008']
    with (
        running_node(peer, muscle=muscles),
        running(ViewerNode(['/joint_states'], take=True)) as viewer,
    ):

        def rivals() -> set[int]:
            return {viewer.readers[each].newest.take_newest()[1].rivals for each in prefixes}

        def connected() -> bool:
            return set(viewer.readers) == prefixes and all(
                reader.newest.take_newest()[0] is not None for reader in viewer.readers.values()
            )

        assert peer.until(connected)
        assert peer.until(lambda: rivals() == {1})  # the peer
        info = viewer.readers['/deltoid'].newest.take_newest()[0]
        assert peer.until(lambda: viewer.move_arm(info, STILL, STILL))
        for each in prefixes:
            reader = viewer.readers[each]
            reader.discover()
            assert reader.newest.take_newest()[1].rivals == 1
            info = reader.newest.take_newest()[0]
            assert info.bands == BroadMuscle.load(each[1:]).band_names  # before any state


def test_a_node_that_goes_is_missed_and_one_that_comes_back_is_met_again(
    peer: Peer, ros: None
) -> None:
    first = MuscleStatePublisher()
    with running(ViewerNode(['/joint_states'], take=True)) as viewer:
        with together(peer, first):
            assert peer.until(lambda: bool(viewer.readers) and values(viewer).present)
        first.destroy_node()
        assert peer.until(lambda: not values(viewer).present)
        second = MuscleStatePublisher()
        with together(peer, second):
            assert peer.until(lambda: values(viewer).present and learnt(viewer))
            before = values(viewer).answered
            assert peer.until(
                lambda: move(viewer, (0.1, 0.2, 0.3)) and values(viewer).answered > before
            )
        second.destroy_node()


def test_a_reader_whose_ros_is_shut_down_ends_without_a_word() -> None:
    context = Context()
    rclpy.init(context=context)
    viewer = ViewerNode(context=context)
    asked = iter(range(5))

    def going() -> bool:
        if next(asked) == 2:
            context.shutdown()
        return True

    viewer.spin(going)
    assert next(asked) == 3  # it went on no longer


# Arguments


def test_a_missing_library_is_named_with_what_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'viser', None)
    with pytest.raises(SystemExit, match=r"pip install 'viser>=1\.1,<2'"):
        main(['muscle_viewer'])


def test_it_listens_on_this_machine_alone_and_says_so() -> None:
    options = parse_arguments(['muscle_viewer', '--ros-args', '-r', '__ns:=/a'])
    assert (options.host, options.port) == ('127.0.0.1', None)
    assert 'http://127.0.0.1:8080/?token=abc (from this machine only' in address_line(
        options.host, PORT, 'abc'
    )
    assert 'can see the arm and move it' in address_line('0.0.0.0', PORT, 'abc')


def test_a_busy_port_that_was_asked_for_is_named_in_one_line() -> None:
    with socket.create_server(('127.0.0.1', 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(SystemExit) as ended:
            find_port('127.0.0.1', port)
    assert ended.value.code == f'muscle_viewer: port {port} is taken; --port chooses another'


def test_behind_a_busy_default_port_comes_the_next_free_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with contextlib.suppress(OSError), socket.create_server(('127.0.0.1', PORT)):
        assert find_port('127.0.0.1', None) > PORT
        assert capsys.readouterr().out.count('\n') == 1


@pytest.mark.parametrize(
    ('host', 'port', 'line'),
    [
        ('127.0.0.1', 70000, '--port 70000: 0 to 65535 expected'),
        ('203.0.113.7', 8080, 'cannot listen on 203.0.113.7:8080'),
    ],
)
def test_an_address_that_cannot_be_listened_on_is_named(host: str, port: int, line: str) -> None:
    with pytest.raises(SystemExit) as ended:
        find_port(host, port)
    assert line in str(ended.value.code)
