# SPDX-License-Identifier: Apache-2.0
"""The model under study: its attachments, obstacle spheres and looks, and the thesis's errata."""

from __future__ import annotations

from ...drawing.units import MILLIMETRES
from ..attachments import compare_positions
from ..pictures import poses
from ..subject import Subject
from .parts import Cell, Chapter, Part, PicturePart, TablePart

ERRATA: tuple[tuple[int, str, str, str], ...] = (
    (1, 'Table 6.1.2', 'B12 is printed as a copy of A12 (30621.7357335389)',
     '-43.7196566, which Table 6.2.2 gives back to 1e-5 mm'),
    (2, 'Table 6.2.1', 's = 0.662: y and z have the wrong signs', 'the polynomial'),
    (3, 'Table 6.2.2', 'z is shifted by a row at s = 0.569 and 0.662', 'the polynomial'),
    (4, 'Table 5.1', 'spheres 1 to 3 have one number in all four columns, a negative radius',
     'left out; `--spheres FILE` takes them, should they be found'),
    (5, 'Tables 6.3', 'the captions of radius and phi stand apart from their rows',
     'E0 to E4 are the radius (36 to 14 mm over the bands), D0 to D4 phi (rad)'),
    (6, 'ch. 5', 'phi is called second-order once; five coefficients are printed', 'all five'),
    (7, 'ch. 5', 'N is said to point 34 deg medial and 62 deg inferior to anterior; the vector '
     'does not, and is no unit vector', 'the vector, normalised'),
    (8, 'Figures E.4, E.5', 'lengths and moment arms are labelled mm/degree', 'mm'),
    (9, 'ch. 6', 'no band is said to enter an interference sphere; the printed parameters let them',
     'reported: see *Interference*'),
    (10, 'ch. 7', 'lengths are said to span 115 to 200 mm; straight lines between the printed '
     'attachments reach 90 mm', 'reported: see *Experiments*'),
)  # fmt: skip

OTHER = """
    This is not the published deltoid: the tables and the errata of the thesis are left out, and the
    span of the attachments is that of the bands.
"""


def model_chapter(subject: Subject) -> Chapter:
    """Return the chapter on the model."""
    muscle = subject.muscle
    heads = ', '.join(f'{head.name} ({head.represented_by})' for head in muscle.heads)
    return Chapter('Model', [
        f"""
        `{muscle.name}`: {len(muscle.band_names)} bands; heads, and the band that represents each in
        comparisons: {heads}. Source: {' '.join(muscle.source.split())}.

        Frames: right scapula, x lateral, y anterior, z superior, origin at the glenohumeral centre;
        the humerus frame coincides with it when the arm hangs.
        """,
        PicturePart(
            'e1_attachments',
            """E.1. Attachments with the arm at the side: the bands (coloured, numbered) within
            their whole span (bone-coloured). Large spheres: the interference spheres, which stand
            for bone here; cylinder: the humeral shaft, schematic. The thesis draws reconstructed
            bones, which are not available.""",
            lambda: poses.attachments_figure(subject),
        ),
        PicturePart(
            'e2_spheres',
            """E.2. The obstacle spheres with the arm at the side. A sphere and the attachments of
            its band have one colour and one number.""",
            lambda: poses.obstacles_figure(subject),
        ),
        PicturePart(
            'e3_e6_to_e9_poses',
            """E.3 and E.6 to E.9. The muscle at the poses, and from the sides, that the thesis
            shows. Bone is drawn through: bands within it can be seen.""",
            lambda: poses.poses_figure(subject),
        ),
        PicturePart(
            'e10_montage',
            'E.10. From extension to flexion. The thesis names no angles; these are ours.',
            lambda: poses.montage_figure(subject),
        ),
        *(_printed_parts(subject) if subject.is_published else [OTHER]),
    ])  # fmt: skip


def _printed_parts(subject: Subject) -> list[Part]:
    """Return the thesis's tables of attachments, done again, and its errata."""
    return [
        """
        The thesis prints the attachments. Here they are, from its polynomials, beside what it
        prints: they agree to 1e-5 mm except in the rows marked.
        """,
        _position_table(subject, '6.2.1', 'origins, scapula frame'),
        _position_table(subject, '6.2.2', 'insertions, humerus frame'),
        TablePart(
            'errata', 'Errata of the thesis, and what is taken instead',
            ('number', 'where', 'what', 'taken'), ERRATA,
        ),
    ]  # fmt: skip


def _position_table(subject: Subject, table: str, what: str) -> TablePart:
    rows: list[tuple[Cell, ...]] = [
        (
            each.band,
            f'{each.s:.3f}',
            *(MILLIMETRES * x for x in each.point),
            *(MILLIMETRES * x for x in each.printed.point),
            each.printed.erratum,
        )
        for each in compare_positions(subject.muscle, table)
    ]
    axes = tuple(f'{axis}_mm' for axis in 'xyz')
    return TablePart(
        f'table_{table.replace(".", "_")}_{what.split(",")[0]}',
        f'Table {table}, done again: {what}',
        ('band', 's', *axes, *(f'printed_{axis}' for axis in axes), 'erratum'),
        rows,
        digits=5,
    )
