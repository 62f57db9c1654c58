# SPDX-License-Identifier: Apache-2.0
"""How far modelled moment arms are from measured ones: ours, and those of published models.

The measurements are those of Ackland et al. 2008: flexion and abduction, three heads. Differences
are modelled minus measured, at every 10 deg of the motion but the first (where nothing was
measured) as far as the measurement goes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats
from .experiments import CUBIC, Experiment
from .literature import HEADS, RHYTHM, AngleCurve, measured_arms, published_curves, published_models

ROUNDING = 1e-9  # rad: of equal angles
THESIS_LENGTH, THESIS_ARM = 8e-3, 7e-3  # m: the thesis's mean deviations, arms halved (ch. 6)


@dataclass(frozen=True)
class AngleReading:
    """One reading of the measured angle, whose source does not say what it is."""

    name: str
    angle: float
    """Glenohumeral angle per measured angle."""
    arm: float
    """Moment arm about the glenohumeral angle per measured moment arm."""

    def apply(self, curve: AngleCurve) -> AngleCurve:
        """Return a measured curve over the glenohumeral angle, if the reading is right."""
        return AngleCurve(self.angle * curve.angles, self.arm * curve.values)


AS_IS = AngleReading('angle as is', 1.0, 1.0)  # glenohumeral
TWO_THIRDS = AngleReading('two thirds of it', 2.0 / 3.0, 1.0)  # against the thorax, scapula 1 : 2
# ... and the tendon's excursion was divided by that angle, too
BY_THORAX = AngleReading('two thirds, arms by 3/2', 2.0 / 3.0, 1.5)
ANGLE_READINGS = (AS_IS, TWO_THIRDS, BY_THORAX)


@dataclass(frozen=True, eq=False)
class Deviation:
    """A model's moment arms or lengths, of one head in one motion, minus the measured ones."""

    model: str
    head: str
    motion: str
    reading: AngleReading
    angles: Floats
    """(k,) rad"""
    differences: Floats
    """(k,) m"""

    @property
    def mean(self) -> float:
        """The mean of the absolute differences, m."""
        return float(np.abs(self.differences).mean())

    @property
    def worst(self) -> float:
        """The largest difference by its size, m, with its sign."""
        return float(self.differences[np.abs(self.differences).argmax()])

    @property
    def worst_angle(self) -> float:
        """The angle of the worst difference, rad."""
        return float(self.angles[np.abs(self.differences).argmax()])


def is_comparable(muscle: BroadMuscle) -> bool:
    """Return whether a muscle is a deltoid of the three heads that were measured."""
    names = {head.name for head in muscle.heads}
    return 'deltoid' in muscle.name.lower() and names >= set(HEADS)


def mean_size(deviations: Iterable[Deviation]) -> float:
    """Return the mean absolute difference, m, over heads, motions and steps, as the thesis does."""
    return float(np.abs(np.concatenate([each.differences for each in deviations])).mean())


def arm_deviations(
    experiments: Sequence[Experiment], reading: AngleReading, name: str, cubic: bool = False
) -> list[Deviation]:
    """Return the deviations of simulated moment arms, of the bands that represent heads.

    Parameters
    ----------
    experiments
        What was simulated.
    reading
        What the measured angle is assumed to be.
    name
        Of the model.
    cubic
        Whether the moment arms are the thesis's, from a cubic through the lengths, or exact.
    """
    return [
        _deviation(
            name, head, motion, reading,
            AngleCurve(one.angles, (one.cubic_arms if cubic else one.arms)[:, one.column(head)]),
            reading.apply(curve),
        )
        for one in experiments
        for (head, motion), curve in measured_arms().items()
        if motion == one.motion.name
    ]  # fmt: skip


def model_deviations(reading: AngleReading) -> list[Deviation]:
    """Return the deviations of the published models' moment arms in a reading.

    The angle of a model with the shoulder rhythm is that of the arm against the thorax: its curves
    are compared as they are, and only where the measured angle is read so, too.
    """
    deviations = []
    for name in published_models():
        rhythm = name.endswith(RHYTHM)
        if rhythm and reading is AS_IS:
            continue
        for (head, motion), curve in measured_arms().items():
            there = curve if rhythm else reading.apply(curve)
            modelled = published_curves()[name][head, motion]
            deviations.append(_deviation(name, head, motion, reading, modelled, there))
    return deviations


def length_deviations(
    experiments: Sequence[Experiment], reading: AngleReading, name: str
) -> list[Deviation]:
    """Return the deviations of simulated lengths from those that measured moment arms give.

    The thesis does not print the lengths at the start; the model's own are taken, so that only
    excursions are compared.
    """
    deviations = []
    for one in experiments:
        for (head, motion), curve in measured_arms().items():
            if motion == one.motion.name:
                ours = AngleCurve(one.angles, one.lengths[:, one.column(head)])
                there = integrate_arms(reading.apply(curve), start=float(ours.values[0]))
                deviations.append(_deviation(name, head, motion, reading, ours, there))
    return deviations


def integrate_arms(arms: AngleCurve, start: float) -> AngleCurve:
    """Return the lengths that moment arms give: a cubic through them, integrated (thesis ch. 5).

    Parameters
    ----------
    arms
        m, over the angle.
    start
        The length at 0 rad, m.
    """
    cubic = np.polynomial.Polynomial.fit(arms.angles, arms.values, CUBIC).integ()
    return AngleCurve(arms.angles, start - (cubic(arms.angles) - cubic(0.0)))


def _deviation(
    model: str,
    head: str,
    motion: str,
    reading: AngleReading,
    modelled: AngleCurve,
    there: AngleCurve,
) -> Deviation:
    """Compare at the modelled curve's angles, as far as the measured one goes; linear between."""
    q = modelled.angles
    within = (q > ROUNDING) & (q >= there.angles[0] - ROUNDING) & (q <= there.angles[-1] + ROUNDING)
    wanted = np.interp(q[within], there.angles, there.values)
    return Deviation(model, head, motion, reading, q[within], modelled.values[within] - wanted)
