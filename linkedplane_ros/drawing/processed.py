# SPDX-License-Identifier: Apache-2.0
"""A processed recording as arrays: what an output of `linkedplane process` holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..types import Bytes, Floats


@dataclass(frozen=True, eq=False)
class ProcessedRecording:
    """A recording and the muscle's states: m frames, n bands; NaN where there is no state."""

    title: str
    heads: Mapping[str, tuple[str, ...]]
    """Each head's bands, in order."""
    bands: tuple[str, ...]
    """(n)"""
    coordinates: tuple[str, ...]
    """(3)"""
    times: Floats
    """(m,) s"""
    angles: Floats
    """(m, 3) rad"""
    lengths: Floats
    """(m, n) m"""
    arms: Floats
    """(m, n, 3) m, positive: shortening turns the joint in the coordinate's positive direction."""
    wrap: Bytes
    """(m, n) WrapState of each band."""
