"""The rivals: what the thesis says of independent bands, measured, and what each method costs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..rivals.breadth import Breadth, compare
from ..rivals.cost import FINITE_ELEMENTS, Cost, cost
from ..rivals.methods import LINKED
from . import rivals_chart
from .experiments import MILLIMETRES
from .parts import Cell, Chapter, Picture, Table
from .subject import Subject

WAYS = 6
JUMP = 1.0  # mm: more is a jump, and no rounding or kink
PER_DEGREE = MILLIMETRES * math.pi / 180.0  # m/rad as mm/deg
PER_CENT = 100.0
MICROSECONDS = 1e6

INTRODUCTION = """
    The thesis sets linked planes against independent bands: straight lines, via points, and the
    obstacle sets of Garner and Pandy (2000). It says that these slip off their obstacles or slip
    quickly round them, that they ignore each other, and that linked planes keep adjacent bands
    together (ch. 1, 3 and 7). Here each is a path model of its own, on the same attachments.
    **Nobody has published obstacles of the rivals for this muscle**: two rules choose them here
    (below), and other ones would do otherwise. What is measured is defined in
    `linkedplane_ros/rivals/breadth.py`: *slip*, how fast the middle of a band moves as the joint
    turns; *jumps* of a length or a moment vector from one pose to the next; *spacing* of neighbours
    at a quarter, half and three quarters of the bands, and *breadth* at half of them, over those
    with the arm at the side; *crossed*, poses with neighbours in reverse order.
"""


def chapter(subject: Subject) -> Chapter:
    """Return the chapter on the rivals."""
    if len(subject.muscle.band_names) < 2:
        return Chapter('Rivals', ['The muscle has a single band, which has no breadth to keep.'])
    found = compare(subject.muscle, ways=WAYS)
    return Chapter('Rivals', [
        INTRODUCTION,
        _verdict(found),
        Picture(
            'rivals',
            """Each method over the thesis's motions, over the whole range of each coordinate alone,
            and over straight ways between random poses of the range.""",
            lambda: rivals_chart.rivals(found),
        ),
        _breadth(found),
        _obstacles(found),
        f"""
        What a configuration takes, all bands, lengths and moment vectors, measured as this report
        was made, the methods taking turns; and, as published, {FINITE_ELEMENTS}.
        """,
        _cost(cost(subject.muscle)),
    ])  # fmt: skip


def _verdict(found: Sequence[Breadth]) -> str:
    """Return which of the thesis's claims these figures bear out, in a list."""
    by_method: dict[str, list[Breadth]] = {}
    for each in found:
        by_method.setdefault(each.method, []).append(each)
    linked = by_method.pop(LINKED)
    jumping = {
        method: max(MILLIMETRES * max(each.length_jump, each.moment_jump) for each in of)
        for method, of in by_method.items()
    }
    jumping = {method: jump for method, jump in jumping.items() if jump > JUMP}
    slips = {
        method: PER_DEGREE * max(each.slip for each in of)
        for method, of in by_method.items() if method not in jumping
    }  # fmt: skip
    fastest = max(slips, key=slips.__getitem__)
    least = min(each.breadth_least for each in linked)
    broader = [m for m, of in by_method.items() if min(one.breadth_least for one in of) > least]
    crossing = ', '.join(f'{PER_CENT * each.crossed:.1f} % ({each.motion})' for each in linked)
    jumps = '; '.join(f'{method} ({jump:.0f} mm)' for method, jump in jumping.items()) or 'none'
    return f"""
        * *Independent bands slip quickly*: the middle of a linked band moves by up to
          {PER_DEGREE * max(each.slip for each in linked):.1f} mm/deg; of the methods that do not
          jump, *{fastest}* is the fastest, {slips[fastest]:.1f} mm/deg.
        * *They jump*, in a length or a moment vector: {jumps}. Linked planes:
          {MILLIMETRES * max(max(each.length_jump, each.moment_jump) for each in linked):.1g} mm.
        * *Linked bands keep their order*: neighbours are crossed at {crossing} of the poses.
        * *Linked bands keep the muscle's breadth*: it falls to {least:.2f} of that with the arm at
          the side. Of the {len(by_method)} rivals, these keep more:
          {'; '.join(broader) or 'none'}.
    """


def _breadth(found: Sequence[Breadth]) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (each.method, each.motion, each.poses, PER_DEGREE * each.slip,
         MILLIMETRES * each.length_jump, MILLIMETRES * each.moment_jump,
         each.spacing_least, each.spacing_most, each.breadth_least, each.breadth_most,
         PER_CENT * each.crossed, PER_CENT * each.wrapped, PER_CENT * each.inside,
         PER_CENT * each.in_bone)
        for each in found
    ]  # fmt: skip
    return Table(
        'rivals', 'Each method and set of motions (slip in mm/deg; shares in per cent)',
        ('method', 'motions', 'poses', 'slip', 'length_jump_mm', 'moment_jump_mm', 'spacing_least',
         'spacing_most', 'breadth_least', 'breadth_most', 'poses_crossed', 'bands_wrapped',
         'bands_inside_their_obstacle', 'poses_in_bone'), rows, digits=2,
    )  # fmt: skip


def _obstacles(found: Sequence[Breadth]) -> Table:
    rows: list[tuple[Cell, ...]] = list(
        dict.fromkeys((each.method, each.obstacles) for each in found)
    )
    return Table('rivals_obstacles', 'Their obstacles', ('method', 'obstacles'), rows)


def _cost(found: Sequence[Cost]) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (each.method, MICROSECONDS * each.one_call, MICROSECONDS * each.batch) for each in found
    ]
    return Table(
        'cost', 'Time for a configuration', ('method', 'one_call_us', 'in_a_batch_us'), rows,
    )  # fmt: skip
