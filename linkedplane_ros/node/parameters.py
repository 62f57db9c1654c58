"""The node's parameters: one table for declaration, descriptors, validation and the README."""

from __future__ import annotations

import math
from array import array
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..drawing.shapes import MARKER_RATE, POINTS_ON_ARC
from ..joints.conventions import JOINT_CONVENTIONS, SIDES, JointConvention
from ..joints.joint_state import JointMap
from ..muscle.broad_muscle import BroadMuscle
from ..solver.linked_plane_solver import LinkedPlaneSolver

Value = str | bool | int | float | list[str] | list[float]


@dataclass(frozen=True)
class ParameterSpec:
    """One parameter; its type is that of its default."""

    name: str
    default: Value
    meaning: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    numbers: bool = False
    """A text that may be given as a number or numbers, too."""
    several: bool = False
    """A text that may be given as a list of texts, too."""

    @property
    def kind(self) -> Parameter.Type:
        """The ROS type of the parameter."""
        if isinstance(self.default, list):
            strings = self.name == 'joint_names'
            return Parameter.Type.STRING_ARRAY if strings else Parameter.Type.DOUBLE_ARRAY
        return Parameter.Type.from_parameter_value(self.default)

    def descriptor(self) -> ParameterDescriptor:
        """Return what `ros2 param describe` shows. Whole numbers for a double are let through."""
        descriptor = ParameterDescriptor(
            name=self.name,
            type=self.kind.value,
            description=self.meaning,
            dynamic_typing=True,
            additional_constraints=f'one of: {", ".join(self.choices)}' if self.choices else '',
        )
        if self.low is not None and self.high is not None:
            if isinstance(self.default, int):
                descriptor.integer_range = [
                    IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)
                ]
            else:
                descriptor.floating_point_range = [
                    FloatingPointRange(from_value=self.low, to_value=self.high, step=0.0)
                ]
        return descriptor

    def checked(self, value: Any) -> Value:
        """Return the value as the parameter's type; ValueError names what would be right."""
        if isinstance(self.default, list):
            return self._checked_list(value)
        if self.numbers and not isinstance(value, str):
            items = value if isinstance(value, (Sequence, array)) else [value]
            if not all(finite_number(item) for item in items):
                raise self._fault(value, 'numbers or text')
            return ','.join(repr(float(item)) for item in items)
        if self.several and not isinstance(value, str):
            items = list(value) if isinstance(value, Sequence) else []
            if not items or not all(isinstance(item, str) for item in items):
                raise self._fault(value, 'a text or a list of text')
            return items
        if isinstance(self.default, (bool, str)):
            if type(value) is not type(self.default):
                word = 'true or false' if isinstance(self.default, bool) else 'text'
                raise self._fault(value, word)
            if self.choices and value not in self.choices:
                raise self._fault(value, f'one of {", ".join(self.choices)}')
            return value  # type: ignore[no-any-return]
        whole = isinstance(self.default, int)
        if not finite_number(value) or (whole and not isinstance(value, int)):
            raise self._fault(value, 'a whole number' if whole else 'a finite number, as 30.0')
        if self.low is not None and self.high is not None and not self.low <= value <= self.high:
            raise self._fault(value, f'{self.low:g} to {self.high:g}')
        return int(value) if whole else float(value)

    def _checked_list(self, value: Any) -> Value:
        strings = self.kind is Parameter.Type.STRING_ARRAY
        items = (
            list(value) if isinstance(value, Sequence) and not isinstance(value, str) else [value]
        )
        if strings:
            if items in ([], ['']):
                return []
            if len(items) != 3 or not all(isinstance(item, str) and item for item in items):
                raise self._fault(value, '3 joint names')
            if len(set(items)) < 3:
                raise self._fault(value, '3 different joints')
            return items
        if len(items) != 3 or not all(finite_number(item) for item in items):
            raise self._fault(value, '3 finite numbers')
        return [float(item) for item in items]

    def _fault(self, value: Any, right: str) -> ValueError:
        given = list(value) if isinstance(value, Sequence) and not isinstance(value, str) else value
        return ValueError(f'parameter {self.name}: {given!r} given, {right} expected')


def finite_number(value: Any) -> bool:
    """Return whether a value is a number that can be used."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


SPECS = (
    ParameterSpec(
        'muscle',
        'deltoid',
        'A bundled model, or the path of a model file (.yaml); or a list of them, of different '
        'names.',
        several=True,
    ),
    ParameterSpec(
        'scale',
        '1',
        "The subject's size: a factor, 3 (x,y,z), 6 (the scapula's, then the humerus's), or the "
        'path of a .yaml file of measurements.',
        numbers=True,
    ),
    ParameterSpec('side', 'right', "The shoulder's side of the body.", choices=SIDES),
    ParameterSpec(
        'joint_convention',
        'flexion_abduction_rotation',
        'What the three angles mean: humerus against scapula, right-shoulder axes x lateral, '
        'y anterior, z superior.',
        choices=tuple(JOINT_CONVENTIONS),
    ),
    ParameterSpec(
        'joint_names',
        [''],
        "The three joints in the convention's order; one empty name: its coordinates.",
    ),
    ParameterSpec(
        'joint_signs', [1.0, 1.0, 1.0], 'angle = sign * position + offset: the three signs, +-1.'
    ),
    ParameterSpec(
        'joint_offsets', [0.0, 0.0, 0.0], 'angle = sign * position + offset: three offsets, rad.'
    ),
    ParameterSpec('frame_id', 'scapula', 'The frame of the outputs.'),
    ParameterSpec('markers.enabled', True, 'Publish markers.'),
    ParameterSpec(
        'markers.rate',
        MARKER_RATE,
        "Markers a second at most, Hz, by the input's stamps; 0: with every message.",
        0.0,
        10000.0,
    ),
    ParameterSpec(
        'markers.details', True, 'Planes, interference spheres, and where bands enter them, too.'
    ),
    ParameterSpec(
        'markers.points', POINTS_ON_ARC, 'Points drawn on the arc of a wrapped band.', 2, 1000
    ),
)

STILL = (0.0, 0.0, 0.0)  # rad, rad/s
NAMES = tuple(spec.name for spec in SPECS)


@dataclass(frozen=True)
class Settings:
    """All parameters, checked and turned into what the node works with."""

    solvers: tuple[LinkedPlaneSolver, ...]
    """One a muscle, whose names all differ."""
    left_out: Mapping[str, str]
    """What was given for a muscle but cannot be used, each with the line that tells why."""
    scale: str
    convention: JointConvention
    joints: JointMap
    frame_id: str
    markers_enabled: bool
    markers_rate: float
    markers_points: int
    markers_details: bool

    @staticmethod
    def from_values(values: Mapping[str, Any], may_fail: Collection[str] = ()) -> Settings:
        """Build the settings of a whole set of parameters; ValueError names what is wrong.

        Muscles that may fail are left out where they do, as long as another one is left.
        """
        checked: dict[str, Any] = {spec.name: spec.checked(values[spec.name]) for spec in SPECS}
        convention = JOINT_CONVENTIONS[checked['joint_convention']]
        if any(abs(sign) != 1.0 for sign in checked['joint_signs']):
            raise ValueError(
                f'parameter joint_signs: {checked["joint_signs"]} given, 1.0 or -1.0 expected'
            )
        if not checked['frame_id']:
            raise ValueError("parameter frame_id: '' given, the name of a frame expected")
        solvers, left_out = made(
            listed(checked['muscle']), checked['scale'], checked['side'], convention, may_fail
        )
        return Settings(
            solvers=solvers,
            left_out=left_out,
            scale=checked['scale'],
            convention=convention,
            joints=JointMap(
                tuple(checked['joint_names']) or convention.coordinates,
                tuple(checked['joint_signs']),
                tuple(checked['joint_offsets']),
            ),
            frame_id=checked['frame_id'],
            markers_enabled=checked['markers.enabled'],
            markers_rate=checked['markers.rate'],
            markers_points=checked['markers.points'],
            markers_details=checked['markers.details'],
        )


def listed(muscle: Any) -> list[str]:
    """Return what a value of the parameter `muscle` lists; nothing if it is no such value."""
    items = [muscle] if isinstance(muscle, str) else muscle
    return [str(item) for item in items] if isinstance(items, Sequence) else []


def made(
    muscles: Sequence[str],
    scale: str,
    side: str,
    convention: JointConvention,
    may_fail: Collection[str],
) -> tuple[tuple[LinkedPlaneSolver, ...], dict[str, str]]:
    """Return the muscles' solvers, and why those that may fail are not among them."""
    solvers: dict[str, LinkedPlaneSolver] = {}
    given: dict[str, str] = {}
    left_out: dict[str, str] = {}
    for text in muscles:
        try:
            solver = LinkedPlaneSolver(BroadMuscle.load(text).scaled(scale), side)
            solver.answer(convention, STILL, STILL)  # compiled before it is needed
        except ValueError as error:
            if text not in may_fail:
                raise
            left_out[text] = str(error)
            continue
        name = solver.muscle.name
        if name in solvers:
            raise ValueError(
                f'parameter muscle: {given[name]!r} and {text!r} are both named {name}, the prefix '
                'of their topics; different names expected'
            )
        solvers[name], given[name] = solver, text
    if not solvers:
        raise ValueError('; '.join(dict.fromkeys(left_out.values())))
    return tuple(solvers.values()), left_out


def markdown() -> str:
    """Return the table of the parameters, as the README has it."""
    lines = ['| name | default | meaning |', '| --- | --- | --- |']
    for spec in SPECS:
        limits = f' {spec.low:g} to {spec.high:g}.' if spec.low is not None else ''
        choices = f' One of {", ".join(f"`{c}`" for c in spec.choices)}.' if spec.choices else ''
        default = yaml.safe_dump(spec.default, default_flow_style=True).split('\n')[0]
        lines.append(f'| `{spec.name}` | `{default}` | {spec.meaning}{limits}{choices} |')
    return '\n'.join(lines)


def declare(node: Node) -> Settings:
    """Declare every parameter on a node and return the settings; ValueError as from_values.

    Any muscle may fail as long as another one is left.

    The values are checked here before their descriptors are: rclpy's own complaint about a value
    out of range does not name it.
    """
    free = ParameterDescriptor(dynamic_typing=True)
    values = {
        spec.name: node.declare_parameter(spec.name, spec.default, free).value for spec in SPECS
    }
    settings = Settings.from_values(values, may_fail=listed(values['muscle']))
    for spec in SPECS:
        node.set_descriptor(spec.name, spec.descriptor())
    return settings
