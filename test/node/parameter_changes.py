# SPDX-License-Identifier: Apache-2.0
"""Values that parameters refuse, and changes of the parameters of a running node."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter
from ros_harness import Peer

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.node.muscle_state_publisher import MuscleStatePublisher

EXACT = 1e-12  # m: the node computes what the solver computes
DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']
POSE = (0.3, 0.8, -0.2)  # rad
# parameter, wrong value, what the refusal says
WRONG: list[tuple[str, Any, str]] = [
    ('muscle', 3, 'text expected'),
    ('muscle', 'biceps', 'neither a bundled model (deltoid, deltoid_ackland2008, deltoid_girdle, '),
    ('muscle', '', 'neither a bundled model'),
    ('muscle', ['biceps', 'triceps'], "'biceps' is neither a bundled model"),
    ('muscle', ['deltoid', 'deltoid'], 'different names expected'),
    ('muscle', [1, 2], 'a list of text expected'),
    ('scale', 'large', 'one factor, 3'),
    ('scale', -1.0, 'a factor > 0'),
    ('scale', True, 'numbers or text'),
    ('scale', ['1', '2'], 'numbers or text'),
    ('input', 'mocap', 'one of joint_states, tf expected'),
    ('input', 3, 'text expected'),
    ('rest_frames', 3, 'a list of [BONE:=]WHERE expected'),
    ('rest_frames', ['first'], 'only with input tf'),
    ('frame_axes', 'dh', 'one of model, isb expected'),
    ('frame_axes', 'isb', 'only with input tf'),
    ('side', 'up', 'one of right, left expected'),
    ('side', True, 'text expected'),
    ('side', ['left'], 'text expected'),
    ('joint_convention', 'euler', 'one of flexion_abduction_rotation, isb_yxy, opensim_tsm'),
    ('joint_convention', 1.0, 'text expected'),
    ('skeleton', 'biceps', 'neither a bundled skeleton (hip, shoulder_girdle) nor a path'),
    ('skeleton', '/nowhere/arm.urdf', 'No such file'),
    ('skeleton', 'arm.urdf.xacro', 'ros2 run xacro xacro'),
    ('skeleton', 'hip', "no link of that name for bone 'scapula'"),
    ('skeleton', 3, 'text expected'),
    ('bone_links', ['scapula:=blade'], 'only with a skeleton'),
    ('bone_links', [1.0], 'a list of BONE:=LINK expected'),
    ('rhythm', 'samba', 'one of constant_ratio, de_groot_brand_2001, mobl or a ratio above 0'),
    ('rhythm', -2.0, 'a ratio above 0 expected'),
    ('rhythm', True, 'numbers or text expected'),
    ('rest', 'still', 'only with a rhythm'),
    ('rest', [0.5, 0.1, -0.2], 'only with a rhythm'),
    ('rest', True, 'numbers or text expected'),
    ('joint_names', ['a', 'b'], '3 joint names expected'),
    ('joint_names', ['a', 'b', 'c', 'd'], '3 joint names expected'),
    ('joint_names', ['a', 'b', ''], '3 joint names expected'),
    ('joint_names', ['a', 'b', 'a'], '3 different joints expected'),
    ('joint_names', ['a', 'a', 'a'], '3 different joints expected'),
    ('joint_names', [1, 2, 3], '3 joint names expected'),
    ('joint_names', 'abc', '3 joint names expected'),
    ('joint_names', ['\n', '\t', ' '], '3 joint names that print expected'),
    ('joint_names', ['a', 'b', '  '], '3 joint names that print expected'),
    ('joint_names', ['a', 'b', 'c\x1b[1m'], '3 joint names that print expected'),
    ('joint_signs', [1.0, 1.0], '3 finite numbers expected'),
    ('joint_signs', [1.0, 0.5, 1.0], '1.0 or -1.0 expected'),
    ('joint_signs', [1, 0, 1], '1.0 or -1.0 expected'),
    ('joint_signs', [1.0, 1.0, -2.0], '1.0 or -1.0 expected'),
    ('joint_signs', ['+', '-', '+'], '3 finite numbers expected'),
    ('joint_signs', 1.0, '3 finite numbers expected'),
    ('joint_offsets', [0.0, math.nan, 0.0], '3 finite numbers expected'),
    ('joint_offsets', [0.0, 0.0, math.inf], '3 finite numbers expected'),
    ('joint_offsets', [0.0] * 4, '3 finite numbers expected'),
    ('joint_offsets', [True, False, True], '3 finite numbers expected'),
    ('joint_offsets', [1e17, 0.0, 0.0], 'a full turn (2 pi rad) either way at most expected'),
    ('joint_offsets', [0.0, -6.2832, 0.0], 'a full turn (2 pi rad) either way at most expected'),
    ('joint_offsets', [0.0, 0.0, 1e308], 'a full turn (2 pi rad) either way at most expected'),
    ('joint_timeout', -1.0, '0 to 100000 expected'),
    ('joint_timeout', math.inf, 'a finite number'),
    ('joint_timeout', '1 s', 'a finite number'),
    ('frame_id', '', 'the name of a frame expected; tf2 has none that is empty'),
    ('frame_id', 'a b\n', 'at most 255 characters that print, without blanks, expected'),
    ('frame_id', 'a b', 'without blanks, expected'),
    ('frame_id', 'a\u2003b', 'without blanks, expected'),
    ('frame_id', 256 * 'f', '(256 characters), at most 255'),
    ('frame_id', 7, 'text expected'),
    ('frame_id', '/scapula', "tf2 has none that starts with '/'"),
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


@contextmanager
def connected(node: MuscleStatePublisher) -> Iterator[Peer]:
    """Provide a peer that works together with a node."""
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


def change_parameters(node: MuscleStatePublisher, **values: Any) -> SetParametersResult:
    """Set a batch of parameters at once; a double underscore stands for a dot."""
    return node.set_parameters_atomically(
        [as_sent(name.replace('__', '.'), value) for name, value in values.items()]
    )


def answer_to_pose(peer: Peer, names: tuple[str, ...] = THESIS.coordinates) -> tuple[Any, ...]:
    """Send a pose; return the answer: lengths, moment arms, band states, moment arms' message."""
    before = min(peer.counts().values())
    peer.send(names, POSE, nanoseconds=before + 1)
    assert peer.answers(before + 1)
    got = [peer.got[topic][before] for topic in ('band_lengths', 'moment_arms', 'band_states')]
    assert got[2].header.stamp.nanosec == before + 1
    return np.array(got[0].data), np.array(got[1].data).reshape(-1, 3), got[2], got[1]


def expected_answer(
    convention: str = THESIS.name, side: str = 'right', angles: tuple[float, ...] = POSE
) -> tuple[Any, Any]:
    """Return the lengths and moment arms that the solver gives."""
    chosen = JOINT_CONVENTIONS[convention]
    state = LinkedPlaneSolver(DELTOID, side).solve(chosen.rotation(angles))
    return state.lengths, state.moment_vectors @ chosen.axes(angles, side)


def agree(got: tuple[Any, ...], want: tuple[Any, Any]) -> bool:
    """Return whether an answer is what the solver gives."""
    return bool(np.abs(got[0] - want[0]).max() <= EXACT and np.abs(got[1] - want[1]).max() <= EXACT)
