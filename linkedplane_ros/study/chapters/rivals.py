# SPDX-License-Identifier: Apache-2.0
"""The rivals: what the thesis says of independent bands, measured, and what each method costs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ...drawing.units import MILLIMETRES
from ...rivals.breadth import Breadth, compare
from ...rivals.cost import FINITE_ELEMENTS, Cost, cost
from ...rivals.methods import LINKED
from ..pictures import rivals as rivals_chart
from ..subject import Subject
from .parts import Cell, Chapter, PicturePart, TablePart

RANDOM_SWEEPS = 12
JUMP = 1.0  # mm: more is a jump, and no rounding or kink
SAME = 0.01  # of linked planes' figure: no worse than that
PER_DEGREE = MILLIMETRES * math.pi / 180.0  # m/rad as mm/deg
PER_CENT = 100.0
MICROSECONDS = 1e6

INTRODUCTION = """
    The thesis sets linked planes against independent bands: straight lines, via points, and the
    obstacle sets of Garner and Pandy (2000). It says that these slip off their obstacles or slip
    quickly round them, that they ignore each other, and that linked planes keep adjacent bands
    together (ch. 1, 3 and 7). Here each is a path model of its own, on the same attachments.
    **Nobody has published obstacles of the rivals for this muscle**: two rules choose them here
    (below), and others would give other results. What is measured is defined in
    `linkedplane_ros/rivals/breadth.py`: *move*, the farthest that the middle of a band moves from a
    pose to the next, 0.5 deg on; *slip*, how fast it moves as the joint turns, all but the fastest
    hundredth; *jumps* of a length or a moment vector; *spacing* of neighbours at a quarter, half
    and three quarters of the bands, and *breadth* at half of them, over those with the arm at the
    side; *crossed*, poses with neighbours in reverse order. Where an end of a band lies inside its
    obstacle it has no path: moves and jumps leave that out, so those who are often inside look
    smoother than they are.
"""


VERDICT = """
    In short: that independent bands *jump* and let *gaps* open wider is confirmed by the cylinders,
    the double cylinder and, in its moment arms, the sphere-capped cylinder, not by all; that they
    *slip* faster is true of bands round spheres and caps, not of straight lines, via points or
    cylinders; linked bands *cross*, too, away from the thesis's own motions; and linked planes do
    **not** keep the muscle's *breadth* better: most rivals keep more of it.
"""


@dataclass(frozen=True)
class Claim:
    """A claim of the thesis, and the measure that it is put to; more of it is worse."""

    words: str
    unit: str
    worse: Callable[[Breadth], float]
    scale: float
    least: float
    """Below it there is none."""


CLAIMS = (
    Claim('independent bands slip quickly', 'mm/deg', lambda each: each.slip, PER_DEGREE, 0.0),
    Claim('they leave their place at once', 'mm in 0.5 deg', lambda each: each.move, MILLIMETRES,
          0.0),
    Claim('lengths jump', 'mm', lambda each: each.length_jump, MILLIMETRES, JUMP),
    Claim('moment arms jump', 'mm', lambda each: each.moment_jump, MILLIMETRES, JUMP),
    Claim('neighbours cross', '% of poses', lambda each: each.crossed, PER_CENT, 0.0),
    Claim('breadth is lost', '% lost', lambda each: 1.0 - each.breadth_least, PER_CENT, 0.0),
    Claim('gaps open', 'widest over that at the side', lambda each: each.spacing_most, 1.0, 0.0),
)  # fmt: skip


def rivals_chapter(subject: Subject) -> Chapter:
    """Return the chapter on the rivals."""
    if len(subject.muscle.band_names) < 2:
        return Chapter('Rivals', ['The muscle has a single band, which has no breadth to keep.'])
    breadths = compare(subject.muscle, sweeps=RANDOM_SWEEPS)
    return Chapter('Rivals', [
        INTRODUCTION,
        _claim_table(breadths),
        VERDICT,
        PicturePart(
            'rivals',
            """Each method over the thesis's motions, over the whole range of each coordinate,
            and over straight motions between random poses of the range.""",
            lambda: rivals_chart.rivals_figure(breadths),
        ),
        _breadth_table(breadths),
        _obstacle_table(breadths),
        f"""
        What a configuration takes, all bands, lengths and moment vectors, measured as this report
        was made, the methods taking turns; and, as published, {FINITE_ELEMENTS}.
        """,
        _cost_table(cost(subject.muscle)),
    ])  # fmt: skip


def _claim_table(breadths: Sequence[Breadth]) -> TablePart:
    """Return, for each claim and set of motions, how many rivals do worse than linked planes."""
    rows: list[tuple[Cell, ...]] = []
    for claim in CLAIMS:
        for motion in dict.fromkeys(each.motion for each in breadths):
            values = {
                each.method: claim.scale * claim.worse(each)
                for each in breadths if each.motion == motion
            }  # fmt: skip
            values = {name: v if v > claim.least else 0.0 for name, v in values.items()}
            linked = values.pop(LINKED)
            worse = [name for name, value in values.items() if value > (1.0 + SAME) * linked]
            worst = max(values, key=values.__getitem__)
            rows.append(
                (claim.words, claim.unit, motion, linked, f'{len(worse)} of {len(values)}',
                 worst, values[worst], _verdict(len(worse), len(values)))
            )  # fmt: skip
    return TablePart(
        'rivals_claims', "What the thesis says of independent bands, and how many of the rivals' "
        'do worse than linked ones (the same to 1 % counts as no worse)',
        ('claim', 'measured_as', 'motions', 'linked_planes', 'rivals_that_do_worse', 'worst_rival',
         'worst', 'borne_out'), rows, digits=2,
    )  # fmt: skip


def _verdict(worse: int, of: int) -> str:
    return 'no' if not worse else 'yes' if worse == of else 'by some'


def _breadth_table(breadths: Sequence[Breadth]) -> TablePart:
    rows: list[tuple[Cell, ...]] = [
        (each.method, each.motion, each.poses, MILLIMETRES * each.move,
         PER_DEGREE * each.slip,
         MILLIMETRES * each.length_jump, MILLIMETRES * each.moment_jump,
         each.spacing_least, each.spacing_most, each.breadth_least, each.breadth_most,
         PER_CENT * each.crossed, PER_CENT * each.wrapped, PER_CENT * each.inside,
         PER_CENT * each.in_bone, MILLIMETRES * each.deepest)
        for each in breadths
    ]  # fmt: skip
    return TablePart(
        'rivals', 'Each method and set of motions (slip in mm/deg; shares in per cent)',
        ('method', 'motions', 'poses', 'move_mm', 'slip', 'length_jump_mm', 'moment_jump_mm',
         'spacing_least', 'spacing_most', 'breadth_least', 'breadth_most', 'poses_crossed',
         'bands_wrapped', 'bands_inside_their_obstacle', 'poses_in_bone',
         'deepest_in_bone_mm'), rows, digits=2,
    )  # fmt: skip


def _obstacle_table(breadths: Sequence[Breadth]) -> TablePart:
    rows: list[tuple[Cell, ...]] = list(
        dict.fromkeys((each.method, each.obstacles) for each in breadths)
    )
    return TablePart('rivals_obstacles', 'Their obstacles', ('method', 'obstacles'), rows)


def _cost_table(breadths: Sequence[Cost]) -> TablePart:
    rows: list[tuple[Cell, ...]] = [
        (each.method, MICROSECONDS * each.one_call, MICROSECONDS * each.batch) for each in breadths
    ]
    return TablePart(
        'cost', 'Time for a configuration', ('method', 'one_call_us', 'in_a_batch_us'), rows,
    )  # fmt: skip
