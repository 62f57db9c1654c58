"""How far modelled moment arms are from measured ones: ours, and those of published models.

The measurements are those of Ackland et al. 2008: flexion and abduction, three heads. Differences
are modelled less measured, at every 10 deg of the motion but the first (where nothing was measured)
as far as the measurement goes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..muscle.broad_muscle import BroadMuscle
from ..types import Floats
from .experiments import CUBIC, Experiment
from .literature import HEADS, RHYTHM, Curve, measured, published, rivals

SAME = 1e-9  # rad: rounding of angles that are the same
THESIS_LENGTH, THESIS_ARM = 8e-3, 7e-3  # m: the thesis's mean deviations, arms halved (ch. 6)


@dataclass(frozen=True)
class Reading:
    """What the angle of the measurement may be: its source does not say."""

    name: str
    angle: float
    """Glenohumeral angle per measured angle."""
    arm: float
    """Moment arm about the glenohumeral angle per measured moment arm."""

    def of(self, curve: Curve) -> Curve:
        """Return a measured curve over the glenohumeral angle."""
        return Curve(self.angle * curve.angles, self.arm * curve.values)


AS_IS = Reading('angle as is', 1.0, 1.0)  # glenohumeral
TWO_THIRDS = Reading('two thirds of it', 2.0 / 3.0, 1.0)  # against the thorax, scapula 1 : 2
# ... and the tendon's excursion was divided by that angle, too
BY_THORAX = Reading('two thirds, arms by 3/2', 2.0 / 3.0, 1.5)
READINGS = (AS_IS, TWO_THIRDS, BY_THORAX)


@dataclass(frozen=True, eq=False)
class Deviation:
    """A model's moment arms or lengths, of one head in one motion, less the measured ones."""

    model: str
    head: str
    motion: str
    reading: Reading
    angles: Floats
    """(k,) rad"""
    differences: Floats
    """(k,) m"""

    @property
    def mean(self) -> float:
        """The mean of the differences' sizes, m."""
        return float(np.abs(self.differences).mean())

    @property
    def worst(self) -> float:
        """The difference that is largest in size, m, with its sign."""
        return float(self.differences[np.abs(self.differences).argmax()])

    @property
    def worst_at(self) -> float:
        """The angle of the worst one, rad."""
        return float(self.angles[np.abs(self.differences).argmax()])


def is_comparable(muscle: BroadMuscle) -> bool:
    """Return whether a muscle is a deltoid of the three heads that were measured."""
    names = {head.name for head in muscle.heads}
    return 'deltoid' in muscle.name.lower() and names >= set(HEADS)


def mean_of(deviations: Iterable[Deviation]) -> float:
    """Return the mean size of all differences, m: over heads, motions and steps, as the thesis."""
    return float(np.abs(np.concatenate([each.differences for each in deviations])).mean())


def of_arms(
    experiments: Sequence[Experiment], reading: Reading, name: str, cubic: bool = False
) -> list[Deviation]:
    """Return the deviations of simulated moment arms: each head's representing band's.

    Exact moment arms, or the thesis's, from a cubic through the lengths.
    """
    return [
        _deviation(
            name, head, motion, reading,
            Curve(one.angles, (one.cubic_arms if cubic else one.arms)[:, one.column(head)]),
            reading.of(curve),
        )
        for one in experiments
        for (head, motion), curve in measured().items()
        if motion == one.motion.name
    ]  # fmt: skip


def of_published(reading: Reading) -> list[Deviation]:
    """Return the deviations of the published models' moment arms.

    The angle of a model with the shoulder rhythm is that of the arm against the thorax: it is
    compared as it is, and only where the measured angle is read so as well.
    """
    found = []
    for name in rivals():
        rhythm = name.endswith(RHYTHM)
        if rhythm and reading is AS_IS:
            continue
        for (head, motion), curve in measured().items():
            there = curve if rhythm else reading.of(curve)
            modelled = published()[name][head, motion]
            found.append(_deviation(name, head, motion, reading, modelled, there))
    return found


def of_lengths(experiments: Sequence[Experiment], reading: Reading, name: str) -> list[Deviation]:
    """Return the deviations of simulated lengths from those that measured moment arms give.

    The thesis's lengths at the start are not printed; the model's own are taken, so that excursions
    alone tell.
    """
    found = []
    for one in experiments:
        for (head, motion), curve in measured().items():
            if motion == one.motion.name:
                ours = Curve(one.angles, one.lengths[:, one.column(head)])
                there = lengths_of(reading.of(curve), start=float(ours.values[0]))
                found.append(_deviation(name, head, motion, reading, ours, there))
    return found


def lengths_of(arms: Curve, start: float) -> Curve:
    """Return the lengths, m, from `start` at 0 rad on, that moment arms over the angle give.

    A cubic through all of the moment arms is integrated (thesis ch. 5).
    """
    cubic = np.polynomial.Polynomial.fit(arms.angles, arms.values, CUBIC).integ()
    return Curve(arms.angles, start - (cubic(arms.angles) - cubic(0.0)))


def _deviation(
    model: str, head: str, motion: str, reading: Reading, modelled: Curve, there: Curve
) -> Deviation:
    """Compare at the modelled curve's angles, as far as the measured one goes; linear between."""
    q = modelled.angles
    within = (q > SAME) & (q >= there.angles[0] - SAME) & (q <= there.angles[-1] + SAME)
    wanted = np.interp(q[within], there.angles, there.values)
    return Deviation(model, head, motion, reading, q[within], modelled.values[within] - wanted)
