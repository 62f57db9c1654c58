# SPDX-License-Identifier: Apache-2.0
"""Recordings of which only the metadata is read."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import yaml


def write_metadata(folder: Path, *topics: str, empty: Collection[str] = (), **others: str) -> str:
    """Write what a bag says of itself: topics of joint states, and others with their type.

    Those that are `empty` have no messages.
    """
    types = dict.fromkeys(topics, 'sensor_msgs/msg/JointState')
    types |= {f'/{name}': kind for name, kind in others.items()}
    listed = [
        {
            'topic_metadata': {'name': name, 'type': kind},
            'message_count': 0 if name in empty else 601,
        }
        for name, kind in types.items()
    ]
    facts = {'rosbag2_bagfile_information': {'topics_with_message_count': listed}}
    folder.mkdir()
    (folder / 'metadata.yaml').write_text(yaml.safe_dump(facts))
    return str(folder)
