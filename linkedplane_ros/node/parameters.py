# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: their defaults, meanings and limits, for the node and its documentation.

No ROS is needed here; `declaration` declares them on a node, `settings` builds what it works with.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from ..drawing.shapes import MARKER_RATE, POINTS_ON_ARC
from ..errors import LinkedPlaneError, describe_value
from ..joints.conventions import JOINT_CONVENTIONS
from ..joints.sides import SIDES
from ..muscle.yaml_mapping import quotes_hint
from ..skeleton.rhythms import RHYTHMS

Value = str | bool | int | float | list[str] | list[float]


@dataclass(frozen=True)
class ParameterSpec:
    """One parameter; its type is that of its default."""

    name: str
    default: Value
    meaning: str
    """One or more sentences."""
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    numbers: bool = False
    """Whether a text may also be given as a number or a list of numbers."""
    several: bool = False
    """Whether a text may also be given as a list of texts."""

    @property
    def default_text(self) -> str:
        """The default as YAML, as it is given on a command line."""
        return dump_yaml(self.default)

    def describe(self, quote: str = '') -> str:
        """Return the meaning with the limits; the choices between quotes."""
        limits = f' {self.low:g} to {self.high:g}.' if self.low is not None else ''
        choices = ', '.join(f'{quote}{choice}{quote}' for choice in self.choices)
        return f'{self.meaning}{limits}' + (f' One of {choices}.' if choices else '')

    def check(self, value: Any, joints: int | None = 3) -> Value:
        """Return a value as the parameter's type.

        Parameters
        ----------
        value
            As rclpy gives it. A whole number is accepted for a double.
        joints
            How many items a list for the joints must have; None: any number.

        Raises
        ------
        LinkedPlaneError
            It names the parameter, the value, and what is expected.

        """
        if isinstance(self.default, list):
            return self._check_list(value, joints)
        if self.numbers and not isinstance(value, str):
            items = value if isinstance(value, (Sequence, array)) else [value]
            if not items or not all(is_finite_number(item) for item in items):
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
            return value
        whole = isinstance(self.default, int)
        if not is_finite_number(value) or (whole and not isinstance(value, int)):
            raise self._fault(value, 'a whole number' if whole else 'a finite number, as 30.0')
        if self.low is not None and self.high is not None and not self.low <= value <= self.high:
            raise self._fault(value, f'{self.low:g} to {self.high:g}')
        return int(value) if whole else float(value)

    def _check_list(self, value: Any, joints: int | None) -> Value:
        items = list(value) if is_list(value) else [value]
        if self.name in ('bone_links', 'rest_frames'):
            if not items or not all(isinstance(item, str) for item in items):
                entry = 'BONE:=LINK' if self.name == 'bone_links' else '[BONE:=]WHERE'
                raise self._fault(value, f'a list of {entry}')
            return items
        each = 'a list of' if joints is None else str(joints)
        right = len(items) == (joints or len(items))
        if self.name == 'joint_names':
            if items in ([], ['']):
                return []
            if not right or not all(isinstance(item, str) and item for item in items):
                raise self._fault(value, f'{each} joint names')
            if not all(item.strip() and item.isprintable() for item in items):
                raise self._fault(value, f'{each} joint names that print')
            if len(set(items)) < len(items):
                raise self._fault(value, f'{each} different joints')
            return items
        if not right or not all(is_finite_number(item) for item in items):
            raise self._fault(value, f'{each} finite numbers')
        return [float(item) for item in items]

    def _fault(self, value: Any, expected: str) -> LinkedPlaneError:
        given = list(value) if is_list(value) else value
        line = f'parameter {self.name}: {describe_value(given)} given, {expected} expected'
        if isinstance(self.default, str) or self.name == 'joint_names':
            items = given if isinstance(given, list) else [given]
            line += next(filter(None, map(quotes_hint, items)), '')
        return LinkedPlaneError(line)


def is_list(value: Any) -> bool:
    """Return whether a value is a sequence, but no text."""
    return isinstance(value, Sequence) and not isinstance(value, str)


def is_finite_number(value: Any) -> bool:
    """Return whether a value is a finite number; true and false are none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def dump_yaml(value: Value) -> str:
    """Return a value as YAML in one line, as it is given on a command line."""
    dumped: str = yaml.safe_dump(value, default_flow_style=True, width=math.inf)
    return dumped.split('\n')[0]


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
        'What the three angles mean: humerus against scapula (with a rhythm: against the thorax), '
        'right-shoulder axes x lateral, y anterior, z superior. A skeleton has its own.',
        choices=tuple(JOINT_CONVENTIONS),
    ),
    ParameterSpec(
        'input',
        'joint_states',
        'What moves the bones: joint states, or the poses of the bones in `/tf` and `/tf_static`, '
        'as frames of their names, or as `bone_links` says.',
        choices=('joint_states', 'tf'),
    ),
    ParameterSpec(
        'rest_frames',
        [''],
        "With `input: tf`, where the bones' frames stand at the muscle's rest, for all or as "
        "`BONE:=...`: `coincide` (with the ground bone's), `first` (as when they first come), "
        "`X,Y,Z,ROLL,PITCH,YAW` in the ground bone's frame (m, rad), or as the links of a "
        "skeleton; empty: the `skeleton`'s links, else `coincide`, or `first` with a warning if "
        'one begins more than 50 mm away.',
    ),
    ParameterSpec(
        'frame_axes',
        'model',
        "With `input: tf`, the axes of the bones' frames: x to the body's right, y anterior, "
        'z superior (`model`), or x anterior, y superior, z to the right (`isb`).',
        choices=('model', 'isb'),
    ),
    ParameterSpec(
        'skeleton',
        '',
        'The chain of joints that moves the bones, in place of the convention: a bundled one '
        '(`shoulder_girdle`, `hip`), the path of a .urdf, or `robot_description`, the URDF on the '
        'topic of that name; empty: none.',
    ),
    ParameterSpec(
        'bone_links',
        [''],
        "With a skeleton, or `input: tf`: the links, or frames, of the muscle's bones that are not "
        'named as the bones, a list of `BONE:=LINK`; `LINK@X,Y,Z,ROLL,PITCH,YAW` (m, rad) where '
        "the bone's frame is not the link's.",
    ),
    ParameterSpec(
        'rhythm',
        '',
        'For angles of the humerus against the thorax, how scapula and clavicle follow: '
        f'{", ".join(f"`{name}`" for name in RHYTHMS)}, or a number, the ratio of glenohumeral to '
        'scapulothoracic elevation; empty: they do not, the angles are against the scapula.',
        numbers=True,
    ),
    ParameterSpec(
        'rest',
        '',
        'Where the rhythm starts from. `still`: the first second in which the arm hangs still, '
        "nothing is answered before; or 3 or 5 numbers, rad: the scapula's protraction, lateral "
        "rotation and tilt with the arm hanging, and the humerus' plane of elevation and elevation "
        "there; empty: an average subject's (of a ratio: the thorax's axes).",
        numbers=True,
    ),
    ParameterSpec(
        'joint_names',
        [''],
        "The three joints in the convention's order, or one for each of a skeleton's coordinates; "
        'one empty name, or none: the coordinates.',
    ),
    ParameterSpec(
        'joint_signs',
        [1.0, 1.0, 1.0],
        'angle = sign * position + offset: the three signs, +-1, or one '
        "for each of a skeleton's coordinates (where they are all 1, the default is right).",
    ),
    ParameterSpec(
        'joint_offsets',
        [0.0, 0.0, 0.0],
        "angle = sign * position + offset: three offsets, rad, or one for each of a skeleton's "
        'coordinates (of prismatic ones, m); a full turn (2 pi) either way at most.',
    ),
    ParameterSpec(
        'joint_timeout',
        0.0,
        'How much older than a message the joints that are not in it may be, s, by the stamps and '
        'by their arrival; nothing is answered from older ones. 0: any age.',
        0.0,
        1e5,
    ),
    ParameterSpec(
        'frame_id',
        'scapula',
        'The frame of the outputs: 1 to 255 characters that print, no blanks.',
    ),
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

NAMES = tuple(spec.name for spec in SPECS)


def parameter_rows() -> list[tuple[str, str, str]]:
    """Return the rows of the documentation's table, in Markdown: name, default, meaning."""
    return [(f'`{spec.name}`', f'`{spec.default_text}`', spec.describe('`')) for spec in SPECS]
