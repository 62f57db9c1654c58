# SPDX-License-Identifier: Apache-2.0
"""The poses of the girdle's bones against the thorax in the recordings of the folder shared."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from reference import Array
from scipy.spatial.transform import Rotation

RECORDINGS = 'girdle_abduction_mcap', 'girdle_shrug_mcap'


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
