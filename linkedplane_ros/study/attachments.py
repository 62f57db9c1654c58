"""Where the muscle is attached: the bands, the whole span of s, and the thesis's own tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..muscle.parts import METRES, Listed
from ..types import Floats
from .literature import PrintedPoint, printed_positions

SPAN = 41  # points drawn of the whole span
AGREES = 1e-8  # m: what the thesis's tables and its polynomials may differ by (errata 1 to 3)


@dataclass(frozen=True, eq=False)
class Attachments:
    """Origins (k, 3), scapula frame, and insertions (k, 3), humerus frame, m, at s (k,)."""

    s: Floats
    origins: Floats
    insertions: Floats


@dataclass(frozen=True)
class Position:
    """A band's origin or insertion beside what the thesis prints for it; m."""

    band: str
    s: float
    point: tuple[float, float, float]
    printed: PrintedPoint

    @property
    def off(self) -> float:
        """The largest difference of a coordinate from the printed one, m."""
        return float(np.abs(np.subtract(self.point, self.printed.point)).max())


def of_bands(muscle: BroadMuscle) -> Attachments:
    """Return the attachments of a muscle's bands."""
    return Attachments(muscle.definition.s_of_bands, muscle.origins, muscle.insertions)


def of_whole_span(muscle: BroadMuscle) -> Attachments:
    """Return the attachments over all of s; for any but the published deltoid, from band to band.

    Only there it is known that the polynomials hold from s = 0 to 1 (thesis ch. 5). Attachments
    that are listed are those of the bands.
    """
    definition = muscle.definition
    curves = (*definition.origin, *definition.insertion)
    if any(isinstance(curve, Listed) for curve in curves):
        return of_bands(muscle)
    first, last = (0.0, 1.0) if is_published(muscle) else definition.s_of_bands[[0, -1]].tolist()
    s = np.linspace(first, last, SPAN)
    points = METRES[definition.length] * np.array([curve.evaluate(s) for curve in curves])
    return Attachments(s, points[:3].T, points[3:].T)


def is_published(muscle: BroadMuscle) -> bool:
    """Return whether a muscle is, to the bit, the thesis's deltoid."""
    thesis = BroadMuscle.load('deltoid')
    return all(
        np.array_equal(getattr(muscle, field), getattr(thesis, field))
        for field in (
            'origins', 'insertions', 'sphere_centres', 'sphere_radii', 'plane_angles',
            'ground_point', 'humeral_point', 'reference_normal',
        )
    )  # fmt: skip


def positions(muscle: BroadMuscle, table: str) -> list[Position]:
    """Return the thesis's Table '6.2.1' (origins) or '6.2.2' (insertions), done again.

    ValueError unless the model has as many bands as the table.
    """
    ours = of_bands(muscle)
    points = ours.origins if table == '6.2.1' else ours.insertions
    return [
        Position(band, s, (x, y, z), printed)
        for band, s, (x, y, z), printed in zip(
            muscle.band_names, ours.s.tolist(), points.tolist(), printed_positions(table),
            strict=True,
        )
    ]  # fmt: skip
