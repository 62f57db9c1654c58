# SPDX-License-Identifier: Apache-2.0
"""Where the muscle is attached: its bands, the whole span of s, and the thesis's own tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..muscle.parts import METRES, Listed
from ..types import Floats, Point
from .literature import PrintedPoint, printed_positions

SPAN = 41  # points drawn of the whole span


@dataclass(frozen=True, eq=False)
class Attachments:
    """Origins (k, 3), scapula frame, and insertions (k, 3), humerus frame, m, at s (k,)."""

    s: Floats
    origins: Floats
    insertions: Floats


@dataclass(frozen=True)
class ComparedPosition:
    """A band's origin or insertion beside what the thesis prints for it; m."""

    band: str
    s: float
    point: Point
    printed: PrintedPoint

    @property
    def deviation(self) -> float:
        """The largest difference of a coordinate from the printed one, m."""
        return float(np.abs(np.subtract(self.point, self.printed.point)).max())


def band_attachments(muscle: BroadMuscle) -> Attachments:
    """Return the attachments of a muscle's bands."""
    return Attachments(muscle.definition.s_of_bands, muscle.origins, muscle.insertions)


def span_attachments(muscle: BroadMuscle) -> Attachments:
    """Return the attachments over the whole span of s.

    For the published deltoid it is known that the polynomials hold from s = 0 to 1 (thesis ch. 5);
    for any other muscle the span is from the first band to the last. Attachments that the model
    lists are those of the bands.
    """
    definition = muscle.definition
    curves = (*definition.origin, *definition.insertion)
    if any(isinstance(curve, Listed) for curve in curves):
        return band_attachments(muscle)
    first, last = (0.0, 1.0) if is_published(muscle) else definition.s_of_bands[[0, -1]].tolist()
    s = np.linspace(first, last, SPAN)
    points = METRES[definition.length] * np.array([curve.evaluate(s) for curve in curves])
    return Attachments(s, points[:3].T, points[3:].T)


def is_published(muscle: BroadMuscle) -> bool:
    """Return whether a muscle is the thesis's deltoid, exactly."""
    thesis = BroadMuscle.load('deltoid')
    return all(
        np.array_equal(getattr(muscle, field), getattr(thesis, field))
        for field in (
            'origins', 'insertions', 'sphere_centres', 'sphere_radii', 'plane_angles',
            'ground_point', 'humeral_point', 'reference_normal',
        )
    )  # fmt: skip


def compare_positions(muscle: BroadMuscle, table: str) -> list[ComparedPosition]:
    """Return a muscle's attachments beside those that the thesis prints.

    Parameters
    ----------
    muscle
        The published deltoid: as many bands as the table has.
    table
        '6.2.1', the origins, or '6.2.2', the insertions.
    """
    ours = band_attachments(muscle)
    points = ours.origins if table == '6.2.1' else ours.insertions
    return [
        ComparedPosition(band, s, (x, y, z), printed)
        for band, s, (x, y, z), printed in zip(
            muscle.band_names, ours.s.tolist(), points.tolist(), printed_positions(table),
            strict=True,
        )
    ]  # fmt: skip
