# SPDX-License-Identifier: Apache-2.0
"""The thoracoscapular model's landmarks and OpenSim's poses of it, in the girdle's frames.

Landmarks and joint centres: ThoracoscapularShoulderModel.osim, opensim-org/opensim-core, commit
0435b081, its markers and joints; m, each in the frame of its body there (x anterior, y superior,
z lateral, on the right side).
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from linkedplane_ros.types import Floats

IJ = np.zeros(3)
C7 = np.array([-0.08990623421296981, 0.032756917796796417, 0.0])
T8 = np.array([-0.11115525679995039, -0.15443215563755253, 0.0])
PX = np.array([0.069763444038110495, -0.1643116134037392, 0.0])
SC = np.array([0.0063249765, 0.0069300434, 0.025464432])
AC_IN_CLAVICLE = np.array([-0.02924, 0.02024, 0.12005])
AC_IN_SCAPULA = np.array([-0.01357, 0.00011, -0.01523])
GH = np.array([-0.0095499448, -0.034001364, 0.0089968219])
AI = np.array([-0.115392862716, -0.116437282764, -0.0910237780043])
TS = np.array([-0.092186032542, -0.00248403755982, -0.105886839143])
AA = np.array([-0.0448068836244, 0.00346983559164, 0.01724282181])
EL = np.array([0.001346959352920416, -0.2856253572657072, 0.022248897937526969])
EM = np.array([0.001484159287009536, -0.2820152389959702, -0.044651095860843031])

GOLDEN = 'literature/girdle/chain_golden_poses.csv'  # in the folder shared


def unit(vector: Floats) -> Floats:
    return vector / np.linalg.norm(vector)


def frame(z: Floats, front: Floats) -> Floats:
    """Return the axes by rows, from z and a direction near y."""
    y = unit(front - (front @ z) * z)
    return np.array([np.cross(y, z), y, z])


THORAX = frame(unit((IJ + C7) / 2 - (PX + T8) / 2), PX - T8)
SCAPULA = frame(unit(TS - AI), np.cross(TS - AI, AA - AI))
HUMERUS = frame(unit(-(EL + EM) / 2), np.cross(-(EL + EM), EL - EM))


def clavicle_axes(rotation: Floats) -> Floats:
    """Return the clavicle's axes by rows, from its rotation in the thorax at rest."""
    x = unit(AC_IN_CLAVICLE)
    y = unit(np.cross(rotation.T @ THORAX[2], x))
    return np.array([x, y, np.cross(x, y)])


def golden_poses(shared: Path) -> list[dict[str, tuple[Floats, Floats]]]:
    """Return the poses as OpenSim has them: of each bone (R, t) in the thorax, the model's axes."""
    poses: dict[str, dict[str, tuple[Floats, Floats]]] = {}
    lines = [
        line
        for line in (shared / GOLDEN).read_text(encoding='utf-8').splitlines()
        if not line.startswith('#')
    ]
    for row in csv.DictReader(lines):
        w, x, y, z = (float(row[key]) for key in ('qw', 'qx', 'qy', 'qz'))
        v = np.array([x, y, z])
        across = np.cross(v, np.eye(3)).T  # v x
        rotation = np.eye(3) + 2.0 * (w * across + across @ across)
        point = np.array([float(row[key]) for key in 'xyz'])
        poses.setdefault(row['pose'], {})[row['bone']] = rotation, point
    return list(poses.values())


def girdle_poses(shared: Path) -> list[dict[str, tuple[Floats, Floats]]]:
    """Return the poses as the girdle has them: in the thorax's frame, of the bones' frames."""
    golden = golden_poses(shared)
    clavicle = clavicle_axes(golden[0]['clavicle'][0])
    axes = {'clavicle': clavicle, 'scapula': SCAPULA, 'humerus': HUMERUS}
    origins = {'clavicle': np.zeros(3), 'scapula': GH, 'humerus': np.zeros(3)}
    return [
        {
            bone: (THORAX @ R @ axes[bone].T, THORAX @ (t + R @ origins[bone] - IJ))
            for bone, (R, t) in pose.items()
        }
        for pose in golden
    ]
