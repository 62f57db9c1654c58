# SPDX-License-Identifier: Apache-2.0
"""The command `linkedplane study`: the report, tables and figures that it writes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from optional import requires
from studies import read_table

from linkedplane_ros.commands.main import main
from linkedplane_ros.drawing.figure_files import house_style
from linkedplane_ros.rivals.methods import LINKED
from linkedplane_ros.study import report
from linkedplane_ros.study.pictures import animation, charts, poses
from linkedplane_ros.study.subject import Subject

pytestmark = [pytest.mark.usefixtures('coarse'), requires('matplotlib')]

MODEL = Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml'
FIGURES = {
    'e1_attachments', 'e2_spheres', 'e3_e6_to_e9_poses', 'e4_lengths', 'e5_moment_arms',
    'e10_montage', 'interference_depths', 'interference_where', 'fidelity_moment_arms',
    'rivals',
}  # fmt: skip
TABLES = {
    'table_6_2_1_origins', 'table_6_2_2_insertions', 'errata', 'heads', 'cubic_less_exact',
    'experiments', 'interference_summary', 'interference_by_band', 'interference_entries',
    'fidelity_by_head', 'fidelity_thesis', 'fidelity_models', 'fidelity_all', 'rivals',
    'rivals_obstacles', 'rivals_claims', 'cost',
}  # fmt: skip


def test_a_study_is_a_report_with_tables_and_figures(study: Path) -> None:
    assert {path.name for path in study.iterdir()} == {'report.md', 'tables', 'figures'}
    assert {path.stem for path in (study / 'figures').iterdir()} == FIGURES
    assert {path.stem for path in (study / 'tables').iterdir()} == TABLES


def test_every_link_of_the_report_leads_to_a_file_and_every_file_has_a_link(study: Path) -> None:
    links = set(re.findall(r'\]\(([^)]+)\)', (study / 'report.md').read_text()))
    files = {str(path.relative_to(study)) for path in study.glob('*/*')}
    assert links == files


def test_the_figures_are_pictures_that_fill_a_page(study: Path) -> None:
    from matplotlib.image import imread

    for path in (study / 'figures').iterdir():
        picture = imread(path)
        assert picture.shape[1] == round(poses.WIDTH * report.DPI)
        shares = np.histogram(picture[..., :3].mean(axis=2), bins=4, range=(0.0, 1.0))[0]
        assert shares[:2].sum() > 0.005 * shares.sum(), path  # there is ink


def test_the_report_names_units_sign_and_errata(study: Path) -> None:
    text = (study / 'report.md').read_text()
    for words in (
        'x lateral, y anterior, z superior',
        'r = -dL/dq',
        'Lengths and\nmoment arms are in mm, angles in degrees',
        'No moment arm in this report is scaled unless it says so.',
        '132 of 702 checks find one that does, at 25 of',
        'What does not.',
        'What is unknown.',
    ):
        assert words in text, words
    for number in range(1, 11):
        assert f'\n| {number} | ' in text


def test_the_tables_hold_what_the_solver_gives(study: Path) -> None:
    table = read_table(study, 'experiments')
    assert len(table) == 26 * 9
    subject = Subject.load('deltoid')
    (row,) = (
        each
        for each in table
        if (each['motion'], each['angle_deg'], each['band']) == ('abduction', '30', 'posterior_2')
    )
    one = subject.experiments[1]
    # mm: six decimals are written
    assert float(row['length_mm']) == pytest.approx(1e3 * one.lengths[3, 7], abs=1e-6)
    assert float(row['moment_arm_mm']) == pytest.approx(1e3 * one.arms[3, 7], abs=1e-6)
    assert float(row['moment_arm_cubic_mm']) == pytest.approx(1e3 * one.cubic_arms[3, 7], abs=1e-6)
    assert row['head'] == 'posterior'
    assert len(read_table(study, 'interference_entries')) == 132 + 72 + 118


def test_the_rivals_stand_beside_the_linked_planes(study: Path) -> None:
    found = read_table(study, 'rivals')
    assert len(found) == 10 * 3
    assert {row['method'] for row in found} == {row['method'] for row in read_table(study, 'cost')}
    linked = [row for row in found if row['method'] == LINKED]
    assert all(float(row['length_jump_mm']) < 1e-3 for row in linked)
    assert float(linked[0]['poses_crossed']) == 0.0  # over the thesis's motions
    double = [float(row['length_jump_mm']) for row in found if row['method'] == 'double cylinder']
    assert min(double) > 1.0
    text = (study / 'report.md').read_text()
    assert 'Nobody has published obstacles' in text
    assert '5 to 10 hours a run' in text
    claims = read_table(study, 'rivals_claims')
    assert len(claims) == 7 * 3
    breadth = [row['rivals_that_do_worse'] for row in claims if row['claim'] == 'breadth is lost']
    assert breadth == ['4 of 9', '1 of 9', '2 of 9']  # not borne out


def test_the_errata_are_marked_in_the_tables_of_positions(study: Path) -> None:
    for table, wrong in (('table_6_2_1_origins', ['0.662']),
                         ('table_6_2_2_insertions', ['0.569', '0.662'])):  # fmt: skip
        assert [row['s'] for row in read_table(study, table) if row['erratum']] == wrong


@pytest.mark.parametrize(
    ('page', 'table'),
    [
        ('fidelity', 'fidelity_by_head'),
        ('fidelity', 'fidelity_thesis'),
        ('fidelity', 'fidelity_models'),
        ('rivals', 'rivals_claims'),
    ],
)
def test_the_documentation_has_the_tables_of_the_report(study: Path, page: str, table: str) -> None:
    path = MODEL.parents[2] / 'doc' / 'explanation' / f'{page}.md'
    _, _, rest = path.read_text(encoding='utf-8').partition(f'<!-- {table} -->\n')
    shown = rest.partition(f'\n<!-- /{table} -->')[0]
    assert len(shown.splitlines()) > 5
    assert shown in (study / 'report.md').read_text()


def test_half_scaled_moment_arms_say_so(tmp_path: Path, study: Path) -> None:
    subject = Subject.load('deltoid', scale=0.5)
    text = '\n'.join(
        report._part(part, prepared(tmp_path), animated=False)
        for chapter in report.CHAPTERS[1:2]
        for part in chapter(subject).parts
        if not hasattr(part, 'draw')
    )
    assert '**Moment arms of this model are multiplied by 0.5**' in text
    assert 'unless it says so' not in text
    for whole, half in zip(read_table(study, 'heads'), read_table(tmp_path, 'heads'), strict=True):
        assert whole['middle_length_mm'] == half['middle_length_mm']
        for quantity in ('middle_arm_mm', 'middle_cubic_arm_mm'):
            assert float(half[quantity]) == pytest.approx(0.5 * float(whole[quantity]), abs=1e-6)
    with house_style():
        page = charts.moment_arms_figure(subject)
    assert '0.5 x moment arm (mm)' in page.axes[0].get_ylabel()


def prepared(folder: Path) -> Path:
    """Return a folder with places for tables and figures."""
    for sub in ('tables', 'figures'):
        (folder / sub).mkdir(exist_ok=True)
    return folder


def test_further_spheres_are_checked_and_named(quick: None, tmp_path: Path) -> None:
    spheres = tmp_path / 'found.yaml'
    spheres.write_text(
        'units: {length: mm}\n'
        'interference_spheres: {sphere_1: {centre: [0.0, 0.0, -60.0], radius: 5.0}}\n'
    )
    assert main(['study', str(tmp_path / 'out'), '--spheres', str(spheres)]) == 0
    text = (tmp_path / 'out' / 'report.md').read_text()
    assert f'sphere_1; those of `{spheres}` among them' in ' '.join(text.split())
    assert 'are lost' not in text
    assert [row['checks'] for row in read_table(tmp_path / 'out', 'interference_summary')] == [
        '936'
    ] * 3


def test_flexion_is_an_endless_gif_there_and_back(tmp_path: Path) -> None:
    from PIL import Image

    animation.write_animation(
        Subject.load('deltoid'), tmp_path / 'flexion.gif', step=np.radians(40.0)
    )
    with Image.open(tmp_path / 'flexion.gif') as picture:
        assert picture.n_frames == 4  # 0, 40, 80, 40 deg
        assert picture.info['loop'] == 0
        assert picture.size == (800, 340)
        frames = []
        for k in range(picture.n_frames):
            picture.seek(k)
            frames.append(np.asarray(picture.convert('L'), dtype=float))
    assert np.abs(frames[1] - frames[0]).max() > 50.0  # it moves
    assert np.abs(frames[2] - frames[1]).max() > 50.0
    np.testing.assert_array_equal(frames[1], frames[3])  # and comes back
