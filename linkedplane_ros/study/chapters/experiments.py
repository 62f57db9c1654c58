# SPDX-License-Identifier: Apache-2.0
"""The simulated experiments: tables and curves of lengths and moment arms, flexion moving."""

from __future__ import annotations

import numpy as np

from ...drawing.units import DEGREES, MILLIMETRES
from ...solver.states import WrapState
from ..experiments import Experiment
from ..pictures import animation, charts
from ..subject import Subject
from .parts import AnimationPart, Cell, Chapter, PicturePart, TablePart

UNSCALED = """
    No moment arm in this report is scaled unless it says so. (The thesis halves its simulated ones
    before it compares them with those of elderly cadavers; `--half` does.)
"""
SCALED = """
    **Moment arms of this model are multiplied by {:g}** in all tables and figures of this report
    that do not say otherwise, as the thesis does before it compares them with those of elderly
    cadavers. Lengths are not.
"""
ARMS = """
    Grey: measured (Ackland et al. 2008), over the measured angle as it is and over two thirds of
    it. The measurements that the thesis compares with are not available as numbers.
"""
LENGTHS = """
    Grey: what measured moment arms give (Ackland et al. 2008), by the thesis's way: a cubic through
    them, integrated, from the model's own first length; over the measured angle as it is and over
    two thirds of it.
"""
NONE = 'No measurement of these heads is available.'


def experiments_chapter(subject: Subject) -> Chapter:
    """Return the chapter on the experiments."""
    return Chapter('Experiments', [
        """
        From the arm at the side, every 10 deg: flexion to 80 deg about lateral (+x), abduction to
        90 deg about posterior (-y), scaption to 60 deg about the axis 30 deg lateral of posterior
        (sin 30, -cos 30, 0). The axes stay where they are in the scapula.

        Moment arms are about the motion's axis, r = -dL/dq: positive where shortening carries the
        motion on (flexor, abductor, elevator). *Exact* ones are analytic, the linked planes
        included; *cubic* ones are the thesis's: a cubic through the lengths at these poses, by
        least squares, differentiated. The thesis states no sign.
        """,
        SCALED.format(subject.scale) if subject.scale != 1.0 else UNSCALED,
        _span_text(subject),
        _head_table(subject),
        _cubic_table(subject),
        _band_table(subject),
        PicturePart(
            'e4_lengths',
            'E.4. Lengths, all bands of each head. ' + (LENGTHS if subject.is_comparable else NONE),
            lambda: charts.lengths_figure(subject),
        ),
        PicturePart(
            'e5_moment_arms',
            'E.5. Moment arms, all bands of each head. '
            + (ARMS if subject.is_comparable else NONE),
            lambda: charts.moment_arms_figure(subject),
        ),
        AnimationPart(
            'flexion',
            """Flexion from 0 to 80 deg and back, each band's plane drawn: the planes keep their
            angles to one another and turn together, with theta.""",
            lambda path: animation.write_animation(subject, path),
        ),
    ])  # fmt: skip


def _span_text(subject: Subject) -> str:
    """Return which lengths there are."""
    lengths = MILLIMETRES * np.concatenate(
        [
            one.lengths[:, one.column(head.name)]
            for one in subject.experiments
            for head in subject.muscle.heads
        ]
    )
    thesis = ' The thesis says 115 to 200 mm (erratum 10).' if subject.is_published else ''
    return (
        f'Lengths of the bands that represent the heads span {lengths.min():.0f} to '
        f'{lengths.max():.0f} mm.{thesis}'
    )


def _head_table(subject: Subject) -> TablePart:
    """Return lengths and moment arms of the bands that represent the heads."""
    heads = [head.name for head in subject.muscle.heads]
    rows: list[tuple[Cell, ...]] = []
    for one in subject.experiments:
        columns = [one.column(head) for head in heads]
        quantities = [one.lengths, one.arms, one.cubic_arms]
        for pose, angle in enumerate(one.angles.tolist()):
            values = [MILLIMETRES * float(each[pose, k]) for k in columns for each in quantities]
            rows.append((one.motion.name, round(DEGREES * angle), *values))
    names = [
        f'{head}_{quantity}_mm' for head in heads for quantity in ('length', 'arm', 'cubic_arm')
    ]
    return TablePart(
        'heads', 'Lengths and moment arms of the bands that represent the heads',
        ('motion', 'angle_deg', *names), rows,
    )  # fmt: skip


def _cubic_table(subject: Subject) -> TablePart:
    """Return what the thesis's way of differentiating does."""
    rows: list[tuple[Cell, ...]] = []
    for head in subject.muscle.heads:
        for one in subject.experiments:
            k = one.column(head.name)
            off = MILLIMETRES * (one.cubic_arms - one.arms)[:, k]
            worst = int(np.abs(off).argmax())
            rows.append(
                (head.name, one.motion.name, float(np.abs(off).mean()), float(off[worst]),
                 round(DEGREES * one.angles[worst]))
            )  # fmt: skip
    return TablePart(
        'cubic_less_exact', 'Moment arms from cubics, minus the exact ones',
        ('head', 'motion', 'mean_size_mm', 'worst_mm', 'at_deg'), rows,
    )  # fmt: skip


def _band_table(subject: Subject) -> TablePart:
    """Return every band at every pose."""
    return TablePart(
        'experiments', 'Every band at every pose',
        ('motion', 'angle_deg', 'theta_deg', 'band', 'head', 'length_mm', 'moment_arm_mm',
         'moment_arm_cubic_mm', 'wrap_state'),
        [row for one in subject.experiments for row in _band_rows(one)], visible=False,
    )  # fmt: skip


def _band_rows(one: Experiment) -> list[tuple[Cell, ...]]:
    muscle, cubic = one.states.solver.muscle, one.cubic_arms
    return [
        (
            one.motion.name,
            round(DEGREES * one.angles[pose]),
            DEGREES * float(one.states.theta[pose]),
            band,
            muscle.find_head(band),
            MILLIMETRES * float(one.lengths[pose, k]),
            MILLIMETRES * float(one.arms[pose, k]),
            MILLIMETRES * float(cubic[pose, k]),
            WrapState(one.states.wrap[pose, k]).name.lower(),
        )
        for pose in range(len(one.angles))
        for k, band in enumerate(muscle.band_names)
    ]
