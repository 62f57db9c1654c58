# SPDX-License-Identifier: Apache-2.0
"""From a tree of joints to the arrays that the kernels read."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..joints.articulation import PRISMATIC
from ..joints.rotations import rotation_about
from ..types import Floats, Point, Triple
from .joint_tree import FIXED, Joint, JointTree
from .kinematics import NUMBERS, SLIDING, STILL, TURNING, Chain

X, Y, Z = np.eye(3)
SAME_FRAME = np.eye(3, 4)


def pack_tree(tree: JointTree, bones: Sequence[str]) -> Chain:
    """Return a tree as the kernel takes it, with links of it as bones, in their own frames."""
    joints = tree.order_joints()
    links = {tree.root: 0, **{joint.child: i + 1 for i, joint in enumerate(joints)}}
    numbers = {joint.name: i for i, joint in enumerate(tree.independent)}
    sources = [tree.find_source(joint) or ('', 0.0, 0.0) for joint in joints]
    parents = [links[joint.parent] for joint in joints]
    above = np.zeros((len(links), len(joints)), dtype=np.int64)  # the joints between root and link
    for i, parent in enumerate(parents):
        above[i + 1] = above[parent]
        above[i + 1, i] = 1
    places = [links[bone] for bone in bones]
    integers = [
        (parent, kind_number(joint), numbers.get(source, -1))
        for parent, joint, (source, _, _) in zip(parents, joints, sources, strict=True)
    ]
    floats = [
        [*place_in_link(joint.xyz, joint.rpy).ravel(), *unit_joint_axis(joint), factor, offset]
        for joint, (_, factor, offset) in zip(joints, sources, strict=True)
    ]
    return Chain(
        np.array(integers, dtype=np.int64).reshape(-1, 3),
        np.array(floats, dtype=np.float64).reshape(-1, NUMBERS),
        np.array(places, dtype=np.int64),
        np.repeat(SAME_FRAME[np.newaxis], len(bones), axis=0),
        above[places[1:]] - above[places[0]],
    )


def kind_number(joint: Joint) -> int:
    """Return how the kernel moves a joint."""
    if joint.kind == FIXED:
        return STILL
    return SLIDING if joint.kind == PRISMATIC else TURNING


def unit_joint_axis(joint: Joint) -> Floats:
    """Return the axis (3,) at a length of 1; any of a fixed joint."""
    if joint.kind == FIXED:
        return X
    largest = max(map(abs, joint.axis))  # or the squares may be out of range
    axis = np.array(joint.axis) / largest
    return axis / np.linalg.norm(axis)


def place_in_link(xyz: Point, rpy: Triple) -> Floats:
    """Return the pose (3, 4) of a URDF's origin: turned about fixed x, y and z."""
    roll, pitch, yaw = rpy
    rotation = rotation_about(Z, yaw) @ rotation_about(Y, pitch) @ rotation_about(X, roll)
    return np.column_stack([rotation, xyz])
