"""A MarkerArray as it comes over the wire: CDR bytes to arrays, without a message for each point.

rclpy takes six times as long to make its messages: too long for the rate of a screen.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from ...types import Floats

ENCAPSULATION = 4  # bytes before the message; alignment counts from behind them
# visualization_msgs/Marker
CYLINDER, SPHERE, LINE_STRIP, LINE_LIST, SPHERE_LIST, TRIANGLE_LIST = 3, 2, 4, 5, 7, 11
ADD, DELETE, DELETE_ALL = 0, 2, 3


@dataclass(frozen=True, eq=False)
class Marker:
    """What is drawn of a visualization_msgs/Marker; lengths in m."""

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


def markers(message: bytes) -> list[Marker]:
    """Return the markers of a serialised MarkerArray; ValueError if it is none."""
    try:
        reader = Reader(message)
        return [reader.marker() for _ in range(reader.count())]
    except (struct.error, IndexError, ValueError) as error:
        raise ValueError(f'not a serialised MarkerArray: {error}') from None


class Reader:
    """Reads plain CDR (XCDR version 1) from its beginning to its end."""

    def __init__(self, message: bytes) -> None:
        """Take the byte order from the encapsulation header."""
        order = '<' if message[1] & 1 else '>'
        self._body = message[ENCAPSULATION:]  # alignment counts from here
        self._at = 0
        self._count = struct.Struct(order + 'I')
        self._head = struct.Struct(order + '3i')
        self._look = struct.Struct(order + '10d4f')
        self._reals, self._singles = order + 'f8', order + 'f4'

    def count(self) -> int:
        """Return the length of what follows."""
        at = self._at + 3 & ~3
        self._at = at + 4
        return int(self._count.unpack_from(self._body, at)[0])

    def skip(self) -> None:
        """Pass over a string, or a sequence of bytes."""
        size = self.count()
        self._at += size

    def text(self) -> str:
        """Return a string."""
        size = self.count()
        start, self._at = self._at, self._at + size
        return self._body[start : self._at - 1].decode()

    def rows(self, kind: str, size: int, width: int) -> Floats:
        """Return a sequence of rows of `width` numbers of so many bytes each."""
        count = self.count()
        if not count:
            return np.empty((0, width))
        start = -(-self._at // size) * size
        self._at = start + count * width * size
        found = np.frombuffer(self._body, kind, count * width, start)
        return found.reshape(count, width).astype(np.float64)

    def marker(self) -> Marker:
        """Return a marker."""
        self._at = (self._at + 3 & ~3) + 8  # the stamp
        self.skip()  # the frame
        namespace = self.text()
        start = self._at + 3 & ~3
        number, kind, action = self._head.unpack_from(self._body, start)
        start = start + 12 + 7 & ~7
        look = np.array(self._look.unpack_from(self._body, start))
        self._at = start + 96 + 9  # a lifetime, and whether the frame is locked
        points = self.rows(self._reals, 8, 3)
        colours = self.rows(self._singles, 4, 4)
        self.skip()  # a texture
        self._at = (self._at + 3 & ~3) + 8
        for _ in range(3):
            self.skip()
        self.rows(self._singles, 4, 2)
        for _ in range(4):  # a text, a mesh
            self.skip()
        self._at += 1
        place, turn, scale, colour = look[:3], look[3:7], look[7:10], look[10:]
        return Marker(namespace, number, kind, action, place, turn, scale, colour, points, colours)
