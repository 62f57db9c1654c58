# SPDX-License-Identifier: Apache-2.0
"""Fidelity: the model beside measurements and published models; what agrees and what does not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ...drawing.units import DEGREES, MILLIMETRES
from ..experiments import HALF, MOTIONS, simulate_motions
from ..fidelity import (
    ANGLE_READINGS,
    AS_IS,
    THESIS_ARM,
    THESIS_LENGTH,
    TWO_THIRDS,
    AngleReading,
    Deviation,
    arm_deviations,
    length_deviations,
    mean_size,
    model_deviations,
)
from ..literature import published_models
from ..pictures import charts
from ..subject import Subject
from .parts import Cell, Chapter, PicturePart, TablePart

THIS = 'this model'
BACK = math.radians(-30.0)  # about the vertical: from the plane of the scapula to the body's
ELSEWHERE = """
    The available measurements are of the deltoid's anterior, middle and posterior heads; this model
    is not called a deltoid with heads of these names, so nothing is compared.
"""
ABOUT = """
    **Measured** are the moment arms of Ackland et al. 2008 (J Anat 213:383-390; 8 cadaver arms,
    tendon excursion): three heads, in flexion and abduction, not in scaption. One curve for each is
    available, without scatter, digitised by others to about 1 mm.

    The source of the numbers does not say whether its angle is glenohumeral or that of the arm
    against the thorax. So there are readings: the *angle as is*; *two thirds of it*, the
    glenohumeral share of an elevation by the usual 2 : 1; and, if the excursion was divided by that
    same larger angle, *arms by 3/2* as well. None of them is known to be right.

    A difference is modelled minus measured: the exact moment arm of the band that represents the
    head, at every 10 deg but the first as far as both go. A mean is that of sizes, over heads,
    motions and steps. **Each table names the scale**: none, or
    the thesis's half.
"""


def fidelity_chapter(subject: Subject) -> Chapter:
    """Return the chapter on fidelity."""
    if not subject.is_comparable:
        return Chapter('Fidelity', [ELSEWHERE])
    scales = {scale: replace(subject, scale=scale) for scale in (1.0, HALF)}
    ours = {
        (scale, reading): arm_deviations(each.experiments, reading, THIS)
        for scale, each in scales.items()
        for reading in ANGLE_READINGS
    }
    scaled = f"This model's are multiplied by {subject.scale:g}."
    return Chapter('Fidelity', [
        ABOUT,
        _head_table(ours),
        _thesis_table(scales),
        _model_table(ours),
        PicturePart(
            'fidelity_moment_arms',
            f"""Measured moment arms (grey) beside this model's (the bands that represent the heads)
            and those of published models. Open markers: with the shoulder rhythm; their angle is
            that of the arm against the thorax. {'' if subject.scale == 1.0 else scaled}""",
            lambda: charts.fidelity_figure(subject),
        ),
        _deviation_table(ours),
        *([_verdict_text(subject, ours)] if subject.is_published else []),
    ])  # fmt: skip


Ours = dict[tuple[float, AngleReading], list[Deviation]]


def _head_table(ours: Ours) -> TablePart:
    """Return mean and worst, unscaled, and the mean of halved moment arms, in two readings."""
    rows: list[tuple[Cell, ...]] = []
    for k, one in enumerate(ours[1.0, AS_IS]):
        cells: list[Cell] = []
        for reading in (AS_IS, TWO_THIRDS):
            whole, half = ours[1.0, reading][k], ours[HALF, reading][k]
            cells += [MILLIMETRES * x for x in (whole.mean, whole.worst, half.mean)]
        rows.append((one.head, one.motion, *cells))
    means = [
        MILLIMETRES * mean_size(ours[scale, reading])
        for reading in (AS_IS, TWO_THIRDS)
        for scale in (1.0, HALF)
    ]
    rows.append(('all', 'both', means[0], None, means[1], means[2], None, means[3]))
    quantities = ('mean_mm', 'worst_mm', 'mean_if_halved_mm')
    columns = [f'{name}_{each}' for name in ('as_is', 'two_thirds') for each in quantities]
    return TablePart(
        'fidelity_by_head', 'Moment arms of this model, minus the measured ones',
        ('head', 'motion', *columns), rows,
    )  # fmt: skip


def _thesis_table(scales: dict[float, Subject]) -> TablePart:
    """Return the thesis's own summary beside what its procedure gives here."""
    rows: list[tuple[Cell, ...]] = []
    for what, thesis, scale, cubic in (
        ('lengths', THESIS_LENGTH, 1.0, None),
        ('moment arms x 0.5, from cubics', THESIS_ARM, HALF, True),
        ('moment arms x 1, from cubics', None, 1.0, True),
        ('moment arms x 1, exact', None, 1.0, False),
    ):
        ran = scales[scale].experiments
        means = [
            mean_size(
                length_deviations(ran, reading, THIS)
                if cubic is None
                else arm_deviations(ran, reading, THIS, cubic)
            )
            for reading in (AS_IS, TWO_THIRDS)
        ]
        rows.append(
            (what, None if thesis is None else MILLIMETRES * thesis,
             *(MILLIMETRES * mean for mean in means))
        )  # fmt: skip
    return TablePart(
        'fidelity_thesis',
        "The thesis's summary (mean deviation from Kuechle et al. 1997; flexion, abduction and "
        'scaption) beside the same procedure here (from Ackland et al. 2008; flexion and '
        "abduction). Lengths begin with the model's own; the thesis's first ones are not printed",
        ('quantity', 'thesis_mm', 'here_as_is_mm', 'here_two_thirds_mm'), rows,
    )  # fmt: skip


def _model_table(ours: Ours) -> TablePart:
    """Return the mean deviation of every model in every reading."""
    published = {reading: model_deviations(reading) for reading in ANGLE_READINGS}
    rows: list[tuple[Cell, ...]] = [
        (
            f'{THIS} x {scale:g}',
            *(MILLIMETRES * mean_size(ours[scale, each]) for each in ANGLE_READINGS),
        )
        for scale in (1.0, HALF)
    ]
    for name in published_models():
        means = (
            [each for each in published[reading] if each.model == name]
            for reading in ANGLE_READINGS
        )
        rows.append((name, *(MILLIMETRES * mean_size(each) if each else None for each in means)))
    return TablePart(
        'fidelity_models',
        'Mean deviation of the moment arms of all models from the same measurement. With the '
        "rhythm (+r) the model's own angle is against the thorax: compared as it is, where the "
        'measured one is read so',
        ('model', 'as_is_mm', 'two_thirds_mm', 'two_thirds_x_1.5_mm'), rows,
    )  # fmt: skip


def _deviation_table(ours: Ours) -> TablePart:
    found: Iterable[tuple[str, Deviation]] = [
        *(
            (f'{each.model} x {scale:g}', each)
            for (scale, _), all_ in ours.items()
            for each in all_
        ),
        *((each.model, each) for reading in ANGLE_READINGS for each in model_deviations(reading)),
    ]
    rows: list[tuple[Cell, ...]] = [
        (name, each.reading.name, each.head, each.motion, len(each.differences),
         MILLIMETRES * each.mean, MILLIMETRES * each.worst, round(DEGREES * each.worst_angle))
        for name, each in found
    ]  # fmt: skip
    return TablePart(
        'fidelity_all', 'Every model, reading, head and motion',
        ('model', 'reading', 'head', 'motion', 'steps', 'mean_mm', 'worst_mm', 'at_deg'), rows,
        visible=False,
    )  # fmt: skip


def _verdict_text(subject: Subject, ours: Ours) -> str:
    """Return what agrees, what does not and what is unknown of the published deltoid."""
    readings = (AS_IS, TWO_THIRDS)
    turned = simulate_motions(subject.muscle, [motion.rotate(BACK) for motion in MOTIONS])
    planes = _join_mm(mean_size(arm_deviations(turned, each, THIS)) for each in readings)
    whole, half = (
        _join_mm(mean_size(ours[scale, each]) for each in readings) for scale in (1.0, HALF)
    )
    arms = [each for reading in readings for each in ours[1.0, reading]]
    lengths = [each for r in readings for each in length_deviations(subject.experiments, r, THIS)]

    def off(head: str, motion: str, found: Sequence[Deviation] = arms) -> str:
        return _join_mm(each.mean for each in found if (each.head, each.motion) == (head, motion))

    return f"""
        Two figures are those of the angle as is and of two thirds of it, moment arms unscaled.

        **What agrees**, within 12 mm from 10 deg on (13 mm before, where it is twice what was
        measured). The middle head in abduction ({off('middle', 'abduction')}), the anterior head in
        flexion ({off('anterior', 'flexion')}). What the thesis says of its own curves comes out: a
        posterior moment arm that is negative in early abduction and then rises nearly linearly,
        arched posterior lengths in abduction and scaption.

        **What does not.** The posterior head. In flexion its measured moment arm is that of an
        extensor throughout; the model's is smaller, fades and changes sign
        ({off('posterior', 'flexion')}; on the mean no published model here is farther off). In
        abduction it rises to 26 mm at 90 deg, the measured one to 1 mm
        ({off('posterior', 'abduction')}). The thesis says other things of Kuechle's measurement:
        that the magnitudes of the posterior head in flexion are very similar, and that the measured
        arm in abduction is positive and rises, where the model's is negative at first. There the
        two measurements disagree. The middle head in flexion is too steep, from -9 to 25 mm, where
        0 to 10 were measured ({off('middle', 'flexion')}). The anterior head in abduction is too
        large ({off('anterior', 'abduction')}; halved, the thesis counts it among the best matched).
        The mean deviation of halved moment arms is above the thesis's 7 mm; that of lengths meets
        its 8 mm, but hides the posterior one in flexion ({off('posterior', 'flexion', lengths)}).

        **Of the published models** MyoArm's DELT2 is known to be off, and MoBL's anterior arm has a
        spike of 28 mm at 70 deg of flexion: their means do not measure the care taken.

        **Halving** the moment arms takes the mean deviation from {whole} to {half}: it helps in the
        one reading and harms in the other. This measurement does not show whether it is
        right.

        **What is unknown.** The angle of the measurement. How the specimens compare with the very
        muscular man of the model, and how far they scatter. Which part of a head was measured: the
        bands of one head differ by up to {_spread(subject):.0f} mm. Kuechle 1997, Liu 1997 and Otis
        1994, to which the model was fitted or compared, are not available as numbers: agreement
        with them, and anything in scaption, is not tested.

        **Planes.** The thesis lays x laterally *in the plane of the scapula* and calls the turn
        about -y abduction; taken literally that is elevation in the plane of the scapula, and its
        scaption lies 30 deg before that. The measured planes are the body's. With all motions
        turned back by 30 deg about the vertical the mean deviation is {planes}, instead of {whole}:
        this explains little.
    """


def _spread(subject: Subject) -> float:
    """Return by how much moment arms, unscaled, of bands of one head differ at most, mm."""
    bands = subject.muscle.band_names
    of_heads = [[bands.index(band) for band in head.bands] for head in subject.muscle.heads]
    return MILLIMETRES * max(
        float(np.ptp(one.arms[:, columns], axis=1).max()) / subject.scale
        for one in subject.experiments
        for columns in of_heads
    )


def _join_mm(lengths: Iterable[float]) -> str:
    """Return lengths, m, as mm with 'and' between."""
    return f'{" and ".join(f"{MILLIMETRES * each:.1f}" for each in lengths)} mm'
