# SPDX-License-Identifier: Apache-2.0
"""The names that a frame of the outputs may have."""

from __future__ import annotations

from ..errors import LinkedPlaneError, describe_value

LONGEST_FRAME = 255  # characters


def check_frame_name(owner: str, frame: str) -> None:
    """Refuse what is no name of a frame for tf2; `owner` is the option or parameter it is of."""
    given = f'{owner}: {describe_value(frame)} given'
    if not frame or frame.startswith('/'):
        fault = "starts with '/'" if frame else 'is empty'
        raise LinkedPlaneError(f'{given}, the name of a frame expected; tf2 has none that {fault}')
    if len(frame) > LONGEST_FRAME or not frame.isprintable() or ' ' in frame:
        raise LinkedPlaneError(
            f'{given} ({len(frame)} characters), at most {LONGEST_FRAME} characters that print, '
            'without blanks, expected'
        )
