# SPDX-License-Identifier: Apache-2.0
"""Studies of muscles that are not the published deltoid."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from optional import requires
from studies import read_table

from linkedplane_ros.commands.main import main
from linkedplane_ros.study.interference import PRINTED

pytestmark = [pytest.mark.usefixtures('coarse'), requires('matplotlib')]

MODEL = Path(__file__).parents[2] / 'linkedplane_ros' / 'models' / 'deltoid.yaml'


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
    assert 'No measurement of these heads is available.' in text
    assert 'Ackland' not in text
    assert {path.stem for path in (out / 'tables').iterdir()} == {
        'heads', 'cubic_less_exact', 'experiments', 'rivals', 'rivals_obstacles',
        'rivals_claims', 'cost',
    }  # fmt: skip
    assert 'front_length_mm' in read_table(out, 'heads')[0]


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
    assert [row['reading'] for row in read_table(out, 'interference_summary')] == [PRINTED]
