# SPDX-License-Identifier: Apache-2.0
"""Bones that six joints each move anywhere, as a URDF, and the joints' values at given poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from linkedplane_ros.types import Floats

AXES = {'x': '1 0 0', 'y': '0 1 0', 'z': '0 0 1'}
SLIDES, TURNS = ('x', 'y', 'z'), ('z', 'y', 'x')


def write_urdf(ground: str, bones: Sequence[str], prefix: str = '') -> str:
    """Return a URDF: each bone slides along x, y, z of the ground, then turns about z, y, x."""
    parts = [f'<robot name="free"><link name="{prefix}{ground}"/>']
    for bone in bones:
        steps = [('prismatic', each) for each in SLIDES] + [('continuous', each) for each in TURNS]
        parent = prefix + ground
        for k, (kind, axis) in enumerate(steps):
            child = prefix + bone + (f'_{k}' if k < 5 else '')
            parts.append(
                f'<link name="{child}"/><joint name="{name_joint(bone, kind, axis)}" type="{kind}">'
                f'<parent link="{parent}"/><child link="{child}"/><axis xyz="{AXES[axis]}"/>'
                '<limit lower="-10" upper="10"/></joint>'
            )
            parent = child
    return ''.join((*parts, '</robot>'))


def name_joint(bone: str, kind: str, axis: str) -> str:
    return f'{bone}_{"slide" if kind == "prismatic" else "turn"}_{axis}'


def list_joints(bones: Sequence[str]) -> list[str]:
    """Return the names of the joints, in the order of the URDF."""
    return [
        name_joint(bone, kind, axis)
        for bone in bones
        for kind, axes in (('prismatic', SLIDES), ('continuous', TURNS))
        for axis in axes
    ]


def find_values(poses: Mapping[str, tuple[Floats, Floats]]) -> list[float]:
    """Return the values of the joints at poses (R, t) of the bones, m and rad."""
    return [
        value
        for R, t in poses.values()
        for value in (*t.tolist(), *Rotation.from_matrix(R).as_euler('ZYX').tolist())
    ]


def find_screws(poses: Mapping[str, tuple[Floats, Floats]]) -> dict[str, Floats]:
    """Return of each bone the screws (6, 6) of its joints, (w, v) by rows: axes through t."""
    found = {}
    for bone, (R, t) in poses.items():
        z, y, _ = Rotation.from_matrix(R).as_euler('ZYX')
        first = Rotation.from_euler('Z', z)
        axes = np.array([
            (0.0, 0.0, 1.0),
            first.apply((0.0, 1.0, 0.0)),
            (first * Rotation.from_euler('Y', y)).apply((1.0, 0.0, 0.0)),
        ])  # fmt: skip
        slides = np.hstack((np.zeros((3, 3)), np.eye(3)))
        found[bone] = np.vstack((slides, np.hstack((axes, np.cross(t, axes)))))
    return found
