# SPDX-License-Identifier: Apache-2.0
"""The small inputs that went wrong, each in a folder with a README that says what is right."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(scope='session')
def cases(shared: Path) -> Path:
    """Return the folder of the cases beside the repository."""
    folder = shared / 'cases'
    if not folder.is_dir():
        pytest.skip('../shared/cases is not there: none of its inputs')
    return folder
