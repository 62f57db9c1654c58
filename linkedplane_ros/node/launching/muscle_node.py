# SPDX-License-Identifier: Apache-2.0
"""The node that a launch file starts: its parameters, and the names that others meet it by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from posixpath import join
from typing import Any

from launch_ros.actions import Node
from launch_ros.utilities import make_namespace_absolute, prefix_namespace
from rclpy.exceptions import InvalidTopicNameException
from rclpy.validate_full_topic_name import validate_full_topic_name

from launch import LaunchContext

from ...errors import LinkedPlaneError
from ...muscle.broad_muscle import BroadMuscle
from ..articulations import list_coordinates
from ..parameters import Value
from ..settings import check_values, list_muscles, load_muscles
from ..topics import JOINT_STATES, NODE_NAME
from .arguments import PARAMETERS, check_parameters
from .parameter_file import read_parameter_file


@dataclass(frozen=True)
class MuscleNode:
    """The node that a launch file starts with some arguments, seen from the launch's context."""

    namespace: str
    """As it is given to launch_ros, which puts it into the namespace around it."""
    full_namespace: str
    joint_states: str
    """The topic as it is given; the node subscribes `input_topic`."""
    input_topic: str
    """The full name of the topic of joint states."""
    params_file: Path | None
    given: Mapping[str, Value]
    """The parameters that arguments set."""
    parameters: Mapping[str, Any]
    """All parameters, by the arguments, else the file, else the launch files around, else the
    defaults."""

    @staticmethod
    def from_arguments(context: LaunchContext, values: Mapping[str, str]) -> MuscleNode:
        """Return the node of the arguments of a launch file.

        Parameters
        ----------
        context
            Where the node is started: launch files around this one may have pushed a namespace,
            or set parameters and remappings for all nodes.
        values
            The arguments by name; of parameters that are missing or empty, the defaults hold.

        Raises
        ------
        LinkedPlaneError
            For an argument, or a file of parameters, that cannot be used.

        """
        outer = context.launch_configurations
        namespace = values['namespace']
        full_namespace = make_namespace_absolute(
            prefix_namespace(outer.get('ros_namespace'), namespace)
        )
        params_file = Path(values['params_file']).expanduser() if values['params_file'] else None
        given = check_parameters(values)
        name = join(full_namespace, NODE_NAME)
        from_outside: dict[str, Any] = {}
        for item in outer.get('global_params', ()):  # a name and its value, or a file
            pair = isinstance(item, tuple)
            from_outside |= [item] if pair else read_parameter_file(Path(item), name)
        input_topic = resolve_topic(
            JOINT_STATES.name,
            [*outer.get('ros_remaps', ()), (JOINT_STATES.name, values['joint_states'])],
            full_namespace,
        )
        parameters = {
            **{spec.name: spec.default for spec in PARAMETERS},
            **from_outside,
            **(read_parameter_file(params_file, name) if params_file else {}),
            **given,
        }
        check_node(input_topic, parameters)
        return MuscleNode(
            namespace=namespace,
            full_namespace=full_namespace,
            joint_states=values['joint_states'],
            input_topic=input_topic,
            params_file=params_file,
            given=given,
            parameters=parameters,
        )

    def start(self) -> Node:
        """Return the action that starts the node."""
        return Node(
            package='linkedplane_ros',
            executable=NODE_NAME,
            name=NODE_NAME,  # the arguments win over what a file says for a node of this full name
            namespace=self.namespace,
            remappings=[(JOINT_STATES.name, self.joint_states)],
            parameters=[
                *([str(self.params_file)] if self.params_file else []),
                *([self.given] if self.given else []),  # launch_ros keeps types
            ],
            output='screen',
        )

    @property
    def frame_id(self) -> str:
        """The frame of the outputs."""
        return str(self.parameters['frame_id'])

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints that the node takes; none where they come with a URDF on a topic."""
        checked = check_values(self.parameters)
        return tuple(checked['joint_names']) or list_coordinates(checked)

    @property
    def marker_topic(self) -> str:
        """The full name of the topic of markers, of the first muscle."""
        name, *_ = *list_muscles(self.parameters['muscle']), ''
        with suppress(LinkedPlaneError):  # the node says what is wrong with it
            name = BroadMuscle.load(name).name
        return join(self.full_namespace, name, 'markers')


def check_node(input_topic: str, parameters: Mapping[str, Any]) -> None:
    """Raise LinkedPlaneError for what the node would refuse, before a player plays to nobody."""
    try:
        validate_full_topic_name(input_topic)
    except InvalidTopicNameException:
        raise LinkedPlaneError(
            f"joint_states: {input_topic!r} given, a topic's name expected: letters, digits, '_' "
            "and '/'"
        ) from None
    checked = check_values(parameters)
    muscles = list_muscles(checked['muscle'])
    load_muscles(muscles, checked['scale'], muscles)  # the node goes on with those that it can load


def resolve_topic(topic: str, remappings: Iterable[tuple[str, str]], namespace: str) -> str:
    """Return the full name of a topic of the node: the first remapping of it counts."""

    def full(name: str) -> str:
        return join(namespace, name.replace('~', join(namespace, NODE_NAME), 1))

    targets = (full(target) for source, target in remappings if full(source) == full(topic))
    return next(targets, full(topic))
