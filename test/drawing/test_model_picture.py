# SPDX-License-Identifier: Apache-2.0
"""The picture of a model: what stands in it, and how it ends."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from optional import requires

from linkedplane_ros import JOINT_CONVENTIONS, BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.commands.main import main
from linkedplane_ros.drawing.colours import head_colours
from linkedplane_ros.drawing.picture import model_figure, pictured_poses, sphere_grid

pytestmark = requires('matplotlib')

DELTOID = BroadMuscle.load('deltoid')
THESIS = JOINT_CONVENTIONS['flexion_abduction_rotation']


def test_a_picture_shows_bands_ends_and_spheres_in_mm_at_three_poses_from_two_sides() -> None:
    figure = model_figure(DELTOID)
    assert len(figure.axes) == 6
    colours = head_colours(DELTOID)
    for axes, angles in zip(figure.axes, [*pictured_poses(DELTOID)] * 2, strict=True):
        state = LinkedPlaneSolver(DELTOID).solve(THESIS.rotation(angles))
        *bands, shaft = axes.lines
        for line, path, colour in zip(bands, state.paths(24), colours, strict=True):
            np.testing.assert_allclose(line.get_data_3d(), 1e3 * path.T, atol=1e-9)
            assert line.get_color() == colour
        head, end = np.array(shaft.get_data_3d()).T
        assert np.abs(head).max() == 0.0
        np.testing.assert_allclose(end / np.linalg.norm(end), -state.rotation[:, 2], atol=1e-9)
        # 9 obstacle and 3 interference spheres, origins and insertions
        assert len(axes.collections) == 9 + 3 + 2
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ['anterior', 'middle', 'posterior', 'humerus', 'interference spheres']


def test_the_poses_are_hanging_and_raised_within_the_range_of_motion() -> None:
    np.testing.assert_allclose(
        np.degrees(pictured_poses(DELTOID)), [[0, 0, 0], [80, 0, 0], [0, 90, 0]]
    )
    small = replace(DELTOID, range_of_motion=((0.1, 0.5), (0.0, 0.6), (-0.1, 0.1)))
    np.testing.assert_allclose(pictured_poses(small), [[0.1, 0, 0], [0.5, 0, 0], [0.1, 0.6, 0]])


def test_a_shared_sphere_is_drawn_once() -> None:
    shared = replace(
        DELTOID,
        sphere_frame='ground',
        sphere_centres=np.zeros((9, 3)),
        sphere_radii=np.full(9, 0.02),
    )
    assert len(model_figure(shared).axes[0].collections) == 1 + 3 + 2


def test_a_ball_is_a_sphere() -> None:
    centre = np.array([0.01, -0.02, 0.03])
    away = sphere_grid(centre, 0.05) - 1e3 * centre[:, np.newaxis, np.newaxis]
    np.testing.assert_allclose(np.linalg.norm(away, axis=0), 50.0, atol=1e-9)


@pytest.mark.parametrize(('ending', 'begins'), [('png', b'\x89PNG'), ('svg', b'<?xml')])
def test_info_draws_a_model(ending: str, begins: bytes, tmp_path: Path) -> None:
    file = tmp_path / f'picture.{ending}'
    assert main(['info', 'example_shared_sphere', '--png', str(file)]) == 0
    assert file.read_bytes().startswith(begins)
    assert [each.name for each in tmp_path.iterdir()] == [file.name]


@pytest.mark.parametrize(
    ('name', 'told'),
    [
        ('deltoid.bmp', 'a picture ends in .png or .svg'),
        ('absent/deltoid.png', 'cannot be written: No such file or directory'),
    ],
)
def test_a_picture_that_cannot_be_written_ends_in_one_line(
    name: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['info', '--png', str(tmp_path / name)]) == 1
    out, err = capsys.readouterr()
    assert out == ''
    assert err == f'linkedplane: {tmp_path / name}: {told}\n'


def test_without_matplotlib_a_picture_is_refused_with_how_to_get_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    assert main(['info', '--png', str(tmp_path / 'deltoid.png')]) == 1
    assert 'pip install matplotlib (rosdep key: python3-matplotlib)' in capsys.readouterr().err
