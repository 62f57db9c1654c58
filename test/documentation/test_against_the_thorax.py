# SPDX-License-Identifier: Apache-2.0
"""What is said of rhythms and shrugs is what the recordings of the girdle give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rhythms
from bags import read_csv
from optional import requires
from pages import TOP
from scipy.spatial.transform import Rotation

from linkedplane_ros.processing.options import Options
from linkedplane_ros.processing.task import Task, run_task

PAGE = (TOP / 'doc/how_to/against_the_thorax.md').read_text(encoding='utf-8')


@pytest.fixture(scope='module', params=['abduction', 'shrug'])
def motion(shared: Path, request: pytest.FixtureRequest) -> rhythms.Comparison:
    """Return a recorded motion of the girdle, solved."""
    return rhythms.Comparison(
        rhythms.read_poses(shared / 'recordings' / f'girdle_{request.param}_mcap')
    )


@requires('rosbags')
def test_the_tables_of_errors_are_what_the_script_prints(motion: rhythms.Comparison) -> None:
    rows = '\n'.join(motion.rows())
    assert f'{rhythms.COLUMNS}\n{rows}\n' in PAGE


@requires('rosbags')
def test_the_bands_of_the_shrug_change_as_it_says(shared: Path) -> None:
    poses = rhythms.read_poses(shared / 'recordings/girdle_shrug_mcap')
    changes = list(rhythms.Comparison(poses).changes())
    assert '\n'.join((rhythms.CHANGES, *changes)) + '\n' in PAGE
    turns = [
        np.degrees(Rotation.from_matrix(R @ R[0].T).magnitude().max())
        for R, _ in (poses[bone] for bone in ('humerus', 'scapula', 'clavicle'))
    ]
    assert turns == pytest.approx([8.0, 20.0, 20.0], abs=0.5)


@requires('rosbags')
def test_process_changes_the_bands_of_the_shrug_by_as_much(tmp_path: Path, shared: Path) -> None:
    options = Options(
        muscle='deltoid_girdle', humerus='humerus', scapula='scapula', clavicle='clavicle'
    )
    source = shared / 'recordings/girdle_shrug_mcap'
    assert run_task(Task(source, tmp_path / 'out.csv', options)).fault == ''
    _, names, values = read_csv(tmp_path / 'out.csv')
    lengths = [k for k, name in enumerate(names) if name.startswith('band_lengths/')]
    spans = [f' {1e3 * span:.1f} |' for span in np.ptp(values[:, lengths], axis=0)]
    table = PAGE.partition(rhythms.CHANGES)[2].strip().splitlines()
    for row, span in zip(table, spans, strict=False):
        assert row.endswith(span)
    assert len(spans) == 9


@requires('rosbags')
def test_a_rigid_motion_of_the_whole_body_changes_none_of_it(shared: Path) -> None:
    poses = rhythms.read_poses(shared / 'recordings/girdle_shrug_mcap')
    some = {bone: (R[::40], t[::40]) for bone, (R, t) in poses.items()}
    R0, t0 = Rotation.from_rotvec((0.3, -0.2, 0.5)).as_matrix(), np.array((0.1, 0.2, 0.3))
    moved = {bone: (R0 @ R, t @ R0.T + t0) for bone, (R, t) in some.items()}
    for bone in ('clavicle', 'humerus'):
        for turned, still in zip(
            rhythms.against_scapula(moved, bone), rhythms.against_scapula(some, bone), strict=True
        ):
            np.testing.assert_allclose(turned, still, rtol=0, atol=1e-12)
