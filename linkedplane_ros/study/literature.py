# SPDX-License-Identifier: Apache-2.0
"""Numbers of others: measured and modelled moment arms of the deltoid, and the thesis's tables.

Sources, licences and limits: linkedplane_ros/literature/README.md. The files are in mm and deg;
what is returned here is in m and rad.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np

from ..muscle.parts import METRES
from ..types import Floats, Point

HEADS = ('anterior', 'middle', 'posterior')
RHYTHM = '+r'  # ends the name of a model whose scapula follows the arm
OWN_PREFIX = 'LP'  # begins the names of this project's model in the table of models


@dataclass(frozen=True, eq=False)
class AngleCurve:
    """A quantity over a motion's angle."""

    angles: Floats
    """(k,) rad, increasing"""
    values: Floats
    """(k,) m; a moment arm is positive where shortening carries the motion on."""


MotionCurves = Mapping[tuple[str, str], AngleCurve]
"""By head and motion."""


@dataclass(frozen=True)
class PrintedPoint:
    """An attachment as the thesis prints it."""

    s: float
    point: Point
    """m"""
    erratum: str
    """What is wrong with the row; empty if nothing is."""


@cache
def measured_arms() -> MotionCurves:
    """Return the moment arms that Ackland et al. 2008 measured, in flexion and abduction."""
    return _curves(read_rows('ackland2008_deltoid_moment_arms.csv'), 'head', 'moment_arm_mm')


@cache
def published_curves(quantity: str = 'moment_arm_mm') -> Mapping[str, MotionCurves]:
    """Return curves of published models, by the model's name; LP ... are this project's.

    The angle is glenohumeral; with RHYTHM in the name it is that of the arm against the thorax.

    Parameters
    ----------
    quantity
        'moment_arm_mm' or 'length_mm': a quantity of the table. The curves are in m and rad.
    """
    table = [
        row for row in read_rows('published_models_deltoid.csv') if row['quantity'] == quantity
    ]
    for row in table:
        row['motion'] = row['motion'].split(' ')[0]
    names = [n for n in table[0] if n not in ('motion', 'part', 'angle_deg', 'quantity')]
    return {name: _curves(table, 'part', name) for name in names}


def published_models() -> list[str]:
    """Return the names of the published models that are not this project's."""
    return [name for name in published_curves() if not name.startswith(OWN_PREFIX)]


@cache
def printed_positions(table: str) -> tuple[PrintedPoint, ...]:
    """Return the rows of the thesis's Table '6.2.1' (origins) or '6.2.2' (insertions)."""
    return tuple(
        PrintedPoint(
            float(row['s']),
            (
                METRES['mm'] * float(row['x_mm']),
                METRES['mm'] * float(row['y_mm']),
                METRES['mm'] * float(row['z_mm']),
            ),
            row['erratum'],
        )
        for row in read_rows('xu_tables_6_2.csv')
        if row['table'] == table
    )


def read_rows(file: str) -> list[dict[str, str]]:
    """Return the rows of one of the package's tables of literature."""
    place = resources.files('linkedplane_ros') / 'literature' / file
    return list(csv.DictReader(place.read_text(encoding='utf-8').splitlines()))


def _curves(table: list[dict[str, str]], head: str, value: str) -> MotionCurves:
    points: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in table:
        key = row[head], row['motion']
        angle = math.radians(float(row['angle_deg']))
        points.setdefault(key, []).append((angle, METRES['mm'] * float(row[value])))
    return {key: AngleCurve(*np.array(rows).T) for key, rows in points.items()}
