# SPDX-License-Identifier: Apache-2.0
"""Frames that hang on each other, as in /tf: where each is, by the newest transforms."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..joints.joint_state import Rejected
from ..types import Floats, Triple
from .motion import Place

Quaternion = tuple[float, float, float, float]  # x, y, z, w


class Transform(NamedTuple):
    """What a frame hangs on, and where it is there."""

    parent: str
    turn: Quaternion
    shift: Triple
    """m"""
    stamp: int
    """ns"""
    place: Place
    """The message that it came with."""
    static: bool
    """Whether it holds for all times."""


class FrameTree:
    """The newest transform of each frame: dynamic and static ones in one tree, as tf2 has them."""

    def __init__(self) -> None:
        """Begin without frames."""
        self._hung: dict[str, Transform] = {}

    def __contains__(self, frame: str) -> bool:
        return frame in self._hung

    def __getitem__(self, frame: str) -> Transform:
        return self._hung[frame]

    @property
    def names(self) -> list[str]:
        """All frames that have been met, sorted; those that others hang on, too."""
        parents = {each.parent for each in self._hung.values()}
        return sorted({*self._hung, *parents} - {''})

    def hang(self, frame: str, transform: Transform) -> None:
        """Take in a frame's transform, instead of an older one."""
        self._hung[frame] = transform

    def find_chain(self, frame: str) -> list[str]:
        """Return a frame and those that it hangs on, up to the one below the root.

        Raises
        ------
        Rejected
            If it hangs on itself, by whatever frames between ('loop').
        """
        chain: list[str] = []
        seen: set[str] = set()
        while frame in self._hung:
            chain.append(frame)
            seen.add(frame)
            frame = self._hung[frame].parent
            if frame in seen:
                loop = ' on '.join(map(repr, [*chain[chain.index(frame) :], frame]))
                raise Rejected('loop', f'frames hang in a loop: {loop}; a tree expected')
        return chain

    def find_root(self, frame: str) -> str:
        """Return the frame that it hangs on last, itself if on none; Rejected as `find_chain`."""
        chain = self.find_chain(frame)
        return self._hung[chain[-1]].parent if chain else frame

    def place_in_root(self, frame: str) -> tuple[Floats, Floats]:
        """Return where a frame stands in its root: R (3, 3), t (3,) m.

        Raises
        ------
        Rejected
            For a transform on the way that is none; its `frame` is the one at fault.
        """
        R, t = np.eye(3), np.zeros(3)
        for each in self.find_chain(frame):
            hung = self._hung[each]
            try:
                turn = rotation_from_quaternion(*hung.turn)
            except Rejected as error:
                raise MisplacedFrame(error, each) from None
            R, t = turn @ R, turn @ t + np.array(hung.shift)
        return R, t


class MisplacedFrame(Rejected):
    """A frame whose newest transform is none."""

    def __init__(self, error: Rejected, frame: str) -> None:
        """Keep the frame beside the reason."""
        super().__init__(error.reason, str(error))
        self.frame = frame


def rotation_from_quaternion(x: float, y: float, z: float, w: float) -> Floats:
    """Return the rotation (3, 3) of a quaternion; Rejected unless it has unit length."""
    size = x * x + y * y + z * z + w * w
    if not 0.99 < size < 1.01:
        raise Rejected('not_unit', f'quaternion ({x:g}, {y:g}, {z:g}, {w:g}): unit length expected')
    s = 2.0 / size
    return np.array(
        (
            (1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
            (s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)),
            (s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)),
        )
    )


def stamp_in_nanoseconds(stamp: Any) -> int:
    """Return a message's stamp in ns."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)
