# SPDX-License-Identifier: Apache-2.0
"""From the bytes of a MarkerArray (CDR) to arrays, without a message for each point.

rclpy takes six times as long to build its messages: too long for the rate of a screen.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from ...errors import LinkedPlaneError
from ...types import Floats

ENCAPSULATION = 4  # bytes before the message; alignment counts from behind them


@dataclass(frozen=True, eq=False)
class Marker:
    """The part of a visualization_msgs/Marker that is drawn; lengths in m."""

    namespace: str
    number: int
    kind: int
    action: int
    position: Floats
    """(3,)"""
    orientation: Floats
    """(4,) x y z w."""
    scale: Floats
    """(3,)"""
    colour: Floats
    """(4,) red green blue alpha in 0..1."""
    points: Floats
    """(k, 3) in the marker's own frame."""
    colours: Floats
    """(k, 4) of the points, or (0, 4)."""


def read_markers(message: bytes) -> list[Marker]:
    """Return the markers of a serialised MarkerArray; LinkedPlaneError for other bytes."""
    try:
        reader = CdrReader(message)
        return [reader.read_marker() for _ in range(reader.read_count())]
    except (struct.error, IndexError, ValueError) as error:
        raise LinkedPlaneError(f'not a serialised MarkerArray: {error}') from None


class CdrReader:
    """Reads plain CDR (XCDR version 1) from beginning to end."""

    def __init__(self, message: bytes) -> None:
        """Take the byte order from the encapsulation header."""
        order = '<' if message[1] & 1 else '>'
        self._body = message[ENCAPSULATION:]  # alignment counts from here
        self._offset = 0
        self._count = struct.Struct(order + 'I')
        self._head = struct.Struct(order + '3i')
        self._look = struct.Struct(order + '10d4f')
        self._reals, self._singles = order + 'f8', order + 'f4'

    def read_count(self) -> int:
        """Return the length of the string or sequence that follows."""
        start = self._offset + 3 & ~3
        self._offset = start + 4
        return int(self._count.unpack_from(self._body, start)[0])

    def skip_bytes(self) -> None:
        """Skip a string, or a sequence of bytes."""
        size = self.read_count()
        self._offset += size

    def read_text(self) -> str:
        """Return a string."""
        size = self.read_count()
        start, self._offset = self._offset, self._offset + size
        return self._body[start : self._offset - 1].decode()

    def read_rows(self, kind: str, size: int, width: int) -> Floats:
        """Return a sequence of rows (k, width) of numbers of `size` bytes each."""
        count = self.read_count()
        if not count:
            return np.empty((0, width))
        start = -(-self._offset // size) * size
        self._offset = start + count * width * size
        numbers = np.frombuffer(self._body, kind, count * width, start)
        return numbers.reshape(count, width).astype(np.float64)

    def read_marker(self) -> Marker:
        """Return a marker."""
        self._offset = (self._offset + 3 & ~3) + 8  # the stamp
        self.skip_bytes()  # the frame
        namespace = self.read_text()
        start = self._offset + 3 & ~3
        number, kind, action = self._head.unpack_from(self._body, start)
        start = start + 12 + 7 & ~7
        look = np.array(self._look.unpack_from(self._body, start))
        self._offset = start + 96 + 9  # a lifetime, and whether the frame is locked
        points = self.read_rows(self._reals, 8, 3)
        colours = self.read_rows(self._singles, 4, 4)
        self.skip_bytes()  # a texture
        self._offset = (self._offset + 3 & ~3) + 8
        for _ in range(3):
            self.skip_bytes()
        self.read_rows(self._singles, 4, 2)
        for _ in range(4):  # a text, a mesh
            self.skip_bytes()
        self._offset += 1
        if not all(np.isfinite(each).all() for each in (look, points, colours)):
            raise ValueError('finite numbers expected')
        return Marker(
            namespace,
            number,
            kind,
            action,
            look[:3],
            look[3:7],
            look[7:10],
            look[10:],
            points,
            colours,
        )
