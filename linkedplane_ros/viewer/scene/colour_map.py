"""A colour for a number with a sign, even to the eye: from blue over grey to orange.

The way is two straight lines in Oklab (B. Ottosson, "A perceptual color space for image
processing", 2020), where equal distances look equally far apart; grey stands for zero, and both
ends are as far from it and can be told apart by colour-blind readers.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...types import Bytes, Floats

# lightness and the two axes of colour: dark and light grounds set off all of the way, and a screen
# shows it
ZERO = np.array((0.74, 0.0, 0.0))
REACH = 0.24
BLUE, ORANGE = (
    ZERO + REACH * way / np.linalg.norm(way)
    for way in (np.array((-0.19, -0.03, -0.14)), np.array((-0.13, 0.12, 0.095)))
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


def oklab(places: npt.ArrayLike) -> Floats:
    """Return the Oklab colours (..., 3) of places -1..1 on the map."""
    t = np.clip(np.asarray(places, dtype=np.float64), -1.0, 1.0)[..., np.newaxis]
    return np.asarray(ZERO + np.where(t < 0.0, -t * (BLUE - ZERO), t * (ORANGE - ZERO)))


def screen(lab: Floats) -> Floats:
    """Return red, green and blue (..., 3) in 0..1 (sRGB) of Oklab colours, not cut off."""
    linear = (lab @ LMS.T) ** 3 @ LINEAR.T
    low = 12.92 * linear
    return np.asarray(
        np.where(
            linear <= 0.0031308, low, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
        )
    )


def colours(values: npt.ArrayLike, most: float) -> Bytes:
    """Return red, green and blue 0..255 (n, 3) of values from -most to most."""
    shown = screen(oklab(np.asarray(values, dtype=np.float64) / most))
    return np.rint(255.0 * np.clip(shown, 0.0, 1.0)).astype(np.uint8)


def round_up(value: float) -> float:
    """Return the first of 1, 2, 5, 10, 20 ... (with any power of ten) that is not less."""
    if value <= 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(
        step * power for step in (1.0, 2.0, 5.0, 10.0, 20.0) if step * power >= value * (1 - 1e-9)
    )


def legend(title: str, most: float, unit: str) -> str:
    """Return the map with its ends and zero as a piece of HTML."""
    stops = ','.join(
        'rgb({},{},{})'.format(*colour) for colour in colours(np.linspace(-1, 1, 13), 1.0).tolist()
    )
    ends = ''.join(
        f'<span>{value:+g}</span>' if value else '<span>0</span>' for value in (-most, 0, most)
    )
    return (
        f'<div style="padding:0 0.9em 0.6em;font-size:0.8em">{title}, {unit}'
        f'<div style="{BAR}background:linear-gradient(90deg,{stops})"></div>'
        f'<div style="display:flex;justify-content:space-between">{ends}</div></div>'
    )
