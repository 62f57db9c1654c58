# SPDX-License-Identifier: Apache-2.0
"""A tree of links and joints: what a skeleton needs of a URDF, checked as a whole."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from ..errors import LONGEST, SkeletonError, describe_value
from ..joints.articulation import CONTINUOUS, PRISMATIC, REVOLUTE
from ..types import Interval, Point, Triple

FIXED = 'fixed'
KINDS = (REVOLUTE, CONTINUOUS, PRISMATIC, FIXED)
MOST_LINKS = 1000
UNLIMITED: Interval = (-math.inf, math.inf)


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its value is multiplier * the other's + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint between two links; its frame is that of its child link."""

    name: str
    kind: str
    """One of KINDS."""
    parent: str
    child: str
    xyz: Point = (0.0, 0.0, 0.0)
    """Where the joint's frame stands in the parent link, m."""
    rpy: Triple = (0.0, 0.0, 0.0)
    """How it is turned there, rad: R(z, yaw) R(y, pitch) R(x, roll)."""
    axis: Point = (1.0, 0.0, 0.0)
    """In the joint's frame, of any length but 0."""
    limits: Interval = UNLIMITED
    """rad, or m of a prismatic joint."""
    mimic: Mimic | None = None


@dataclass(frozen=True)
class JointTree:
    """Links and joints that hang together as a tree with one root.

    Raises
    ------
    SkeletonError
        One line that names the tree, the joint or link, and the reason.
    """

    name: str
    """What messages call it: a file, or where the text came from."""
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    """As the URDF lists them."""
    bones: tuple[str, ...] = ()
    """The links for which the URDF says it was made, the ground first; () where it does not say."""
    side: str = ''
    """The side of the body that it says it is of; empty where it does not say."""

    def __post_init__(self) -> None:
        if not self.links:
            raise self.fault('no link in it; at least one expected')
        if len(self.links) > MOST_LINKS:
            raise self.fault(f'{len(self.links)} links given, at most {MOST_LINKS} expected')
        self._check_names('link', self.links)
        self._check_names('joint', [joint.name for joint in self.joints])
        self._check_ends()
        self._check_tree()
        for joint in self.joints:
            self.find_source(joint)

    def fault(self, reason: str) -> SkeletonError:
        """Return the error for the tree."""
        return SkeletonError(f'{self.name}: {reason}')

    def joint_fault(self, joint: Joint, reason: str) -> SkeletonError:
        """Return the error for a joint of the tree."""
        return self.fault(f'joint {describe_value(joint.name)}: {reason}')

    @property
    def root(self) -> str:
        """The link that is no joint's child."""
        children = {joint.child for joint in self.joints}
        return next(link for link in self.links if link not in children)

    @property
    def independent(self) -> tuple[Joint, ...]:
        """The joints that move of themselves: neither fixed nor following another."""
        return tuple(each for each in self.joints if each.kind != FIXED and each.mimic is None)

    def order_joints(self) -> list[Joint]:
        """Return the joints that hang from the root, each behind the one of its parent."""
        below: dict[str, list[Joint]] = {}
        for joint in self.joints:
            below.setdefault(joint.parent, []).append(joint)
        ordered = list(below.get(self.root, ()))
        for joint in ordered:
            ordered += below.get(joint.child, ())
        return ordered

    def find_source(self, joint: Joint) -> tuple[str, float, float] | None:
        """Return the independent joint that a joint follows, with factor and offset.

        Itself with 1 and 0 where it follows none; None for a fixed joint.
        """
        if joint.kind == FIXED:
            return None
        factor, offset = 1.0, 0.0
        seen = {joint.name: None}  # in the order of the way
        at = joint
        while at.mimic is not None:
            followed = self._named.get(at.mimic.joint)
            if followed is None:
                missing = describe_value(at.mimic.joint)
                raise self.joint_fault(at, f'mimics {missing}, which is no joint of it')
            if followed.kind == FIXED:
                fixed = describe_value(followed.name)
                raise self.joint_fault(at, f'mimics {fixed}, which is fixed')
            if followed.name in seen:
                way = list(seen)
                circle = list_names(way[way.index(followed.name) :])
                raise self.fault(f'joints mimic each other in a circle: {circle}')
            offset += factor * at.mimic.offset
            factor *= at.mimic.multiplier
            seen[followed.name] = None
            at = followed
        if not (math.isfinite(factor) and math.isfinite(offset)):
            raise self.fault(
                f'joint {describe_value(joint.name)}: what it mimics gives no finite number'
            )
        return at.name, factor, offset

    @cached_property
    def _named(self) -> dict[str, Joint]:
        return {joint.name: joint for joint in self.joints}

    def _check_names(self, what: str, names: Sequence[str]) -> None:
        repeated = [name for name, count in Counter(names).items() if count > 1]
        if repeated:
            given = f'{what} {describe_value(repeated[0])}: given twice'
            raise self.fault(f'{given}; names that differ expected')

    def _check_ends(self) -> None:
        """Refuse joints whose links are not there, and links with two parents."""
        known = set(self.links)
        owner: dict[str, Joint] = {}
        for joint in self.joints:
            for end, link in ('parent', joint.parent), ('child', joint.child):
                if link not in known:
                    missing = describe_value(link)
                    raise self.joint_fault(joint, f'its {end} {missing} is no link of it')
            child = describe_value(joint.child)
            if joint.parent == joint.child:
                raise self.joint_fault(joint, f'parent and child are both {child}')
            if joint.child in owner:
                names = (describe_value(each.name) for each in (owner[joint.child], joint))
                both = ' and '.join(names)
                raise self.fault(
                    f'link {child}: the child of joints {both}, a loop; a tree expected'
                )
            owner[joint.child] = joint

    def _check_tree(self) -> None:
        """Refuse several roots, and joints that hang from none."""
        children = {joint.child for joint in self.joints}
        roots = [link for link in self.links if link not in children]
        if len(roots) > 1:
            raise self.fault(
                f'{len(roots)} links without a parent, {list_names(roots)}; one root expected'
            )
        if roots and len(self.order_joints()) == len(self.joints):
            return
        above = {joint.child: joint for joint in self.joints}
        hanging = {joint.name for joint in self.order_joints()} if roots else set()
        joint = next(each for each in self.joints if each.name not in hanging)
        circle: list[Joint] = []
        while joint not in circle:
            circle.append(joint)
            joint = above[joint.parent]
        names = [each.name for each in circle[circle.index(joint) :]]
        raise self.fault(f'joints {list_names(names)} form a loop; a tree expected')


def list_names(names: Iterable[str], most: int = 8) -> str:
    """Return names as messages list them: the first few, in quotes where they need them."""
    names = list(names)
    shown = ', '.join(name if is_plain(name) else describe_value(name) for name in names[:most])
    return shown + (f' and {len(names) - most} more' if len(names) > most else '')


def is_plain(name: str) -> bool:
    """Return whether a name can stand in a list without quotes."""
    return name.isprintable() and ' ' not in name and len(name) < LONGEST
