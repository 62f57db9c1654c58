# SPDX-License-Identifier: Apache-2.0
"""The arguments of the launch files: declared once, those of the parameters from their table.

The argument of a parameter is empty by default: then the node's own default holds, or what a file
of parameters says.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from launch.actions import DeclareLaunchArgument

from ...errors import LinkedPlaneError, describe_value
from ...muscle.yaml_mapping import load_yaml
from ..parameters import SPECS, ParameterSpec, Value

Argument = tuple[str, str, str]
"""Name, default and meaning."""

PARAMETERS = (
    *SPECS,
    ParameterSpec(
        'use_sim_time',
        False,
        'Take the time from /clock; a recording is then played with its clock.',
    ),
)
PARAMS_FILE: Argument = (
    'params_file',
    '',
    'A file of parameters; the arguments that are given here win over it.',
)
RECORDING: tuple[Argument, ...] = (
    ('bag', '', 'A recording to play, looped; empty: none.'),
    ('bag_topic', '', "The recording's topic of joint states; empty: /joint_states, or the one."),
    ('delay', '5.0', 'Waited before each round of the recording, s: until all have connected.'),
)


def parameter_argument(spec: ParameterSpec, prefix: str = '') -> Argument:
    """Return the argument that sets a parameter of the node."""
    return f'{prefix}{spec.name}', '', f"{spec.describe()} The node's default: {spec.default_text}."


def declare_arguments(arguments: Iterable[Argument]) -> list[DeclareLaunchArgument]:
    """Return the actions that declare the arguments of a launch file."""
    return [
        DeclareLaunchArgument(name, default_value=default, description=meaning)
        for name, default, meaning in arguments
    ]


def check_parameters(values: Mapping[str, str]) -> dict[str, Value]:
    """Return the parameters that the arguments set.

    Parameters
    ----------
    values
        The arguments by name, as YAML; those that are missing or empty set nothing.

    Raises
    ------
    LinkedPlaneError
        It names the parameter that cannot be used, its value, and what is expected.

    """
    checked = {}
    for spec in PARAMETERS:
        text = values.get(spec.name, '')
        if text:
            joints = None if values.get('skeleton') else 3
            value = spec.check(parse_argument(spec.name, text), joints)
            checked[spec.name] = spec.default if value == [] else value
    return checked


def parse_argument(name: str, text: str) -> Any:
    """Return the value of an argument."""
    try:
        return load_yaml(text)
    except LinkedPlaneError as error:
        raise LinkedPlaneError(f'{name}: {describe_value(text)} given, {error}') from None
