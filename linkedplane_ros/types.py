# SPDX-License-Identifier: Apache-2.0
"""The types that the whole package shares; each is defined only here."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Bytes = npt.NDArray[np.uint8]
"""Numbers 0 to 255: wrap states, colours, serialised messages."""
Stamps = npt.NDArray[np.int64]
"""Times in ns since the epoch."""

Triple = tuple[float, float, float]
"""A number for each of a convention's three coordinates."""
JointValues = tuple[float, ...]
"""A number for each of d coordinates: rad, or m of prismatic joints; or its speed."""
Point = tuple[float, float, float]
"""x, y, z along the axes of a frame, in the unit that its owner states."""
Colour = tuple[float, float, float]
"""Red, green and blue, 0 to 1."""
Interval = tuple[float, float]
"""The least and the greatest value."""
Intervals = tuple[Interval, ...]
