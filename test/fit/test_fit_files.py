# SPDX-License-Identifier: Apache-2.0
"""What a fit leaves on disk: a report that is true, and nothing lost when it fails."""

from __future__ import annotations

import math
import os
import resource
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import PROGRAM, command_fault, command_output
from fits import QUICK_OPTIONS, simulated, write_data
from optional import requires

from linkedplane_ros import BroadMuscle, LinkedPlaneSolver
from linkedplane_ros.fit.data import read_data

pytestmark = requires('pymoo', 'matplotlib')

DELTOID = BroadMuscle.load('deltoid')
SHORT = (*QUICK_OPTIONS[:4], '--polish', 2, '--weights', 'interference=0')


def deviations(model: Path, data: Path) -> dict[tuple[str, str], list[tuple[float, float]]]:
    """Return of each part and motion the angles, deg, and how far moment arms are off, mm."""
    muscle = BroadMuscle.load(model)
    solver, found = LinkedPlaneSolver(muscle), {}
    for row in read_data(data, muscle).measurements:
        rotation, axis = row.pose()
        arm = solver.solve(rotation).moment_vectors[row.band] @ axis
        of = found.setdefault((row.part, row.motion), [])
        of.append((math.degrees(row.angle), 1e3 * (arm - row.arm)))
    return found


def test_the_reports_figures_are_those_of_the_models(
    tmp_path: Path,
    task: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    command_output(capsys, *task, *SHORT)
    start, fitted = (deviations(Path(task[k]), Path(task[2])) for k in (1, 3))
    report = (tmp_path / 'fitted.md').read_text(encoding='utf-8').partition('| moment arm, mm |')[2]
    for (part, motion), after in fitted.items():
        before = [off for _, off in start[part, motion]]
        angle, worst = max(after, key=lambda row: abs(row[1]))
        offs = np.array([off for _, off in after])
        assert (
            f'| {part}, {motion} | {len(after)} | {np.abs(before).mean():.2f} '
            f'| {np.abs(offs).mean():.2f} | {math.sqrt(np.mean(offs**2)):.2f} '
            f'| {worst:+.2f} at {angle:.0f} deg |'
        ) in report


@pytest.mark.parametrize('name', ['example_shared_sphere', 'example_humerus_spheres'])
def test_any_muscle_is_fitted(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    muscle = BroadMuscle.load(name)
    parts = tuple(head.name for head in muscle.heads)
    data = write_data(tmp_path, simulated(muscle, parts, off=1e-3))
    out = command_output(
        capsys, 'fit', name, data, tmp_path / 'fitted.yaml', *SHORT, '--polish', 20
    )
    before, after = (
        float(out.split(sep)[1].split()[0].replace(',', '')) for sep in ('criterion', '->')
    )
    assert after < before
    assert BroadMuscle.load(tmp_path / 'fitted.yaml').band_names == muscle.band_names


def test_a_muscle_of_one_band_is_fitted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    band = DELTOID.band_names[:1]
    one = replace(
        DELTOID,
        heads=(replace(DELTOID.heads[0], bands=band, represented_by=band[0]),),
        band_names=band,
        origins=DELTOID.origins[:1],
        insertions=DELTOID.insertions[:1],
        sphere_centres=DELTOID.sphere_centres[:1],
        sphere_radii=DELTOID.sphere_radii[:1],
        plane_angles=DELTOID.plane_angles[:1],
    )
    one.to_yaml(tmp_path / 'one.yaml')
    data = write_data(tmp_path, simulated(one, ('anterior',), off=1e-3))
    command_output(capsys, 'fit', tmp_path / 'one.yaml', data, tmp_path / 'fitted.yaml', *SHORT)
    report = (tmp_path / 'fitted.md').read_text(encoding='utf-8')
    assert 'inf' not in report
    assert 'behind the one before' not in report


def test_a_full_disk_takes_nothing_that_is_there(tmp_path: Path, task: list[str]) -> None:
    before = {}
    for path in (Path(task[3]), Path(task[3]).with_suffix('.md')):
        path.write_text('mine')
        before[path] = path.read_bytes()
    size = 2000  # bytes, less than a model's file
    run = subprocess.run(
        [*PROGRAM, *task, *map(str, SHORT), '--force'],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
        env={**os.environ, 'LINKEDPLANE_COMPILE': '0'},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 1
    assert run.stderr.startswith('linkedplane: ')
    assert run.stderr.count('\n') == 1
    assert 'File too large' in run.stderr
    assert {path: path.read_bytes() for path in before} == before
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {'start.yaml', 'data.csv', 'fitted.yaml', 'fitted.md'}


@pytest.mark.parametrize('name', ['fitted.yaml', 'fitted.md', 'fitted.png'])
def test_nothing_that_is_there_is_replaced_unasked(
    name: str,
    tmp_path: Path,
    task: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / name).write_text('mine')
    assert f'{name}: exists already; --force replaces it' in command_fault(capsys, *task)
    assert (tmp_path / name).read_text() == 'mine'


def test_the_measurements_are_not_replaced_even_by_force(
    tmp_path: Path,
    task: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    data = Path(task[2]).rename(tmp_path / 'fitted.yaml')
    line = command_fault(capsys, task[0], task[1], data, data, *SHORT, '--force')
    assert 'fitted.yaml: holds the measurements; another name expected' in line


def test_a_place_that_cannot_be_written_to_is_told_before_the_search(
    tmp_path: Path,
    task: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / 'fitted.md').mkdir()
    assert 'fitted.md: is a folder; the name of a file expected' in command_fault(capsys, *task)
    nowhere = tmp_path / 'nowhere' / 'fitted.yaml'
    assert 'fitted.yaml: no folder ' in command_fault(capsys, *task[:3], nowhere)


def test_a_start_without_a_path_is_told_before_the_search(
    tmp_path: Path,
    task: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    radius = DELTOID.coefficients['sphere.radius[4]']
    DELTOID.with_coefficients({'sphere.radius[4]': radius + 60.0}).to_yaml(task[1])
    assert 'start.yaml: a band has no path anywhere' in command_fault(capsys, *task)


def test_the_command_of_the_report_does_it_again(
    tmp_path: Path,
    task: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / 'fitted.md').write_text('old')
    command_output(capsys, *task, *SHORT, '--force')
    second = (tmp_path / 'fitted.md').read_text(encoding='utf-8').splitlines()[2]
    words = ' '.join(map(str, (*task, *SHORT)))
    assert second == f'`linkedplane {words}`'
