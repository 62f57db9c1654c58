# SPDX-License-Identifier: Apache-2.0
"""From a URDF to a tree of joints; what says nothing of links and joints is passed over.

Read with the standard library: the maintained `urdf_parser_py` is ROS's alone, PyPI's is of 2021.
"""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from ..errors import SkeletonError, describe_value
from ..joints.sides import SIDES
from ..types import Interval, Triple
from .joint_tree import FIXED, KINDS, UNLIMITED, Joint, JointTree, Mimic, list_names

MOST_BYTES = 16 * 2**20
"""Of a URDF: those of whole robots have some hundred kB."""
NUMBER = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf|infinity)', re.I)
XACRO = re.compile(r'\$\{|\$\(')  # an expression, or a substitution
EXPAND = 'expand it: ros2 run xacro xacro FILE.xacro -o FILE.urdf'
MOVING_FREELY = {'floating': 'six', 'planar': 'three', 'spherical': 'three', 'ball': 'three'}


class _Builder(ElementTree.TreeBuilder):
    """Builds a tree, but of no document that declares entities: they may grow without bound."""

    def doctype(self, name: str, *_: str | None) -> None:
        """Refuse a document type, before anything in it is read."""
        raise SkeletonError(f'it declares a document type, {describe_value(name)}; none expected')


def parse_urdf(name: str, text: str | bytes) -> JointTree:
    """Return the tree of joints in a URDF.

    Parameters
    ----------
    name
        What messages call it.
    text
        The URDF, at most 16 MiB; as bytes in the encoding that it declares.

    Returns
    -------
    JointTree
        With the links as bones that an element `<linkedplane_ros bones="..." side="..."/>` names,
        and the side of the body that it says they are of.

    Raises
    ------
    SkeletonError
        One line that names the joint or link and the reason.
    """
    robot = _parse_xml(name, text)
    if local_name(robot) != 'robot':
        raise SkeletonError(f'{name}: its root is <{local_name(robot)}>; <robot>, a URDF, expected')
    _refuse_xacro(name, robot)
    children = [(local_name(each), each) for each in robot]
    links = tuple(
        _read_name(name, f'link {i}', each)
        for i, each in enumerate(each for tag, each in children if tag == 'link')
    )
    joints = tuple(
        _read_joint(name, i, each)
        for i, each in enumerate(each for tag, each in children if tag == 'joint')
    )
    ours = next((each for tag, each in children if tag == 'linkedplane_ros'), Element(''))
    side = ours.get('side', '')
    if side not in ('', *SIDES):
        given = f'{describe_value(side)} given'
        raise SkeletonError(f"{name}: linkedplane_ros: side: {given}, 'right' or 'left' expected")
    return JointTree(name, links, joints, tuple(ours.get('bones', '').split()), side)


def local_name(element: Element) -> str:
    """Return an element's name without its namespace."""
    return element.tag.rpartition('}')[2] if isinstance(element.tag, str) else ''


def _parse_xml(name: str, text: str | bytes) -> Element:
    if not isinstance(text, (str, bytes)):
        raise SkeletonError(f'{name}: {describe_value(text)} given, the text of a URDF expected')
    if len(text) > MOST_BYTES:
        most = f'{MOST_BYTES / 2**20:g} MiB'
        raise SkeletonError(f'{name}: larger than {most}, the most that is read')
    if not text.strip():
        raise SkeletonError(f'{name}: empty; a URDF expected')
    parser = ElementTree.XMLParser(target=_Builder())
    try:
        parser.feed(text)
        return parser.close()
    except SkeletonError as error:
        raise SkeletonError(f'{name}: {error}') from None
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        expected = EXPAND if 'unbound prefix' in str(error) else 'a URDF expected'
        raise SkeletonError(f'{name}: not valid XML: {error}; {expected}') from None


def _refuse_xacro(name: str, robot: Element) -> None:
    """Refuse macros that are left, and expressions where numbers and names should be."""
    for element in robot.iter():
        tag = element.tag if isinstance(element.tag, str) else ''
        if 'xacro' in tag:
            raise SkeletonError(f'{name}: has <xacro:{local_name(element)}> in it; {EXPAND}')
    for element in robot:
        if local_name(element) in ('link', 'joint'):
            parts = element if local_name(element) == 'joint' else ()
            for value in (value for each in (element, *parts) for value in each.attrib.values()):
                if XACRO.search(value):
                    raise SkeletonError(f'{name}: has {describe_value(value)} in it; {EXPAND}')


def _read_name(file: str, what: str, element: Element) -> str:
    name = element.get('name', '')
    if not name.strip():
        raise SkeletonError(f'{file}: {what}: has no name')
    return name


def _read_joint(file: str, i: int, element: Element) -> Joint:
    name = _read_name(file, f'joint {i}', element)
    joint = _Reader(f'{file}: joint {describe_value(name)}', element)
    kind = joint.read_kind()
    axis = joint.read_triple('axis', 'xyz', (1.0, 0.0, 0.0))
    if kind != FIXED and not any(axis):
        raise joint.fault('axis: xyz is 0 0 0; a direction expected')
    return Joint(
        name,
        kind,
        joint.read_link('parent'),
        joint.read_link('child'),
        joint.read_triple('origin', 'xyz', (0.0, 0.0, 0.0)),
        joint.read_triple('origin', 'rpy', (0.0, 0.0, 0.0)),
        axis,
        joint.read_limits(kind),
        joint.read_mimic() if kind != FIXED else None,
    )


class _Reader:
    """Reads the parts of a joint; each error names file and joint."""

    def __init__(self, where: str, element: Element) -> None:
        self.where = where
        self.kind = element.get('type')
        self.parts: dict[str, Element] = {}
        for part in element:
            self.parts.setdefault(local_name(part), part)

    def fault(self, reason: str) -> SkeletonError:
        """Return the error for the joint."""
        return SkeletonError(f'{self.where}: {reason}')

    def read_kind(self) -> str:
        """Return the type, one of KINDS."""
        expected = f'{list_names(KINDS)} expected'
        if self.kind is None:
            raise self.fault(f'has no type; {expected}')
        if self.kind in MOVING_FREELY:
            freely = MOVING_FREELY[self.kind]
            raise self.fault(f'type {self.kind!r} has {freely} coordinates; {expected}')
        if self.kind not in KINDS:
            raise self.fault(f'type {describe_value(self.kind)} is not known; {expected}')
        return self.kind

    def read_link(self, end: str) -> str:
        """Return the name of the parent or the child link."""
        part = self.parts.get(end)
        link = '' if part is None else part.get('link', '')
        if not link:
            raise self.fault(f'has no {end} link')
        return link

    def read_triple(self, tag: str, attribute: str, default: Triple) -> Triple:
        """Return three numbers of a part; the default where they are not given."""
        part = self.parts.get(tag)
        text = None if part is None else part.get(attribute)
        if text is None:
            return default
        words = text.split()
        if len(words) != 3:
            given = f'{describe_value(text)} given'
            raise self.fault(f'{tag}: {attribute}: {given}, three numbers expected')
        x, y, z = (self.read_number(f'{tag}: {attribute}', word) for word in words)
        return x, y, z

    def read_limits(self, kind: str) -> Interval:
        """Return the limits, UNLIMITED of a joint that has none."""
        part = self.parts.get('limit')
        if kind not in ('revolute', 'prismatic'):
            return UNLIMITED
        if part is None:
            other = ', or type continuous,' if kind == 'revolute' else ''
            raise self.fault(f'{kind}, but has no <limit>; lower and upper{other} expected')
        lower, upper = (
            self.read_number(f'limit: {end}', part.get(end, '0')) for end in ('lower', 'upper')
        )
        if lower > upper:
            raise self.fault(f'limit: lower {lower:g} is above upper {upper:g}')
        return lower, upper

    def read_mimic(self) -> Mimic | None:
        """Return what the joint follows, None if it moves of itself."""
        part = self.parts.get('mimic')
        if part is None:
            return None
        if not part.get('joint'):
            raise self.fault('mimic: has no joint')
        return Mimic(
            part.get('joint', ''),
            self.read_number('mimic: multiplier', part.get('multiplier', '1')),
            self.read_number('mimic: offset', part.get('offset', '0')),
        )

    def read_number(self, what: str, text: str) -> float:
        """Return a finite number."""
        if not NUMBER.fullmatch(text.strip()):
            raise self.fault(f'{what}: {describe_value(text)} given, a number expected')
        number = float(text)
        if not math.isfinite(number):
            raise self.fault(f'{what}: {text.strip()} given, a finite number expected')
        return number
