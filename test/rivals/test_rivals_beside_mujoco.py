# SPDX-License-Identifier: Apache-2.0
"""The rivals' paths beside MuJoCo's: spheres and cylinders on either bone."""

from __future__ import annotations

from typing import Any

import numpy as np
from optional import requires
from random_bands import random_models, random_rotations
from reference import Array

from linkedplane_ros import WrapState
from linkedplane_ros.rivals import Bands, Cylinder, PathModel, Sphere

pytestmark = requires('mujoco')

STILL = np.eye(3)


def mujoco_paths(models: list[PathModel], sides: Array | None) -> Any:
    """Return MuJoCo's tendons of single spheres or cylinders; sides (n, 3), in the bone's frame."""
    import mujoco
    from rivals import MujocoBands, format_vector

    bodies: dict[str, list[str]] = {'scapula': [], 'humerus': []}
    tendons = []
    for i, model in enumerate(models):
        kind = 'cylinder' if isinstance(model, Cylinder) else 'sphere'
        axis = f'zaxis="{format_vector(model.axis)}"' if isinstance(model, Cylinder) else ''
        bodies['scapula'].append(f'<site name="p{i}" pos="{format_vector(model.origin)}"/>')
        bodies['humerus'].append(f'<site name="s{i}" pos="{format_vector(model.insertion)}"/>')
        bodies[model.bone].append(
            f'<geom name="g{i}" type="{kind}" size="{model.radius:.17g} 0.01" {axis} '
            f'pos="{format_vector(model.centre)}" mass="0" contype="0" conaffinity="0"/>'
        )
        side = ''
        if sides is not None:
            bodies[model.bone].append(f'<site name="o{i}" pos="{format_vector(sides[i])}"/>')
            side = f'sidesite="o{i}"'
        tendons.append(
            f'<spatial><site site="p{i}"/><geom geom="g{i}" {side}/><site site="s{i}"/></spatial>'
        )

    class Paths(MujocoBands):
        def __init__(self) -> None:
            self._mujoco = mujoco
            self._model = mujoco.MjModel.from_xml_string(
                f'<mujoco><worldbody>{"".join(bodies["scapula"])}<body><joint type="ball"/>'
                '<geom type="sphere" size="0.01" mass="1" contype="0" conaffinity="0"/>'
                f'{"".join(bodies["humerus"])}</body></worldbody>'
                f'<tendon>{"".join(tendons)}</tendon></mujoco>'
            )
            self._data = mujoco.MjData(self._model)

    return Paths()


def beside(model: PathModel, R: Array) -> bool:
    """Return whether the obstacle is beside the line, not beyond one of its ends."""
    bone = R if model.bone == 'humerus' else STILL
    line = R @ model.insertion - model.origin
    off = bone @ model.centre - model.origin
    if isinstance(model, Cylinder):
        w = bone @ model.axis / np.linalg.norm(model.axis)
        line, off = line - (line @ w) * w, off - (off @ w) * w
    return bool(0.0 < off @ line < line @ line)


def check_against_mujoco(models: list[PathModel], sides: Array | None, R: Array) -> Array:
    """Compare lengths and moments where both have the rule; return the wrap states compared.

    MuJoCo wraps beyond half a turn, and hooks no line round an obstacle that is not beside it.
    """
    state = Bands(models).solve(R)
    lengths, moments = mujoco_paths(models, sides).solve(R)
    told = state.wrap <= WrapState.CLEAR
    told &= (state.wrap == WrapState.CLEAR) | np.array([beside(model, R) for model in models])
    # m: two closed forms of the same path
    np.testing.assert_allclose(state.lengths[told], lengths[told], rtol=0, atol=1e-9)
    np.testing.assert_allclose(state.moment_vectors[told], moments[told], rtol=0, atol=1e-9)
    return state.wrap[told]


def test_spheres_on_either_bone_are_mujocos() -> None:
    wrap = np.concatenate(
        [check_against_mujoco(random_models(Sphere, 300, seed), None, random_rotations(1, seed)[0])
         for seed in range(3)]
    )  # fmt: skip
    assert [(wrap == each).sum() > 50 for each in (WrapState.WRAPPED, WrapState.CLEAR)] == [1, 1]


def test_cylinders_on_either_bone_are_mujocos_on_the_same_side() -> None:
    wraps = []
    for seed in range(3):
        models, R = random_models(Cylinder, 300, seed), random_rotations(1, seed)[0]
        sides = []
        for model in models:
            bone = R if model.bone == 'humerus' else STILL
            line = bone.T @ (R @ model.insertion - model.origin)
            aside = np.cross(line, model.axis)
            sides.append(model.centre + aside / np.linalg.norm(aside))
        wraps.append(check_against_mujoco(models, np.array(sides), R))
    wrap = np.concatenate(wraps)
    assert [(wrap == each).sum() > 100 for each in (WrapState.WRAPPED, WrapState.CLEAR)] == [1, 1]
