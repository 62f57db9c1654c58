# SPDX-License-Identifier: Apache-2.0
"""The units that people read; everything before a picture is in m, rad and s."""

from __future__ import annotations

import math

MILLIMETRES = 1e3  # in a metre
DEGREES = 180.0 / math.pi  # in a radian
