# SPDX-License-Identifier: Apache-2.0
"""The published shoulder rhythms, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ..errors import LinkedPlaneError
from .rhythm import Coefficients, ConstantRatio, LinearRhythm, Rhythm


def _degrees(constant: float, plane: float, elevation: float, rest: float) -> Coefficients:
    return float(np.radians(constant)), plane, elevation, rest


def _tested(*figures: float) -> str:
    turn, mean, worst, shrug_turn, shrug_mean, shrug_worst = figures
    return (
        'one subject, rest taken from the first frame; mean error of the scapula, mean and worst '
        f'in band length of the deltoid: an abduction to 155 deg {turn:.1f} deg, {mean:.1f} mm, '
        f'{worst:.1f} mm; a shrug {shrug_turn:.1f} deg, {shrug_mean:.1f} mm, {shrug_worst:.1f} mm'
    )


_RHYTHMS: tuple[Rhythm, ...] = (
    ConstantRatio(
        'constant_ratio',
        'Inman, Saunders, Abbott 1944: 2 to 1 on the average',
        'raising the arm in any plane, on the average shoulder',
        (0.0, np.pi),
        _tested(14.1, 4.2, 18.6, 4.9, 1.4, 8.9),
        ratio=2.0,
    ),
    LinearRhythm(
        'de_groot_brand_2001',
        'de Groot, Brand 2001, Clin Biomech 16:735-743; coefficients as in two public models that '
        'agree (TechForParalysis, AnyBody); the paper itself was not seen',
        '10 subjects, 23 positions of the arm, loads up to 20 N',
        (0.0, np.pi),
        _tested(12.8, 3.5, 20.5, 5.5, 1.6, 9.6),
        (
            _degrees(-1.203, 0.140, -0.049, 0.901),
            _degrees(3.095, -0.079, 0.396, 0.414),
            _degrees(0.659, -0.028, 0.184, 0.886),
        ),
        (_degrees(-4.983, 0.120, -0.242, 0.851), _degrees(3.917, -0.046, 0.123, 0.493)),
    ),
    LinearRhythm(
        'mobl',
        'slopes of MoBL-ARMS 4.1 (Saul 2015) and MyoArm: those of de Groot and Brand without the '
        "plane, and 0.1025, not 0.123, for the clavicle's elevation (a slip in these models, kept)",
        'elevation alone, any plane',
        (0.0, 2.61799),
        _tested(10.7, 3.5, 18.0, 5.3, 1.5, 9.3),
        ((0.0, 0.0, -0.049, 1.0), (0.0, 0.0, 0.396, 1.0), (0.0, 0.0, 0.178, 1.0)),
        ((0.0, 0.0, -0.242, 1.0), (0.0, 0.0, 0.1025, 1.0)),
    ),
)
RHYTHMS: Mapping[str, Rhythm] = MappingProxyType({rhythm.name: rhythm for rhythm in _RHYTHMS})
"""The published rhythms by name."""


def rhythm_from(name: str) -> Rhythm:
    """Return a rhythm by its name, or the constant ratio that a number says.

    Raises
    ------
    LinkedPlaneError
        For another name, and for a ratio that is not a positive, finite number.
    """
    if name in RHYTHMS:
        return RHYTHMS[name]
    try:
        ratio = float(name)
    except ValueError:
        ratio = -1.0
    if not 0.0 < ratio < np.inf:
        raise LinkedPlaneError(
            f'rhythm: {name!r} given, one of {", ".join(RHYTHMS)} or a ratio above 0 expected'
        )
    return ConstantRatio(
        'constant_ratio', 'given as a number', 'unknown', (0.0, np.pi), '', ratio=ratio
    )
