# SPDX-License-Identifier: Apache-2.0
"""The stamps of a bag's messages, and which of them were never filled in."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from .poses import TF_TYPE

SECOND = 10**9  # ns: a clock that begins at 0 has gone on by less than this at its next message
OTHER_CLOCK = 5 * SECOND  # a stamp further from its recorded time is of another clock
HEADER = 4  # bytes of CDR before the message


def read_header_stamp(topic: str, kind: str, data: bytes) -> int | None:
    """Return the stamp of a message, ns, from its bytes; of transforms that of the first.

    None where there is none: of static transforms, which hold at all times, or of bytes too few.
    """
    place = HEADER + 4 if kind == TF_TYPE else HEADER  # a sequence has its length first
    if topic.endswith('/tf_static') or len(data) < place + 8:
        return None
    seconds, nanoseconds = struct.unpack_from('<iI' if data[1] & 1 else '>iI', data, place)
    return int(seconds) * SECOND + int(nanoseconds)


def find_unstamped(stamps: Sequence[int], following: int) -> list[int]:
    """Return the indices of stamps, ns, that are 0 because nobody filled them in.

    A 0 is one where the clock begins if the next other stamp is that of its first second; else it
    was not filled in.

    Parameters
    ----------
    stamps
        (k) ns, in recorded order.
    following
        The first stamp behind them that is not 0; 0: there is none.
    """
    found = []
    for k in range(len(stamps) - 1, -1, -1):
        if stamps[k]:
            following = stamps[k]
        elif not 0 < following < SECOND:
            found.append(k)
    return found[::-1]


def find_offset(stamp: int, time: int) -> int:
    """Return what is added to recorded times for the clock of a stamp, ns: 0 if it is the same."""
    offset = stamp - time
    return offset if abs(offset) > OTHER_CLOCK else 0
