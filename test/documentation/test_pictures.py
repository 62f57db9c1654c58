# SPDX-License-Identifier: Apache-2.0
"""The pictures can be drawn again, with the names that the package has now."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest
from pages import TOP

SCRIPTS = sorted((TOP / 'doc' / 'pictures').glob('render_*.py'))


@pytest.mark.parametrize('name', ['band', 'plain', 'plots', 'poses', 'theta'])
def test_a_picture_can_be_drawn_again(name: str, tmp_path: Path) -> None:
    pytest.importorskip('matplotlib')
    script = runpy.run_path(str(TOP / 'doc' / 'pictures' / f'render_{name}.py'))
    script['main'](tmp_path / 'picture.png')
    assert (tmp_path / 'picture.png').read_bytes().startswith(b'\x89PNG')


@pytest.mark.parametrize('script', SCRIPTS, ids=lambda path: path.stem)
def test_every_script_loads(script: Path) -> None:
    if script.stem == 'render_viewer':
        pytest.importorskip('playwright')
        pytest.importorskip('viser')
    assert callable(runpy.run_path(str(script))['main'])
