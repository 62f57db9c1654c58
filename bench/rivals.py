# SPDX-License-Identifier: Apache-2.0
"""The same bands in other people's engines, unlinked: each takes its own shortest way round.

Both take n bands with spheres fixed to the ground (scapula) frame: origins, centres (n, 3) ground,
insertions (n, 3) humerus, radii (n,), m.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkedplane_ros.types import Floats

SIGNS = (1.0, -1.0, 1.0)  # flexion about x, abduction about -y, rotation about z


class MujocoBands:
    """Spatial tendons round sphere geoms; the humerus on a ball joint."""

    def __init__(self, origins: Floats, insertions: Floats, centres: Floats, radii: Floats) -> None:
        """Compile the model."""
        import mujoco

        self._mujoco = mujoco
        ground, humerus, tendons = [], [], []
        for i in range(len(radii)):
            ground.append(f'<site name="p{i}" pos="{format_vector(origins[i])}"/>')
            ground.append(
                f'<geom name="g{i}" type="sphere" size="{radii[i]:.17g}" '
                f'pos="{format_vector(centres[i])}" mass="0" contype="0" conaffinity="0"/>'
            )
            humerus.append(f'<site name="s{i}" pos="{format_vector(insertions[i])}"/>')
            tendons.append(
                f'<spatial><site site="p{i}"/><geom geom="g{i}"/><site site="s{i}"/></spatial>'
            )
        self._model = mujoco.MjModel.from_xml_string(
            f'<mujoco><worldbody>{"".join(ground)}<body><joint type="ball"/>'
            '<geom type="sphere" size="0.01" mass="1" contype="0" conaffinity="0"/>'
            f'{"".join(humerus)}</body></worldbody><tendon>{"".join(tendons)}</tendon></mujoco>'
        )
        self._data = mujoco.MjData(self._model)

    def set_pose(self, rotation: Floats) -> None:
        """Turn the humerus, (3, 3) humerus -> ground."""
        self._mujoco.mju_mat2Quat(self._data.qpos, np.ascontiguousarray(rotation).ravel())

    def update(self) -> None:
        """Compute what lengths and Jacobian take, and no more of forward kinematics."""
        self._mujoco.mj_kinematics(self._model, self._data)
        self._mujoco.mj_comPos(self._model, self._data)
        self._mujoco.mj_tendon(self._model, self._data)

    def solve(self, rotation: Floats) -> tuple[Floats, Floats]:
        """Return lengths (n,) and moment vectors (n, 3), m, ground axes."""
        self.set_pose(rotation)
        self.update()
        n = self._model.ntendon
        jacobian = np.zeros((n, 3))
        row_count, row_start = self._model.ten_J_rownnz, self._model.ten_J_rowadr
        for i in range(n):
            for k in range(row_start[i], row_start[i] + row_count[i]):
                jacobian[i, self._model.ten_J_colind[k]] = self._data.ten_J[k]
        return self._data.ten_length.copy(), -jacobian @ rotation.T


class OpenSimBands:
    """Path actuators round wrap spheres; flexion, abduction, rotation on a gimbal joint."""

    def __init__(self, origins: Floats, insertions: Floats, centres: Floats, radii: Floats) -> None:
        """Build the model."""
        import opensim

        opensim.Logger.setLevelString('Error')
        model = opensim.Model()
        ground = model.getGround()
        body = opensim.Body('humerus', 1.0, opensim.Vec3(0), opensim.Inertia(1))
        self._keep: list[Any] = []  # what the model points into
        zero = opensim.Vec3(0)
        joint = opensim.GimbalJoint('gh', ground, zero, zero, body, zero, zero)  # x, y, z in turn
        model.addBody(body)
        model.addJoint(joint)
        self._bands = []
        for i in range(len(radii)):
            sphere = opensim.WrapSphere()
            sphere.setName(f'sphere{i}')
            sphere.set_radius(float(radii[i]))
            sphere.set_translation(opensim.Vec3(*centres[i].tolist()))
            ground.addWrapObject(sphere)
            band = opensim.PathActuator()
            band.setName(f'band{i}')
            band.addNewPathPoint('p', ground, opensim.Vec3(*origins[i].tolist()))
            band.addNewPathPoint('s', body, opensim.Vec3(*insertions[i].tolist()))
            band.updGeometryPath().addPathWrap(sphere)
            model.addForce(band)
            self._bands.append(band)
            self._keep.append(sphere)
        self._model = model
        self._state = model.initSystem()
        self._coordinates = [joint.get_coordinates(k) for k in range(3)]
        self._keep += [body, joint]

    def solve(self, angles: Floats) -> tuple[Floats, Floats]:
        """Return lengths (n,) and moment arms (n, 3), m, at flexion, abduction, rotation in rad."""
        for coordinate, sign, angle in zip(self._coordinates, SIGNS, angles, strict=True):
            coordinate.setValue(self._state, sign * float(angle), False)
        self._model.realizePosition(self._state)
        paths = [band.getGeometryPath() for band in self._bands]
        lengths = np.array([path.getLength(self._state) for path in paths])
        arms = np.array(
            [[path.computeMomentArm(self._state, q) for q in self._coordinates] for path in paths]
        )
        return lengths, arms * SIGNS


def format_vector(vector: Floats) -> str:
    """Return a vector as MJCF writes it."""
    return ' '.join(f'{x:.17g}' for x in vector)
