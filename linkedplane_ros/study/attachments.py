"""Where the muscle is attached: the bands, the whole span of s, and the thesis's own tables."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..model import BroadMuscle
from ..model_file import METRES, model_file
from .literature import PrintedPoint, printed_positions

Floats = npt.NDArray[np.float64]

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


def of_bands(name: str | Path) -> Attachments:
    """Return the attachments of a model's bands."""
    first, last, count = _bands(name)
    return _at(name, np.linspace(first, last, count))


def of_whole_span(name: str | Path, muscle: BroadMuscle) -> Attachments:
    """Return the attachments over all of s; for any but the published deltoid, from band to band.

    Only there it is known that the polynomials hold from s = 0 to 1 (thesis ch. 5).
    """
    first, last, _ = (0.0, 1.0, 0) if is_published(muscle) else _bands(name)
    return _at(name, np.linspace(first, last, SPAN))


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


def positions(name: str | Path, table: str) -> list[Position]:
    """Return the thesis's Table '6.2.1' (origins) or '6.2.2' (insertions), done again.

    ValueError unless the model has as many bands as the table.
    """
    ours, names = of_bands(name), BroadMuscle.load(name).band_names
    points = ours.origins if table == '6.2.1' else ours.insertions
    return [
        Position(band, s, (x, y, z), printed)
        for band, s, (x, y, z), printed in zip(
            names, ours.s.tolist(), points.tolist(), printed_positions(table), strict=True
        )
    ]


def _bands(name: str | Path) -> tuple[float, float, int]:
    bands = model_file(name).section('bands')
    span = bands.section('s')
    return span.number('first'), span.number('last'), len(bands.names('names'))


def _at(name: str | Path, s: Floats) -> Attachments:
    file = model_file(name)
    metres = file.section('units').choice('length', METRES)
    origins, insertions = file.curve('origin', s), file.curve('insertion', s)
    return Attachments(s, metres * origins, metres * insertions)
