# SPDX-License-Identifier: Apache-2.0
"""Interference: which band enters which bone sphere, where and by how much."""

from __future__ import annotations

from ...drawing.units import DEGREES, MILLIMETRES
from ...solver.states import WrapState
from ..interference import (
    FRAME_READINGS,
    PRINTED,
    REVERSED_Z,
    Checks,
    check_experiments,
)
from ..pictures import charts, poses
from ..subject import Subject
from .parts import Cell, Chapter, PicturePart, TablePart

ALTERNATIVE = f"""
    Erratum 9 names an alternative reading: the z axis of the obstacle spheres' moving frame
    reversed, as a cross product with its factors swapped would give. It is read in two ways here:
    only *{REVERSED_Z}* (y as it was; the frame is then left-handed), which fits the erratum's
    words best, though *nearly clears bands 1 to 6* is not true of bands 5 and 6 in flexion; and
    with y = z cross x taken literally, so that y is reversed, too.
    Neither keeps the bands out of bone.
"""
LOST = """
    Three of the thesis's six spheres are lost (erratum 4) and not made up here; `--spheres FILE`
    takes them.
"""


def interference_chapter(subject: Subject) -> Chapter:
    """Return the chapter on interference."""
    names = ', '.join(subject.muscle.interference_names)
    if not names:
        return Chapter('Interference', ['The model has no interference spheres.'])
    readings = {PRINTED: subject}
    if subject.is_published:
        readings |= {
            name: subject.with_frame_reading(name) for name in FRAME_READINGS if name != PRINTED
        }
    checked = {name: check_experiments(each.experiments) for name, each in readings.items()}
    pictured = {
        name: (readings[name], checked[name]) for name in (PRINTED, REVERSED_Z) if name in checked
    }
    further = '' if subject.spheres is None else f'; those of `{subject.spheres}` among them'
    return Chapter('Interference', [
        f"""
        A band interferes where any part of its path, straight or curved, touches or enters a sphere
        that stands for bone (thesis ch. 5). The least distance of the whole path from each centre
        is computed in closed form. Spheres: {names}{further}. The arm at the side is the first pose
        of each motion and counts with each, so that 26 poses are 24 different ones.
        """,
        *([LOST] if subject.is_published and subject.spheres is None else []),
        *([_verdict_text(checked[PRINTED]), ALTERNATIVE] if subject.is_published else []),
        _summary_table(checked),
        _band_table(checked),
        PicturePart(
            'interference_depths',
            """How far bands pass under the surface of bone: mm of the deepest entry of each band at
            each pose; below it, small, the numbers of the spheres entered.""",
            lambda: charts.depths_figure({name: each for name, (_, each) in pictured.items()}),
        ),
        PicturePart(
            'interference_where',
            """Where: black is the part of a band within bone, white dots are the points nearest to
            the centres of the spheres that it enters; S4 is sphere 4.""",
            lambda: poses.entries_figure(pictured),
        ),
        _entry_table(checked),
    ])  # fmt: skip


def _verdict_text(checks: Checks) -> str:
    """Return what the printed parameters do, in a paragraph."""
    entries = checks.entries
    deepest = max(entries, key=lambda each: each.depth)
    straight = sum(each.wrap != WrapState.WRAPPED for each in entries)
    return f"""
        **The thesis says that no band enters an interference sphere. With its printed parameters
        {len(entries)} of {checks.count} checks find one that does, at {checks.poses_entered} of
        {checks.poses} poses, by up to {MILLIMETRES * deepest.depth:.1f} mm** ({deepest.band} into
        {deepest.sphere} at {DEGREES * deepest.angle:.0f} deg of {deepest.motion}). {straight} of
        these entries are of bands that touch no obstacle: the straight line between their printed
        attachments passes through bone.
    """


def _summary_table(checked: dict[str, Checks]) -> TablePart:
    rows: list[tuple[Cell, ...]] = []
    for name, checks in checked.items():
        entries = checks.entries
        deepest = max((each.depth for each in entries), default=None)
        rows.append(
            (name, checks.count, len(entries), checks.poses, checks.poses_entered,
             None if deepest is None else MILLIMETRES * deepest,
             *(sum(each.sphere == sphere for each in entries) for sphere in checks.spheres))
        )  # fmt: skip
    spheres = next(iter(checked.values())).spheres
    return TablePart(
        'interference_summary', 'Interference by reading of the printed parameters',
        ('reading', 'checks', 'entries', 'poses', 'poses_with_entries', 'deepest_mm',
         *(f'entries_of_{sphere}' for sphere in spheres)), rows,
    )  # fmt: skip


def _band_table(checked: dict[str, Checks]) -> TablePart:
    bands = next(iter(checked.values())).experiments[0].states.solver.muscle.band_names
    rows: list[tuple[Cell, ...]] = []
    for k, band in enumerate(bands):
        cells: list[Cell] = []
        for checks in checked.values():
            deepest = MILLIMETRES * float(checks.deepest_of_bands[k])
            cells += [int(checks.entries_of_bands[k]), deepest if deepest >= 0.0 else None]
        rows.append((band, *cells))
    columns = [
        f'{name.replace(",", "").replace(" ", "_")}_{quantity}'
        for name in checked for quantity in ('entries', 'deepest_mm')
    ]  # fmt: skip
    return TablePart('interference_by_band', 'Entries and the deepest one of each band',
                 ('band', *columns), rows)  # fmt: skip


def _entry_table(checked: dict[str, Checks]) -> TablePart:
    rows: list[tuple[Cell, ...]] = [
        (name, each.motion, round(DEGREES * each.angle), each.band, each.sphere,
         MILLIMETRES * each.depth, *(MILLIMETRES * x for x in each.point),
         WrapState(each.wrap).name.lower())
        for name, checks in checked.items() for each in checks.entries
    ]  # fmt: skip
    return TablePart(
        'interference_entries', 'Every entry, with the point of the path that lies deepest',
        ('reading', 'motion', 'angle_deg', 'band', 'sphere', 'depth_mm', 'x_mm', 'y_mm', 'z_mm',
         'wrap_state'), rows, visible=False,
    )  # fmt: skip
