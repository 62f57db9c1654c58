"""The command `linkedplane study`: what it writes, what it leaves alone, how it ends."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread

from linkedplane_ros import BroadMuscle
from linkedplane_ros.commands.main import main
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.rivals.methods import LINKED
from linkedplane_ros.study import report
from linkedplane_ros.study.chapters.parts import Table, heading
from linkedplane_ros.study.interference import PRINTED, check
from linkedplane_ros.study.pictures import animation, charts, figures
from linkedplane_ros.study.subject import Subject

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


@pytest.fixture(scope='module', autouse=True)
def coarse() -> Iterator[None]:
    """Draw with fewer pixels: they take half of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, 'DPI', 50)
        yield


@pytest.fixture(scope='module')
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a study of the published deltoid, without the animation."""
    folder = tmp_path_factory.mktemp('studies') / 'study'
    assert main(['study', str(folder), '--no-animation']) == 0
    return folder


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write text and tables alone: what is asked of the folder does not hang on its pictures."""
    monkeypatch.setattr(report, 'CHAPTERS', report.CHAPTERS[2:4])
    monkeypatch.setattr(charts, 'depths', lambda readings: blank())
    monkeypatch.setattr(charts, 'fidelity', lambda subject: blank())
    monkeypatch.setattr(figures, 'entries', lambda readings: blank())


def blank() -> object:
    """Return an empty figure."""
    from matplotlib.figure import Figure

    return Figure(figsize=(0.1, 0.1))


def rows(folder: Path, table: str) -> list[dict[str, str]]:
    """Return the rows of one of a study's tables."""
    with (folder / 'tables' / f'{table}.csv').open(newline='') as file:
        return list(csv.DictReader(file))


def fault(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Return the one line of a study whose input is at fault."""
    assert main(['study', *map(str, arguments)]) == 1
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('linkedplane: ')
    assert err.count('\n') == 1
    return err


# What it writes


def test_a_study_is_a_report_with_tables_and_figures(study: Path) -> None:
    assert {path.name for path in study.iterdir()} == {'report.md', 'tables', 'figures'}
    assert {path.stem for path in (study / 'figures').iterdir()} == FIGURES
    assert {path.stem for path in (study / 'tables').iterdir()} == TABLES


def test_every_link_of_the_report_leads_to_a_file_and_every_file_has_a_link(study: Path) -> None:
    links = set(re.findall(r'\]\(([^)]+)\)', (study / 'report.md').read_text()))
    files = {str(path.relative_to(study)) for path in study.glob('*/*')}
    assert links == files


def test_the_figures_are_pictures_that_fill_a_page(study: Path) -> None:
    for path in (study / 'figures').iterdir():
        picture = imread(path)
        assert picture.shape[1] == round(figures.WIDTH * report.DPI)
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
    table = rows(study, 'experiments')
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
    assert len(rows(study, 'interference_entries')) == 132 + 72 + 118


def test_the_rivals_stand_beside_the_linked_planes(study: Path) -> None:
    found = rows(study, 'rivals')
    assert len(found) == 10 * 3
    assert {row['method'] for row in found} == {row['method'] for row in rows(study, 'cost')}
    linked = [row for row in found if row['method'] == LINKED]
    assert all(float(row['length_jump_mm']) < 1e-3 for row in linked)
    assert float(linked[0]['poses_crossed']) == 0.0  # over the thesis's motions
    double = [float(row['length_jump_mm']) for row in found if row['method'] == 'double cylinder']
    assert min(double) > 1.0
    text = (study / 'report.md').read_text()
    assert 'Nobody has published obstacles' in text
    assert '5 to 10 hours a run' in text
    claims = rows(study, 'rivals_claims')
    assert len(claims) == 7 * 3
    breadth = [row['rivals_that_do_worse'] for row in claims if row['claim'] == 'breadth is lost']
    assert breadth == ['4 of 9', '1 of 9', '2 of 9']  # not borne out


def test_the_errata_are_marked_in_the_tables_of_positions(study: Path) -> None:
    for table, wrong in (('table_6_2_1_origins', ['0.662']),
                         ('table_6_2_2_insertions', ['0.569', '0.662'])):  # fmt: skip
        assert [row['s'] for row in rows(study, table) if row['erratum']] == wrong


@pytest.mark.parametrize(
    'table', ['fidelity_by_head', 'fidelity_thesis', 'fidelity_models', 'rivals_claims']
)
def test_the_readme_has_the_tables_of_the_report(study: Path, table: str) -> None:
    _, _, rest = (MODEL.parents[2] / 'README.md').read_text().partition(f'<!-- {table} -->\n')
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
    for whole, half in zip(rows(study, 'heads'), rows(tmp_path, 'heads'), strict=True):
        assert whole['middle_length_mm'] == half['middle_length_mm']
        for quantity in ('middle_arm_mm', 'middle_cubic_arm_mm'):
            assert float(half[quantity]) == pytest.approx(0.5 * float(whole[quantity]), abs=1e-6)
    with figures.drawing():
        page = charts.moment_arms(subject)
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
    assert [row['checks'] for row in rows(tmp_path / 'out', 'interference_summary')] == ['936'] * 3


def test_flexion_is_an_endless_gif_there_and_back(tmp_path: Path) -> None:
    from PIL import Image

    animation.write(Subject.load('deltoid'), tmp_path / 'flexion.gif', step=np.radians(40.0))
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


# Other muscles


def other(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    """Return a model file, the published deltoid's with changes."""
    text = MODEL.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / 'mine.yaml'
    path.write_text(text)
    return path


def test_a_muscle_that_is_no_deltoid_is_studied_without_the_literature(tmp_path: Path) -> None:
    spheres = re.search(r'\ninterference_spheres:.*?\n\n', MODEL.read_text(), re.DOTALL)
    assert spheres is not None
    mine = other(
        tmp_path,
        ('name: deltoid', 'name: gluteus'),
        ('\n  anterior: {bands', '\n  front: {bands'),
        (spheres[0], '\n\n'),
        ('first: 0.10', 'first: 0.11'),
    )
    out = tmp_path / 'out'
    assert main(['study', str(out), '--muscle', str(mine), '--no-animation']) == 0
    text = ' '.join((out / 'report.md').read_text().split())
    assert 'This is not the published deltoid' in text
    assert 'The model has no interference spheres.' in text
    assert 'so nothing is compared' in text
    assert 'No measurement of these heads is at hand.' in text
    assert 'Ackland' not in text
    assert {path.stem for path in (out / 'tables').iterdir()} == {
        'heads', 'cubic_less_exact', 'experiments', 'rivals', 'rivals_obstacles',
        'rivals_claims', 'cost',
    }  # fmt: skip
    assert 'front_length_mm' in rows(out, 'heads')[0]


def test_a_deltoid_fitted_anew_is_compared_but_not_with_the_thesis(
    quick: None, tmp_path: Path
) -> None:
    mine = other(tmp_path, ('37.294653]', '37.394653]'))
    out = tmp_path / 'out'
    assert main(['study', str(out), '--muscle', str(mine)]) == 0
    text = ' '.join((out / 'report.md').read_text().split())
    assert 'Erratum 9' not in text
    assert 'What agrees.' not in text
    assert 'fidelity_models' in text
    assert [row['reading'] for row in rows(out, 'interference_summary')] == [PRINTED]


# What it leaves alone


def test_a_folder_with_anything_in_it_is_left_alone(
    quick: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'notes.txt').write_text('mine')
    for options in ((), ('--force',)):
        line = fault(capsys, tmp_path, *options)
        assert f'{tmp_path}: not empty and no study; only a study is replaced' in line
    assert [path.name for path in tmp_path.iterdir()] == ['notes.txt']


def test_a_study_is_replaced_only_by_force_and_only_if_nothing_else_is_in_it(
    quick: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / 'out'
    out.mkdir()  # an empty folder will do
    assert main(['study', str(out)]) == 0
    before = (out / 'report.md').read_text()
    capsys.readouterr()
    assert f'{out}: holds a study; --force to replace it' in fault(capsys, out)
    assert main(['study', str(out), '--half', '--force']) == 0
    assert (out / 'report.md').read_text() != before
    capsys.readouterr()
    (out / 'figures' / 'mine.svg').write_text('mine')
    assert 'mine.svg: is not of the study' in fault(capsys, out, '--force')
    assert (out / 'figures' / 'mine.svg').read_text() == 'mine'
    assert [path.name for path in tmp_path.iterdir()] == ['out']


def test_a_study_may_be_written_where_one_stands(
    quick: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for options in ((), ('--force',)):
        assert main(['study', '.', *options]) == 0
        assert Path.cwd() == tmp_path
        assert {path.name for path in Path().iterdir()} == {'report.md', 'tables', 'figures'}


def test_a_study_that_fails_leaves_what_there_was(
    quick: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(subject: Subject) -> object:
        raise RecordingError('no')

    subject = Subject.load('deltoid')
    report.write(subject, tmp_path / 'old')
    before = {path: path.read_bytes() for path in tmp_path.rglob('*') if path.is_file()}
    monkeypatch.setattr(charts, 'fidelity', broken)
    for name, force in (('new', False), ('old', True)):
        with pytest.raises(RecordingError):
            report.write(subject, tmp_path / name, force)
    assert before == {path: path.read_bytes() for path in tmp_path.rglob('*') if path.is_file()}
    assert [path.name for path in tmp_path.iterdir()] == ['old']


@pytest.mark.parametrize(
    ('options', 'reason'),
    [
        (('--muscle', 'biceps'), "'biceps' is neither a bundled model"),
        (('--muscle', 'gone.yaml'), 'gone.yaml: cannot be read'),
        (('--spheres', 'gone.yaml'), 'gone.yaml: cannot be read'),
    ],
)
def test_an_input_at_fault_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], reason: str
) -> None:
    assert reason in fault(capsys, tmp_path / 'out', *options)
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'file').write_text('mine')
    assert 'a file; a folder expected' in fault(capsys, tmp_path / 'file')
    assert 'No such file or directory' in fault(capsys, tmp_path / 'gone' / 'out')


def test_wrong_usage_ends_with_2(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(['study'])
    assert caught.value.code == 2
    assert 'usage: linkedplane study' in capsys.readouterr().err


def test_without_matplotlib_one_line_says_what_to_install(tmp_path: Path) -> None:
    code = (
        'import sys; sys.modules["matplotlib"] = None; '
        'from linkedplane_ros.commands.main import main; '
        f'sys.exit(main(["study", {str(tmp_path / "o")!r}]))'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr == (
        "linkedplane: a study needs the matplotlib library: pip install 'linkedplane_ros[tools]'\n"
    )
    assert not list(tmp_path.iterdir())


# Its parts


def test_a_table_shows_units_and_hides_no_digits_from_machines() -> None:
    table = Table('t', 'T', ('band', 'length_mm', 'at_deg'), [('a|b', 1.23456789, 30),
                                                              ('c', None, -0)])  # fmt: skip
    assert table.csv() == 'band,length_mm,at_deg\na|b,1.234568,30\nc,,0\n'
    assert table.markdown().splitlines() == [
        '| band | length (mm) | at (deg) |',
        '| --- | ---: | ---: |',
        '| a\\|b | 1.2 | 30 |',
        '| c |  | 0 |',
    ]
    assert heading('mean_size_mm') == 'mean size (mm)'


def test_a_tiny_negative_number_is_shown_without_its_sign() -> None:
    assert '| 0.0 |' in Table('t', 'T', ('x_mm',), [(-0.01,)]).markdown()


@pytest.mark.parametrize('chart', [charts.lengths, charts.moment_arms, charts.fidelity])
def test_no_word_of_a_chart_runs_off_the_page(chart: Callable[[Subject], Any]) -> None:
    with figures.drawing():
        figure = chart(Subject.load('deltoid', scale=0.5))
        FigureCanvasAgg(figure).draw()
        page = figure.bbox
        labels = [axes.yaxis.label for axes in figure.axes if axes.get_ylabel()]
        for words in (*figure.legends, *labels):
            box = words.get_window_extent()
            assert page.x0 <= box.x0 < box.x1 <= page.x1, words
            assert page.y0 <= box.y0 < box.y1 <= page.y1, words


def test_a_chart_of_depths_says_where_and_how_deep() -> None:
    subject = Subject.load('deltoid')
    with figures.drawing():
        (axes,) = charts.depths({PRINTED: check(subject.experiments)}).axes
    words = [text.get_text() for text in axes.texts]
    assert words.count('20') == 2  # mm, flexion 50 and 60
    assert words.count('<1') == 4
    assert '4,5,6' in words
    assert BroadMuscle.load('deltoid').band_names[0] in axes.get_yticklabels()[0].get_text()
