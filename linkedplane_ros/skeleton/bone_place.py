# SPDX-License-Identifier: Apache-2.0
"""The place of a bone's frame in its link, as a user writes it: LINK@X,Y,Z,ROLL,PITCH,YAW."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import SkeletonError, describe_value
from ..types import Point, Triple

Origin = tuple[Point, Triple]
"""Where a frame stands in a link, as a URDF has it: x, y, z, m, and roll, pitch, yaw, rad."""


def split_place(bone: str, text: str, links: Sequence[str]) -> tuple[str, Origin | None]:
    """Return the link that a text names, and where the bone's frame stands in it.

    Parameters
    ----------
    bone
        For the message.
    text
        A link's name, or LINK@X,Y,Z,ROLL,PITCH,YAW.
    links
        The names that there are; a link may have an @ in its name.

    Returns
    -------
    link : str
        Its name, whether there is such a link or not.
    place : Origin or None
        None: the text does not say.

    Raises
    ------
    SkeletonError
        For anything but 6 finite numbers after the @.
    """
    link, at, numbers = text.rpartition('@')
    if text in links or not at:
        return text, None
    try:
        values = [float(each) for each in numbers.split(',')]
    except ValueError:
        values = []
    if len(values) != 6 or not np.isfinite(values).all():
        raise SkeletonError(
            f'bone_links: {bone}: {describe_value(text)} given, LINK or '
            'LINK@X,Y,Z,ROLL,PITCH,YAW (m, rad) expected'
        )
    x, y, z, roll, pitch, yaw = values
    return link, ((x, y, z), (roll, pitch, yaw))
