# SPDX-License-Identifier: Apache-2.0
"""Open a ROS 2 bag: its folder with metadata.yaml, or one of its files."""

from __future__ import annotations

from pathlib import Path

from ...errors import RecordingError
from ...libraries import advise_install
from ..formats import BAGS, check_format
from .bag import Bag
from .messages import MessageReader


def open_bag(path: Path) -> Bag:
    """Return an open bag.

    Parameters
    ----------
    path
        Its folder, or one of its files.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    try:
        reader = MessageReader()
    except ImportError:
        raise RecordingError(
            f'a recording needs the rosbags library: {advise_install("rosbags")}'
        ) from None
    if not path.exists():
        raise RecordingError(f'{path}: no such file or folder')
    check_format(path, BAGS)
    try:
        bag = Bag(path, reader)
    except OSError as error:
        raise RecordingError(f'{path}: cannot be read: {error.strerror}') from None
    if bag.is_of_ros1():
        bag.close()
        raise RecordingError(
            f'{path}: an MCAP file of ROS 1; convert the .bag it is from with rosbags-convert'
        )
    return bag
