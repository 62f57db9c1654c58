# SPDX-License-Identifier: Apache-2.0
"""The figures as files: every output is plotted, and nothing half-written stays."""

from __future__ import annotations

import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import NAMES, exit_status, odd_motion, write_bag
from optional import requires
from plotted import ONE_HEAD

from linkedplane_ros import JOINT_CONVENTIONS
from linkedplane_ros.commands.main import main
from linkedplane_ros.drawing.plot import figures, save_figures
from linkedplane_ros.errors import RecordingError
from linkedplane_ros.processing.reading import read_processed

pytestmark = requires('matplotlib')

ISB = JOINT_CONVENTIONS['isb_yxy']


def matplotlib_settings() -> dict[str, Any]:
    """Return matplotlib's settings; the backend is read without making matplotlib choose one."""
    import matplotlib

    return {key: dict.__getitem__(matplotlib.rcParams, key) for key in matplotlib.rcParams}


def test_png_files_are_pictures(tmp_path: Path) -> None:
    files = save_figures(ONE_HEAD, tmp_path / 'raise.v1', 'png')
    names = ['over_time', *(f'against_{name}' for name in ISB.coordinates)]
    assert [file.name for file in files] == [f'raise.v1_{name}.png' for name in names]
    assert sorted(tmp_path.iterdir()) == sorted(files)  # and nothing else
    for file in files:
        assert file.read_bytes().startswith(b'\x89PNG\r\n\x1a\n')


def test_svg_files_are_xml_with_text_and_the_same_every_time(tmp_path: Path) -> None:
    files, again = (save_figures(ONE_HEAD, tmp_path / name, 'svg') for name in ('one', 'two'))
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
        save_figures(ONE_HEAD, tmp_path / folder / 'raise', 'png')
    file = tmp_path / folder / 'raise_over_time.png'
    assert str(caught.value) == f'{file}: cannot be written: {reason}'


def test_without_matplotlib_the_reason_names_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    with pytest.raises(RecordingError, match=r'^a picture needs the matplotlib library: pip'):
        figures(ONE_HEAD)


def test_a_file_that_cannot_be_replaced_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / 'raise_over_time.svg').mkdir()
    with pytest.raises(RecordingError, match=r'raise_over_time\.svg: cannot be written'):
        save_figures(ONE_HEAD, tmp_path / 'raise', 'svg')
    assert [path.name for path in tmp_path.iterdir()] == ['raise_over_time.svg']


def test_the_settings_of_matplotlib_are_left_alone(tmp_path: Path) -> None:
    before = matplotlib_settings()
    save_figures(ONE_HEAD, tmp_path / 'raise', 'svg')
    assert matplotlib_settings() == before


def test_matplotlib_is_loaded_with_a_figure_and_its_windows_and_ros_never(tmp_path: Path) -> None:
    code = """if True:
        import sys
        import numpy as np
        from pathlib import Path
        from linkedplane_ros.drawing.plot import save_figures
        from linkedplane_ros.drawing.processed import ProcessedRecording

        def loaded(*modules):
            print(*(module for module in modules if module in sys.modules), sep=' ')

        loaded('matplotlib', 'rclpy', 'visualization_msgs', 'rosbags')
        one, arms, wrap = np.ones((1, 1)), np.ones((1, 1, 3)), np.zeros((1, 1), dtype=np.uint8)
        given = np.ones(1), np.ones((1, 3)), one, arms, wrap
        empty = ProcessedRecording('', {'h': ('b',)}, ('b',), ('x', 'y', 'z'), *given)
        save_figures(empty, Path('raise'), 'png')
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


@pytest.mark.parametrize(
    'name', ['out', 'out.csv', pytest.param('OUT.PARQUET', marks=requires('pyarrow'))]
)
def test_every_kind_of_output_is_plotted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
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
    bag = write_bag(tmp_path / 'in', odd_motion())
    monkeypatch.chdir(tmp_path)
    for path in (tmp_path / 'other.csv', bag, tmp_path / 'nowhere.csv', '.'):
        assert main(['plot', str(path)]) == 1
        error = capsys.readouterr().err
        assert str(tmp_path if path == '.' else path) in error
        assert error.count('\n') == 1


def test_a_bag_is_drawn_as_it_stands(tmp_path: Path) -> None:
    source = write_bag(tmp_path / 'in', odd_motion())
    options = ['--signs', '1', '-1', '1', '--offsets', '0.1', '0', '0', '--side', 'left']
    for name in ('out', 'out.csv'):
        assert exit_status([str(source), str(tmp_path / name), *options]) == 0
    bag, table = (read_processed(tmp_path / name) for name in ('out', 'out.csv'))
    assert (bag.bands, bag.coordinates, bag.heads) == (table.bands, table.coordinates, table.heads)
    for name in ('angles', 'lengths', 'arms', 'wrap'):
        np.testing.assert_array_equal(getattr(bag, name), getattr(table, name))
    np.testing.assert_allclose(bag.times, table.times, rtol=1e-15)
