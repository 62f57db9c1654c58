"""The figures: what they show is what was given, in mm and deg, and it can be read in print."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from bags import NAMES, exit_status, odd_motion, write
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver, WrapState
from linkedplane_ros.commands.main import main
from linkedplane_ros.drawing.colours import HEAD_COLOURS
from linkedplane_ros.drawing.plot import (
    CROWDED,
    MOST,
    STATES,
    Processed,
    covered,
    figures,
    save,
    shades,
    thinned,
)
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.processing.reading import read

EXACT = 1e-9  # mm, deg, s: drawn are the given numbers, but for the rounding of their units
VISIBLE = 0.2  # of the way from black to white: greys side by side in one panel
FRAMES = 60
ROWS = 5
DELTOID = BroadMuscle.load('deltoid')
ISB = JOINT_CONVENTIONS['isb_yxy']
Array = np.ndarray


def sweep(elevations: Array) -> Processed:
    """Return the deltoid's answers at these elevations, rad, 0.02 s from one to the next."""
    angles = np.column_stack((np.full(len(elevations), 0.5), elevations, 0.3 * elevations))
    states = LinkedPlaneSolver(DELTOID).solve_batch([ISB.rotation(row) for row in angles])
    return Processed(
        title='sweep.csv: deltoid, right, isb_yxy',
        heads={head.name: head.bands for head in DELTOID.heads},
        bands=DELTOID.band_names,
        coordinates=ISB.coordinates,
        times=0.02 * np.arange(len(elevations)),
        angles=angles,
        lengths=states.lengths,
        arms=states.moment_vectors @ np.array([ISB.axes(row) for row in angles]),
        wrap=states.wrap,
    )


SWEEP = sweep(np.linspace(0.1, 2.2, FRAMES))
ONE_HEAD = dataclasses.replace(SWEEP, heads={'middle': ('middle_1', 'middle_2')})  # quickly drawn


@pytest.fixture(scope='module')
def made() -> dict[str, Figure]:
    """Return the figures of the sweep."""
    return figures(SWEEP)


def repeated(processed: Processed, frames: int) -> Processed:
    """Return the recording over and over, 0.02 s from one frame to the next."""
    which = np.arange(frames) % len(processed.times)
    fields = {
        name: getattr(processed, name)[which] for name in ('angles', 'lengths', 'arms', 'wrap')
    }
    return dataclasses.replace(processed, times=0.02 * np.arange(frames), **fields)


def panels(figure: Figure) -> Any:
    """Return the axes, (5, number of heads)."""
    return np.array(figure.axes).reshape(ROWS, -1)


def drawn(axes: Any, band: str) -> tuple[Array, Array]:
    """Return the x and y of a band's line."""
    (line,) = (line for line in axes.lines if line.get_label() == band)
    return line.get_xdata(), line.get_ydata()


def bars(axes: Any, lane: int, state: int) -> list[tuple[float, float]]:
    """Return the (start, end) of the bars of a state in the strip of a head's band."""
    kind = axes.collections[len(STATES) * lane + len(STATES) - 1 - state]
    assert kind.get_facecolor()[0, :3] == pytest.approx([list(STATES.values())[state]] * 3)
    return [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in kind.get_paths()]


def grey(colour: Any) -> float:
    """Return the lightness of a colour in a greyscale print, 0..1."""
    red, green, blue = to_rgb(colour)
    return 0.299 * red + 0.587 * green + 0.114 * blue


def settings() -> dict[str, Any]:
    """Return matplotlib's settings; the backend as it is set, for to ask for it chooses one."""
    return {key: dict.__getitem__(matplotlib.rcParams, key) for key in matplotlib.rcParams}


def ticks_within(axes: Any) -> list[Text]:
    """Return the labels of the ticks of x that are drawn."""
    low, high = axes.get_xlim()
    return [text for text in axes.get_xticklabels() if low <= text.get_position()[0] <= high]


def texts(figure: Figure) -> list[str]:
    """Return every text in a figure, each in one line."""
    return [' '.join(text.get_text().split()) for text in figure.findobj(Text)]


def test_there_is_a_figure_over_time_and_one_against_each_coordinate(
    made: dict[str, Figure],
) -> None:
    assert list(made) == ['over_time', *(f'against_{name}' for name in ISB.coordinates)]


def test_each_head_has_a_column_named_by_its_legend(made: dict[str, Figure]) -> None:
    for figure in made.values():
        assert panels(figure).shape == (ROWS, len(DELTOID.heads))
        for axes, head in zip(panels(figure)[0], DELTOID.heads, strict=True):
            legend = axes.get_legend()
            assert legend.get_title().get_text() == f'{head.name} head'
            assert tuple(text.get_text() for text in legend.get_texts()) == head.bands


def test_the_axes_are_named_with_their_units(made: dict[str, Figure]) -> None:
    arms = [f'moment arm (mm)\nabout {name}' for name in ISB.coordinates]
    across = ['time (s)', *(f'{name} (deg)' for name in ISB.coordinates)]
    for figure, x in zip(made.values(), across, strict=True):
        rows = [axes.get_ylabel() for axes in panels(figure)[:, 0]]
        assert rows == ['length (mm)', *arms, 'wrap state']
        assert [axes.get_xlabel() for axes in panels(figure)[-1]] == [x] * len(DELTOID.heads)


def test_the_lines_are_the_given_numbers_in_mm_over_s_and_deg(made: dict[str, Figure]) -> None:
    across = [SWEEP.times, *np.degrees(SWEEP.angles).T]
    down = [SWEEP.lengths, *np.moveaxis(SWEEP.arms, 2, 0)]
    for figure, x in zip(made.values(), across, strict=True):
        for column, head in enumerate(DELTOID.heads):
            for axes, quantity in zip(panels(figure)[:-1, column], down, strict=True):
                for band in head.bands:
                    given = 1000 * quantity[:, DELTOID.band_names.index(band)]
                    assert drawn(axes, band)[0] == pytest.approx(x, abs=EXACT)
                    assert drawn(axes, band)[1] == pytest.approx(given, abs=EXACT)


def test_rows_share_their_scale_and_all_panels_share_x(made: dict[str, Figure]) -> None:
    for figure in made.values():
        assert len({axes.get_xlim() for axes in panels(figure).flat}) == 1
        assert all(len({axes.get_ylim() for axes in row}) == 1 for row in panels(figure))


def test_the_title_and_the_sign_of_a_moment_arm_stand_in_each_figure_once(
    made: dict[str, Figure],
) -> None:
    sign = "shortening turns the joint in the coordinate's positive direction"
    for figure in made.values():
        assert texts(figure).count(SWEEP.title) == 1
        assert sum(sign in text for text in texts(figure)) == 1


def test_the_bands_of_a_head_differ_in_grey_and_in_line_style(made: dict[str, Figure]) -> None:
    for figure in made.values():
        for axes, head in zip(panels(figure)[1], DELTOID.heads, strict=True):
            lines = [line for line in axes.lines if line.get_label() in head.bands]
            greys = sorted(grey(line.get_color()) for line in lines)
            assert np.diff(greys).min() > VISIBLE
            assert greys[-1] < 1 - VISIBLE  # paper
            assert len({str(line._dash_pattern) for line in lines}) == len(head.bands)


@pytest.mark.parametrize('count', [2, 3, 9])
def test_the_shades_of_every_colour_have_evenly_spaced_greys(count: int) -> None:
    for colour in HEAD_COLOURS:
        steps = np.diff([grey(shade) for shade in shades(colour, count)])
        assert steps == pytest.approx(steps[0])
        assert steps[0] > 0.5 / count


def test_a_band_alone_is_dark_enough_for_paper_whatever_its_colour() -> None:
    assert all(grey(shades(colour, 1)[0]) < 0.5 for colour in HEAD_COLOURS)


def test_the_wrap_states_have_a_legend_and_differ_in_grey(made: dict[str, Figure]) -> None:
    assert list(STATES) == [state.name.lower() for state in WrapState]
    assert -np.diff([*STATES.values()]).max() > VISIBLE
    for figure in made.values():
        (legend,) = figure.legends
        assert [text.get_text() for text in legend.get_texts()] == list(STATES)
        shown = [grey(patch.get_facecolor()) for patch in legend.get_patches()]
        assert shown == pytest.approx(list(STATES.values()))


def test_each_band_has_a_named_strip_of_its_wrap_states_over_time(made: dict[str, Figure]) -> None:
    cell = SWEEP.times[-1] / 1000
    middles = SWEEP.times[:-1] + 0.01  # between a frame and the next
    for axes, head in zip(panels(made['over_time'])[-1], DELTOID.heads, strict=True):
        assert tuple(text.get_text() for text in axes.texts) == head.bands
        for lane, band in enumerate(head.bands):
            wrap = SWEEP.wrap[:-1, DELTOID.band_names.index(band)]
            for state in WrapState:
                spans = bars(axes, lane, state)
                shown = [any(a - cell <= t <= b + cell for a, b in spans) for t in middles]
                assert np.array_equal(shown, wrap == state)


def test_where_a_coordinate_returns_in_another_state_both_are_shown() -> None:
    there_and_back = sweep(np.append(np.linspace(0.2, 1.0, 30), np.linspace(1.0, 0.2, 30)))
    wrap = np.full_like(there_and_back.wrap, WrapState.WRAPPED)
    wrap[40:] = WrapState.CLEAR
    figure = figures(dataclasses.replace(there_and_back, wrap=wrap))['against_elevation']
    low, high, turned = np.degrees((0.2, 1.0, there_and_back.angles[40, 1]))
    axes = panels(figure)[-1, 0]
    assert bars(axes, 0, WrapState.WRAPPED) == [pytest.approx((low, high), abs=0.1)]
    assert bars(axes, 0, WrapState.CLEAR) == [pytest.approx((low, turned), abs=0.1)]


def test_a_state_of_one_frame_and_a_gap_show_in_the_strip() -> None:
    x = np.arange(10.0)
    here = np.array([0, 0, 1, 0, 0, 1, 1, 1, 0, 0], dtype=bool)
    assert covered(x, here) == [pytest.approx((2, 1), abs=0.01), pytest.approx((5, 3), abs=0.01)]
    assert covered(x, np.zeros(10, dtype=bool)) == []


def test_a_frame_without_answer_breaks_the_line() -> None:
    lengths = ONE_HEAD.lengths.copy()
    lengths[20:30] = lengths[31:40] = np.nan
    figure = figures(dataclasses.replace(ONE_HEAD, lengths=lengths))['over_time']
    axes = panels(figure)[0, 0]
    gaps = np.flatnonzero(np.isnan(drawn(axes, 'middle_1')[1]))
    assert gaps.tolist() == [*range(20, 30), *range(31, 40)]
    assert axes.lines[0].get_markevery() == [30]  # a dot, where no line can be


def test_a_recording_without_any_answer_is_an_empty_figure() -> None:
    nothing = {name: np.full_like(getattr(ONE_HEAD, name), np.nan) for name in ('lengths', 'arms')}
    for figure in figures(dataclasses.replace(ONE_HEAD, **nothing)).values():
        assert bars(panels(figure)[-1, 0], 0, WrapState.WRAPPED) == []


def test_one_frame_alone_is_a_dot() -> None:
    alone = repeated(ONE_HEAD, 1)
    for figure in figures(alone).values():
        axes = panels(figure)[0, 0]
        assert drawn(axes, 'middle_1')[1] == pytest.approx(1000 * alone.lengths[:, 3], abs=EXACT)
        assert axes.lines[0].get_markevery() == [0]
        assert np.ptp(axes.get_xlim()) == pytest.approx(1)


def test_a_recording_of_no_frames_is_named() -> None:
    with pytest.raises(RecordingError, match=r'^sweep\.csv: .*: no frames to plot$'):
        figures(repeated(ONE_HEAD, 0))


def test_dates_are_shown_from_the_first_frame_on() -> None:
    dated = dataclasses.replace(ONE_HEAD, times=ONE_HEAD.times + 1.7e9)
    axes = panels(figures(dated)['over_time'])
    assert axes[-1, 0].get_xlabel() == 'time since 1700000000.000 s (s)'
    rounding = 1e-6  # s, of a date in a float
    assert drawn(axes[0, 0], 'middle_1')[0] == pytest.approx(ONE_HEAD.times, abs=rounding)


def test_a_short_series_is_not_thinned() -> None:
    x, y = np.arange(100.0), np.sin(np.arange(100.0))
    assert all(a is b for a, b in zip(thinned(x, y, 100), (x, y), strict=True))


@pytest.mark.parametrize(('frames', 'most'), [(1001, 1000), (1003, 50), (100_003, 4000), (17, 5)])
def test_extremes_survive_thinning(frames: int, most: int) -> None:
    random = np.random.default_rng(frames)
    x, y = np.cumsum(random.random(frames)), random.normal(size=frames)
    peak, trough, turn = random.choice(frames, 3, replace=False)
    y[peak], y[trough], x[turn] = 99.0, -99.0, 2 * x[-1]
    few, values = thinned(x, y, most)
    assert len(few) == len(values) <= most
    assert {x[peak], x[trough], x[turn], x[0]} <= set(few)
    assert (values.max(), values.min()) == (99.0, -99.0)
    places = np.flatnonzero(np.isin(y, values))
    assert np.array_equal(x[places], few)  # in their order
    assert np.array_equal(y[places], values)


def test_every_run_keeps_its_own_extremes() -> None:
    y = np.random.default_rng(1).normal(size=10_000)
    _, few = thinned(np.arange(10_000.0), y, 500)
    for run in y.reshape(100, 100):
        assert {run.min(), run.max(), run[0], run[-1]} <= set(few)


def test_a_gap_survives_thinning_beside_the_extremes() -> None:
    y = np.arange(1000.0)
    y[500] = np.nan
    y[503] = 5000.0
    _, few = thinned(np.arange(1000.0), y, 100)
    assert np.isnan(few).sum() == 1
    assert np.nanmax(few) == 5000.0


def test_a_long_recording_is_drawn_with_few_points_and_its_peaks() -> None:
    long = repeated(ONE_HEAD, CROWDED + 1)
    long.lengths[12_345] = 0.5
    for name, figure in figures(long).items():
        axes = panels(figure)[0, 0]
        for line in (line for line in axes.lines if line.get_label() in long.bands):
            assert len(line.get_xdata()) <= MOST
            assert line.get_ydata().max() == pytest.approx(500, abs=EXACT)
            # a line through a few frames of a cloud would show what was never there
            assert (line.get_linestyle() == 'None') == name.startswith('against')


@pytest.mark.parametrize('processed', [SWEEP, ONE_HEAD], ids=['three heads', 'one head'])
def test_no_text_is_cropped_or_lies_on_another(processed: Processed) -> None:
    titled = dataclasses.replace(processed, title='a_long_name_of_a_file ' * 8)
    for figure in figures(titled).values():
        width, height = figure.get_size_inches()
        box = figure.get_tightbbox()
        assert 0 <= box.x0 < box.x1 <= width
        assert 0 <= box.y0 < box.y1 <= height
        legends = [*figure.legends, *(axes.get_legend() for axes in panels(figure)[0])]
        labels = [axes.yaxis.label for axes in panels(figure)[:, 0]]
        labels += [axes.xaxis.label for axes in panels(figure)[-1]]
        ticks = [text for axes in panels(figure)[-1] for text in ticks_within(axes)]
        shown = [*figure.texts, *legends, *labels, *ticks, *panels(figure)[-1, 0].texts]
        boxes = [artist.get_window_extent() for artist in shown]
        for i, one in enumerate(boxes):
            assert not any(one.overlaps(other) for other in boxes[:i]), shown[i]


def test_png_files_are_pictures(tmp_path: Path) -> None:
    files = save(ONE_HEAD, tmp_path / 'raise.v1', 'png')
    names = ['over_time', *(f'against_{name}' for name in ISB.coordinates)]
    assert [file.name for file in files] == [f'raise.v1_{name}.png' for name in names]
    assert sorted(tmp_path.iterdir()) == sorted(files)  # and nothing else
    for file in files:
        assert file.read_bytes().startswith(b'\x89PNG\r\n\x1a\n')


def test_svg_files_are_xml_with_text_and_the_same_every_time(tmp_path: Path) -> None:
    files, again = (save(ONE_HEAD, tmp_path / name, 'svg') for name in ('one', 'two'))
    for file, other in zip(files, again, strict=True):
        root = ElementTree.parse(file).getroot()
        words = ' '.join(''.join(text.itertext()) for text in root.iter() if 'text' in text.tag)
        assert all(word in words for word in ('length (mm)', 'middle_2', 'wrapped', 'sweep.csv'))
        assert file.read_bytes() == other.read_bytes()


@pytest.mark.parametrize(
    ('folder', 'reason'), [('nowhere', 'No such file or directory'), ('file', 'Not a directory')]
)
def test_a_folder_that_does_not_exist_is_named_in_one_line(
    tmp_path: Path, folder: str, reason: str
) -> None:
    (tmp_path / 'file').touch()
    with pytest.raises(RecordingError) as caught:
        save(ONE_HEAD, tmp_path / folder / 'raise', 'png')
    file = tmp_path / folder / 'raise_over_time.png'
    assert str(caught.value) == f'{file}: not written: {reason}'


def test_without_matplotlib_the_reason_names_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    with pytest.raises(RecordingError, match=r'^a picture needs the matplotlib library: pip'):
        figures(ONE_HEAD)


def test_a_file_that_cannot_be_replaced_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / 'raise_over_time.svg').mkdir()
    with pytest.raises(RecordingError, match=r'raise_over_time\.svg: not written'):
        save(ONE_HEAD, tmp_path / 'raise', 'svg')
    assert [path.name for path in tmp_path.iterdir()] == ['raise_over_time.svg']


def test_the_settings_of_matplotlib_are_left_alone(tmp_path: Path) -> None:
    before = settings()
    save(ONE_HEAD, tmp_path / 'raise', 'svg')
    assert settings() == before


def test_names_are_shown_as_they_are() -> None:
    odd = dataclasses.replace(ONE_HEAD, title='cost_$1_$2.csv')
    figure = figures(odd)['over_time']
    (title,) = (text for text in figure.texts if text.get_text() == odd.title)
    assert not title.get_parse_math()


def test_matplotlib_is_loaded_with_a_figure_and_its_windows_and_ros_never(tmp_path: Path) -> None:
    code = """if True:
        import sys
        import numpy as np
        from pathlib import Path
        from linkedplane_ros.drawing.plot import Processed, save

        def loaded(*modules):
            print(*(module for module in modules if module in sys.modules), sep=' ')

        loaded('matplotlib', 'rclpy', 'visualization_msgs', 'rosbags')
        one, arms, wrap = np.ones((1, 1)), np.ones((1, 1, 3)), np.zeros((1, 1), dtype=np.uint8)
        given = np.ones(1), np.ones((1, 3)), one, arms, wrap
        save(Processed('', {'h': ('b',)}, ('b',), ('x', 'y', 'z'), *given), Path('raise'), 'png')
        loaded('matplotlib', 'matplotlib.pyplot', 'rclpy', 'visualization_msgs', 'rosbags')
    """
    command = [sys.executable, '-c', code]
    root = {'PYTHONPATH': str(Path(__file__).resolve().parents[2])}
    ran = subprocess.run(
        command,
        cwd=tmp_path,
        env={**os.environ, **root},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout.splitlines() == ['', 'matplotlib']


@pytest.mark.parametrize('name', ['out', 'out.csv', 'OUT.PARQUET'])
def test_every_kind_of_output_is_plotted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    source = write(tmp_path / 'in', odd_motion())
    assert exit_status([str(source), str(tmp_path / name), '--side', 'left']) == 0
    capsys.readouterr()
    assert main(['plot', str(tmp_path / name), '--svg']) == 0
    files = capsys.readouterr().out.split()
    stem = Path(name).stem
    against = [f'{stem}_against_{coordinate}.svg' for coordinate in NAMES]
    assert [Path(each).name for each in files] == [f'{stem}_over_time.svg', *against]
    assert 'left' in Path(files[0]).read_text()


def test_what_is_no_output_is_not_plotted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'other.csv').write_text('time,a\n0,1\n')
    bag = write(tmp_path / 'in', odd_motion())
    monkeypatch.chdir(tmp_path)
    for path in (tmp_path / 'other.csv', bag, tmp_path / 'nowhere.csv', '.'):
        assert main(['plot', str(path)]) == 1
        error = capsys.readouterr().err
        assert str(tmp_path if path == '.' else path) in error
        assert error.count('\n') == 1


def test_a_bag_is_drawn_as_it_stands(tmp_path: Path) -> None:
    source = write(tmp_path / 'in', odd_motion())
    options = ['--signs', '1', '-1', '1', '--offsets', '0.1', '0', '0', '--side', 'left']
    for name in ('out', 'out.csv'):
        assert exit_status([str(source), str(tmp_path / name), *options]) == 0
    bag, table = (read(tmp_path / name) for name in ('out', 'out.csv'))
    assert (bag.bands, bag.coordinates, bag.heads) == (table.bands, table.coordinates, table.heads)
    for name in ('angles', 'lengths', 'arms', 'wrap'):
        np.testing.assert_array_equal(getattr(bag, name), getattr(table, name))
    np.testing.assert_allclose(bag.times, table.times, rtol=1e-15)
