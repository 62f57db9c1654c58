# SPDX-License-Identifier: Apache-2.0
"""A colour for a number with a sign, in steps that look even: from blue over grey to orange.

The map is two straight lines in Oklab (B. Ottosson, "A perceptual color space for image
processing", 2020), where equal distances look equal; grey stands for zero, both ends are equally
far from it, and colour-blind readers can tell them apart.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...types import Bytes, Colour, Floats

# lightness and the two axes of colour: visible on dark and light grounds, and within sRGB
ZERO = np.array((0.74, 0.0, 0.0))
REACH = 0.24
BLUE, ORANGE = (
    ZERO + REACH * direction / np.linalg.norm(direction)
    for direction in (np.array((-0.19, -0.03, -0.14)), np.array((-0.13, 0.12, 0.095)))
)

LMS = np.array(
    (
        (1.0, 0.3963377774, 0.2158037573),
        (1.0, -0.1055613458, -0.0638541728),
        (1.0, -0.0894841775, -1.2914855480),
    )
)
LINEAR = np.array(
    (
        (4.0767416621, -3.3077115913, 0.2309699292),
        (-1.2684380046, 2.6097574011, -0.3413193965),
        (-0.0041960863, -0.7034186147, 1.7076147010),
    )
)

BAR = 'height:0.8em;border-radius:2px;'


def oklab(numbers: npt.ArrayLike) -> Floats:
    """Return the Oklab colours (..., 3) of numbers -1..1 on the map."""
    t = np.clip(np.asarray(numbers, dtype=np.float64), -1.0, 1.0)[..., np.newaxis]
    return np.asarray(ZERO + np.where(t < 0.0, -t * (BLUE - ZERO), t * (ORANGE - ZERO)))


def srgb(lab: Floats) -> Floats:
    """Return red, green and blue (..., 3) in 0..1 of Oklab colours, not clipped."""
    linear = (lab @ LMS.T) ** 3 @ LINEAR.T
    low = 12.92 * linear
    return np.asarray(
        np.where(
            linear <= 0.0031308, low, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
        )
    )


def map_colours(values: npt.ArrayLike, limit: float) -> Bytes:
    """Return red, green and blue, 0..255, (n, 3) of values from -limit to limit."""
    rgb = srgb(oklab(np.asarray(values, dtype=np.float64) / limit))
    return np.rint(255.0 * np.clip(rgb, 0.0, 1.0)).astype(np.uint8)


def round_up(value: float) -> float:
    """Return the least of 1, 2, 5, 10, 20 ... (or less than 1: 0.5, 0.2 ...) that is not below."""
    if value <= 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(
        step * power for step in (1.0, 2.0, 5.0, 10.0, 20.0) if step * power >= value * (1 - 1e-9)
    )


def css_colour(colour: Colour) -> str:
    """Return a colour as CSS has it."""
    red, green, blue = (round(255 * part) for part in colour)
    return f'rgb({red},{green},{blue})'


def legend_html(title: str, limit: float, unit: str) -> str:
    """Return the map with its ends and zero, as HTML."""
    stops = ','.join(
        'rgb({},{},{})'.format(*colour)
        for colour in map_colours(np.linspace(-1, 1, 13), 1.0).tolist()
    )
    ends = ''.join(
        f'<span>{value:+g}</span>' if value else '<span>0</span>' for value in (-limit, 0, limit)
    )
    return (
        f'<div style="padding:0 0.9em 0.6em;font-size:0.8em">{title}, {unit}'
        f'<div style="{BAR}background:linear-gradient(90deg,{stops})"></div>'
        f'<div style="display:flex;justify-content:space-between">{ends}</div></div>'
    )
