# SPDX-License-Identifier: Apache-2.0
"""Which joints are a convention's coordinates, with their signs and offsets."""

from __future__ import annotations

import math

import pytest

from linkedplane_ros import LinkedPlaneError
from linkedplane_ros.joints.joint_state import JointMap, JointMemory, Rejected

NAMES = ('flexion', 'abduction', 'rotation')


@pytest.mark.parametrize('names', [('a', 'a', 'b'), ('a', 'b', 'a'), ('a', 'b', 'b'), ('a',) * 3])
def test_two_coordinates_of_one_joint_are_refused(names: tuple[str, str, str]) -> None:
    with pytest.raises(LinkedPlaneError, match=f'^joints {", ".join(names)}: 3 different joints'):
        JointMap(names, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))


@pytest.mark.parametrize('place', range(6))
@pytest.mark.parametrize('value', [math.nan, math.inf])
def test_signs_and_offsets_are_finite(place: int, value: float) -> None:
    numbers = [1.0, -1.0, 1.0, 0.5, 0.0, -0.5]
    numbers[place] = value
    with pytest.raises(LinkedPlaneError, match=r'^signs .*, offsets .*: finite numbers expected'):
        JointMap(NAMES, tuple(numbers[:3]), tuple(numbers[3:]))


@pytest.mark.parametrize('place', range(3))
@pytest.mark.parametrize('value', [1e17, -1e308, 6.2832])
def test_offsets_are_a_full_turn_at_most(place: int, value: float) -> None:
    offsets = [math.tau, -math.tau, 0.5]
    JointMap(NAMES, (1.0, 1.0, 1.0), tuple(offsets))
    offsets[place] = value
    with pytest.raises(LinkedPlaneError, match=r'^offsets .*: a full turn at most expected'):
        JointMap(NAMES, (1.0, 1.0, 1.0), tuple(offsets))


def test_a_joint_map_comes_back_from_the_facts_of_an_output() -> None:
    joints = JointMap(("it's", 'b c', '\u00e4'), (1.0, -1.0, -1.0), (0.1, -2e-17, 3.0))
    assert JointMap.from_facts(joints.facts) == joints
    assert joints.facts['joint_signs'] == '1 -1 -1'


def test_joints_of_a_skeleton_are_read_by_their_kinds() -> None:
    kinds = ('revolute', 'continuous', 'prismatic')
    joints = JointMap(NAMES, (1.0, -1.0, 1.0), (0.0, 0.5, 20.0), kinds)
    memory = JointMemory(joints)
    angles, _, _ = memory.take_message(NAMES, (6.0, 1000.0, 99.0), ())
    assert angles == (6.0, -999.5, 119.0)
    wrong = (6.3, 'degrees'), (1.1e6, 'too_large'), (101.0, 'too_large')
    for k, (value, reason) in enumerate(wrong):
        positions = [0.0, 0.0, 0.0]
        positions[k] = value
        with pytest.raises(Rejected, match=NAMES[k]) as caught:
            memory.take_message(NAMES, positions, ())
        assert caught.value.reason == reason
    with pytest.raises(LinkedPlaneError, match='100 m at most expected of a prismatic joint'):
        JointMap(NAMES, (1.0, 1.0, 1.0), (0.0, 0.0, 101.0), kinds)


def test_idle_joints_are_neither_needed_nor_read() -> None:
    joints = JointMap(NAMES, (1.0, 1.0, 1.0), (0.1, 0.2, 0.3), idle=frozenset(NAMES[1:2]))
    memory = JointMemory(joints)
    names = NAMES[2], NAMES[1]
    with pytest.raises(Rejected, match=f'waiting for joint {NAMES[0]!r}'):
        memory.take_message(names, (1.0, float('nan')), (2.0, 3.0))
    angles, speeds, _ = memory.take_message(NAMES[:1], (4.0,), (5.0,))
    assert angles == (4.1, 0.0, 1.3)
    assert speeds == (5.0, 0.0, 2.0)
