# SPDX-License-Identifier: Apache-2.0
"""The messages of a bag, out of their bytes."""

from __future__ import annotations

from contextlib import suppress
from typing import Any


def deserialize_message(reader: Any, data: bytes, kind: str) -> Any:
    """Return a message from its bytes.

    Messages that rclpy serialised may end in up to 12 surplus bytes, which rosbags refuses; then
    they are cut off.
    """
    try:
        return reader.deserialize(data, kind)
    except Exception as error:
        for surplus in (4, 8, 12):
            with suppress(Exception):
                return reader.deserialize(data[:-surplus], kind)
        raise error
