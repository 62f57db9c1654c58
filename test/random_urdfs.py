# SPDX-License-Identifier: Apache-2.0
"""URDFs of random trees, and MuJoCo's answers for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkedplane_ros import Skeleton
from linkedplane_ros.types import Floats

FOR_MUJOCO = (
    '<mujoco><compiler fusestatic="false" discardvisual="false" boundmass="0.001" '
    'boundinertia="0.000001"/></mujoco>'
)
KINDS = ('revolute', 'continuous', 'prismatic', 'fixed')


def link(name: str) -> str:
    return f'<link name="{name}"/>'


def joint(name: str, kind: str, parent: str, child: str, inside: str = '') -> str:
    limit = '' if '<limit' in inside or kind in ('fixed', 'continuous') else LIMIT
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'{inside}{limit}</joint>'
    )


LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


def robot(*parts: str) -> str:
    return f'<robot name="robot">{FOR_MUJOCO}{"".join(parts)}</robot>'


def random_urdf(seed: int, links: int = 8) -> str:
    """Return a tree of joints of all kinds with frames and axes anyhow, some of them mimics."""
    rng = np.random.default_rng(seed)
    joints = []
    free: list[str] = []
    for i in range(1, links):
        kind = KINDS[i % 4] if i < 5 else KINDS[rng.integers(4)]
        xyz, rpy, axis = (' '.join(map(repr, rng.normal(size=3).tolist())) for _ in range(3))
        inside = f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
        if kind != 'fixed' and free and rng.random() < 0.4:
            factor, offset = rng.normal(size=2).tolist()
            inside += f'<mimic joint="{rng.choice(free)}" multiplier="{factor}" offset="{offset}"/>'
        if kind != 'fixed':
            free.append(f'j{i}')  # also a mimic: one that follows it follows on
        joints.append(joint(f'j{i}', kind, f'l{rng.integers(i)}', f'l{i}', inside))
    order = rng.permutation(len(joints))
    return robot(*(link(f'l{i}') for i in range(links)), *(joints[i] for i in order))


class MujocoTree:
    """MuJoCo's reading of a URDF, its mimic joints led by the test."""

    def __init__(self, text: str, skeleton: Skeleton) -> None:
        import mujoco

        self._mujoco = mujoco
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.skeleton = skeleton
        self.joints = [each for each in skeleton.tree.joints if each.kind != 'fixed']

    def value(self, name: str, values: dict[str, float]) -> float:
        """Return the value of a joint; the definition of a mimic joint, read anew."""
        mimic = next(each for each in self.joints if each.name == name).mimic
        if mimic is None:
            return values[name]
        return mimic.multiplier * self.value(mimic.joint, values) + mimic.offset

    def set_values(self, q: Floats) -> None:
        values = dict(zip(self.skeleton.coordinates, q.tolist(), strict=True))
        for each in self.joints:
            self.data.qpos[self.model.joint(each.name).qposadr[0]] = self.value(each.name, values)
        self._mujoco.mj_kinematics(self.model, self.data)
        self._mujoco.mj_comPos(self.model, self.data)

    def body(self, link: str) -> Any:
        """Return MuJoCo's body of a link; the root may be the world."""
        names = [self.model.body(i).name for i in range(self.model.nbody)]
        return self.data.body(link if link in names else 'world')

    def pose(self, link: str, ground: str) -> Floats:
        """Return the (3, 4) pose of a link seen from another."""
        G, g = self.body(ground).xmat.reshape(3, 3), self.body(ground).xpos
        R, t = self.body(link).xmat.reshape(3, 3), self.body(link).xpos
        return np.column_stack([G.T @ R, G.T @ (t - g)])

    def screws(self, link: str, ground: str) -> Floats:
        """Return the (d, 6) screws of a link seen from another."""
        G, g = self.body(ground).xmat.reshape(3, 3), self.body(ground).xpos
        at = {}
        for each in link, ground:
            v, w = np.zeros((2, 3, self.model.nv))
            self._mujoco.mj_jac(self.model, self.data, v, w, g, self.body(each).id)
            at[each] = np.vstack([G.T @ w, G.T @ v])
        by_joint = (at[link] - at[ground]).T
        zeros = dict.fromkeys(self.skeleton.coordinates, 0.0)
        screws = []
        for name in self.skeleton.coordinates:
            screw = np.zeros(6)
            for each in self.joints:
                slope = self.value(each.name, {**zeros, name: 1.0}) - self.value(each.name, zeros)
                screw += slope * by_joint[self.model.joint(each.name).dofadr[0]]
            screws.append(screw)
        return np.array(screws)
