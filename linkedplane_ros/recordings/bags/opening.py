# SPDX-License-Identifier: Apache-2.0
"""Open a ROS 2 bag by the rosbags library."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...errors import RecordingError
from ...libraries import advise_install
from ..formats import BAGS, check_format


def open_bag(path: Path) -> Any:
    """Return an open reader of rosbags; RecordingError if the bag cannot be read."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise RecordingError(
            f'a recording needs the rosbags library: {advise_install("rosbags")}'
        ) from None
    if not path.exists():
        raise RecordingError(f'{path}: no such file or folder')
    check_format(path, BAGS)
    try:
        reader = AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY))
        reader.open()
    except Exception as error:  # a broken file breaks in many ways
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RecordingError(f'{path}: not a readable rosbag2: {text}') from None
    return reader
