# SPDX-License-Identifier: Apache-2.0
"""A recording played by `ros2 bag play` to the nodes that a launch file starts.

`linkedplane play` waits for its subscribers by itself, but plays the joint states alone, and needs
a library that does not come with ROS.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import closing, suppress
from pathlib import Path
from posixpath import join

from launch.actions import ExecuteProcess

from ...errors import LinkedPlaneError, RecordingError
from ...recordings.bags.opening import open_bag
from ...recordings.bags.topics import (
    JOINT_STATE,
    choose_joint_topic,
    list_topics,
    read_joint_names,
)
from ..parameters import is_finite_number
from .arguments import parse_argument


def player_actions(
    values: Mapping[str, str], wanted: Collection[str], clock: bool, joints: Collection[str] = ()
) -> list[ExecuteProcess]:
    """Return the action that plays the recording of the arguments; none if there is none.

    Parameters
    ----------
    values
        The arguments by name: `bag`, `bag_topic`, `delay`.
    wanted
        The full names of the topics on which the nodes expect joint states.
    clock
        Whether the recorded time is published on /clock.
    joints
        The joints that the one node takes; empty: several nodes take what they are given.

    Raises
    ------
    LinkedPlaneError
        If the recording's joint states would not reach the nodes.

    """
    if not values['bag']:
        return []
    bag = Path(values['bag']).expanduser()
    delay = parse_argument('delay', values['delay'])
    if not is_finite_number(delay) or delay < 0.0:
        raise LinkedPlaneError(f'delay: {values["delay"]} given, seconds from 0 expected')
    rules = remap_joint_states(bag, values['bag_topic'], set(wanted), joints)
    command = ['ros2', 'bag', 'play', '--loop', str(bag)]
    command += ['--delay', str(float(delay))] if delay else []  # 0 is refused
    command += ['--clock'] if clock else []
    command += ['--remap', *rules] if rules else []
    return [ExecuteProcess(cmd=command, output='screen')]


def remap_joint_states(
    bag: Path, chosen: str, wanted: set[str], joints: Collection[str] = ()
) -> list[str]:
    """Return the rules by which a recording's joint states reach the topics that are wanted.

    Parameters
    ----------
    bag
        The recording's folder, or one of its files.
    chosen
        The recording's topic of joint states; empty: the one that has the joints, if the recording
        can be read here, else the one that is wanted, /joint_states, or the only one.
    wanted
        The full names of the topics.
    joints
        The joints that are taken from it; empty: any.

    Raises
    ------
    LinkedPlaneError
        If there is no such topic, or if several are wanted that are not all recorded.

    """
    if not bag.exists():
        raise RecordingError(f'bag: {bag}: no such file or folder')
    listening = ' and '.join(sorted(wanted))
    if chosen and len(wanted) > 1:
        raise LinkedPlaneError(f'bag_topic: {chosen} given, but the nodes listen on {listening}')
    topic = join('/', chosen) if chosen else None
    try:
        recorded = list_topics(bag)
    except RecordingError as fault:
        if topic is None:
            raise RecordingError(
                f'{fault}; bag_topic:=TOPIC names its joint states unread'
            ) from None
        recorded = [(topic, JOINT_STATE)]
    held = {name for name, kind in recorded if kind == JOINT_STATE}
    names = read_names(bag) if topic is None and joints and len(held) > 1 else None
    has_joints = names is None or all(set(joints) <= set(names.get(each, ())) for each in wanted)
    if topic is None and wanted <= held and has_joints:
        return []
    if len(wanted) > 1:
        raise RecordingError(
            f'{bag}: joint states on {" and ".join(sorted(held)) or "no topic"}, but the nodes '
            f'listen on {listening}; left_joint_states:=TOPIC and right_joint_states:=TOPIC '
            'choose others'
        )
    topic = choose_joint_topic(bag, recorded, topic, 'bag_topic:={}', names, joints)
    return [f'{topic}:={goal}' for goal in wanted if goal != topic]


def read_names(bag: Path) -> dict[str, list[str]] | None:
    """Return the joints of each topic of joint states; None if the recording cannot be read."""
    with suppress(RecordingError), closing(open_bag(bag)) as opened:
        return read_joint_names(opened)
    return None
