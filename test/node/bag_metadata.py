# SPDX-License-Identifier: Apache-2.0
"""Recordings of which only the metadata is read."""

from __future__ import annotations

from pathlib import Path

import yaml


def write_metadata(folder: Path, *topics: str, **others: str) -> str:
    """Write what a bag says of itself: topics of joint states, and others with their type."""
    types = dict.fromkeys(topics, 'sensor_msgs/msg/JointState')
    types |= {f'/{name}': kind for name, kind in others.items()}
    listed = [{'topic_metadata': {'name': name, 'type': kind}} for name, kind in types.items()]
    facts = {'rosbag2_bagfile_information': {'topics_with_message_count': listed}}
    folder.mkdir()
    (folder / 'metadata.yaml').write_text(yaml.safe_dump(facts))
    return str(folder)
