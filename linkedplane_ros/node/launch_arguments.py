# SPDX-License-Identifier: Apache-2.0
"""The arguments of the launch files: declared once, those of the parameters from their table."""

from __future__ import annotations

from collections.abc import Iterable

from launch.actions import DeclareLaunchArgument

from .parameters import SPECS

Argument = tuple[str, str, str]
"""Name, default and meaning."""

USE_SIM_TIME: Argument = (
    'use_sim_time',
    'false',
    'Take the time from /clock, as of a recording played with --clock.',
)


def parameter_argument(name: str) -> Argument:
    """Return the argument that sets a parameter of the node."""
    spec = next(spec for spec in SPECS if spec.name == name)
    return name, spec.default_text, spec.meaning


def declare_arguments(arguments: Iterable[Argument]) -> list[DeclareLaunchArgument]:
    """Return the actions that declare the arguments of a launch file."""
    return [
        DeclareLaunchArgument(name, default_value=default, description=meaning)
        for name, default, meaning in arguments
    ]
