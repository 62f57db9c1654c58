# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for the launch packages, which cannot be had from PyPI: enough to see what is started.

They take the arguments that the real classes take, and no others.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

TOP = Path(__file__).parents[1]


class Values(dict[str, Any]):
    """The launch configurations, and which of them have been read."""

    def __init__(self, values: dict[str, Any], read: set[str] | None = None) -> None:
        super().__init__(values)
        self.read: set[str] = set() if read is None else read

    def __getitem__(self, name: str) -> Any:
        self.read.add(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        self.read.add(name)
        return super().get(name, default)


class PathJoinSubstitution:
    def __init__(self, substitutions: Sequence[Any]) -> None:
        self.parts = substitutions


class FindPackageShare:
    def __init__(self, package: str) -> None:
        assert package == 'linkedplane_ros'


class IfCondition:
    def __init__(self, predicate_expression: Any) -> None:
        self.expression = predicate_expression

    def holds(self, values: Values) -> bool:
        return {'true': True, 'false': False}[text(self.expression, values)]


class DeclareLaunchArgument:
    def __init__(self, name: str, *, default_value: str, description: str) -> None:
        self.name, self.default, self.description = name, default_value, description


class LaunchContext:
    def __init__(self, values: Values) -> None:
        self.launch_configurations = values


class OpaqueFunction:
    def __init__(self, *, function: Callable[[LaunchContext], list[Any]]) -> None:
        self.function = function


class ExecuteProcess:
    def __init__(self, *, cmd: Sequence[Any], condition: Any = None, output: str = 'log') -> None:
        self.cmd, self.condition = cmd, condition
        self.started = False


class Node:
    def __init__(
        self,
        *,
        package: str,
        executable: str,
        name: str | None = None,
        namespace: Any = '',
        parameters: Sequence[str | dict[str, Any]] = (),
        remappings: Sequence[tuple[Any, Any]] = (),
        arguments: Sequence[Any] = (),
        condition: Any = None,
        output: str = 'log',
    ) -> None:
        self.package, self.executable = package, executable
        self.name, self.namespace = name, namespace
        self.parameters, self.remappings, self.arguments = parameters, remappings, arguments
        self.condition = condition
        self.started = False


class PythonLaunchDescriptionSource:
    """Reads the file once, as the real one does."""

    def __init__(self, launch_file_path: Any) -> None:
        self.path = launch_file_path
        self.description: LaunchDescription | None = None

    def describe(self, values: Values) -> LaunchDescription:
        if self.description is None:
            self.description = describe(Path(text(self.path, values)))
        return self.description


class IncludeLaunchDescription:
    def __init__(self, source: Any, *, launch_arguments: Iterable[tuple[str, Any]]) -> None:
        self.source, self.arguments = source, list(launch_arguments)


class GroupAction:
    def __init__(self, actions: Sequence[Any]) -> None:
        self.actions = actions


class Action:
    """Only a name in type hints."""


def make_namespace_absolute(ns: str) -> str:
    return ns if ns.startswith('/') else f'/{ns}'


def prefix_namespace(base_ns: str | None, ns: str) -> str:
    combined = ns if not base_ns or ns.startswith('/') else f'{base_ns.rstrip("/")}/{ns}'
    return combined if combined == '/' else combined.rstrip('/')


class LaunchDescription:
    def __init__(self, initial_entities: Sequence[Any]) -> None:
        self.entities = initial_entities


PLACES: dict[str, tuple[Any, ...]] = {
    'launch': (Action, LaunchContext, LaunchDescription),
    'launch.actions': (
        DeclareLaunchArgument, ExecuteProcess, GroupAction, IncludeLaunchDescription,
        OpaqueFunction,
    ),
    'launch.conditions': (IfCondition,),
    'launch.launch_description_sources': (PythonLaunchDescriptionSource,),
    'launch.substitutions': (PathJoinSubstitution,),
    'launch_ros': (),
    'launch_ros.actions': (Node,),
    'launch_ros.substitutions': (FindPackageShare,),
    'launch_ros.utilities': (make_namespace_absolute, prefix_namespace),
}  # fmt: skip


def describe(path: Path) -> LaunchDescription:
    """Return the description of a launch file, built with the stand-ins."""
    before = {name: sys.modules.get(name) for name in PLACES}
    try:
        for name, kinds in PLACES.items():
            module = ModuleType(name)
            for kind in kinds:
                setattr(module, kind.__name__, kind)
            sys.modules[name] = module
        spec = importlib.util.spec_from_file_location(path.stem.replace('.', '_'), path)
        assert spec is not None
        assert spec.loader is not None
        file = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(file)
        description: LaunchDescription = file.generate_launch_description()
        return description
    finally:
        for name, found in before.items():
            sys.modules.pop(name)
            if found is not None:
                sys.modules[name] = found


def text(value: Any, values: Values) -> str:
    """Return what a substitution, or a list of them, comes to."""
    if isinstance(value, str):
        return value
    if isinstance(value, FindPackageShare):
        return str(TOP)
    if isinstance(value, PathJoinSubstitution):
        return '/'.join(text(part, values) for part in value.parts)
    assert isinstance(value, list), value
    return ''.join(text(part, values) for part in value)


def list_started(path: Path, **arguments: Any) -> list[Node | ExecuteProcess]:
    """Return what a launch file starts with these arguments, every substitution carried out.

    Among the arguments may be what launch files around it have set: `ros_namespace`, `ros_remaps`,
    `global_params`.
    """
    return list_started_with(describe(path).entities, Values(arguments))


def list_started_with(entities: Sequence[Any], values: Values) -> list[Node | ExecuteProcess]:
    """Return what these entities start, in order; `values` keeps what was read of it."""
    found: list[Node | ExecuteProcess] = []
    for entity in entities:
        if isinstance(entity, DeclareLaunchArgument):
            values.setdefault(entity.name, entity.default)
        elif isinstance(entity, GroupAction):
            found += list_started_with(entity.actions, Values(values, values.read))
        elif isinstance(entity, OpaqueFunction):
            found += list_started_with(entity.function(LaunchContext(values)), values)
        elif isinstance(entity, IncludeLaunchDescription):
            values.update((name, text(value, values)) for name, value in entity.arguments)
            inner = entity.source.describe(values)
            names = {e.name for e in inner.entities if isinstance(e, DeclareLaunchArgument)}
            unknown = {name for name, _ in entity.arguments} - names
            assert not unknown, f'{unknown} not declared in what is included'
            found += list_started_with(inner.entities, values)
        elif entity.condition is None or entity.condition.holds(values):
            assert not entity.started, 'one action is started twice'
            entity.started = True
            found.append(substitute(entity, values))
    return found


def parameter(value: Any, values: Values) -> Any:
    """Return a parameter as the node gets it: of the type that it has here; text stays text."""
    return value if isinstance(value, bool | int | float | list) else text(value, values)


def substitute(action: Node | ExecuteProcess, values: Values) -> Node | ExecuteProcess:
    """Return an action with plain text for every substitution."""
    if isinstance(action, ExecuteProcess):
        return ExecuteProcess(cmd=[text(word, values) for word in action.cmd])
    return Node(
        package=action.package,
        executable=action.executable,
        name=action.name,
        namespace=text(action.namespace, values),
        parameters=[
            given
            if isinstance(given, str)
            else {name: parameter(value, values) for name, value in given.items()}
            for given in action.parameters
        ],
        remappings=[(text(a, values), text(b, values)) for a, b in action.remappings],
        arguments=[text(word, values) for word in action.arguments],
    )
