# SPDX-License-Identifier: Apache-2.0
"""The colours of the heads and their bands, the same in every picture."""

from __future__ import annotations

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Colour

# Okabe and Ito's palette: distinct in print and to colour-blind readers
HEAD_COLOURS = (
    (0.84, 0.37, 0.00),
    (0.00, 0.62, 0.45),
    (0.00, 0.45, 0.70),
    (0.80, 0.47, 0.65),
    (0.94, 0.89, 0.26),
    (0.34, 0.71, 0.91),
)
SHARED = (0.45, 0.45, 0.45)  # what belongs to several heads
LUMINANCE = np.array((0.299, 0.587, 0.114))  # weights of red, green, blue (ITU-R BT.601)
DARKEST, ALONE, LIGHTEST = 0.12, 0.4, 0.68  # greys of a head's first, only and last band


def head_colour(number: int) -> Colour:
    """Return the colour of a muscle's head by its number, from 0 on; six, then again the first."""
    return HEAD_COLOURS[number % len(HEAD_COLOURS)]


def head_colours(muscle: BroadMuscle) -> list[Colour]:
    """Return each band's colour, (n): that of its head."""
    colours = {head.name: head_colour(i) for i, head in enumerate(muscle.heads)}
    return [colours[muscle.find_head(band)] for band in muscle.band_names]


def sphere_colours(muscle: BroadMuscle) -> dict[int, Colour]:
    """Return the colour of each obstacle sphere, by the first of the bands that share it."""
    colours = head_colours(muscle)
    return {
        first: colours[first] if len({colours[i] for i in bands}) == 1 else SHARED
        for first, bands in muscle.bands_by_sphere().items()
    }


def shades(colour: Colour, count: int) -> list[Colour]:
    """Return `count` shades of a colour, dark to light, with evenly spaced greys."""
    grey = float(LUMINANCE @ colour)
    greys = np.linspace(DARKEST, LIGHTEST, count).tolist() if count > 1 else [ALONE]
    red, green, blue = (np.interp(greys, (0.0, grey, 1.0), (0.0, c, 1.0)).tolist() for c in colour)
    return list(zip(red, green, blue, strict=True))


def band_shades(muscle: BroadMuscle) -> list[Colour]:
    """Return each band's colour, (n): its head's, from dark to light within the head."""
    colours: dict[str, Colour] = {}
    for number, head in enumerate(muscle.heads):
        shades_of_head = shades(head_colour(number), len(head.bands))
        colours.update(zip(head.bands, shades_of_head, strict=True))
    return [colours[band] for band in muscle.band_names]
