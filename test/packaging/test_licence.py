# SPDX-License-Identifier: Apache-2.0
"""Every file that can hold a comment names its licence at its head."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

TOP = Path(__file__).parents[2]
LINE = 'SPDX-License-Identifier: Apache-2.0'
# what has no comments, or is data; what writes a bag's metadata keeps none
WITHOUT = {'.csv', '.gif', '.json', '.mcap', '.png'}
NAMES_WITHOUT = {'.gitignore', 'LICENSE', 'linkedplane_ros', 'metadata.yaml'}


def tracked_files() -> list[Path]:
    try:
        listed = subprocess.run(
            ['git', 'ls-files'], cwd=TOP, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        pytest.skip('not a git repository: unknown which files are ours')
    return [TOP / name for name in listed.stdout.splitlines() if (TOP / name).exists()]


def test_every_file_names_its_licence() -> None:
    files = [
        path
        for path in tracked_files()
        if path.suffix not in WITHOUT and path.name not in NAMES_WITHOUT
    ]
    assert len(files) > 300
    heads = {path: path.read_text(encoding='utf-8').split('\n')[:3] for path in files}
    assert [path.name for path, head in heads.items() if LINE not in ''.join(head)] == []
    assert 'Apache License' in (TOP / 'LICENSE').read_text()
    assert '>Apache-2.0</license>' in (TOP / 'package.xml').read_text()
