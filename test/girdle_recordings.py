# SPDX-License-Identifier: Apache-2.0
"""The poses of the girdle's bones against the thorax in the recordings of the folder shared."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from reference import Array
from scipy.spatial.transform import Rotation

from linkedplane_ros import JOINT_CONVENTIONS

RECORDINGS = 'girdle_abduction_mcap', 'girdle_shrug_mcap'
THORACIC = ('thorax', 'clavicle', 'scapula', 'humerus')
# the turns at rest, rad, from the head of shoulder_girdle.urdf
REST = np.radians([-29.9, 8.9, 0.0, 67.1, -4.7, 0.1])


def girdle_poses(bag: Path) -> dict[str, tuple[Array, Array]]:
    """Return (R, t), (m, 3, 3) and (m, 3) m, of each bone in a recording."""
    from rosbags.highlevel import AnyReader

    turns: dict[str, list[list[float]]] = {}
    places: dict[str, list[list[float]]] = {}
    with AnyReader([bag]) as reader:
        topics = [each for each in reader.connections if each.topic == '/tf']
        for connection, _, raw in reader.messages(topics):
            for each in reader.deserialize(raw, connection.msgtype).transforms:  # type: ignore[attr-defined]
                assert each.header.frame_id == 'thorax'
                turn, place = each.transform.rotation, each.transform.translation
                bone = each.child_frame_id
                turns.setdefault(bone, []).append([turn.x, turn.y, turn.z, turn.w])
                places.setdefault(bone, []).append([place.x, place.y, place.z])
    return {
        bone: (Rotation.from_quat(rows).as_matrix(), np.array(places[bone]))
        for bone, rows in turns.items()
    }


def angles_zyx(rotation: Array) -> Array:
    """Return the angles (a, b, c) of R(z, a) R(-y, b) R(x, c)."""
    return np.array([
        np.arctan2(rotation[1, 0], rotation[0, 0]),
        np.arcsin(rotation[2, 0]),
        np.arctan2(rotation[2, 1], rotation[2, 2]),
    ])  # fmt: skip


def angles_from_poses(pose: dict[str, tuple[Array, Array]]) -> Array:
    """Return the girdle's nine coordinates from the orientations of its bones in the thorax."""
    clavicle, scapula, humerus = (pose[bone][0] for bone in THORACIC[1:])
    sc, ac = angles_zyx(clavicle), angles_zyx(clavicle.T @ scapula)
    gh = JOINT_CONVENTIONS['isb_yxy'].angles(scapula.T @ humerus)
    return np.concatenate([np.concatenate([sc, ac]) - REST, gh])


def recorded_angles(bag: Path) -> Array:
    """Return the nine coordinates (m, 9) of the bundled girdle in a recording's poses."""
    poses = girdle_poses(bag)
    frames = range(len(poses['clavicle'][0]))
    return np.array([
        angles_from_poses({bone: (R[i], t[i]) for bone, (R, t) in poses.items()}) for i in frames
    ])  # fmt: skip


def recorded_joints(bag: Path) -> list[str]:
    """Return the names of the joints in a recording: those of the thoracoscapular model."""
    from rosbags.highlevel import AnyReader

    with AnyReader([bag]) as reader:
        topics = [each for each in reader.connections if each.topic == '/joint_states']
        _, _, raw = next(reader.messages(topics))
        return list(reader.deserialize(raw, topics[0].msgtype).name)  # type: ignore[attr-defined]
