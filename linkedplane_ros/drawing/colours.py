"""The colours of the heads, the same in every picture."""

from __future__ import annotations

from ..muscle.broad_muscle import BroadMuscle
from ..types import Colour

# Okabe and Ito's palette: told apart in print and by colour-blind readers
HEAD_COLOURS = (
    (0.84, 0.37, 0.00),
    (0.00, 0.62, 0.45),
    (0.00, 0.45, 0.70),
    (0.80, 0.47, 0.65),
    (0.94, 0.89, 0.26),
    (0.34, 0.71, 0.91),
)
SHARED = (0.45, 0.45, 0.45)  # what belongs to several heads


def head_colours(muscle: BroadMuscle) -> list[Colour]:
    """Return each band's colour, (n): one for each head."""
    colours = {
        head.name: HEAD_COLOURS[i % len(HEAD_COLOURS)] for i, head in enumerate(muscle.heads)
    }
    return [colours[muscle.head_of(band)] for band in muscle.band_names]


def sphere_colours(muscle: BroadMuscle) -> dict[int, tuple[float, float, float]]:
    """Return the colour of each obstacle sphere, by the first of the bands that share it."""
    colours = head_colours(muscle)
    return {
        first: colours[first] if len({colours[i] for i in bands}) == 1 else SHARED
        for first, bands in muscle.sharers().items()
    }
